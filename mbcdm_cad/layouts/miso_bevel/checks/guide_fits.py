"""Guide pulley and its axle: bearings inside, walls round them, bending of the axle."""

from __future__ import annotations

from math import pi

import numpy as np

from mbcdm_cad.checks.comparison import Check, Comparison, at_least, worst
from mbcdm_cad.checks.design_variables import down, up
from mbcdm_cad.layouts.miso_bevel.checks.bearings import guide_forces_N
from mbcdm_cad.layouts.miso_bevel.layout import BevelLayout

# Yield over bending stress (usual for steady loads on ductile metal).
STRESS_SAFETY = 1.5


def guide_wall(s: BevelLayout) -> Comparison:
    """Wall round the bearings in both ends of the guide."""
    g = s.guide
    limit = s.drive.guide_material.min_wall_mm
    starts, ends = [g.bottom_z, *g.walls_z], [*g.walls_z, g.top_z]
    seats = (("lower", g.bottom_z, g.bottom_z + g.seat_depth), ("upper", g.top_z - g.seat_depth, g.top_z))
    return worst(
        at_least(f"guide's wall round the {name} bearing", radius - g.seat_radius, limit, "mm")
        for name, low, high in seats
        for radius, start, end in zip(g.surface_radii, starts, ends, strict=True)
        if start < high and end > low
    )


def guide_length(s: BevelLayout) -> Comparison:
    """Length of the guide that is left between its two bearings for the shoulders."""
    g = s.guide
    return at_least(
        "shoulder between the guide's bearings",
        g.top_z - g.bottom_z - 2 * g.seat_depth,
        2 * s.drive.guide_material.min_wall_mm,
        "mm",
    )


def axle_stress(s: BevelLayout) -> Comparison:
    """Bending stress of the axle under the guide's two bearings, as a beam on shelf and top plate."""
    g, v = s.guide, s.levels
    span = v.top_plate_bottom_z - v.bearing_shelf_top_z
    below = g.bottom_z + g.seat_depth / 2 - v.bearing_shelf_top_z
    above = v.top_plate_bottom_z - (g.top_z - g.seat_depth / 2)
    bending = 0.0
    for lower, upper in s.once("guide_forces", guide_forces_N):
        on_plate = (lower * below + upper * (span - above)) / span
        on_shelf = lower + upper - on_plate
        moments = float(np.linalg.norm(on_shelf)) * below, float(np.linalg.norm(on_plate)) * above
        bending = max(bending, *moments)
    stress = bending / (pi * s.axle.radius**3 / 4)
    strength = s.drive.axle_material.yield_MPa
    return at_least(
        f"yield {strength:g} MPa over the axle's bending stress {stress:.4g} MPa",
        strength / max(stress, 1e-12),
        STRESS_SAFETY,
        "times",
    )


CHECKS = (
    Check(
        "guide_wall",
        "Guide's wall round its bearings",
        "material: min_wall_mm",
        guide_wall,
        adjust=(up("transmission.guide_radii_mm"), up("all radii of transmission")),
        advice="choose a smaller guide.bearing",
    ),
    Check(
        "guide_length",
        "Guide is long enough for two bearings",
        "material: min_wall_mm",
        guide_length,
        adjust=(up("all radii of transmission"),),
        advice="choose a narrower guide.bearing",
    ),
    Check(
        "axle_stress",
        "Guide axle's bending stress",
        "beam theory; 1.5 on yield: usual rule",
        axle_stress,
        adjust=(down("rope.preload_N"), down("loads.peak_torque_Nm")),
        advice="choose a guide.bearing of larger bore",
    ),
)
