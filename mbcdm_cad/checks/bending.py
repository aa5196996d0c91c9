"""How sharply the cable is bent: against the design's own limit, and against the rope's catalogue, which only warns.

The paper's own design (14.8 at its smallest pulley) falls below every rope maker's minimum for 7x7.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

import numpy as np

from mbcdm_cad.checks.finding import Check, Finding, at_least, worst
from mbcdm_cad.checks.knobs import down, floored, up
from mbcdm_cad.checks.subject import Subject
from mbcdm_cad.configurations.miso_bevel.cable_path import stop_geometry

# Strength efficiency of wire rope bent over D/d, from rope makers' tables.
EFFICIENCY_RATIO = (10.0, 15.0, 20.0, 40.0)
EFFICIENCY = (0.86, 0.89, 0.91, 0.95)
# Below this makers call the life "relatively low".
LOW_LIFE_RATIO = 16.0
# A cable hooked round a pin without moving keeps about four fifths of its strength at D/d = 6 (rope makers' tables).
ANCHOR_RATIO = 6.0


def strength_efficiency(ratio: float) -> float:
    """Share of the breaking load left when bent over D/d = ``ratio``, interpolated; constant outside 10 to 40."""
    return float(np.interp(ratio, EFFICIENCY_RATIO, EFFICIENCY))


def _ratios(s: Subject) -> list[tuple[str, float]]:
    d = s.drive.cable.diameter_mm
    return [
        (f"D/d of {c.name} on the {body}", 2 * radius / d)
        for c in s.steps
        for body, radius in (
            ("input pulley", c.input_radius_mm),
            ("guide", c.guide_radius_mm),
            ("drum", c.drum_radius_mm),
        )
    ]


def _cost(ratio: float) -> str:
    life = "; life 'relatively low' under 16" if ratio < LOW_LIFE_RATIO else ""
    return f"{strength_efficiency(ratio):.1%} of the breaking load left{life}"


def bend_ratio(s: Subject) -> Finding:
    """Pitch diameter over cable diameter against the design's limit."""
    limit = s.drive.limits.bend_ratio_min
    return worst(at_least(name, ratio, limit, "D/d") for name, ratio in _ratios(s))


def bend_ratio_minimum(s: Subject) -> Finding:
    """The same against the rope's catalogue minimum."""
    limit = s.drive.cable.bend_ratio_minimum
    return worst(at_least(name, ratio, limit, "D/d", _cost(ratio)) for name, ratio in _ratios(s))


def bend_ratio_desired(s: Subject) -> Finding:
    """The same against what the catalogue asks for."""
    limit = s.drive.cable.bend_ratio_desired
    return worst(at_least(name, ratio, limit, "D/d", _cost(ratio)) for name, ratio in _ratios(s))


def _thinner_or_larger(measure: Callable[[Subject], Finding], s: Subject) -> str:
    """What a rope maker would ask for: he has no smaller D/d to offer."""
    share = measure(s).limit / measure(s).actual
    return (
        f"a rope of at most {floored(s.drive.cable.diameter_mm / share)} mm, or all radii {share:.4g} times as large; "
        "else inspect the cables often"
    )


def anchor_bend(s: Subject) -> Finding:
    """The standing bend before the swaged stop inside the input pulley."""
    s.levels  # noqa: B018 - without levels there is no winding, hence no stop
    d = s.drive.cable.diameter_mm
    return worst(
        at_least(
            f"D/d of the bend at the stop of {c.name}",
            2 * stop_geometry(s.drive, c).bend_radius_mm / d,
            ANCHOR_RATIO,
            "D/d",
        )
        for c in s.steps
    )


_THINNER = (down("rope diameter_mm"), down("transmission.ratios.input_to_guide"), up("all radii of transmission"))
CHECKS = (
    Check(
        "bend_ratio", "Bend ratio at every pulley", "limits.bend_ratio_min; paper Table 1", bend_ratio, turns=_THINNER
    ),
    Check(
        "bend_ratio_minimum",
        "Bend ratio against the catalogue's minimum",
        "rope catalogue; efficiency 95/91/89/86 % at D/d 40/20/15/10",
        bend_ratio_minimum,
        "warn",
        advice=partial(_thinner_or_larger, bend_ratio_minimum),
    ),
    Check(
        "bend_ratio_desired",
        "Bend ratio against the catalogue's wish",
        "rope catalogue; efficiency 95/91/89/86 % at D/d 40/20/15/10",
        bend_ratio_desired,
        "warn",
        advice=partial(_thinner_or_larger, bend_ratio_desired),
    ),
    Check(
        "anchor_bend",
        "Standing bend at the cable's stop",
        "rope makers' tables, interpolated: estimate",
        anchor_bend,
        turns=_THINNER,
    ),
)
