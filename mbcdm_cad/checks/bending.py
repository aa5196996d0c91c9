"""Bend ratio D/d of the cable: compared with the design's limit, and with the rope's catalogue, which only warns.

The paper's design (14.8 at its smallest pulley) is below every rope maker's minimum for 7x7.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from functools import partial
from typing import Any

import numpy as np

from mbcdm_cad.checks.comparison import Check, Comparison, at_least, worst
from mbcdm_cad.checks.design_variables import Adjustment
from mbcdm_cad.checks.remedies import floored
from mbcdm_cad.layouts.base import Layout

# Strength efficiency of wire rope bent over D/d, from rope makers' tables.
EFFICIENCY_RATIO = (10.0, 15.0, 20.0, 40.0)
EFFICIENCY = (0.86, 0.89, 0.91, 0.95)
# Below this rope makers call the life "relatively low".
LOW_LIFE_RATIO = 16.0
# A static cable bent round a pin keeps about four fifths of its strength at D/d = 6 (rope makers' tables).
ANCHOR_RATIO = 6.0


def strength_efficiency(ratio: float) -> float:
    """Share of the breaking load left when bent over D/d = ``ratio``, interpolated; constant outside 10 to 40."""
    return float(np.interp(ratio, EFFICIENCY_RATIO, EFFICIENCY))


def _ratios(s: Layout) -> list[tuple[str, float]]:
    d = s.drive.cable.diameter_mm
    return [(f"D/d of {cable} on the {pulley}", 2 * radius / d) for cable, pulley, radius in s.bends_mm()]


def _cost(ratio: float) -> str:
    life = "; life 'relatively low' under 16" if ratio < LOW_LIFE_RATIO else ""
    return f"{strength_efficiency(ratio):.1%} of the breaking load left{life}"


def bend_ratio(s: Layout) -> Comparison:
    """Pitch diameter over cable diameter is compared with the limit of the design."""
    limit = s.drive.limits.bend_ratio_min
    return worst(at_least(name, ratio, limit, "D/d") for name, ratio in _ratios(s))


def bend_ratio_minimum(s: Layout) -> Comparison:
    """Pitch diameter over cable diameter is compared with the minimum in the rope's catalogue."""
    limit = s.drive.cable.bend_ratio_minimum
    return worst(at_least(name, ratio, limit, "D/d", _cost(ratio)) for name, ratio in _ratios(s))


def bend_ratio_desired(s: Layout) -> Comparison:
    """Pitch diameter over cable diameter is compared with the value that the catalogue recommends."""
    limit = s.drive.cable.bend_ratio_desired
    return worst(at_least(name, ratio, limit, "D/d", _cost(ratio)) for name, ratio in _ratios(s))


def _desired(drive: Any) -> bool:
    """Whether the file asks for a life, and the ratio is above the least, below which that check says it."""
    targets = drive.targets
    wanted = targets.life_cycles is not None or targets.life_h is not None
    return wanted and bool(drive.layout.smallest_bend_ratio >= drive.cable.bend_ratio_minimum)


def _thinner_or_larger(measure: Callable[[Layout], Comparison], s: Layout) -> str:
    """Advice for a bend ratio below the catalogue: a thinner rope or larger radii."""
    share = measure(s).limit / measure(s).actual
    return (
        f"a rope of at most {floored(s.drive.cable.diameter_mm / share)} mm, or all radii {share:.4g} times as large; "
        "else inspect the cables often"
    )


def anchor_bend(bends_mm: Callable[[Any], Iterable[tuple[str, float]]], s: Layout) -> Comparison:
    """The constant bend of the cable before the swaged stop inside the input pulley."""
    d = s.drive.cable.diameter_mm
    return worst(
        at_least(f"D/d of the bend at the stop of {cable}", 2 * radius / d, ANCHOR_RATIO, "D/d")
        for cable, radius in bends_mm(s)
    )


def anchor_check(bends_mm: Callable[[Any], Iterable[tuple[str, float]]], adjust: tuple[Adjustment, ...]) -> Check:
    """The check; ``bends_mm``: of a design under test, (cable, radius of the bend before its stop) of each cable."""
    return Check(
        "anchor_bend",
        "Standing bend at the cable's stop",
        "rope makers' tables, interpolated: estimate",
        partial(anchor_bend, bends_mm),
        adjust=adjust,
    )


def bending_checks(adjust: tuple[Adjustment, ...]) -> tuple[Check, ...]:
    """The checks; ``adjust``: the configuration's variables that increase the bending radii."""
    efficiency = "rope catalogue; efficiency 95/91/89/86 % at D/d 40/20/15/10"
    return (
        Check(
            "bend_ratio",
            "Bend ratio at every pulley",
            "limits.bend_ratio_min; paper Table 1",
            bend_ratio,
            adjust=adjust,
        ),
        Check(
            "bend_ratio_minimum",
            "Bend ratio against the catalogue's minimum",
            efficiency,
            bend_ratio_minimum,
            "warn",
            advice=partial(_thinner_or_larger, bend_ratio_minimum),
        ),
        Check(
            "bend_ratio_desired",
            "Bend ratio against the catalogue's recommendation",
            f"{efficiency}; only where targets ask for a life",
            bend_ratio_desired,
            "warn",
            applies=_desired,
            advice=partial(_thinner_or_larger, bend_ratio_desired),
        ),
    )
