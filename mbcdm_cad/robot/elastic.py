"""A drive that gives and loses, for simulators: cables with their hysteresis, parts that give, motors, friction."""

from __future__ import annotations

from dataclasses import dataclass
from math import inf

from mbcdm_cad.design.drive import Drive
from mbcdm_cad.errors import MbcdmError
from mbcdm_cad.layouts.base import NoFigureError
from mbcdm_cad.layouts.lumped import Compliance, axis_friction, compliance_of
from mbcdm_cad.layouts.structure import input_play_rad
from mbcdm_cad.model.duty.heat import COPPER_PER_K, RATED_AT_C, motor_heat
from mbcdm_cad.robot.stage import CableStage, cable_stages

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


@dataclass(frozen=True)
class ElasticDrive:
    """All that a simulator needs besides masses and joints.

    ``turns``: of each input for one of the drum. ``drum_friction_Nm`` and ``input_friction_Nm`` at each axis, that of
    the motors apart; ``gear_share``: loss of a gearhead over the torque at its output, besides. ``payload_kg_m2``:
    inertia of the design's payload about the drum's axis. ``play_rad``: of each input, from one side to the other, by a
    belt or gear stage and by a servo's gears; where there is any, the stages are the cables alone, and what is before
    the inputs stands between motor and input, with the play.
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
    rubs, train = axis_friction(drive), drive.layout.losses
    try:
        compliance = compliance_of(drive)
    except (NoFigureError, ValueError) as error:
        raise MbcdmError(f"{drive.name}: no elastic drive: {error}; 'mbcdm check' names the part") from None
    turns = tuple(body.turns_per_drum for body in drive.layout.routed.routes.inputs)
    play = input_play_rad(drive, motors_held=True)
    return ElasticDrive(
        stages=cable_stages(drive, inf if play > 0.0 else compliance.before_inputs_Nm_rad),
        turns=turns,
        compliance=compliance,
        motor=_motor(drive, train.motor_idle_Nm),
        gear_ratio=drive.reduction.ratio,
        gear_share=train.gear_share,
        drum_friction_Nm=rubs.drum_Nm,
        input_friction_Nm=rubs.inputs_Nm,
        payload_kg_m2=drive.loads.carried.about_axis_kg_m2,
        play_rad=play,
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
        ambient_C=drive.layout.duty.ambient_C,
    )
