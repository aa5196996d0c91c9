"""Ratings of a design: peak torque at the drum by motor, cable strength, slack, slip; limits of the motor itself.

With equal preloads on unequal radii the two cables of an input leave a bias torque T_pre (r_2 - r_1) on it, so the
limit differs by direction; preloads with T ~ 1/r within a pair remove the bias.

A motor is a DC machine between two terminals (K torque constant, R resistance, V bus voltage, I current):

    torque      M = K I                 copper loss   P = R I^2 = R (M / K)^2
    speed       w <= (V - R I) / K      no load       w_0 = V / K

A sinusoidal drive has the same copper loss for the same torque; inductance, iron losses and friction are left out, so
that the speed at high load is an upper bound.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from mbcdm_cad.design.drive import Drive
from mbcdm_cad.model.equilibrium import Equilibrium, solve_equilibrium, solve_weighted
from mbcdm_cad.model.losses import Train
from mbcdm_cad.model.si import GPA, MM, MM2, DriveSI, ModelError
from mbcdm_cad.routes import Floats
from mbcdm_cad.routes.route import RoutedDrive

# Names of the ratings in `Analysis.limits`.
MOTOR, MOTOR_LOSSY, GEARHEAD, GEARHEAD_PEAK = "motor", "motor_with_losses", "gearhead_rated", "gearhead_maximum"
MOTOR_ALONE, MOTOR_ALONE_PEAK = "motor_alone", "motor_alone_peak"


class Modelled(Protocol):
    """What the model's figures follow from: a layout is one, with the drive in SI, its losses and its wraps."""

    @property
    def drive(self) -> Drive: ...
    @property
    def routed(self) -> RoutedDrive: ...
    @property
    def si(self) -> DriveSI: ...
    @property
    def losses(self) -> Train: ...
    @property
    def softer_ends(self) -> float: ...
    @property
    def wraps_at_ends_rad(self) -> tuple[Mapping[str, NDArray[np.float64]], ...]: ...


@dataclass(frozen=True)
class Requirements:
    """Requirements on the designs; each is one number, or one value for each design."""

    load_Nm: Any
    half_travel_rad: Any
    input_rating_Nm: Any
    rope_diameter_m: Any
    tension_limit_N: Any
    helix_lead_m: Any


def input_ratings_Nm(drive: Drive) -> dict[str, float]:
    """Torque limits of one input without losses, N m: motor through the gearhead; the gearhead's own.

    Without a gearhead: the motor's continuous torque, and that at its peak current.
    """
    if drive.gearhead.absent:
        return {
            MOTOR_ALONE: drive.motor.rated_torque_mNm * 1e-3 * drive.reduction.ratio,
            MOTOR_ALONE_PEAK: drive.motor.peak_torque_mNm * 1e-3 * drive.reduction.ratio,
        }
    return {
        MOTOR: drive.motor.rated_torque_mNm * 1e-3 * drive.reduction.ratio,
        GEARHEAD: drive.reduction.rated_torque_mNm * 1e-3,
        GEARHEAD_PEAK: drive.reduction.max_torque_mNm * 1e-3,
    }


def motor_rating(drive: Drive) -> str:
    """Name of the motor's continuous rating without losses."""
    return MOTOR_ALONE if drive.gearhead.absent else MOTOR


def motor_input_Nm(design: Modelled) -> float:
    """Torque at an input by the motor's continuous rating, with the losses that ``limits.losses`` counts."""
    drive = design.drive
    if drive.limits.counts_losses:
        losses = design.losses
        return losses.rating_Nm(losses.output_Nm(drive.motor.rated_torque_mNm * 1e-3))
    return input_ratings_Nm(drive)[motor_rating(drive)]


def tension_limit_N(drive: Drive) -> float:
    """Largest tension allowed: breaking load over the safety factor."""
    return drive.cable.breaking_load_N / drive.limits.tension_safety_factor


