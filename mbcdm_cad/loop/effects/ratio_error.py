"""A wrong pitch radius or encoder scale: both have the same signature, proportional to the angle."""

from __future__ import annotations

from mbcdm_cad.loop.effect import Effect, Parameter
from mbcdm_cad.loop.prepare.prepared import Prepared
from mbcdm_cad.loop.prepare.setup import Setup, Simulator
from mbcdm_cad.model.si import DriveSI
from mbcdm_cad.routes import Floats


def _apply(setup: Setup, values: Floats, _: Simulator) -> Setup:
    return setup.with_added(values[0] * setup.drum_rad)


def offer(d: DriveSI | None, p: Prepared) -> list[Effect]:
    """Always."""
    return [
        Effect(
            "ratio_error",
            "pitch radius or encoder scale",
            "output over input differs from the declared ratio",
            "pitch radii of drum and input pulleys with a micrometer over the cable; counts per turn of the encoders",
            "a full turn of each encoder against a reference tells the scale from the radii",
            (Parameter("share", 1e-5, -0.5, 0.5),),
            _apply,
            plain="the ratio of output to inputs is {share} {way_share} than declared",
        )
    ]
