"""What stands between a position loop and the drum: motor, gearhead, load.

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
"""

from __future__ import annotations

from dataclasses import dataclass
from math import radians

from mbcdm_cad.design.drive import Drive
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
