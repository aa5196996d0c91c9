"""A drive that gives and loses, for simulators: cables with their hysteresis, parts that give, motors, friction.

Between a motor and the drum gearhead, pulley and cables in series carry a torque that depends on the course of g, the
drum's angle less that of the motor over its ratio. The model gives it (:mod:`mbcdm_cad.model.hysteresis`); a spring and
elements that are springs up to a limit, where they slip, follow it in loops of any size, since the loops are nearly
twice the curve of first loading (Masing). The limits are chosen, the stiffnesses follow by least squares above zero.
"""

from dataclasses import dataclass
from itertools import pairwise
from math import inf

import numpy as np

from mbcdm_cad.design.blocks import AsBuilt
from mbcdm_cad.design.drive import Drive
from mbcdm_cad.errors import MbcdmError
from mbcdm_cad.layouts.base import NoFigureError
from mbcdm_cad.layouts.lumped import Compliance, axis_friction, compliance_of
from mbcdm_cad.layouts.registry import layout_of
from mbcdm_cad.layouts.structure import input_play_rad
from mbcdm_cad.model.heat import COPPER_PER_K, RATED_AT_C, motor_heat
from mbcdm_cad.model.hysteresis import simulate
from mbcdm_cad.model.si import DriveSI
from mbcdm_cad.routes import Floats

# Twist at which each element slips, over the turn under the test torque.
SLIP_TURNS = (0.1, 0.22, 0.45, 0.9, 1.8)
# Loads of the loops that are fitted, over the test torque; never above the peak torque.
_LEVELS = (0.3, 1.0, 2.0)
_SAMPLES = 300


@dataclass(frozen=True)
class SlipElement:
    """A spring that slips at its limit, both at the drum."""

    stiffness_Nm_rad: float
    limit_Nm: float


@dataclass(frozen=True)
class CableStage:
    """Gearhead and cables of one input, at the drum: torque that turns the drum = preload - spring g - elements.

    ``preload_Nm``: torque of the preload on the drum, which acts on the input too, through its ratio.
    """

    input_index: int
    preload_Nm: float
    spring_Nm_rad: float
    slips: tuple[SlipElement, ...]

    @property
    def sticking_Nm_rad(self) -> float:
        """Stiffness while nothing slips."""
        return self.spring_Nm_rad + sum(slip.stiffness_Nm_rad for slip in self.slips)


def cable_stages(drive: Drive, before_inputs_Nm_rad: float) -> tuple[CableStage, ...]:
    """A stage for each input, fitted to loops; ``before_inputs_Nm_rad``: stiffness between motor and input's encoder.

    Raises ``ModelError`` where there is no loop.
    """
    d = layout_of(drive).si
    test = drive.loads.test_torque_Nm
    levels = [min(level * test, max(test, drive.loads.peak_torque_Nm)) for level in _LEVELS]
    loops = [_loop(d, level) for level in levels]
    give = 1.0 / (before_inputs_Nm_rad * np.asarray(d.input_turns) ** 2)
    return tuple(_stage(d, i, float(give[i]), list(zip(levels, loops, strict=True))) for i in range(d.n_inputs))


def slipping(twist_rad: Floats, limit_rad: float) -> Floats:
    """Deflection of an elastic-slip element over a course of twists that begins at rest, rad."""
    found = np.zeros(twist_rad.size)
    for k, (before, now) in enumerate(pairwise(twist_rad), 1):
        found[k] = min(max(found[k - 1] + now - before, -limit_rad), limit_rad)
    return found


def _loop(d: DriveSI, load_Nm: float) -> tuple[Floats, Floats]:
    """Drum angles (n,) and tensions (n_cables, n) from the preload on, up to the load, to its opposite and back."""
    corners = [(0.0, load_Nm), (load_Nm, -load_Nm), (-load_Nm, load_Nm)]
    load = np.concatenate([np.linspace(a, b, _SAMPLES) for a, b in corners])
    run = simulate(d, np.zeros((d.n_inputs, load.size)), load)
    return np.append(0.0, run.drum_angle_rad), np.column_stack([d.preload_N, run.tension_N])


