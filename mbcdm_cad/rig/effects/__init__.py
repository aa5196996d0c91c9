"""The effects that an experiment can contain; any number can act together.

Each effect is a block of the experiment file whose field ``effect`` names it. Its method ``apply(bench)`` changes the
bench and adds an entry to the truth.
"""

from typing import Annotated

from pydantic import Field

from mbcdm_cad.rig.effects import cables, machine

AnyEffect = Annotated[
    cables.AnchorSlip
    | machine.BearingFriction
    | machine.BrakeStickSlip
    | cables.Creep
    | machine.EccentricEncoder
    | cables.EccentricPulley
    | machine.EncoderScale
    | machine.EncoderSubdivision
    | machine.GearMesh
    | machine.GearheadLash
    | cables.InputCreep
    | cables.LandWear
    | cables.Modulus
    | machine.MotorCogging
    | cables.Preload
    | cables.RadiusError
    | cables.RopeFriction
    | cables.RopeLay
    | machine.SensorDelay
    | machine.ShaftCompliance
    | machine.SlowPart
    | cables.StepClimb
    | cables.StrandDamage
    | cables.Temperature
    | machine.ViscousDrag,
    Field(discriminator="effect"),
]
