"""Cable wound on under load keeps its tension and brings it back when it is wound off."""

from dataclasses import replace

from mbcdm_cad.loop.effect import MOST_STRENGTH, Effect, Effects, Parameter
from mbcdm_cad.loop.prepare.setup import DriveSI, Prepared


def offer(d: DriveSI | None, p: Prepared) -> Effects:
    """With torque, where the drive is known."""
    if d is None or p.load_Nm is None:
        return
    yield Effect(
        "winding_history",
        "profiles move with the pulleys",
        "the tension profiles on the wraps travel with the pulleys; strength 1 is the whole effect",
        "no part of the bench: the paper's model leaves it out",
        "the same load at a shorter travel, or a bias load",
        (Parameter("strength", 0.5, 0.0, MOST_STRENGTH),),
        lambda s, v, _: replace(s, winding=s.winding + float(v[0])),
        plain="rope wound on under load keeps its tension and brings it back: {strength} times the full effect",
    )
