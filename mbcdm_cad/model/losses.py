"""Friction of single parts and of the whole train of a drive: motors, gearheads, inputs, cables, drum.

All of it is dry: it follows load and direction, not speed. Values that no catalogue entry holds are estimates and carry
a sigma, the standard deviation of their logarithm. Slip on the wraps is not here: what it loses is the area of the loop
that :mod:`mbcdm_cad.model.hysteresis` computes.

Tensions are those of the lossless equilibrium; friction is added to first order. A cable that loses the share s of its
tension T over its tangent points loads its input, of radius r, with s T r more in the direction of motion, tight or
slack. So the preload loses too, and the loss of the cables hardly depends on the load. Torques at an input are

    x = w M_i + cables + bearings,    motor's side of the gearhead, at its output: x + (1/eta - 1) |x| + M_0,

with w = +1 where the motors move the drum against its load, -1 where the load moves the motors. The friction of drum
and passed bodies is shared by the inputs evenly.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from math import inf
from typing import Any

import numpy as np

from mbcdm_cad.design.bought import Bearing, CableStageOutput
from mbcdm_cad.design.drive import Drive
from mbcdm_cad.design.stage import EFFICIENCY_SIGMA
from mbcdm_cad.model.equilibrium import Equilibrium, solve_equilibrium, solve_weighted, sum_per_input
from mbcdm_cad.model.si import MM, DriveSI
from mbcdm_cad.routes import Floats
from mbcdm_cad.routes.route import Body, DriveRoutes, body_load, two_bearing_reactions_N

# Loss of a wire rope over a whole sheave, 0.7 (d/D)^1.33 of its tension. Form: Feyrer, Wire Ropes, on the efficiency of
# sheaves. The factor is an estimate: a sheave with its bearing then has an efficiency of 0.98 at D/d from 20 to 25, a
# rule of rope makers.
ROPE_FACTOR, ROPE_EXPONENT = 0.7, 1.33
ROPE_SIGMA, FIBRE_SIGMA = 0.45, 0.7
# Ball bearings with deep grooves and no rubbing seal: 0.0015 (SKF), 0.0010 to 0.0015 (Koyo); at the start up to twice.
BEARING_MU, BEARING_START, BEARING_SIGMA = 0.0015, 2.0, 0.3
# Shares of loss in proportion to load vary between gearheads of one kind (estimate).
GEARHEAD_SIGMA = 0.2
# Torque at its output that turns an unloaded planetary gearhead, over its continuous torque: an estimate.
GEARHEAD_IDLE_SHARE, GEARHEAD_IDLE_SIGMA = 0.03, 0.7
# Friction of a small motor without current, over its continuous torque: an estimate, from no-load currents of some
# catalogue motors (3 to 5 %).
MOTOR_IDLE_SHARE, MOTOR_IDLE_SIGMA = 0.04, 0.5
# The same where the catalogue has the no-load current: brushes and grease vary between motors of one type (estimate).
MOTOR_STATED_SIGMA = 0.3
# Equivalent load of a ball bearing, ISO 281: 0.56 F_r + Y F_a where that is above F_r; Y for a light axial load.
_RADIAL_SHARE, _AXIAL_SHARE = 0.56, 2.0


def tangent_share(rope_mm: Floats | float, pulley_mm: Floats | float) -> Floats:
    """Share of its tension that a rope loses as it bends on to a pulley or off it, half of that of a whole sheave.

    ``pulley_mm``: diameter at the rope's centre line. The two diameters may have any one unit.
    """
    return np.asarray(0.5 * ROPE_FACTOR * (np.asarray(rope_mm, float) / pulley_mm) ** ROPE_EXPONENT)


def bearing_torque_Nm(radial_N: Floats | float, axial_N: float, bore_m: float) -> Floats:
    """Friction of a running ball bearing, (mu/2) P d, N m (SKF)."""
    radial = np.asarray(radial_N, float)
    equivalent = np.maximum(radial, _RADIAL_SHARE * radial + _AXIAL_SHARE * axial_N)
    return np.asarray(0.5 * BEARING_MU * equivalent * bore_m)


def gearhead_share(efficiency: float) -> float:
    """Torque that a gearhead loses over the torque at its output, both at the output, 1/eta - 1; the same both ways."""
    return 1.0 / efficiency - 1.0


def backward_efficiency(efficiency: float) -> float:
    """Share of the power put in at its output that a gearhead gives at its motor's side, 2 - 1/eta.

    It follows from a loss in proportion to the load. At an efficiency of 0.5 and below it is 0: self-locking.
    """
    return max(1.0 - gearhead_share(efficiency), 0.0)


def motor_idle_mNm(rated_mNm: float, stated_mNm: float | None) -> float:
    """Friction of a motor without current: what the catalogue states, else a share of its continuous torque."""
    return MOTOR_IDLE_SHARE * rated_mNm if stated_mNm is None else stated_mNm


def turned_back_mNm(motor_idle_mNm: float, ratio: float, efficiency: float, gear_rated_mNm: float) -> float:
    """Torque at a gearhead's output that turns it and the motor before it; infinite where the gearhead locks.

    A motor without a gearhead has ratio and efficiency 1 and ``gear_rated_mNm`` 0.
    """
    back = backward_efficiency(efficiency)
    return (GEARHEAD_IDLE_SHARE * gear_rated_mNm + ratio * motor_idle_mNm) / back if back > 0.0 else inf


# Kinds of friction; the causes of one kind are known or wrong together.
ROPE, BEARINGS, GEARHEAD, GEARHEAD_IDLE, MOTOR = "rope", "bearings", "gearhead", "gearhead without load", "motor"
STAGE = "stage"


@dataclass(frozen=True, eq=False)
class RopeBend:
    """Tangent points of the cables on the bodies of one kind: share of its tension that each loses, (n_cables,)."""

    name: str
    share: Floats
    on_input: bool = False


@dataclass(frozen=True, eq=False)
class BearingPair:
    """The two bearings of a body, which turns ``turns`` times for a turn of the drum.

    ``per_tension``: their radial loads for 1 N in each cable, shape (2, 3, n_cables). ``bores_m`` of both; ``axial_N``
    on each. ``input_index``: the input whose body it is, None for drum and passed bodies. ``factor`` on their friction.
    """

    name: str
    turns: float
    bores_m: tuple[float, float]
    per_tension: Floats
    axial_N: float = 0.0
    input_index: int | None = None
    factor: Floats | float = 1.0

    def torque_Nm(self, tension_N: Floats) -> Floats:
        """Friction of both while they run, about the body's axis, for tensions (n_cables, ...)."""
        radial = np.linalg.norm(np.tensordot(self.per_tension, tension_N, axes=1), axis=1)
        return np.asarray(
            self.factor * sum(bearing_torque_Nm(r, self.axial_N, d) for r, d in zip(radial, self.bores_m, strict=True))
        )


