"""Modulus or free length of the rope, which scale the hysteresis loop; or a soft shaft, which adds no hysteresis."""

from dataclasses import replace

from mbcdm_cad.loop.effect import Effect, Effects, Parameter, Words
from mbcdm_cad.loop.prepare.setup import DriveSI, Floats, Prepared, Setup, Simulator

NAME = "stiffness_error"
# Starts of the fit: a rope's modulus may be far from its data sheet's.
STARTS = ([0.0], [-0.3], [0.5])
# No rope has a modulus below this share of the declared one.
LEAST_MODULUS = 0.5
SEPARATE = "load steps with the inputs locked: a series compliance is straight, the cables' loop is not"


def _modulus(setup: Setup, values: Floats, _: Simulator) -> Setup:
    d = setup.drive
    return replace(setup, d=d.with_(modulus_Pa=d.modulus_Pa * (1.0 + values[0])))


def _no_rope(values: Floats) -> str:
    """What to look for if the fitted modulus is too low for any rope; otherwise an empty text."""
    if values[0] >= LEAST_MODULUS - 1.0:
        return ""
    return (
        f"a modulus {-values[0]:.0%} below the declared one would fit, which no rope has: look for play "
        "before an input encoder, a slack cable, or a load torque of the wrong sign or unit"
    )


def offer(d: DriveSI | None, p: Prepared) -> Effects:
    """With torque; the modulus where the drive is known."""
    if p.load_Nm is None:
        return
    series = Effect(
        NAME,
        "compliance in series",
        "something between drum and torque sensor twists in proportion to load",
        "output shaft, hub clamp and coupling",
        SEPARATE,
        (Parameter("compliance_rad_Nm", 1e-6, 0.0),),
        lambda s, v, _: s.with_added(-v[0] * s.borne),
        plain="something between drum and torque sensor twists by {compliance_rad_Nm}",
    )
    if p.run.parts is not None and p.run.parts.give_rad_Nm:
        series = replace(
            series,
            physics="drum, shafts, bearings or frame give more than computed, or something behind them twists",
            where_to_look="screws of hub and frame, bearings, output shaft, hub clamp and coupling",
            parameters=(Parameter("compliance_rad_Nm", 1e-6, -p.run.parts.give_rad_Nm),),
            plain="the structure of the drive, or something behind it, gives {compliance_rad_Nm} more than computed",
            reversed_words=Words(
                "drum, shafts, bearings and frame give less than computed",
                "moduli and walls of the parts, against the design file",
                "the structure of the drive gives less than computed, by {compliance_rad_Nm}",
            ),
        )
    if d is not None:
        yield Effect(
            NAME,
            "modulus of the rope",
            "E A of the rope or its free length differs: the whole loop scales",
            "a pull test of the rope after bedding in",
            SEPARATE,
            (Parameter("share", 0.02, -0.8, 4.0),),
            _modulus,
            plain="the rope's stiffness is {share} {way_share} than the design file says",
            starts=lambda setup, residual: [list(start) for start in STARTS],
            doubtful=_no_rope,
        )
    yield series
