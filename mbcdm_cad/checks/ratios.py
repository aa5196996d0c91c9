"""Ratios that all cables of an input must share, surfaces that can be cut, and bends that the rope allows.

The checks of ratios use nominal radii, with a tolerance far below that of machining: they find errors of the design,
not of parts. The paper's design (D/d 14.8 at its smallest pulley) is below every rope maker's minimum for 7x7.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np

from mbcdm_cad.checks.comparison import Comparison, Findings, at_least, at_most, check, shown, worst
from mbcdm_cad.checks.design_variables import down, up
from mbcdm_cad.checks.run import rounded
from mbcdm_cad.design.drive import CableRun
from mbcdm_cad.design.paths import at
from mbcdm_cad.layouts.base import Layout
from mbcdm_cad.layouts.registry import layout_of
from mbcdm_cad.layouts.sector import SectorLayout
from mbcdm_cad.model.equations import pair_mismatch_m
from mbcdm_cad.model.equilibrium import solve_equilibrium
from mbcdm_cad.parts.drum_sector.design import SectorRun

# 0.6 um on a radius of 6 mm, a tenth of the tolerance of good turning: allows for rounding of nominal radii only.
RATIO_TOLERANCE = 1e-4
# Tension that the mismatch of a pair may add over the travel, as a share of the preload; beyond it the tension differs
# too much from the preload that was set (estimate).
MISMATCH_SHARE = 0.1


def spread(name: str, ratios: Sequence[float], cables: Sequence[CableRun], note: str = "") -> Comparison:
    """Largest relative deviation of the ratios from the first of them."""
    off = [abs(ratio / ratios[0] - 1.0) for ratio in ratios]
    k = int(np.argmax(off))
    listed = ", ".join(f"{ratio:.6g}" for ratio in ratios)
    return at_most(f"{name} = {listed}: {cables[k].name} off", off[k], RATIO_TOLERANCE, "relative", note)


@check("Cables of one input agree over the travel", "derived; a tenth of the preload: estimate")
def pair_mismatch(s: Layout) -> Comparison:
    """Tension that the two cables of an input cause in each other over the travel, from the model."""

    si, idle = s.loads.si, s.loads.idle
    one_of_each = [si.input_of.index(i) for i in range(si.n_inputs)]
    angle = s.half_travel_rad * si.total_ratio[one_of_each]
    poses = np.stack([angle, -angle], axis=1)
    moved = solve_equilibrium(si, np.zeros(2), input_angle_rad=poses).tension_N
    change = np.abs(moved - idle[:, None]).max(axis=1)
    k = int(np.argmax(change))
    length = np.abs(pair_mismatch_m(si, poses)).max() * 1e3
    cable = s.drive.cables[k]
    what = f"over the travel {cable.name} changes by {shown(change[k])} N (pair mismatch {shown(length)} mm):"
    return at_most(what, change[k] / cable.preload_N, MISMATCH_SHARE, "of T_pre")


# Thinnest stub that is still turned between journals of this size (estimate).
SMALLEST_SURFACE_MM = 1.0
# Surfaces must be cut at the pitch radius minus half a cable: this tolerance allows for rounding only.
SURFACE_TOLERANCE_MM = 1e-6


def ratio_if_cut_as_surface(s: SectorLayout, cable: SectorRun) -> float:
    """Total ratio of a cable if its pitch radii were cut as surface radii: (r_o + d/2) / (r_m + d/2)."""
    return (cable.drum_radius_mm + s.flank_mm) / (cable.input_radius_mm + s.flank_mm)


@check(
    "Surfaces r - d/2 can be machined",
    "derived from paper Table 2, which gives pitch radii",
    *down("rope diameter_mm"),
    *up("all radii of transmission"),
)
def surface_radius(s: SectorLayout) -> Findings:
    """Every surface radius r - d/2 can be machined."""
    ratios = "/".join(f"{ratio_if_cut_as_surface(s, c):.4g}" for c in s.steps)
    meant = "/".join(f"{c.drum_radius_mm / c.input_radius_mm:.4g}" for c in s.steps)
    note = f"radii are pitch radii; cut as surface radii the total ratios would be {ratios} instead of {meant}"
    for cable, body, radius in s.bends_mm():
        yield f"r - d/2 of {cable} on the {body}", radius - s.flank_mm, SMALLEST_SURFACE_MM, note


# Strength efficiency of wire rope bent over D/d, from rope makers' tables.
EFFICIENCY_RATIO = (10.0, 15.0, 20.0, 40.0)
EFFICIENCY = (0.86, 0.89, 0.91, 0.95)
# Below this rope makers call the life "relatively low".
LOW_LIFE_RATIO = 16.0
# A static cable bent round a pin keeps about four fifths of its strength at D/d = 6 (rope makers' tables).
ANCHOR_RATIO = 6.0
# What makes the bends gentler, under the names that it has in the layouts.
GENTLER = (*down(at.transmission.input_to_drum, "rope diameter_mm"), *up("all radii of transmission"))
_EFFICIENCY = "rope catalogue; efficiency 95/91/89/86 % at D/d 40/20/15/10"


def strength_efficiency(ratio: float) -> float:
    """Share of the breaking load left when bent over D/d = ``ratio``, interpolated; constant outside 10 to 40."""
    return float(np.interp(ratio, EFFICIENCY_RATIO, EFFICIENCY))


def _ratios(s: Layout) -> list[tuple[str, float]]:
    d = s.drive.cable.diameter_mm
    return [(f"D/d of {cable} on the {pulley}", 2 * radius / d) for cable, pulley, radius in s.bends_mm()]


def _cost(ratio: float) -> str:
    life = "; life 'relatively low' under 16" if ratio < LOW_LIFE_RATIO else ""
    return f"{strength_efficiency(ratio):.1%} of the breaking load left{life}"


@check("Bend ratio at every pulley", "limits.bend_ratio_min; paper Table 1", *GENTLER)
def bend_ratio(s: Layout) -> Comparison:
    """Pitch diameter over cable diameter is compared with the limit of the design."""
    limit = s.drive.limits.bend_ratio_min
    return worst(at_least(name, ratio, limit, "D/d") for name, ratio in _ratios(s))


def _thinner_or_larger(s: Layout, found: Comparison) -> str:
    """Advice for a bend ratio below the catalogue: a thinner rope or larger radii."""
    share = found.limit / found.actual
    return (
        f"a rope of at most {rounded(s.drive.cable.diameter_mm / share)} mm, or all radii {share:.4g} times as large; "
        "else inspect the cables often"
    )


@check("Bend ratio against the catalogue's minimum", _EFFICIENCY, advice_on=_thinner_or_larger, warn=True)
def bend_ratio_minimum(s: Layout) -> Comparison:
    """Pitch diameter over cable diameter is compared with the minimum in the rope's catalogue."""
    limit = s.drive.cable.bend_ratio_minimum
    return worst(at_least(name, ratio, limit, "D/d", _cost(ratio)) for name, ratio in _ratios(s))


