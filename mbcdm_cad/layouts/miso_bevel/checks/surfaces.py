"""Pitch radii and surface radii: the surface is cut at r - d/2, which must be a radius that can be machined."""

from __future__ import annotations

from mbcdm_cad.checks.comparison import Check, Comparison, at_most, worst
from mbcdm_cad.checks.surfaces import SURFACE_RADIUS, SURFACE_TOLERANCE_MM
from mbcdm_cad.layouts.miso_bevel.layout import BevelLayout
from mbcdm_cad.parts.input_pulley.dims import InputPulleyDims


def cut_at_pitch(s: BevelLayout) -> Comparison:
    """The layout cuts every surface at the pitch radius less d/2, so that all cables keep one ratio."""
    cut: list[tuple[str, float, float]] = []
    for k, c in enumerate(s.steps):
        cut.append((f"guide, {c.name}", s.guide.surface_radii[k], c.guide_radius_mm))
        cut.append((f"drum, {c.name}", s.drum.lands[k].surface_radius_mm, c.drum_radius_mm))
    for pulley in s.inputs:
        own = [c for c in s.steps if c.input_name == pulley.name]
        for c, surface in zip(own, _surfaces(s, pulley), strict=True):
            cut.append((f"input pulley, {c.name}", surface, c.input_radius_mm))
    ratios = ", ".join(
        f"{(land.surface_radius_mm + s.flank_mm) / (surface + s.flank_mm):.6g}"
        for land, surface in zip(s.drum.lands, _input_surfaces(s), strict=True)
    )
    return worst(
        at_most(
            f"surface of {name} from pitch radius less d/2",
            abs(surface + s.flank_mm - pitch),
            SURFACE_TOLERANCE_MM,
            "mm",
            f"total ratios at the cables' centre lines {ratios}",
        )
        for name, surface, pitch in cut
    )


def _input_surfaces(s: BevelLayout) -> list[float]:
    by_name = {p.name: p for p in s.inputs}
    found = []
    for c in s.steps:
        own = [o.step for o in s.steps if o.input_name == c.input_name]
        pulley = by_name[c.input_name]
        found.append(_surfaces(s, pulley)[c.step != min(own)])
    return found


def _surfaces(s: BevelLayout, pulley: InputPulleyDims) -> tuple[float, float]:
    """Surface radii of the pulley's two steps by their place along Z, the lower first."""
    radii = (pulley.lower_surface_radius, pulley.upper_surface_radius)
    return (radii[1], radii[0]) if s.drive.motors_above else radii


CHECKS = (
    SURFACE_RADIUS,
    Check(
        "cut_at_pitch",
        "Surfaces are cut half a cable inside the pitch radii",
        "derived from paper Table 2, which gives pitch radii",
        cut_at_pitch,
        advice="the layout room cuts at r - d/2; this fails only if that is changed",
    ),
)