def _stage(d: DriveSI, i: int, give_rad_Nm: float, loops: list[tuple[float, tuple[Floats, Floats]]]) -> CableStage:
    from scipy.optimize import nnls

    own = np.array(d.input_of) == i
    lever = (d.sigma * d.drum_radius_m)[own]
    torques = [lever @ (d.preload_N[own, None] - tension[own]) for _, (_, tension) in loops]
    # The torque that the cables take twists the gearhead too.
    twists = [drum + give_rad_Nm * torque for (_, (drum, _)), torque in zip(loops, torques, strict=True)]
    limits_rad = np.array(SLIP_TURNS) * 0.5 * float(np.ptp(twists[1]))
    rows, wanted = [], []
    for (level, _), twist, torque in zip(loops, twists, torques, strict=True):
        rows.append(np.stack([twist, *(slipping(twist, limit) for limit in limits_rad)], axis=1) / level)
        wanted.append(torque / level)
    scale = float(limits_rad[-1])  # so that the unknowns are torques
    scaled, _ = nnls(np.concatenate(rows) / scale, np.concatenate(wanted))
    spring, *stiff = scaled / scale
    slips = tuple(
        SlipElement(float(k), float(k * limit)) for k, limit in zip(stiff, limits_rad, strict=True) if k > 0.0
    )
    return CableStage(i, float(lever @ d.preload_N[own]), float(spring), slips)


# Torque constant of a motor whose entry has none, N m/A: a scale of the current, without effect on torque and heat.
_CONSTANT_NM_A = 0.01
# Stiffness of gears and shafts that state none, where they have play.
_RIGID_NM_RAD = 1e4


@dataclass(frozen=True)
class RobotMotor:
    """One motor at its own shaft, SI. ``voltage_V``: that of the bus; None where the motor's constants are not known.

    ``heat_K_W`` and ``heat_J_K``: winding and housing as one body. ``friction_Nm`` is the motor's own.
    """

    inertia_kg_m2: float
    constant_Nm_A: float
    resistance_ohm: float
    peak_Nm: float
    friction_Nm: float
    voltage_V: float | None
    heat_K_W: float
    heat_J_K: float
    copper_per_K: float
    rated_at_C: float
    ambient_C: float


# What each kind of file holds of a friction at the drum that was found on the built drive.
_RIGID_HAS = {"torque_Nm", "drag_Nm_s"}
_HAS = {
    "urdf": _RIGID_HAS,
    "mjcf": _RIGID_HAS,
    "elastic": _RIGID_HAS | {"stribeck_Nm", "fades_rad_s", "built_up_rad"},
    "fmu": _RIGID_HAS | {"stribeck_Nm", "fades_rad_s", "load_share", "driving_share", "driven_share"},
}


@dataclass(frozen=True)
class DrumFriction:
    """Friction at the drum that the built drive was found to have besides its design's, as ``as_built`` states it, SI.

    With the drum's speed w: constant + viscous |w| + stribeck exp(-(w/fades)^2) + a share of the load, one where the
    drive moves against it and one where it moves the drive; ``built_up_rad``: path after a reversal in which 63 % of
    the change of constant and Stribeck part are there, 0 for at once. The constant is negative where less rubs.
    """

    constant_Nm: float = 0.0
    viscous_Nm_s: float = 0.0
    stribeck_Nm: float = 0.0
    fades_rad_s: float = 1.0
    driving_share: float = 0.0
    driven_share: float = 0.0
    built_up_rad: float = 0.0

    @property
    def slow_Nm(self) -> float:
        """The part of the constant that builds up."""
        return max(self.constant_Nm, 0.0) if self.built_up_rad > 0.0 else 0.0


def drum_friction(drive: Drive) -> DrumFriction:
    """The sum of all entries of ``as_built`` that are a friction at the drum; none is all zero."""
    values = [value for entry in drive.as_built if _at_drum(entry) for value in entry.values]
    last = {value.name: value.value for value in values}

    def of(name: str) -> float:
        return sum(value.value for value in values if value.name == name)

    return DrumFriction(
        of("torque_Nm"),
        of("drag_Nm_s"),
        of("stribeck_Nm"),
        last.get("fades_rad_s", 1.0),
        of("load_share") + of("driving_share"),
        of("load_share") + of("driven_share"),
        last.get("built_up_rad", 0.0),
    )


def left_out(drive: Drive, kind: str) -> tuple[str, ...]:
    """What the built drive was found to have and a file does not hold, with its figures in SI.

    ``kind``: ``urdf``, ``mjcf``, ``elastic`` (MJCF) or ``fmu``. Effects that change values of the design are in all.
    """
    found = []
    for entry in drive.as_built:
        kept = _HAS[kind] if _at_drum(entry) else set()
        missing = [f"{value.name} {value.value:.4g}" for value in entry.values if value.name not in kept]
        if missing:
            found.append(f"{entry.name} ({entry.form}): {', '.join(missing)}")
    return tuple(found)


def _at_drum(entry: AsBuilt) -> bool:
    place, _, _ = entry.form.partition(":")
    return (entry.name, place) in {("friction", "bearing torque"), ("delay", "viscous drag")}


