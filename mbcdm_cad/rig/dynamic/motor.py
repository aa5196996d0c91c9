"""The motor: rotor, torque limit, current loop, friction and cogging.

    J theta'' = tau - c sign(theta') - b theta' + t sin(n theta + phase) - gearhead
    tau' = (command held within the limit - tau) 2 pi f

``f`` is the bandwidth of the current loop. Figures that the design file does not hold are estimates for a DC motor of
15 mm: friction 0.1 mN m (3 % of the rated torque), current loop 500 Hz.
"""

from __future__ import annotations

from dataclasses import dataclass

from mbcdm_cad.design.drive import Drive

_G_CM2 = 1e-7  # kg m2


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
        for name in ("rotor_inertia_kg_m2", "torque_limit_Nm", "current_bandwidth_Hz"):
            if not getattr(self, name) > 0.0:
                raise ValueError(f"{name} is {getattr(self, name)}; give it > 0")
        for name in ("coulomb_Nm", "viscous_Nms"):
            if not getattr(self, name) >= 0.0:
                raise ValueError(f"{name} is {getattr(self, name)}; give it >= 0")


def motor_of(drive: Drive) -> MotorSpec:
    """The design's motor, limited to its rated torque, as in the paper's calculation of the driving capability."""
    motor = drive.motor
    return MotorSpec(motor.rotor_inertia_g_cm2 * _G_CM2, motor.rated_torque_mNm * 1e-3)
