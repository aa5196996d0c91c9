"""Losses between motors and payload, and two cable stages side by side: plain data, and what the page shows of it."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from math import isfinite
from typing import Any

import numpy as np

from mbcdm_cad.design.bought import Motor
from mbcdm_cad.layouts.base import Layout, NoFigureError
from mbcdm_cad.layouts.life import life_of
from mbcdm_cad.layouts.structure import structure_of
from mbcdm_cad.model.losses import GEARHEAD, GEARHEAD_IDLE, MOTOR, MovingLosses, Train
from mbcdm_cad.model.structure.causes import urad_Nm
from mbcdm_cad.report.table import chart
from mbcdm_cad.routes import Floats

# Loads over the peak torque.
LOAD_SHARES = np.linspace(0.05, 1.0, 20)
# Loads of the picture over speed.
_DRAWN = (4, 9, 19)
SPEED_SHARES = (0.05, 0.1, 0.2, 0.4, 0.6, 0.8)
_WAYS = {1: "against the load", -1: "with the load"}


@dataclass(frozen=True)
class LossesReport:
    """Losses of one design. ``rotors_kg_m2``: inertia of all rotors, seen at the drum."""

    train: Train
    peak_Nm: float
    motor: Motor
    bus_voltage_V: float | None
    rotors_kg_m2: float

    @cached_property
    def unloaded(self) -> MovingLosses:
        """While the drum moves without a load."""
        return self.train.moving(0.0, 1)

    @cached_property
    def motions(self) -> tuple[MovingLosses, ...]:
        """Both ways under loads of both signs, at shares of the peak torque."""
        loads = self.peak_Nm * LOAD_SHARES
        return tuple(self.train.moving(sign * loads, way) for way in (1, -1) for sign in (1.0, -1.0))

    def to_dict(self) -> dict[str, Any]:
        """Everything, ready for JSON; torques of losses are at the drum."""
        back = self.train.backdrive
        return {
            "unloaded": self._motion(self.unloaded),
            "motions": [self._motion(motion) for motion in self.motions],
            "backdrive": None
            if back is None
            else {
                "running_Nm": back.running_Nm,
                "start_Nm": back.start_Nm,
                "sigma_Nm": back.sigma_Nm,
                "by_cause_Nm": {x.name: float(x.torque_Nm) for x in back.losses},
            },
            # How a hand at the drum feels the drive, and the motors feel the hand.
            "transparency": {
                "free_Nm": None if back is None else back.running_Nm,
                "rotors_kg_m2": self.rotors_kg_m2,
                "load_Nm": self.motions[0].load_Nm.tolist(),
                "load_known_to_Nm": self.felt_Nm.tolist(),
            },
            "sigma_ln": {x.kind: x.sigma for x in self.unloaded.losses},
            "electrical": self._electrical(),
        }

    @cached_property
    def felt_Nm(self) -> Floats:
        """To what, plus or minus, the motors' torque tells each load +: half of the losses of both ways."""
        against, along = self.motions[0], self.motions[2]
        return np.asarray(0.5 * (against.lost_Nm + along.lost_Nm))

    def _motion(self, m: MovingLosses) -> dict[str, Any]:
        names = self.train.d.input_names
        return {
            "way": _WAYS[m.way],
            "load_Nm": m.load_Nm.tolist(),
            "efficiency": m.efficiency.tolist() if m.load_Nm.any() else None,
            "efficiency_sigma": m.efficiency_sigma.tolist() if m.load_Nm.any() else None,
            "lost_Nm": m.lost_Nm.tolist(),
            "lost_sigma_Nm": m.sigma_Nm.tolist(),
            "by_cause_Nm": {x.name: x.torque_Nm.tolist() for x in m.losses},
            "motor_mNm": {name: (1e3 * row).tolist() for name, row in zip(names, m.motor_Nm, strict=True)},
        }

    def _electrical(self) -> dict[str, Any] | None:
        """Efficiency both ways with what the copper loses, over speed and load +; None without the motor's values."""
        constant_mNm_A, ohms, volts = self.motor.torque_constant_mNm_A, self.motor.resistance_ohm, self.bus_voltage_V
        if constant_mNm_A is None or ohms is None or volts is None:
            return None
        constant = constant_mNm_A * 1e-3
        to_motor = float(np.max(self.train.d.input_turns)) * self.train.gear_ratio
        speeds = volts / constant / to_motor * np.array(SPEED_SHARES)
        ways = [
            self._with_copper(m, constant, ohms, volts, speeds, to_motor) for m in (self.motions[0], self.motions[2])
        ]
        return {"drum_speed_deg_s": np.degrees(speeds).tolist(), **ways[0], "back": ways[1]}

    @staticmethod
    def _with_copper(
        m: MovingLosses, constant: float, ohms: float, volts: float, speeds: Floats, to_motor: float
    ) -> dict[str, Any]:
        """Efficiency from bus to payload, or back, at each drum speed (rows) and load; none beyond the bus voltage."""
        current = m.motor_Nm / constant
        copper = ohms * np.square(current).sum(axis=0)
        load, at = np.abs(m.load_Nm), speeds[:, None]
        taken = m.lost_Nm + copper / at
        if m.way > 0:
            found = load / (load + taken)
            sigma = found**2 / load * m.sigma_Nm
        else:
            found = np.maximum(load - taken, 0.0) / load
            sigma = np.where(found > 0.0, m.sigma_Nm / load, 0.0)
        # What the voltage leaves for the current that a load asks; beyond it the motors do not reach the speed.
        reached = m.way * ohms * current.max(axis=0) + constant * to_motor * at <= volts
        shown = [np.where(reached, values, np.nan) for values in (found, sigma)]
        rows = [[[None if np.isnan(e) else float(e) for e in row] for row in values] for values in shown]
        return {
            "load_Nm": m.load_Nm.tolist(),
            "copper_loss_W": copper.tolist(),
            "efficiency": rows[0],
            "efficiency_sigma": rows[1],
        }