def requirements(design: Modelled) -> Requirements:
    """Requirements of the design in SI: test torque, travel, rating of an input, rope."""
    drive = design.drive
    return Requirements(
        load_Nm=drive.loads.test_torque_Nm,
        half_travel_rad=np.radians(drive.half_travel_deg),
        input_rating_Nm=motor_input_Nm(design),
        rope_diameter_m=drive.cable.diameter_mm * MM,
        tension_limit_N=tension_limit_N(drive),
        helix_lead_m=drive.helix_lead_mm * MM,
    )


def sigmas_si(design: Modelled) -> dict[str, Any]:
    """Standard deviations that the design file gives, in SI, named as :mod:`mbcdm_cad.model.sensitivity` wants them.

    Those that are 0 throughout are left out: an empty dict means that no value of the file carries a sigma.
    """
    drive, s = design.drive, design.drive.sigmas
    given: dict[str, Any] = {"preload_N": np.array(s.preload_N)}
    geometry = design.si.geometry
    for name in (*geometry.per_cable, *(v.name for v in geometry.varied)):
        # A length without a sigma in the design file counts as exact.
        given[name] = np.array(s.lengths_mm.get(name.removesuffix("_m") + "_mm", 0.0)) * MM
    given |= {
        "friction_coefficient": s.friction_coefficient,
        "modulus_Pa": s.modulus_GPa * GPA,
        "area_m2": s.area_mm2 * MM2,
        "load_Nm": s.test_torque_Nm,
        "input_rating_Nm": s.motor_torque_mNm / drive.motor.rated_torque_mNm * motor_input_Nm(design),
    }
    return {name: size for name, size in given.items() if np.any(np.asarray(size))}


# Name of the limit in `Analysis.limits`.
SLIP = "slip"
# A cable under this share of its preload counts as slack: it leaves its land (estimate).
SLACK_SHARE = 0.01
# Live wraps at one pose, by their names in `DriveSI`.
Wraps = Mapping[str, Any]
# With e^(mu theta) above this no drive reaches the slip limit.
_LARGEST_EXPONENT = 30.0


def input_bias_Nm(d: DriveSI) -> Floats:
    """Torque on each input from the preload alone, at no load, shape (n_inputs, *batch)."""
    return solve_equilibrium(d, 0.0).input_torque_Nm(d)


def balanced_preload_N(d: DriveSI) -> Floats:
    """Preloads with T ~ 1/r_i within each pair and the same mean per pair: no bias on any input."""
    inverse = 1.0 / d.input_radius_m
    preload = np.broadcast_to(d.preload_N, inverse.shape)
    scaled = np.empty_like(inverse)
    for i in range(d.n_inputs):
        pair = [j for j, k in enumerate(d.input_of) if k == i]
        scaled[pair] = inverse[pair] * preload[pair].mean(axis=0) / inverse[pair].mean(axis=0)
    return np.asarray(scaled)


def _load_of(d: DriveSI, at: Equilibrium) -> Floats:
    return np.asarray(np.einsum("j...,j...->...", d.column(d.sigma, at.tension_N.ndim) * d.drum_radius_m, at.tension_N))


def torque_at_input_limit_Nm(d: DriveSI, limit_Nm: Floats | float, direction: int) -> Floats:
    """Load (N m, >= 0, shape (n_inputs, *batch)) at which each input reaches ``limit_Nm`` in ``direction`` (+1 or -1).

    +1 is a load that opposes positive rotation of the drum. Zero where the bias alone reaches the limit.
    """
    limit = np.asarray(limit_Nm, dtype=float)
    shape = (d.n_inputs, *np.broadcast_shapes(limit.shape, d.batch_shape))
    wide, bias = d.lifted(shape), input_bias_Nm(d)
    pulled = np.stack([d.of_input(i) for i in range(d.n_inputs)], axis=1)
    weight = d.column(d.sigma[:, None] * pulled, 1 + len(shape)) * wide.input_radius_m
    load = direction * _load_of(wide, solve_weighted(wide, weight, np.broadcast_to(direction * limit, shape)))
    return np.where(
        direction * bias.reshape(d.n_inputs, *(1,) * (len(shape) - bias.ndim), *bias.shape[1:]) >= limit, 0.0, load
    )