@dataclass(frozen=True)
class Loss:
    """One cause: torque at the drum in N m at each load, of a kind with its sigma (of the logarithm)."""

    name: str
    kind: str
    sigma: float
    torque_Nm: Floats


@dataclass(frozen=True, eq=False)
class MovingLosses:
    """Losses while the drum moves under loads: ``way`` +1 against the load, -1 with it. Arrays over the loads.

    ``motor_Nm``: torque of each motor in the direction of motion, its own friction included, (n_inputs, n); below zero
    the motor brakes.
    """

    way: int
    load_Nm: Floats
    losses: tuple[Loss, ...]
    motor_Nm: Floats

    @cached_property
    def lost_Nm(self) -> Floats:
        """All losses together, at the drum."""
        return np.asarray(sum(loss.torque_Nm for loss in self.losses))

    @cached_property
    def sigma_Nm(self) -> Floats:
        """Standard deviation of :attr:`lost_Nm`: causes of one kind add, kinds are independent."""
        kinds = dict.fromkeys(loss.kind for loss in self.losses)
        each = [sum(x.torque_Nm * x.sigma for x in self.losses if x.kind == kind) for kind in kinds]
        return np.asarray(np.sqrt(sum(np.square(size) for size in each)))

    @cached_property
    def efficiency(self) -> Floats:
        """Power given over power taken: payload over motors, or motors over payload; 0 where nothing comes through."""
        load = np.abs(self.load_Nm)
        if self.way > 0:
            return np.asarray(load / (load + self.lost_Nm))
        return np.asarray(np.maximum(load - self.lost_Nm, 0.0) / load)

    @cached_property
    def efficiency_sigma(self) -> Floats:
        """Standard deviation of the efficiency, to first order."""
        load = np.abs(self.load_Nm)
        slope = load / (load + self.lost_Nm) ** 2 if self.way > 0 else 1.0 / load
        return np.asarray(np.where(self.efficiency > 0.0, slope, 0.0) * self.sigma_Nm)


