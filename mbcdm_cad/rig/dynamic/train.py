"""The dynamic rig as data: moments of inertia, position loop, motor and gearhead of each input, load.

The motor: rotor, torque limit, current loop, friction and cogging.

    J theta'' = tau - c sign(theta') - b theta' + t sin(n theta + phase) - gearhead
    tau' = (command held within the limit - tau) 2 pi f

``f`` is the bandwidth of the current loop. Figures that the design file does not hold are estimates for a DC motor of
15 mm: friction 0.1 mN m (3 % of the rated torque), current loop 500 Hz.

The gearhead: ratio, torsional stiffness, lash, mesh error, drag and a loss that grows with the torque carried. With the
rotor's angle reflected to the output (phi = theta_motor / ratio) and the pulley at p, the shaft carries

    s = k dz(u),  u = phi + e sin(n ratio phi) - p,  dz(u) = u less half the lash, 0 within it

and the rotor feels s du/dphi, so that an error in the mesh is a torque ripple too (virtual work). The loss is Coulomb
friction at the rotor of capacity drag + (1/efficiency - 1) |s|: driven forward the output is efficiency x input; driven
backward the motor has to hold (2 - 1/efficiency) of the load; at an efficiency of 0.5 or less it is self-locking.

The load: an inertia, a brake that can stick, a torque motor without a control loop.

At the input the rotor counts with the square of the gearhead's ratio, which is far more than the pulleys. SI
throughout; inputs are positive when they drive the drum positive, a load torque when it opposes positive rotation.
"""

from dataclasses import dataclass, field
from math import exp, pi, radians

import numpy as np
from scipy.signal.windows import tukey

from mbcdm_cad.design.drive import Drive
from mbcdm_cad.layouts.base import NoFigureError
from mbcdm_cad.layouts.lumped import Compliance, PartsFriction
from mbcdm_cad.layouts.registry import layout_of
from mbcdm_cad.rig.bench import PathOf, RigCable, cables_of, routes_of
from mbcdm_cad.rig.chain import PIECE_RAD
from mbcdm_cad.routes import Floats
from mbcdm_cad.routes.route import DriveRoutes
from mbcdm_cad.storage.compiled import compiled

_G_CM2 = 1e-7  # kg m2


def require_positive(spec: object, *names: str) -> None:
    """Raise ``ValueError`` for a figure of ``spec`` that is not above 0."""
    for name in names:
        if not getattr(spec, name) > 0.0:
            raise ValueError(f"{name} is {getattr(spec, name)}; give it > 0")


def require_not_negative(spec: object, *names: str) -> None:
    """Raise ``ValueError`` for a figure of ``spec`` that is below 0."""
    for name in names:
        if not getattr(spec, name) >= 0.0:
            raise ValueError(f"{name} is {getattr(spec, name)}; give it >= 0")


@dataclass(frozen=True)
class MotorSpec:
    """One motor, at its own shaft. ``cogging_per_turn`` counts periods in a turn of the motor."""

    rotor_inertia_kg_m2: float
    torque_limit_Nm: float
    coulomb_Nm: float = 1e-4
    viscous_Nms: float = 1e-8
    current_bandwidth_Hz: float = 500.0
    cogging_Nm: float = 0.0
    cogging_per_turn: float = 1.0
    cogging_phase_rad: float = 0.0

    def __post_init__(self) -> None:
        require_positive(self, "rotor_inertia_kg_m2", "torque_limit_Nm", "current_bandwidth_Hz")
        require_not_negative(self, "coulomb_Nm", "viscous_Nms")


def motor_of(drive: Drive) -> MotorSpec:
    """The design's motor, limited to its rated torque, as in the paper's calculation of the driving capability."""
    motor = drive.motor
    return MotorSpec(motor.rotor_inertia_g_cm2 * _G_CM2, motor.rated_torque_mNm * 1e-3)