def torque_at_tension_limit_Nm(d: DriveSI, tension_N: Floats | float, direction: int) -> Floats:
    """Load (N m) at which each cable that ``direction`` tightens reaches ``tension_N``; inf for the others."""
    return _load_at_tensions_Nm(d, d.sigma == direction, np.asarray(tension_N, dtype=float), direction)


def _load_at_tensions_Nm(d: DriveSI, which: NDArray[np.bool_], tension_N: Floats, direction: int) -> Floats:
    """Load (N m, >= 0, (n_cables, *batch)) at which each cable of ``which`` (n_cables,) has its tension.

    inf for others. ``tension_N`` broadcasts to (number of these cables, *batch). All are solved at once.
    """
    cables = np.flatnonzero(which)
    shape = (len(cables), *d.batch_shape)
    wide = d.lifted(shape)
    sigma = d.sigma[cables].reshape(-1, *(1,) * len(d.batch_shape))
    weight = d.column(np.eye(d.n_cables)[:, cables] * d.sigma[cables], 1 + len(shape))
    at = solve_weighted(wide, weight, np.broadcast_to(sigma * tension_N, shape))
    found = np.full((d.n_cables, *d.batch_shape), np.inf)
    found[cables] = np.maximum(direction * _load_of(wide, at), 0.0)
    return found


def torque_at_slack_Nm(d: DriveSI, direction: int, ends: Sequence[Wraps] = ()) -> Floats:
    """Load (N m, >= 0) at which each cable that ``direction`` slackens has a hundredth of its preload left.

    inf for the others. ``ends``: the wraps that are there at the poses that count, usually both ends of the travel; the
    lowest load of them is taken. Without them wraps have no end.
    """
    found = []
    for pose in _poses(d, ends):
        slackens = pose.sigma != direction
        preload = np.broadcast_to(pose.preload_N, (pose.n_cables, *pose.batch_shape))[slackens]
        found.append(_load_at_tensions_Nm(pose, slackens, SLACK_SHARE * preload, direction))
    return np.asarray(np.min(found, axis=0))


def _poses(d: DriveSI, ends: Sequence[Wraps]) -> list[DriveSI]:
    return [d.with_(**wraps) for wraps in ends] or [d]


def slip_weight(d: DriveSI, index: int, direction: int | NDArray[np.int_]) -> Floats:
    """Weights w (n_cables, *batch) with sum w_j T_j = 0 where cable ``index`` begins to slip on its input.

    Over a wrap angle theta friction holds at most T_h = T_l e^(mu theta) (capstan equation of Euler and Eytelwein).
    With equal linear sides this is a difference of 2 T_pre tanh(mu theta/2). Raises ``ModelError`` where the cables are
    anchored.
    """
    if d.through_wrap_rad is None:
        raise ModelError("cables are anchored on their inputs: none slips there")
    ndim = 1 + len(d.batch_shape)
    ratio = np.exp(np.minimum(d.friction_coefficient * d.through_wrap_rad[index], _LARGEST_EXPONENT))
    own = d.column(d.sigma * np.isin(np.arange(d.n_cables), d.through_sides[index]), ndim)
    return np.asarray(own * np.where(own * direction > 0.0, 1.0, ratio))


def torque_at_slip_of_Nm(d: DriveSI, index: int, direction: int | NDArray[np.int_]) -> Floats:
    """Load (N m, shape (*batch)) at which cable ``index`` begins to slip on its input.

    ``direction``: one for all designs of the batch, or one for each.
    """
    at = solve_weighted(d, slip_weight(d, index, direction), np.zeros(d.batch_shape))
    return np.maximum(direction * _load_of(d, at), 0.0)