@dataclass(frozen=True, eq=False)
class Backdrive:
    """Torque at the drum that turns it with the motors without current, N m, by cause."""

    losses: tuple[Loss, ...]

    @property
    def running_Nm(self) -> float:
        """While it turns."""
        return float(sum(loss.torque_Nm for loss in self.losses))

    @property
    def start_Nm(self) -> float:
        """To start it: the bearings have up to twice their running friction."""
        return self.start_of_Nm(*(x.kind for x in self.losses))

    def start_of_Nm(self, *kinds: str) -> float:
        """The part of :attr:`start_Nm` that some kinds of friction take."""
        shares = {BEARINGS: BEARING_START}
        return float(sum(x.torque_Nm * shares.get(x.kind, 1.0) for x in self.losses if x.kind in kinds))

    @property
    def sigma_Nm(self) -> float:
        """Standard deviation of :attr:`running_Nm`."""
        return float(MovingLosses(1, np.zeros(()), self.losses, np.zeros(())).sigma_Nm)


@dataclass(frozen=True, eq=False)
class Train:
    """Friction of a whole drive, or of a batch of n drives with one load each; torques in N m.

    For a batch ``d`` is one, shares of the rope are (n_cables, n), and all other figures numbers or (n,).
    ``gear_share``: loss of a gearhead over its output torque; ``gear_idle_Nm``: torque at its output that turns it
    unloaded; ``motor_idle_Nm``: friction of a motor, ``motor_sigma`` of its logarithm. A belt or gears behind the
    gearhead count with it: ratio, share and idle torque are those at the input, ``stage_share`` the stage's part of
    the share.
    """

    d: DriveSI
    rope: tuple[RopeBend, ...]
    bearings: tuple[BearingPair, ...]
    fibre: bool
    gear_ratio: float
    gear_share: Any
    gear_idle_Nm: Any
    motor_idle_Nm: Any
    motor_sigma: float = MOTOR_IDLE_SIGMA
    stage_share: Any = 0.0
    gear_words: str = "gearheads"

    @property
    def rope_share(self) -> Floats:
        """Share of its tension that each cable loses over all its tangent points, (n_cables,)."""
        return np.asarray(sum(bend.share for bend in self.rope))

    def moving(self, load_Nm: Floats | float, way: int) -> MovingLosses:
        """Losses while the drum moves against its loads (``way`` +1) or with them (-1).

        Loads above zero oppose positive rotation, and so the drum moves positively with ``way`` +1. Without a load it
        does so with +1, negatively with -1.
        """
        load = np.atleast_1d(np.asarray(load_Nm, float))
        sense = way * np.where(load < 0.0, -1.0, 1.0)
        at = solve_equilibrium(self.d, load)
        rope, bearings = self._rope_losses(at.tension_N), self._bearing_losses(at.tension_N)
        turns = self.d.column(self.d.input_turns, 2)
        at_inputs = sum(sum_per_input_size(self.d, bend.share, at.tension_N) for bend in self.rope)
        at_input = sense * at.input_torque_Nm(self.d) + at_inputs + self._bearings_at_inputs(at.tension_N)
        lost = self.gear_share * np.abs(at_input)
        motor = (at_input + lost + self.gear_idle_Nm) / self.gear_ratio + self.motor_idle_Nm
        of_stage = self.stage_share * np.abs(at_input)
        stage = Loss("belt or gear stage", STAGE, EFFICIENCY_SIGMA, (turns * of_stage).sum(axis=0))
        gear = Loss(
            f"{self.gear_words}, with the load", GEARHEAD, GEARHEAD_SIGMA, (turns * (lost - of_stage)).sum(axis=0)
        )
        idle = tuple(_spread(loss, load) for loss in self._idle)
        causes = tuple(x for x in (*rope, *bearings, stage, gear, *idle) if np.any(x.torque_Nm > 0.0))
        return MovingLosses(way, load, causes, motor)

    @cached_property
    def backdrive(self) -> Backdrive | None:
        """What turns the drum from its side with motors without current; None where the gearheads lock.

        The inputs give way until each carries only what turns its motor, so that no preload loads the gearheads.
        """
        back = 1.0 - self.gear_share
        if back <= 0.0:
            return None
        tension = self._unloaded.tension_N
        behind = [Loss(x.name, x.kind, x.sigma, x.torque_Nm / back) for x in self._idle]
        causes = [*self._rope_losses(tension), *self._bearing_losses(tension), *behind]
        return Backdrive(tuple(x for x in causes if np.any(x.torque_Nm > 0.0)))

    def output_Nm(self, motor_Nm: Floats | float) -> Floats:
        """Torque at its output that a gearhead gives forward for ``motor_Nm`` on the motor's shaft."""
        return np.asarray((np.asarray(motor_Nm) * self.gear_ratio - self.gear_idle_Nm) / (1.0 + self.gear_share))

    def with_drive(self, d: DriveSI) -> "Train":
        """The same train with other preloads or wraps."""
        return self if d is self.d else replace(self, d=d)

    def raised_Nm(self, output_Nm: Floats | float, direction: int) -> Floats:
        """Load (>= 0) against which each input still moves the drum with ``output_Nm`` at its gearhead's output.

        Shape (n_inputs, ...) for any shape of ``output_Nm``; ``direction`` is the sign of the load. Zero where preload
        and friction alone take all of the torque.
        """
        given = np.asarray(output_Nm, float)
        if given.ndim:
            return self._raised(given, direction)
        key = float(given), direction
        if key not in self._raised_before:
            self._raised_before[key] = self._raised(given, direction)
        return self._raised_before[key]

    @cached_property
    def _raised_before(self) -> dict[tuple[float, int], Floats]:
        """Loads by (output, direction): several checks ask for the same."""
        return {}

    def _raised(self, given: Floats, direction: int) -> Floats:
        output = given.reshape(-1)
        d, n = self.d, self.d.n_inputs
        wide, sense, radius = d.lifted((n, output.size)), d.column(d.sigma, 2), d.column(d.input_radius_m, 2)
        lever, idle = d.column(d.sigma, 3) * wide.drum_radius_m, d.column(self._unloaded.tension_N, 2)
        spent = direction * sum_per_input(d, idle, radius)
        spent = spent + sum_per_input_size(d, self.rope_share, idle)
        # One case for each input, which carries the load alone as far as its motor is concerned.
        pulled = np.stack([d.of_input(i) for i in range(n)], axis=1)
        weight = ((sense + direction * d.column(self.rope_share, 2)) * radius)[:, None] * pulled[:, :, None]
        tension = np.broadcast_to(idle[:, None], (d.n_cables, n, output.size))
        # The friction of the bearings follows the tensions, which it hardly changes: two steps are enough.
        for _ in range(2):
            # Input by input: in a batch of drives, tensions of all inputs at once have an axis that turns do not have.
            limit = output - np.stack([self._bearings_at_inputs(tension[:, i])[i] for i in range(n)])
            moves = limit > spent
            tension = solve_weighted(wide, weight, direction * np.where(moves, limit, spent)).tension_N
        load = direction * (lever * tension).sum(axis=0)
        return np.where(moves, load, 0.0).reshape(n, *given.shape)

    def rating_Nm(self, output_Nm: Floats | float) -> float:
        """Torque at an input that a drive without losses would need for the load that this one moves in its worse way.

        For formulas that reckon without losses: with this rating they give that load.
        """
        each = [(way, self.raised_Nm(output_Nm, way)) for way in (1, -1)]
        way, loads = min(each, key=lambda item: float(item[1].min()))
        first = int(loads.argmin())
        at = solve_equilibrium(self.d, way * float(loads[first]))
        return way * float(at.input_torque_Nm(self.d)[first])

    @cached_property
    def _unloaded(self) -> Equilibrium:
        return solve_equilibrium(self.d, 0.0)

    @property
    def _idle(self) -> tuple[Loss, Loss]:
        """What gearheads and motors lose without load, at the drum."""
        turns = self.d.input_turns.sum(axis=0)
        motors = turns * self.gear_ratio * self.motor_idle_Nm
        return (
            Loss(
                f"{self.gear_words}, without load",
                GEARHEAD_IDLE,
                GEARHEAD_IDLE_SIGMA,
                np.asarray(turns * self.gear_idle_Nm),
            ),
            Loss("motors", MOTOR, self.motor_sigma, np.asarray(motors)),
        )

    def _rope_losses(self, tension_N: Floats) -> list[Loss]:
        sigma = FIBRE_SIGMA if self.fibre else ROPE_SIGMA
        lever = self.d.column(self.d.drum_radius_m, tension_N.ndim)
        return [
            Loss(bend.name, ROPE, sigma, (self.d.column(bend.share, tension_N.ndim) * tension_N * lever).sum(axis=0))
            for bend in self.rope
        ]

    def _bearing_losses(self, tension_N: Floats) -> list[Loss]:
        """By name; the bearings of all inputs are one cause."""
        found: dict[str, Floats] = {}
        for b in self.bearings:
            found[b.name] = found.get(b.name, 0.0) + abs(b.turns) * b.torque_Nm(tension_N)
        return [Loss(name, BEARINGS, BEARING_SIGMA, torque) for name, torque in found.items()]

    def _bearings_at_inputs(self, tension_N: Floats) -> Floats:
        """Friction of all bearings at the inputs, (n_inputs, ...)."""
        found = np.zeros((self.d.n_inputs, *tension_N.shape[1:]))
        turns = self.d.column(self.d.input_turns, found.ndim)
        for b in self.bearings:
            torque = b.torque_Nm(tension_N)
            if b.input_index is None:
                found += abs(b.turns) * torque / self.d.n_inputs / turns
            else:
                found[b.input_index] += torque
        return found