@dataclass(frozen=True)
class GearheadSpec:
    """One gearhead, seen at its output.

    ``stiffness_Nm_rad`` is an estimate: a 3 x 10 mm shaft has 64 N m/rad, and the gear train is assumed to be as soft.
    ``mesh_per_motor_turn`` counts periods of the mesh error ``mesh_error_rad`` (at the output) in a turn of the motor.
    """

    ratio: float
    efficiency: float = 1.0
    drag_Nm: float = 0.0
    stiffness_Nm_rad: float = 30.0
    lash_rad: float = 0.0
    mesh_error_rad: float = 0.0
    mesh_per_motor_turn: float = 1.0

    def __post_init__(self) -> None:
        if not 0.0 < self.efficiency <= 1.0:
            raise ValueError(f"efficiency is {self.efficiency}; give it above 0 and not above 1")
        require_positive(self, "ratio", "stiffness_Nm_rad")
        require_not_negative(self, "drag_Nm", "lash_rad")

    @property
    def loss_share(self) -> float:
        """Friction per torque carried, 1/efficiency - 1."""
        return 1.0 / self.efficiency - 1.0


def gearhead_of(drive: Drive, ideal: bool = False) -> GearheadSpec:
    """The design's gearhead; ``ideal`` makes it lossless, as in the paper's calculation of the driving capability."""
    ratio, efficiency = drive.reduction.ratio, 1.0 if ideal else drive.reduction.efficiency
    if drive.servo is None:
        return GearheadSpec(ratio, efficiency)
    servo = drive.servo
    return GearheadSpec(
        ratio, efficiency, stiffness_Nm_rad=servo.stiffness_Nm_rad, lash_rad=0.0 if ideal else radians(servo.lash_deg)
    )


@compiled
def shaft_torque(twist_rad: float, lash_rad: float, stiffness_Nm_rad: float) -> tuple[float, float]:
    """Torque carried, N m, and its slope, N m/rad: a spring with a dead zone of ``lash_rad`` in all."""
    half = 0.5 * lash_rad
    if twist_rad > half:
        return stiffness_Nm_rad * (twist_rad - half), stiffness_Nm_rad
    if twist_rad < -half:
        return stiffness_Nm_rad * (twist_rad + half), stiffness_Nm_rad
    return 0.0, 0.0


@dataclass(frozen=True)
class LoadSpec:
    """The load's constants, SI, about the drum's axis.

    A brake of level c holds c (1 + (static_ratio - 1) exp(-(speed/static_speed)^2)): with a ratio above 1 it can stick
    and slip. ``unbalance_Nm`` is the moment of the weight of an inertia plate,
    M = unbalance sin(angle + unbalance_angle). ``bearing_drag_Nm`` is friction that the torque sensor does not see;
    ``bearing_stribeck_Nm`` exp(-|speed|/``bearing_stribeck_rad_s``) and shares of the torque carried are added to it.
    """

    inertia_kg_m2: float = 0.0
    static_ratio: float = 1.0
    static_speed_rad_s: float = 1e-3
    unbalance_Nm: float = 0.0
    unbalance_angle_rad: float = 0.0
    bearing_drag_Nm: float = 0.0
    bearing_viscous_Nms: float = 0.0
    bearing_stribeck_Nm: float = 0.0
    bearing_stribeck_rad_s: float = 1.0
    bearing_driving_share: float = 0.0
    bearing_driven_share: float = 0.0

    def __post_init__(self) -> None:
        require_not_negative(self, "inertia_kg_m2", "bearing_drag_Nm", "bearing_viscous_Nms", "bearing_stribeck_Nm")
        require_not_negative(self, "bearing_driving_share", "bearing_driven_share")
        if not self.static_ratio >= 1.0:
            raise ValueError(f"static_ratio is {self.static_ratio}; give it >= 1")
        require_positive(self, "static_speed_rad_s", "bearing_stribeck_rad_s")


# Share of a chirp in which it fades in, and out.
FADE_SHARE = 0.02


def standstill(duration_s: float, rate_Hz: float) -> Floats:
    """Hold zero; shape (n, 3)."""
    return np.zeros((round(duration_s * rate_Hz), 3))


def sine(amplitude_rad: float, frequency_Hz: float, cycles: float, rate_Hz: float) -> Floats:
    """A sine of the drum's angle, shape (n, 3). Its first quarter fades in, so that it starts from rest."""
    omega = 2.0 * pi * frequency_Hz
    time = np.arange(round(cycles / frequency_Hz * rate_Hz)) / rate_Hz
    rate = 4.0 * frequency_Hz
    x = np.clip(time * rate, 0.0, 1.0)
    fade = x**3 * (10.0 - 15.0 * x + 6.0 * x**2)
    fade_1 = rate * 30.0 * x**2 * (1.0 - x) ** 2
    fade_2 = rate**2 * 60.0 * x * (1.0 - x) * (1.0 - 2.0 * x)
    wave, wave_1 = amplitude_rad * np.sin(omega * time), amplitude_rad * omega * np.cos(omega * time)
    acceleration = -(omega**2) * wave * fade + 2.0 * wave_1 * fade_1 + wave * fade_2
    return np.stack([wave * fade, wave_1 * fade + wave * fade_1, acceleration], axis=1)


