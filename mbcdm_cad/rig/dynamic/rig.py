"""The dynamic rig as data: the motors, gearheads, loops and sensors of a drive.

SI throughout; inputs are positive when they drive the drum positive, a load torque when it opposes positive rotation.
"""

from __future__ import annotations

from dataclasses import dataclass, field

from mbcdm_cad.design.drive import Drive
from mbcdm_cad.layouts.lumped import Compliance, PartsFriction
from mbcdm_cad.rig.bench import PathOf
from mbcdm_cad.rig.cables import RigCable, cables_of, routes_of
from mbcdm_cad.rig.chain import PIECE_RAD
from mbcdm_cad.rig.dynamic.controller import ControllerSpec
from mbcdm_cad.rig.dynamic.inertias import inertias
from mbcdm_cad.rig.dynamic.train import GearheadSpec, LoadSpec, MotorSpec, gearhead_of, motor_of, require_not_negative

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
