"""Modulus, free length, or a soft shaft: the loop scales, or a compliance in series adds no loop."""

from __future__ import annotations

from dataclasses import replace

from mbcdm_cad.identification.effect import Effect, Parameter
from mbcdm_cad.identification.prepared import Prepared
from mbcdm_cad.identification.setup import Setup, Simulator
from mbcdm_cad.measurement.run import Floats
from mbcdm_cad.model.si import DriveSI

NAME = "stiffness_error"
SEPARATE = "load steps with the inputs locked: a series compliance is straight, the cables' loop is not"


def _modulus(setup: Setup, values: Floats, _: Simulator) -> Setup:
    d = setup.drive
    return replace(setup, d=d.with_(modulus_Pa=d.modulus_Pa * (1.0 + values[0])))


def _series(setup: Setup, values: Floats, _: Simulator) -> Setup:
    return setup.with_added(-values[0] * setup.load)


def offer(d: DriveSI | None, p: Prepared) -> list[Effect]:
    """With torque; the modulus where the drive is known."""
    if p.load_Nm is None:
        return []
    series = Effect(
        NAME,
        "compliance in series",
        "something between drum and torque sensor twists in proportion to load",
        "output shaft, hub clamp and coupling",
        SEPARATE,
        (Parameter("compliance_rad_Nm", 1e-6),),
        _series,
        generic=True,
    )
    if d is None:
        return [series]
    modulus = Effect(
        NAME,
        "modulus of the rope",
        "E A of the rope or its free length differs: the whole loop scales",
        "a pull test of the rope after bedding in",
        SEPARATE,
        (Parameter("share", 0.02, -0.8, 4.0),),
        _modulus,
        generic=True,
    )
    return [modulus, series]