def losses_report(layout: Layout) -> LossesReport:
    """The figures of the losses. Raises ``ModelError`` where the routes have no free span."""
    drive = layout.drive
    train = layout.losses
    rotors = drive.rotor_at_input_kg_m2 * float(np.square(train.d.input_turns).sum())
    return LossesReport(train, drive.loads.peak_torque_Nm, drive.motor, drive.bus_voltage_V, rotors)


_EFFICIENCY = "efficiency", "%"


def losses_shown(found: Mapping[str, Any]) -> dict[str, Any]:
    """What page and report show of the block ``losses``: causes, largest first, and efficiency over a load +."""
    against, along = found["motions"][0], found["motions"][2]
    ways = (("motors move the load", against), ("load moves the motors", along))
    lines = [{"label": label, "x": m["load_Nm"], "y": [100.0 * e for e in m["efficiency"]]} for label, m in ways]
    rows = [
        {
            "cause": cause,
            "unloaded": found["unloaded"]["by_cause_Nm"].get(cause, [0.0])[0],
            "against": torque[-1],
            "along": along["by_cause_Nm"].get(cause, [0.0])[-1],
        }
        for cause, torque in against["by_cause_Nm"].items()
    ]
    return {
        "peak_Nm": against["load_Nm"][-1],
        "rows": sorted(rows, key=lambda row: -row["against"]),
        "all": [found["unloaded"]["lost_Nm"][0], against["lost_Nm"][-1], along["lost_Nm"][-1]],
        "sigma_Nm": against["lost_sigma_Nm"][-1],
        "backdrive": found["backdrive"],
        "over_speed": _over_speed(found["electrical"]),
        "chart": chart("Efficiency from motors to drum, and back", ("load on the drum", "N m"), _EFFICIENCY, lines),
    }


def _over_speed(found: Mapping[str, Any] | None) -> dict[str, Any] | None:
    """The picture of the efficiency with the copper's losses over the drum's speed; None without electrical values."""
    if found is None:
        return None
    lines = []
    for words, block in (("against", found), ("with", found["back"])):
        for k in _DRAWN:
            points = [
                (speed, 100.0 * row[k])
                for speed, row in zip(found["drum_speed_deg_s"], block["efficiency"], strict=True)
                if row[k] is not None
            ]
            if points:
                x, y = zip(*points, strict=True)
                label = f"{words} {block['load_Nm'][k]:.3g} N m"
                lines.append({"label": label, "x": list(x), "y": list(y)})
    title = "Efficiency from bus to drum and back, the copper's losses in it"
    return chart(title, ("speed of the drum", "deg/s"), _EFFICIENCY, lines)


# Kinds of the losses of a first stage in a whole drive, where it stands in place of a gearhead.
_OF_FIRST = (GEARHEAD, GEARHEAD_IDLE)


@dataclass(frozen=True)
class StageFigures:
    """One stage, or both. ``torque_Nm``: what it is made for, at its own drum.

    ``urad_Nm``: turn of the payload, the motor held; ``lost_Nm``: what it loses at the peak torque of the whole, at the
    drum of the whole, motors aside. ``life_cycles``: median of the cable that breaks first, in cycles of the output;
    None where there is no figure, with the reason in ``no_life``.
    """

    stage: str
    ratio: float
    travel_deg: float
    torque_Nm: float
    urad_Nm: float | None
    lost_Nm: float
    life_cycles: float | None
    no_life: str = ""


def stage_figures(layout: Layout) -> tuple[StageFigures, ...]:
    """The first stage, the second, and both; empty for a drive of one stage."""
    first, drive = layout.first_stage_unit, layout.drive
    if first is None:
        return ()
    lost = {True: 0.0, False: 0.0}
    for loss in layout.losses.moving(drive.loads.peak_torque_Nm, 1).losses:
        if loss.kind != MOTOR:
            lost[loss.kind in _OF_FIRST] += float(loss.torque_Nm[0])
    try:
        structure = structure_of(layout)
    except NoFigureError:
        structure = None
    own: float | None = None
    before: float | None = None
    if structure is not None:
        before = urad_Nm(c for c in structure.causes if c.name == drive.mounted)
        own = structure.cables_urad_Nm + structure.motor_urad_Nm - before
    ratios = drive.reduction.ratio, float(layout.routed.routes.inputs[0].turns_per_drum)
    lives = _life(first), _life(layout)
    known = [cycles for cycles, _ in lives if cycles is not None]
    one = StageFigures(
        "first", ratios[0], first.drive.half_travel_deg, first.drive.loads.peak_torque_Nm, before, lost[True], *lives[0]
    )
    two = StageFigures(
        "second", abs(ratios[1]), drive.half_travel_deg, drive.loads.peak_torque_Nm, own, lost[False], *lives[1]
    )
    both = StageFigures(
        "both",
        one.ratio * two.ratio,
        two.travel_deg,
        two.torque_Nm,
        None if own is None or before is None else own + before,
        one.lost_Nm + two.lost_Nm,
        min(known) if len(known) == len(lives) else None,
    )
    return one, two, both


def _life(layout: Layout) -> tuple[float | None, str]:
    """Cycles of the cable that breaks first; None with the reason where one has no figure."""
    try:
        ropes = life_of(layout).ropes
    except NoFigureError as error:
        return None, str(error)
    for rope in ropes:
        if not isfinite(rope.cycles):
            return None, rope.refused if rope.longer else f"{rope.refused}; it may break first"
    return min(rope.cycles for rope in ropes), ""
