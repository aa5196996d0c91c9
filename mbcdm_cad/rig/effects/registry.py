"""All effects of the rig; the field ``effect`` of the experiment file names one."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from mbcdm_cad.rig.effects.friction import BearingFriction, BrakeStickSlip, ViscousDrag
from mbcdm_cad.rig.effects.motor import GearheadLash, GearMesh, MotorCogging, ShaftCompliance, SlowPart
from mbcdm_cad.rig.effects.pulleys import EccentricPulley, InputCreep, LandWear, RadiusError, StepClimb
from mbcdm_cad.rig.effects.rope import (
    AnchorSlip,
    Creep,
    Modulus,
    Preload,
    RopeFriction,
    RopeLay,
    StrandDamage,
    Temperature,
)
from mbcdm_cad.rig.effects.sensors import EccentricEncoder, EncoderScale, EncoderSubdivision, SensorDelay

AnyEffect = Annotated[
    AnchorSlip
    | BearingFriction
    | BrakeStickSlip
    | Creep
    | EccentricEncoder
    | EccentricPulley
    | EncoderScale
    | EncoderSubdivision
    | GearMesh
    | GearheadLash
    | InputCreep
    | LandWear
    | Modulus
    | MotorCogging
    | Preload
    | RadiusError
    | RopeFriction
    | RopeLay
    | SensorDelay
    | ShaftCompliance
    | SlowPart
    | StepClimb
    | StrandDamage
    | Temperature
    | ViscousDrag,
    Field(discriminator="effect"),
]
