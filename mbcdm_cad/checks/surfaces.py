"""Pitch radii and surface radii: the surface is cut at r - d/2, which must be a radius that can be machined."""

from __future__ import annotations

from mbcdm_cad.checks.comparison import Check, Comparison, at_least, worst
from mbcdm_cad.checks.design_variables import down, up
from mbcdm_cad.layouts.sector import SectorLayout
from mbcdm_cad.parts.drum_sector.design import SectorRun

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
