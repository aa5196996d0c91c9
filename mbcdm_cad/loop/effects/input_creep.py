"""Creep of a cable that friction alone holds on its input: too large a travel carries the part that sticks off it.

In the declared model each side of the cable begins at an anchor on the input. Where the wrap is too short for the
travel, rope that was wound on with the tension of one side leaves on the other, as on a belt: under a load that keeps
its direction the drum moves further in every cycle. When this begins and how far it goes follows from the wrap
(:mod:`mbcdm_cad.model.profiles`).
"""

from dataclasses import replace
from math import degrees, pi

import numpy as np

from mbcdm_cad.loop.effect import MOST_STRENGTH, Effect, Effects, Figure, Parameter
from mbcdm_cad.loop.prepare.setup import DriveSI, Prepared

# First guesses of the wrap, shares of that of the design; a shorter one slips as a whole.
STARTS = (1.0, 0.8, 0.6, 0.4)
SHORTEST_RAD = pi
# With less rotation of the input no part of the cable that sticks leaves the wrap.
LEAST_TRAVEL_RAD = 1.0


def offer(d: DriveSI | None, p: Prepared) -> Effects:
    """With torque, for cables that run through over their inputs."""
    if d is None or p.load_Nm is None or d.through_wrap_rad is None or np.ptp(p.common_rad) < LEAST_TRAVEL_RAD:
        return
    wrap, strength = float(np.min(d.through_wrap_rad)), Parameter("strength", 0.2, 0.0, MOST_STRENGTH)
    yield Effect(
        "input_creep",
        "too little wrap for the travel",
        "the travel carries the part of the rope that sticks off the input, so that the cable creeps over it",
        "turns of the cable round the input, grease on them, preload",
        "the same load at a shorter travel, or with a turn more round the input: the drum stays where it is",
        (strength, Parameter("wrap_rad", 0.05, SHORTEST_RAD, 1.5 * wrap, role="place")),
        lambda s, v, _: replace(s, creep=s.creep + float(v[0]), through_rad=float(v[1])),
        starts=lambda setup, residual: [[1.0, max(share * wrap, SHORTEST_RAD)] for share in STARTS],
        figures=(
            Figure("strength", lambda v: float(v[0]), "1 is the whole effect of that wrap"),
            Figure("wrap_deg", lambda v: degrees(float(v[1])), "wrap over the input that friction holds"),
        ),
        hangs_on="the cycles so far",
        plain="the cable creeps over its input, as if it went round by {wrap_deg} only",
    )