def chirp(acceleration_rad_s2: float, from_Hz: float, to_Hz: float, duration_s: float, rate_Hz: float) -> Floats:
    """A sweep of the drum's angle, (n, 3): its acceleration of one size, its frequency rising or falling evenly.

    It fades in and out over ``FADE_SHARE`` of the time each.
    """
    time = np.arange(round(duration_s * rate_Hz)) / rate_Hz
    phase = 2.0 * pi * (from_Hz + 0.5 * (to_Hz - from_Hz) * time / duration_s) * time
    wave = acceleration_rad_s2 * np.sin(phase) * tukey(time.size, 2.0 * FADE_SHARE)
    rate = 2j * pi * np.fft.rfftfreq(time.size, 1.0 / rate_Hz)
    # Nothing below the sweep: an angle that wanders off would be integrated from the fades.
    spectrum = np.where(np.abs(rate) > pi * min(from_Hz, to_Hz), np.fft.rfft(wave), 0.0)
    rate[0] = 1.0
    return np.stack([np.fft.irfft(spectrum / rate**k, time.size) for k in (2, 1, 0)], axis=1)


# Columns of a row of gains.
POSITION, VELOCITY, INTEGRAL, ACCELERATION, FILTER, PERIOD, LIMIT = range(7)
# Columns of a row of states.
SUM, LAST, SPEED = range(3)
STATES = 3


@dataclass(frozen=True)
class ControllerSpec:
    """A position loop. ``inertia_kg_m2`` is the total inertia that the input moves, reflected to the input."""

    inertia_kg_m2: float
    torque_limit_Nm: float
    bandwidth_Hz: float = 5.0
    rate_Hz: float = 1000.0
    velocity_filter_Hz: float = 100.0

    def __post_init__(self) -> None:
        require_positive(self, "inertia_kg_m2", "torque_limit_Nm", "bandwidth_Hz", "rate_Hz", "velocity_filter_Hz")
        if self.bandwidth_Hz * 20.0 > self.rate_Hz:
            raise ValueError(f"bandwidth_Hz {self.bandwidth_Hz} needs a rate_Hz of 20 times that, got {self.rate_Hz}")

    def gains(self) -> tuple[float, ...]:
        """A row of gains for :func:`control`."""
        p = 2.0 * pi * self.bandwidth_Hz
        w = 3.0 * p
        keep = exp(-2.0 * pi * self.velocity_filter_Hz / self.rate_Hz)
        J = self.inertia_kg_m2
        return (p, 2.0 * w * J, w * w * J, J, keep, 1.0 / self.rate_Hz, self.torque_limit_Nm)


@compiled
def control(gains: Floats, state: Floats, reference: Floats, measured: float) -> float:
    """Torque command at the input, N m, within the limit; ``reference`` is (angle, speed, acceleration)."""
    period = gains[PERIOD]
    raw = (measured - state[LAST]) / period
    state[LAST] = measured
    state[SPEED] = gains[FILTER] * state[SPEED] + (1.0 - gains[FILTER]) * raw
    error = reference[1] + gains[POSITION] * (reference[0] - measured) - state[SPEED]
    change = gains[INTEGRAL] * period * error
    command = gains[ACCELERATION] * reference[2] + gains[VELOCITY] * error + state[SUM] + change
    limit = gains[LIMIT]
    if command > limit:
        state[SUM] += min(change, 0.0)
        return float(limit)
    if command < -limit:
        state[SUM] += max(change, 0.0)
        return float(-limit)
    state[SUM] += change
    return float(command)


_G_CM2 = 1e-7  # kg m2


@dataclass(frozen=True)
class Inertias:
    """Moments of inertia in kg m2, each about its own axis; the rotor's is not reflected through the gearhead."""

    rotor_kg_m2: float
    gear_ratio: float
    bodies_kg_m2: dict[str, float]
    routes: DriveRoutes

    @property
    def inputs_kg_m2(self) -> tuple[float, ...]:
        """Inertia that each input turns on its side of the gearhead."""
        return tuple(self.bodies_kg_m2[body.name] for body in self.routes.inputs)

    @property
    def drum_and_passed_kg_m2(self) -> float:
        """The drum and all bodies that the cables turn with it, reflected to the drum."""
        total = self.bodies_kg_m2[self.routes.drum.name]
        for body in self.routes.passed:
            total += self.bodies_kg_m2[body.name] * body.turns_per_drum**2
        return total


