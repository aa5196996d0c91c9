"""All effects of the rig; the field ``effect`` of the experiment file names one."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from mbcdm_cad.rig.effects.anchor_slip import AnchorSlip
from mbcdm_cad.rig.effects.bearing_friction import BearingFriction
from mbcdm_cad.rig.effects.brake_stick_slip import BrakeStickSlip
from mbcdm_cad.rig.effects.creep import Creep
from mbcdm_cad.rig.effects.eccentric_encoder import EccentricEncoder
from mbcdm_cad.rig.effects.eccentric_pulley import EccentricPulley
from mbcdm_cad.rig.effects.encoder_scale import EncoderScale
from mbcdm_cad.rig.effects.encoder_subdivision import EncoderSubdivision
from mbcdm_cad.rig.effects.gear_mesh import GearMesh
from mbcdm_cad.rig.effects.gearhead_lash import GearheadLash
from mbcdm_cad.rig.effects.input_creep import InputCreep
from mbcdm_cad.rig.effects.land_wear import LandWear
from mbcdm_cad.rig.effects.modulus import Modulus
from mbcdm_cad.rig.effects.motor_cogging import MotorCogging
from mbcdm_cad.rig.effects.preload import Preload
from mbcdm_cad.rig.effects.radius_error import RadiusError
from mbcdm_cad.rig.effects.rope_friction import RopeFriction
from mbcdm_cad.rig.effects.rope_lay import RopeLay
from mbcdm_cad.rig.effects.sensor_delay import SensorDelay
from mbcdm_cad.rig.effects.shaft_compliance import ShaftCompliance
from mbcdm_cad.rig.effects.step_climb import StepClimb
from mbcdm_cad.rig.effects.strand_damage import StrandDamage
from mbcdm_cad.rig.effects.temperature import Temperature
from mbcdm_cad.rig.effects.viscous_drag import ViscousDrag

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
    | StepClimb
    | StrandDamage
    | Temperature
    | ViscousDrag,
    Field(discriminator="effect"),
]
