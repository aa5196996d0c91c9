"""Life of the cables against the wanted number of cycles.

The generic figure may fail a wanted life, or warn of it; it never shows one. Only a test of the rope (``life_anchor``)
does.
"""

from __future__ import annotations

from mbcdm_cad.checks.comparison import Check, Comparison, at_least, noted
from mbcdm_cad.checks.design_variables import down, up
from mbcdm_cad.layouts.base import Layout
from mbcdm_cad.model.life.rope_bendings import MOST_BENDINGS

_TEST_IT = "not shown: the generic figure shows no life; test the rope and state its life_anchor"


def life(s: Layout) -> Comparison:
    """Cycles after which nine of ten cables have broken, against the wanted number; without one, the median."""
    found = s.life
    wanted = found.wanted_cycles
    first = found.first
    if first is None:
        return noted(
            "smallest D/d of the cables; their life has no figure:", s.smallest_bend_ratio, "D/d", found.refused
        )
    low, high = first.reached(0.1), first.reached(0.9)
    if wanted is not None and high < wanted:
        what = f"cycles after which nine of ten {first.name} have broken, half of them after {first.cycles:.2g}:"
        return at_least(what, high, wanted, "cycles", found.told)
    what = f"cycles after which half of all {first.name} have broken"
    return noted(what, first.cycles, "cycles", f"one in ten after {low:.2g}, nine after {high:.2g}; {found.told}")


def life_shown(s: Layout) -> Comparison:
    """Cycles after which one cable in ten has broken, against the wanted number: the time to replace them."""
    found = s.life
    wanted = found.wanted_cycles
    first = found.first
    if first is None and wanted is None:
        return noted("the cables' life has no figure, and the design file wants none: cycles", 0.0, "", found.refused)
    if first is None and found.longer:
        what = f"bendings at which the data end, before the cables would break; {wanted:g} cycles wanted:"
        return noted(what, MOST_BENDINGS, "bendings", _TEST_IT)
    if first is None:
        return at_least("cycles that are shown for the cables", 0.0, wanted or 0.0, "cycles", found.refused)
    low, what = first.reached(0.1), f"cycles after which one in ten {first.name} has broken"
    if wanted is None:
        return noted(f"{what}: replace it then;", low, "cycles", "the design file wants none")
    if low >= wanted and found.generic:
        return noted(f"{what}, {wanted:g} wanted:", low, "cycles", _TEST_IT)
    return at_least(what, low, wanted, "cycles", found.told)


def _what_helps(s: Layout) -> str:
    """The changes that help most, with their factors of the life."""
    helps = [f"{each.change} (x{each.factor:.2g})" for each in s.life.helps[:3] if each.factor > 1.0]
    return f"what helps most: {', '.join(helps)}" if helps else "state the life_anchor of a test of the rope"


_ADJUST = (down("rope.preload_N"), up("all radii of transmission"))
CHECKS = (
    Check(
        "life",
        "Cycles until the cables break",
        "targets.life_cycles or life_h; bendings by Feyrer's form, generic figure: estimate",
        life,
        adjust=_ADJUST,
        advice=_what_helps,
    ),
    Check(
        "life_shown",
        "Cycles at which to replace the cables",
        "targets.life_cycles or life_h; one cable in ten, generic figure: estimate",
        life_shown,
        "warn",
        adjust=_ADJUST,
        advice=_what_helps,
    ),
)
