"""A wrong pitch radius or encoder scale: both have the same signature, proportional to the angle."""

from mbcdm_cad.loop.effect import Effect, Effects, Parameter
from mbcdm_cad.loop.prepare.setup import DriveSI, Prepared


def offer(d: DriveSI | None, p: Prepared) -> Effects:
    """Always."""
    yield Effect(
        "ratio_error",
        "pitch radius or encoder scale",
        "output over input differs from the declared ratio",
        "pitch radii of drum and input pulleys with a micrometer over the cable; counts per turn of the encoders",
        "a full turn of each encoder against a reference tells the scale from the radii",
        (Parameter("share", 1e-5, -0.5, 0.5),),
        lambda s, v, _: s.with_added(v[0] * s.drum_rad),
        plain="the ratio of output to inputs is {share} {way_share} than declared",
    )