def _desired(drive: Any) -> bool:
    """Whether the file asks for a life, and the ratio is above the least, below which that check says it."""
    targets = drive.targets
    wanted = targets.life_cycles is not None or targets.life_h is not None
    return wanted and bool(layout_of(drive).smallest_bend_ratio >= drive.cable.bend_ratio_minimum)


@check(
    "Bend ratio against the catalogue's recommendation",
    f"{_EFFICIENCY}; only where targets ask for a life",
    advice_on=_thinner_or_larger,
    applies=_desired,
    warn=True,
)
def bend_ratio_desired(s: Layout) -> Comparison:
    """Pitch diameter over cable diameter is compared with the value that the catalogue recommends."""
    limit = s.drive.cable.bend_ratio_desired
    return worst(at_least(name, ratio, limit, "D/d", _cost(ratio)) for name, ratio in _ratios(s))


@check("Standing bend at the cable's stop", "rope makers' tables, interpolated: estimate", *GENTLER, unit="D/d")
def anchor_bend(s: SectorLayout) -> Findings:
    """The constant bend of the cable before the swaged stop inside the input pulley."""
    slots = {slot.cable_name: slot for pulley in s.inputs for slot in pulley.slots}
    for c in s.steps:
        ratio = 2 * slots[c.name].bend_radius / s.drive.cable.diameter_mm
        yield f"D/d of the bend at the stop of {c.name}", ratio, ANCHOR_RATIO


BENDING = (bend_ratio, bend_ratio_minimum, bend_ratio_desired)
