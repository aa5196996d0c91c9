"""All effects, told apart in the experiment file by their ``effect`` field."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from mbcdm_cad.rig.effects.eccentric_pulley import EccentricPulley
from mbcdm_cad.rig.effects.modulus import Modulus
from mbcdm_cad.rig.effects.preload import Preload
from mbcdm_cad.rig.effects.rope_friction import RopeFriction

AnyEffect = Annotated[EccentricPulley | Modulus | Preload | RopeFriction, Field(discriminator="effect")]
