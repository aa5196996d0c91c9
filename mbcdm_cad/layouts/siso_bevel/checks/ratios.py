"""Radii: one ratio of both steps (Eq. (1) without a guide), surfaces that can be cut, permissible bends of the rope."""

from __future__ import annotations

from collections.abc import Iterator

from mbcdm_cad.checks.bending import anchor_check, bending_checks
from mbcdm_cad.checks.comparison import Check, Comparison, at_most, worst
from mbcdm_cad.checks.design_variables import Adjustment, down, up
from mbcdm_cad.checks.ratios import SURFACE_RADIUS, SURFACE_TOLERANCE_MM, pair_mismatch, spread
from mbcdm_cad.layouts.siso_bevel.cable_path import stop_bend
from mbcdm_cad.layouts.siso_bevel.layout import DirectLayout


def one_ratio(s: DirectLayout) -> Comparison:
    """r_m/r_o is the same for both steps."""
    return spread("r_m/r_o", [c.input_radius_mm / c.drum_radius_mm for c in s.steps], s.steps)


def cut_at_pitch(s: DirectLayout) -> Comparison:
    """The layout cuts every surface at the pitch radius less d/2, so that both cables keep one ratio."""
    pulley = s.inputs[0]
    on_input = (pulley.upper_surface_radius, pulley.lower_surface_radius)
    cut = [
        pair
        for c, land, surface in zip(s.steps, s.drum.lands, on_input, strict=True)
        for pair in (
            (f"drum, {c.name}", land.surface_radius_mm - c.drum_radius_mm),
            (f"input pulley, {c.name}", surface - c.input_radius_mm),
        )
    ]
    return worst(
        at_most(f"surface of {name} from pitch radius less d/2", abs(off + s.flank_mm), SURFACE_TOLERANCE_MM, "mm")
        for name, off in cut
    )


def _stop_bends_mm(s: DirectLayout) -> Iterator[tuple[str, float]]:
    s.require_geometry()  # without a layout there is no room for a stop
    for c in s.steps:
        yield c.name, stop_bend(s.drive, c).bend_radius_mm


def _radii_that_agree(s: DirectLayout) -> str:
    first = s.steps[0]
    radii = ", ".join(f"{c.drum_radius_mm * first.input_radius_mm / first.drum_radius_mm:.5g}" for c in s.steps)
    return f"with step 1 kept, input_radii_mm: [{radii}] gives both steps one ratio"


EQ1 = "paper Eq. (1), without a guide"
_WIDER: tuple[Adjustment, ...] = (
    down("transmission.input_to_drum"),
    down("rope diameter_mm"),
    up("all radii of transmission"),
)
CHECKS = (
    Check("eq1_one_ratio", "Eq. (1): both steps have one ratio", EQ1, one_ratio, advice=_radii_that_agree),
    Check(
        "pair_mismatch",
        "Cables of one input agree over the travel",
        "derived; a tenth of the preload: estimate",
        pair_mismatch,
        advice=_radii_that_agree,
    ),
    SURFACE_RADIUS,
    Check(
        "cut_at_pitch",
        "Surfaces are cut half a cable inside the pitch radii",
        "derived from paper Table 2, which gives pitch radii",
        cut_at_pitch,
        advice="the layout cuts at r - d/2; this fails only if that is changed",
    ),
    *bending_checks(_WIDER),
    anchor_check(_stop_bends_mm, _WIDER),
)