def sum_per_input_size(d: DriveSI, share: Floats, tension_N: Floats) -> Floats:
    """sum_j share_j T_j r_ij over the cables of each input, whichever way they pull, (n_inputs, ...)."""
    ndim = tension_N.ndim
    size = d.column(share, ndim) * d.column(d.input_radius_m, ndim)
    return sum_per_input(d, tension_N, d.column(d.sigma, ndim) * size)


def _spread(loss: Loss, load_Nm: Floats) -> Loss:
    return Loss(loss.name, loss.kind, loss.sigma, np.broadcast_to(loss.torque_Nm, load_Nm.shape))


def train_of(drive: Drive, d: DriveSI, bearings: tuple[BearingPair, ...]) -> Train:
    """The friction of one design. Raises ``ModelError`` where the routes have no free span."""
    gear, motor, stage = drive.gearhead, drive.motor, drive.stage
    idle = motor.idle_torque_mNm
    idle_at_input = 0.0 if gear.absent else GEARHEAD_IDLE_SHARE * gear.rated_torque_mNm * 1e-3
    if isinstance(gear, CableStageOutput):
        idle_at_input = gear.idle_torque_Nm
    if stage is not None:
        idle_at_input *= stage.ratio
    return Train(
        d=d,
        rope=tuple(_rope_bends(d.routes, drive.cable.diameter_mm * MM)),
        bearings=bearings,
        fibre=drive.cable.construction == "braid",
        gear_ratio=drive.reduction.ratio,
        gear_share=gearhead_share(drive.reduction.efficiency),
        gear_idle_Nm=idle_at_input,
        motor_idle_Nm=motor_idle_mNm(motor.rated_torque_mNm, idle) * 1e-3,
        motor_sigma=MOTOR_IDLE_SIGMA if idle is None else MOTOR_STATED_SIGMA,
        stage_share=0.0 if stage is None else gearhead_share(stage.efficiency),
        gear_words=drive.mounted if isinstance(gear, CableStageOutput) else "gearheads",
    )


