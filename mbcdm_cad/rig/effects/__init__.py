"""The effects that an experiment can contain; any number can act together.

Each effect is a block of the experiment file whose field ``effect`` names it. Its method ``apply(bench)`` changes the
bench and adds an entry to the truth.
"""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from mbcdm_cad.rig.effects.cables import (
    AnchorSlip,
    Creep,
    EccentricPulley,
    InputCreep,
    LandWear,
    Modulus,
    Preload,
    RadiusError,
    RopeFriction,
    RopeLay,
    StepClimb,
    StrandDamage,
    Temperature,
)
from mbcdm_cad.rig.effects.machine import (
    BearingFriction,
    BrakeStickSlip,
    EccentricEncoder,
    EncoderScale,
    EncoderSubdivision,
    GearheadLash,
    GearMesh,
    MotorCogging,
    SensorDelay,
    ShaftCompliance,
    SlowPart,
    ViscousDrag,
)

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
