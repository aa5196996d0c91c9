"""Bearing loads against static ratings, and the deflection at the gearhead that the pulley's own bearings leave.

A deep-groove bearing runs normally at a static safety of 1 and quietly at 2 (bearing makers). The cables pull each
input pulley with well over 100 N, more than a gearhead of this size can carry, so each pulley has a bearing at both
ends.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mbcdm_cad.checks.bearings import (
    BEARING_SPACING,
    COUPLING_RUNOUT,
    DRUM_BEARINGS,
    INPUT_BEARINGS,
    LESS,
    QUIET_SAFETY,
    RATING,
    STATIC_SAFETY,
    drum_safety,
    input_safety,
    larger,
    quiet,
    safety,
)
from mbcdm_cad.checks.comparison import Check, Comparison, at_least, worst
from mbcdm_cad.checks.design_variables import down, up
from mbcdm_cad.checks.fixings import STRESS_SAFETY, bent_axle_Nmm, round_shaft_MPa
from mbcdm_cad.layouts.miso_bevel.layout import BevelLayout
from mbcdm_cad.layouts.miso_bevel.routes import GUIDE


def guide_forces_N(s: BevelLayout) -> list[NDArray[np.float64]]:
    """Forces on the axle at the guide's (lower, upper) bearing, shape (2, 3), in each state of the loads."""
    g = s.guide
    apart = (g.top_z - g.bottom_z - g.seat_depth) * 1e-3
    middle = 0.5 * (s.steps[0].drum_radius_mm + s.steps[-1].drum_radius_mm)
    shift = (0.5 * (g.top_z + g.bottom_z) - middle) * 1e-3
    found = []
    for loads in s.loads.on_bodies:
        at = loads.bodies[GUIDE]
        # Moments about the middle of the bearings, which need not be that of the steps.
        moment = at.moment_Nm - np.cross([0.0, 0.0, shift], at.force_N)
        couple = np.array([moment[1], -moment[0], 0.0]) / apart
        found.append(np.stack([at.force_N / 2 - couple, at.force_N / 2 + couple]))
    return found


def guide_reaction_N(s: BevelLayout) -> float:
    """Largest radial load on one of the guide's bearings."""
    return max(float(np.linalg.norm(pair, axis=1).max()) for pair in s.once("guide_forces", guide_forces_N))


def guide_safety(s: BevelLayout, limit: float) -> list[Comparison]:
    return [safety(s.drive.bearings.guide, "guide", guide_reaction_N(s), limit)]


def guide_bearings(s: BevelLayout) -> Comparison:
    """Static safety of the bearings in the guide, from the resulting pull and its moment."""
    return worst(guide_safety(s, STATIC_SAFETY))


def quiet_running(s: BevelLayout) -> Comparison:
    """Static safety of all bearings against the value for quiet running."""
    return worst([*input_safety(s, QUIET_SAFETY), *guide_safety(s, QUIET_SAFETY), *drum_safety(s, QUIET_SAFETY)])


BEARINGS = (
    INPUT_BEARINGS,
    Check(
        "guide_bearings",
        "Guide's bearings carry the cables",
        RATING,
        guide_bearings,
        adjust=LESS,
        advice=larger(guide_bearings, STATIC_SAFETY),
    ),
    DRUM_BEARINGS,
    quiet(quiet_running),
    BEARING_SPACING,
    COUPLING_RUNOUT,
)


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
    ends = v.bearing_shelf_top_z, v.top_plate_bottom_z
    bending = max(bent_axle_Nmm(pair, g.bearings_mm, ends)[0] for pair in s.once("guide_forces", guide_forces_N))
    stress = round_shaft_MPa(s.axle.radius, bending)
    strength = s.drive.axle_material.yield_MPa
    return at_least(
        f"yield {strength:g} MPa over the axle's bending stress {stress:.4g} MPa",
        strength / max(stress, 1e-12),
        STRESS_SAFETY,
        "times",
    )


GUIDE_FITS = (
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
