"""Rules of the rope: which one, its preload, its lead on the input pulleys."""

from __future__ import annotations

from mbcdm_cad.configurations.miso_bevel.sizing.known import LEAD_STEP_MM, STEPS, UNEVEN, BevelKnown
from mbcdm_cad.sizing.rule import Found, Rule, rounded_up

# Preload over the least at which no cable goes slack at peak torque, wraps taken as even.
PRELOAD_FACTOR = 2.0
# Strength of a swaged end over the rope's, before rope and ends are chosen.
SWAGED_SHARE = 0.9
# Strength over the safety factor, because steps and ends are not known yet when the rope is chosen.
STRENGTH_SPARE = 1.01
# The rope that is chosen where none is named: the supplest wire that the catalogue has in all sizes.
CONSTRUCTION = "7x7"
# Mean drum radius over that of step 1, before the steps are known.
MEAN_OVER_FIRST = 1.1


def _share_N(given: BevelKnown) -> float:
    """What the peak torque adds to a cable, four of them sharing it."""
    return float(given["loads.peak_torque_Nm"] * 1e3 / (STEPS * MEAN_OVER_FIRST * given.first_drum_mm))


def _rope(given: BevelKnown) -> Found:
    """The thinnest rope of the construction that holds preload and peak torque."""
    tension = (UNEVEN + PRELOAD_FACTOR) * _share_N(given) * STRENGTH_SPARE
    needed = tension * given["limits.tension_safety_factor"] / SWAGED_SHARE
    ropes = sorted(
        (entry["diameter_mm"], name, entry["breaking_load_N"])
        for name, entry in given.entries("ropes").items()
        if entry["construction"] == CONSTRUCTION
    )
    strong = [name for _, name, breaking in ropes if breaking >= needed]
    return Found(strong[0] if strong else ropes[-1][1], "tension", "next size of the catalogue")


def _preload(given: BevelKnown) -> Found:
    share = _share_N(given)
    most = given["limits.preload_share_max"] * given.rope["breaking_load_N"]
    ends = given.rope["breaking_load_N"] * given.termination.strength_share
    held = ends / given["limits.tension_safety_factor"] - UNEVEN * share
    wanted = PRELOAD_FACTOR * share
    driver = "no_slack" if wanted <= min(most, held) else "tension"
    return Found(float(f"{max(min(wanted, most, held), 0.5 * wanted):.2g}"), driver, "two digits")


def _lead(given: BevelKnown) -> Found:
    largest_input = max(given.input_mm)
    return Found(
        rounded_up(given.clearing_lead_mm(largest_input), LEAD_STEP_MM), "self_clearance", f"up to {LEAD_STEP_MM:g}"
    )


ROPE = (
    Rule(
        "rope.type",
        "the thinnest wire rope that holds preload and peak torque with its safety factor",
        "tension",
        _rope,
        applies=lambda given: not given.has("rope.inline"),
    ),
)
PRELOAD = (Rule("rope.preload_N", "twice what keeps every cable taut at peak torque", "no_slack", _preload),)
LEAD = (
    Rule(
        "rope.helix_lead_mm",
        "the least lead at which a span clears the turn wound before it at the largest fleet angle",
        "self_clearance",
        _lead,
    ),
)