def torque_at_slip_Nm(d: DriveSI, direction: int, ends: Sequence[Wraps] = ()) -> Floats:
    """Load (N m, shape (n, *batch)) at which each cable that friction alone holds begins to slip on its input.

    ``ends``: as in :func:`torque_at_slack_Nm`. A short wrap stretches less, so that the slackened side loses more
    tension.
    """
    found = [
        [torque_at_slip_of_Nm(pose, i, direction) for i in range(len(d.through_sides))] for pose in _poses(d, ends)
    ]
    return np.asarray(np.min(found, axis=0))


# Loads (n_inputs,) that the inputs move in a direction.
Raised = Callable[[int], Floats]


@dataclass(frozen=True)
class TorqueLimit:
    """One limit of the drum's torque in one direction: which part reaches it first, and at which load."""

    cause: str
    limiting: str
    direction: int
    torque_Nm: float


def torque_limits(
    d: DriveSI,
    input_ratings_Nm: dict[str, float],
    tension_limit_N: float,
    raised: Mapping[str, Raised] | None = None,
    ends: Sequence[Wraps] = (),
) -> tuple[TorqueLimit, ...]:
    """Every limit both ways for one design, +1 first: one per rating (by its name), ``strength`` and ``slack``.

    ``slip`` too, where friction alone holds a cable on an input; ``ends``: see :func:`torque_at_slack_Nm`.
    ``raised`` adds limits with all losses counted, by name: functions that give for a direction the loads that each
    input moves.
    """
    found = []
    for direction in (1, -1):
        at_inputs = {cause: torque_at_input_limit_Nm(d, r, direction) for cause, r in input_ratings_Nm.items()}
        at_inputs |= {cause: loads(direction) for cause, loads in (raised or {}).items()}
        for cause, loads in at_inputs.items():
            first = int(np.argmin(loads))
            found.append(TorqueLimit(cause, d.input_names[first], direction, float(loads[first])))
        for cause, loads in (
            ("strength", torque_at_tension_limit_Nm(d, tension_limit_N, direction)),
            ("slack", torque_at_slack_Nm(d, direction, ends)),
        ):
            first = int(np.argmin(loads))
            name = d.cable_names[first] if np.isfinite(loads[first]) else "none"
            found.append(TorqueLimit(cause, name, direction, float(loads[first])))
        if d.through_wrap_rad is not None:
            loads = torque_at_slip_Nm(d, direction, ends)
            first = int(np.argmin(loads))
            found.append(TorqueLimit(SLIP, d.through_names[first], direction, float(loads[first])))
    return tuple(found)


def torque_to_weight_Nm_kg(torque_Nm: float, mass_g: float) -> float:
    """Torque over mass in N m/kg."""
    return torque_Nm / (mass_g * 1e-3)


# Largest number of points of torque over speed, including those at which the voltage begins to limit a torque.
CURVE_POINTS = 9


@dataclass(frozen=True)
class SpeedPoint:
    """Torque (N m) that the drum holds in both directions at one speed: continuously, and for a short time."""

    drum_speed_deg_s: float
    continuous_Nm: float
    peak_Nm: float


@dataclass(frozen=True)
class MotorFigures:
    """Figures of one motor of the drive, and of the drum that all inputs turn together.

    Losses are those of one motor. ``at_peak_load_*``: at the required peak torque of the design, the input that
    carries most of it. ``reflected_inertia_kg_m2``: of all rotors, at the drum.
    """

    bus_voltage_V: float
    continuous_torque_mNm: float
    peak_torque_mNm: float
    continuous_loss_W: float
    peak_loss_W: float
    no_load_speed_rad_s: float
    drum_no_load_speed_deg_s: float
    at_peak_load_torque_mNm: float
    at_peak_load_current_A: float
    at_peak_load_loss_W: float
    at_peak_load_drum_speed_deg_s: float
    reflected_inertia_kg_m2: float
    curve: tuple[SpeedPoint, ...]