def inertias(drive: Drive) -> Inertias:
    """Inertias of the moving parts of ``drive``. Raises ValueError where they have no form."""
    rotor = drive.motor.rotor_inertia_g_cm2 * _G_CM2
    try:
        bodies = dict(layout_of(drive).inertias_kg_m2)
    except NoFigureError as error:
        raise ValueError(str(error)) from None
    return Inertias(rotor, drive.reduction.ratio, bodies, routes_of(drive))


STEP_S = 1e-4
BANDWIDTH_HZ = 5.0
LOOP_RATE_HZ = 1000.0
# Resolution of encoder B of the paper's rig, 18000 lines times 256 [section 5].
DRUM_RESOLUTION_RAD = 1.3635e-6


@dataclass(frozen=True)
class EncoderSpec:
    """An encoder: resolution, white noise before counting, and delay of its readings."""

    resolution_rad: float
    noise_rad: float = 0.0
    delay_s: float = 0.0

    def __post_init__(self) -> None:
        require_not_negative(self, "resolution_rad", "noise_rad", "delay_s")


@dataclass(frozen=True)
class DynamicRig:
    """A drive on the bench: a motor, gearhead, loop and encoder for each input, in the order of the drive's inputs.

    ``cables`` are as built, ``paths`` give their extra length as a function of the angles, as of an eccentric pulley;
    ``piece_rad``, ``transport`` and ``passed_slip`` as in :func:`mbcdm_cad.rig.chain.chains`. Drags are Coulomb
    friction in bearings, each at its own shaft. ``compliance`` and ``friction`` are those of the parts besides the
    cables; as they stand, all parts are rigid and only motors and gearheads lose.
    """

    drive: Drive
    cables: tuple[RigCable, ...]
    motors: tuple[MotorSpec, ...]
    gearheads: tuple[GearheadSpec, ...]
    loops: tuple[ControllerSpec, ...]
    encoders: tuple[EncoderSpec, ...]
    drum_encoder: EncoderSpec = field(default_factory=lambda: EncoderSpec(DRUM_RESOLUTION_RAD))
    load: LoadSpec = field(default_factory=LoadSpec)
    torque_noise_Nm: float = 0.005
    input_drag_Nm: float = 0.0
    passed_drag_Nm: float = 0.0
    step_s: float = STEP_S
    piece_rad: float = PIECE_RAD
    transport: bool = True
    passed_slip: bool = False
    paths: tuple[PathOf, ...] = ()
    compliance: Compliance = field(default_factory=Compliance)
    friction: PartsFriction | None = None


def rig_of(
    drive: Drive,
    load: LoadSpec | None = None,
    ideal_gearhead: bool = False,
    bandwidth_Hz: float = BANDWIDTH_HZ,
    rate_Hz: float = LOOP_RATE_HZ,
) -> DynamicRig:
    """The rig with the design's motors, gearheads and encoders; the loops are tuned to the inertia of each input."""
    load = load or LoadSpec()
    motor, gearhead = motor_of(drive), gearhead_of(drive, ideal_gearhead)
    moved = inertias(drive)
    n_inputs = len(drive.input_names)
    share = (moved.drum_and_passed_kg_m2 + load.inertia_kg_m2) / n_inputs
    turns = input_turns(drive)
    loops = tuple(
        ControllerSpec(
            moved.rotor_kg_m2 * gearhead.ratio**2 + moved.inputs_kg_m2[i] + share / turns[i] ** 2,
            motor.torque_limit_Nm * gearhead.ratio,
            bandwidth_Hz,
            rate_Hz,
        )
        for i in range(n_inputs)
    )
    encoder = EncoderSpec(drive.encoder.resolution_urad * 1e-6)
    return DynamicRig(
        drive, cables_of(drive), (motor,) * n_inputs, (gearhead,) * n_inputs, loops, (encoder,) * n_inputs, load=load
    )


def input_turns(drive: Drive) -> tuple[float, ...]:
    """Turns of each input for one of the drum: the mean over its cables."""
    return tuple(body.turns_per_drum for body in routes_of(drive).inputs)
