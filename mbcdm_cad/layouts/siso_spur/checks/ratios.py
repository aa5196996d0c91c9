"""Radii: surfaces that can be machined, bend ratios that the rope allows."""

from __future__ import annotations

from collections.abc import Iterator

from mbcdm_cad.checks.comparison import Check, Comparison, at_most, worst
from mbcdm_cad.checks.design_variables import Adjustment, down, up
from mbcdm_cad.checks.input_pulley import coupling_checks, dead_turns_check, stop_checks
from mbcdm_cad.checks.ratios import SURFACE_TOLERANCE_MM, anchor_check, bending_checks, surface_radius
from mbcdm_cad.layouts.siso_spur.cable_path import stop_of
from mbcdm_cad.layouts.siso_spur.drive import is_anchored
from mbcdm_cad.layouts.siso_spur.layout import SpurLayout


def cut_at_pitch(s: SpurLayout) -> Comparison:
    """The layout cuts every surface at the pitch radius less d/2."""
    drive = s.drive
    cut = [("input pulley", s.inputs[0].lower_surface_radius - drive.input_radius_mm)]
    cut += [(f"drum, {land.step}", land.surface_radius_mm - drive.drum_radius_mm) for land in s.drum.lands]
    return worst(
        at_most(f"surface of {name} from pitch radius less d/2", abs(off + s.flank_mm), SURFACE_TOLERANCE_MM, "mm")
        for name, off in cut
    )


def _stop_bends_mm(s: SpurLayout) -> Iterator[tuple[str, float]]:
    for c in s.steps:
        yield c.name, stop_of(s.drive, c).bend_radius_mm


WIDER: tuple[Adjustment, ...] = (
    down("transmission.input_to_drum"),
    down("rope diameter_mm"),
    up("all radii of transmission"),
)
CHECKS = (
    surface_radius,
    Check(
        "cut_at_pitch",
        "Surfaces are cut half a cable inside the pitch radii",
        "derived from paper Table 2, which gives pitch radii",
        cut_at_pitch,
        advice="the layout cuts at r - d/2; this fails only if that is changed",
    ),
    *bending_checks(WIDER),
    anchor_check(_stop_bends_mm, WIDER).but(applies=is_anchored),
)
_STOPS = (
    dead_turns_check((up("transmission.turns"), down("transmission.input_to_drum"), down("travel.half_angle_deg"))),
    *stop_checks(WIDER),
)
PULLEY_FITS = (*(check.but(applies=is_anchored) for check in _STOPS), *coupling_checks(WIDER))
