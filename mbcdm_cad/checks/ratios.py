"""Ratios that all cables of an input must share, and the change of tension by a difference.

The checks use nominal radii, with a tolerance far below that of machining: they find errors of the design, not of
parts.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from mbcdm_cad.checks.comparison import Check, Comparison, at_least, at_most, shown, worst
from mbcdm_cad.checks.design_variables import down, up
from mbcdm_cad.design.drive import CableRun
from mbcdm_cad.layouts.base import Layout
from mbcdm_cad.layouts.sector import SectorLayout
from mbcdm_cad.model.equilibrium import solve_equilibrium
from mbcdm_cad.model.kinematics import pair_mismatch_m
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


def smallest_surface(s: SectorLayout) -> Comparison:
    """Every surface radius r - d/2 can be machined."""
    ratios = "/".join(f"{ratio_if_cut_as_surface(s, c):.4g}" for c in s.steps)
    meant = "/".join(f"{c.drum_radius_mm / c.input_radius_mm:.4g}" for c in s.steps)
    note = f"radii are pitch radii; cut as surface radii the total ratios would be {ratios} instead of {meant}"
    return worst(
        at_least(f"r - d/2 of {cable} on the {body}", radius - s.flank_mm, SMALLEST_SURFACE_MM, "mm", note)
        for cable, body, radius in s.bends_mm()
    )


SURFACE_RADIUS = Check(
    "surface_radius",
    "Surfaces r - d/2 can be machined",
    "derived from paper Table 2, which gives pitch radii",
    smallest_surface,
    adjust=(down("rope diameter_mm"), up("all radii of transmission")),
)