@dataclass(frozen=True)
class ElasticDrive:
    """All that a simulator needs besides masses and joints.

    ``turns``: of each input for one of the drum. ``drum_friction_Nm`` and ``input_friction_Nm`` at each axis, that of
    the motors apart; ``built``: what was found at the drum besides, its constant counted in the former. ``gear_share``:
    loss of a gearhead over the torque at its output, besides. ``payload_kg_m2``: inertia of the design's payload about
    the drum's axis. ``play_rad``: of each input, from one side to the other, by a belt or gear stage and by a servo's
    gears; where there is any, the stages are the cables alone, and what is before the inputs stands between motor and
    input, with the play.
    """

    stages: tuple[CableStage, ...]
    turns: tuple[float, ...]
    compliance: Compliance
    motor: RobotMotor
    gear_ratio: float
    gear_share: float
    drum_friction_Nm: float
    input_friction_Nm: tuple[float, ...]
    payload_kg_m2: float
    play_rad: float = 0.0
    built: DrumFriction = DrumFriction()

    @property
    def contact_Nm_rad(self) -> float:
        """Stiffness at an input between motor and pulley, where its play is closed."""
        return min(self.compliance.before_inputs_Nm_rad, _RIGID_NM_RAD)

    @property
    def rest_Nm(self) -> tuple[float, ...]:
        """Torque of each input at the drum while nothing loads it: preloads that do not cancel there turn the drum."""
        stiff = [stage.sticking_Nm_rad for stage in self.stages]
        turn = sum(stage.preload_Nm for stage in self.stages) / sum(stiff)
        return tuple(stage.preload_Nm - k * turn for stage, k in zip(self.stages, stiff, strict=True))

    @property
    def held_Nm(self) -> tuple[float, ...]:
        """The same at the motors' shafts, positive where it drives the drum positively."""
        return tuple(rest / turn / self.gear_ratio for rest, turn in zip(self.rest_Nm, self.turns, strict=True))

    @property
    def input_shares(self) -> tuple[float, ...]:
        """Torque of each input for 1 N m on the payload."""
        return tuple(1.0 / (len(self.turns) * turns) for turns in self.turns)


def elastic_drive(drive: Drive) -> ElasticDrive:
    """The drive with effects that a design file as built holds: modulus, preload, friction of the rope.

    Raises ``ModelError`` where the model has no answer, ``MbcdmError`` where a part has no metal that carries the load.
    """
    rubs, train, built = axis_friction(drive), layout_of(drive).losses, drum_friction(drive)
    try:
        compliance = compliance_of(drive)
    except (NoFigureError, ValueError) as error:
        raise MbcdmError(f"{drive.name}: no elastic drive: {error}; 'mbcdm check' names the part") from None
    turns = tuple(body.turns_per_drum for body in layout_of(drive).routed.routes.inputs)
    play = input_play_rad(drive, motors_held=True)
    return ElasticDrive(
        stages=cable_stages(drive, inf if play > 0.0 else compliance.before_inputs_Nm_rad),
        turns=turns,
        compliance=compliance,
        motor=_motor(drive, train.motor_idle_Nm),
        gear_ratio=drive.reduction.ratio,
        gear_share=train.gear_share,
        drum_friction_Nm=max(rubs.drum_Nm + built.constant_Nm, 0.0),
        input_friction_Nm=rubs.inputs_Nm,
        payload_kg_m2=drive.loads.carried.about_axis_kg_m2,
        play_rad=play,
        built=built,
    )


def _motor(drive: Drive, friction_Nm: float) -> RobotMotor:
    motor, heat = drive.motor, motor_heat(drive.motor)
    known = motor.torque_constant_mNm_A is not None and motor.resistance_ohm is not None
    constant = _CONSTANT_NM_A if not known else float(motor.torque_constant_mNm_A or 0.0) * 1e-3
    return RobotMotor(
        inertia_kg_m2=motor.rotor_inertia_g_cm2 * 1e-7,
        constant_Nm_A=constant,
        resistance_ohm=float(motor.resistance_ohm or 0.0) if known else heat.loss_W_Nm2 * constant**2,
        peak_Nm=motor.peak_torque_mNm * 1e-3,
        friction_Nm=friction_Nm,
        voltage_V=drive.bus_voltage_V if known else None,
        heat_K_W=heat.winding_K_W + heat.housing_K_W * heat.mount,
        heat_J_K=heat.winding_J_K + heat.housing_J_K,
        copper_per_K=COPPER_PER_K,
        rated_at_C=RATED_AT_C,
        ambient_C=layout_of(drive).duty.ambient_C,
    )