def _rope_bends(routes: DriveRoutes, rope_m: float) -> Iterator[RopeBend]:
    """Inputs, each passed body, drum: half a sheave's loss for each tangent point of a cable."""
    groups = [("inputs", routes.inputs), *((body.name, (body,)) for body in routes.passed), ("drum", (routes.drum,))]
    for name, bodies in groups:
        names = {body.name for body in bodies}
        share = np.zeros(len(routes.cables))
        for j, route in enumerate(routes.cables):
            for at in route.contacts():
                if at.wrap.body in names:
                    points = (at.arriving is not None) + (at.leaving is not None)
                    share[j] += points * float(tangent_share(rope_m, 2.0 * at.wrap.radius_m))
        yield RopeBend(f"cables on the {name}", share, on_input=name == "inputs")


def body_bearings(
    d: DriveSI,
    body: Body,
    name: str,
    specs: tuple[Bearing, Bearing],
    at_mm: tuple[float, float],
    axial_N: float = 0.0,
    input_index: int | None = None,
) -> BearingPair:
    """The two bearings of a body, with their middles along its axis."""
    lower, upper = (z * MM for z in at_mm)
    columns = []
    for one in np.eye(d.n_cables):
        load = body_load(d.routes, body.name, one)
        columns.append(two_bearing_reactions_N(load.force_N, load.moment_Nm, load.height_m, lower, upper, body.axis))
    bores = (specs[0].bore_mm * MM, specs[1].bore_mm * MM)
    return BearingPair(name, body.turns_per_drum, bores, np.stack(columns, axis=2), axial_N, input_index)