def motor_figures(design: Modelled, d: DriveSI, peak_input_Nm: float, cap_Nm: float) -> MotorFigures | None:
    """The figures; None where the catalogue holds no electrical values of the motor.

    ``peak_input_Nm``: torque of the input that carries most at the design's peak torque. ``cap_Nm``: limit of the
    torque at the drum from other causes than the motors (strength, slack, slip, gearhead).
    """
    drive = design.drive
    motor, gear, volts = drive.motor, drive.reduction, drive.bus_voltage_V
    constant_mNm_A, ohms = motor.torque_constant_mNm_A, motor.resistance_ohm
    if constant_mNm_A is None or ohms is None or volts is None:
        return None
    constant = constant_mNm_A * 1e-3
    turns = float(np.abs(d.input_turns).max()) * gear.ratio  # of the motor, per turn of the drum
    train = design.losses.with_drive(d)
    rated, peak = motor.rated_torque_mNm * 1e-3, motor.peak_torque_mNm * 1e-3

    def loss_W(torque_Nm: float) -> float:
        return ohms * (torque_Nm / constant) ** 2

    def speed_rad_s(torque_Nm: float) -> float:
        return max(volts - ohms * torque_Nm / constant, 0.0) / constant

    def held_Nm(speeds_rad_s: Floats, most_Nm: float) -> list[float]:
        """Torque at the drum, weaker direction and input, with ``most_Nm`` limited by the voltage at each speed."""
        left = np.maximum(volts - constant * speeds_rad_s, 0.0) * constant / ohms
        given, most = np.minimum(left, most_Nm), gear.max_torque_mNm * 1e-3
        if drive.limits.counts_losses:
            limit = np.minimum(train.output_Nm(given), most)
            ways = [train.raised_Nm(limit, way).min(axis=0) for way in (1, -1)]
        else:
            limit, many = np.minimum(given * gear.ratio, most), d.spread(len(speeds_rad_s))
            ways = [torque_at_input_limit_Nm(many, limit, way).min(axis=0) for way in (1, -1)]
        return [min(float(torque), cap_Nm) for torque in np.minimum(*ways)]

    no_load, asked = volts / constant, peak_input_Nm / gear.ratio
    if drive.limits.counts_losses:
        peak_load = drive.loads.peak_torque_Nm
        # At the shaft, as the catalogue's torques are: the motor's own friction is in none of them.
        asked = float(train.moving(np.array([peak_load, -peak_load]), 1).motor_Nm.max()) - train.motor_idle_Nm
    to_drum = float(np.degrees(1.0 / turns))
    corners = (speed_rad_s(rated), speed_rad_s(peak))
    speeds = np.unique([*np.linspace(0.0, no_load, CURVE_POINTS - len(corners)), *corners])
    return MotorFigures(
        bus_voltage_V=volts,
        continuous_torque_mNm=rated * 1e3,
        peak_torque_mNm=peak * 1e3,
        continuous_loss_W=loss_W(rated),
        peak_loss_W=loss_W(peak),
        no_load_speed_rad_s=no_load,
        drum_no_load_speed_deg_s=no_load * to_drum,
        at_peak_load_torque_mNm=asked * 1e3,
        at_peak_load_current_A=asked / constant,
        at_peak_load_loss_W=loss_W(asked),
        at_peak_load_drum_speed_deg_s=speed_rad_s(asked) * to_drum,
        reflected_inertia_kg_m2=float(drive.rotor_at_input_kg_m2 * (np.asarray(d.input_turns) ** 2).sum()),
        curve=tuple(
            SpeedPoint(float(speed) * to_drum, continuous, moment)
            for speed, continuous, moment in zip(speeds, held_Nm(speeds, rated), held_Nm(speeds, peak), strict=True)
        ),
    )
