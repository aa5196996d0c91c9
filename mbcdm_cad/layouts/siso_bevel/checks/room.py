"""Gaps between turning and fixed parts, distance between cables, and the box compared with its target."""

from __future__ import annotations

from math import sqrt

import numpy as np

from mbcdm_cad.checks.cable_gaps import cables_apart
from mbcdm_cad.checks.comparison import Check, Comparison, at_least, worst
from mbcdm_cad.checks.design_variables import Adjustment, down, up
from mbcdm_cad.checks.drum_outline import before_frame, drum_zones, frame_front_check, rim_points, wrap_points
from mbcdm_cad.checks.size import box_checks, mass_check
from mbcdm_cad.checks.terminals import bodies_of
from mbcdm_cad.layouts.siso_bevel.bill import bill
from mbcdm_cad.layouts.siso_bevel.layout import DirectLayout
from mbcdm_cad.parts.bought.bodies import RING_ENCODER_FLATS


def frame_front(s: DirectLayout) -> Comparison:
    """Gap from all parts that turn with the drum to frame, motor head and boss behind them."""
    return before_frame(s, "frame")


def bought_parts_clear(s: DirectLayout) -> Comparison:
    """Gap of drum and terminals to encoder, motor head, gearhead and motor behind them, where they reach their height.

    The encoder is a cylinder about z below the pulley; the others are above it.
    """
    drive, v, head, found = s.drive, s.levels, s.head, []
    radius, shelf_z = drive.encoder.diameter_mm / 2, -v.top_plate_top_z
    above = (
        ("motor head", -v.bearing_shelf_bottom_z, head.front_y),
        ("gearhead", -v.motor_shelf_bottom_z, drive.gearhead.diameter_mm / 2),
        ("motor", -v.gearhead_bottom_z, drive.motor.diameter_mm / 2),
    )
    for ring in drum_zones(s):
        # Where the ring passes over the encoder's end, beside its axis, the encoder is less deep.
        deep = sqrt(max(radius**2 - max(ring.inner**2 - shelf_z**2, 0.0), 0.0))
        if deep > 0.0 and ring.name != "drum's hub":
            found.append((f"{ring.name} before the encoder", ring.y - deep))
        found += [(f"{ring.name} before the {name}", ring.y - y) for name, z, y in above if ring.top > z]
    return worst(at_least(name, gap, drive.clearances.running_mm, "mm") for name, gap in found)


def box_mm(s: DirectLayout) -> tuple[float, float, float]:
    """Box (X, Z, Y) of all parts with the drum centred, computed from the layout; mm."""
    v, drive = s.levels, s.drive
    d, f = s.drum, s.frame
    points = [rim_points(d), wrap_points(d, s.flank_mm)]
    reach = max(c.input_radius_mm for c in s.steps) + s.flank_mm
    ys = [v.back_y, v.hub_face_y, d.lands[-1].y_end, d.web_end_y + 0.5, reach]
    for t in d.tensioners:
        for _, outline, _, high in bodies_of(s, t, moved=False):
            points.append(outline)
            ys.append(high)
    cloud = np.concatenate(points)
    bodies = max(drive.gearhead.diameter_mm, drive.motor.diameter_mm) / 2
    wide = max(v.side_outer_x, f.column_half_width, f.boss.ear_reach, drive.drum_encoder.diameter_mm / 2, bodies)
    left, right = min(float(cloud[:, 0].min()), -wide), max(float(cloud[:, 0].max()), wide)
    encoder = drive.drum_encoder.diameter_mm / 2 * RING_ENCODER_FLATS
    bottom = min(float(cloud[:, 1].min()), -f.boss.radius, -d.hub_radius, -encoder)
    top = max(-v.motor_bottom_z, float(cloud[:, 1].max()), s.steps[-1].drum_radius_mm + s.flank_mm)
    return right - left, top - bottom, max(ys) - min(ys)


_X: tuple[Adjustment, ...] = (down("drum.sector_half_angle_deg"), up("drum.sector_half_angle_deg"))
_Z: tuple[Adjustment, ...] = (down("support.coupling_space_mm"), up("support.coupling_space_mm"))
_Y: tuple[Adjustment, ...] = (down("drum.hub_face_y_mm"), up("drum.hub_face_y_mm"), up("support.back_y_mm"))
CHECKS = (
    frame_front_check(frame_front),
    Check(
        "drum_sweep",
        "Drum clears motor and gearhead",
        "clearances.running_mm",
        bought_parts_clear,
        adjust=(up("all radii of transmission"), down("transmission.input_to_drum")),
    ),
    Check(
        "cables_apart",
        "Gaps between cables",
        "derived; 0.1 mm: estimate",
        cables_apart,
        adjust=(up("all radii of transmission"), down("rope diameter_mm")),
    ),
    *box_checks(box_mm, "targets.envelope_mm", (_X, _Z, _Y)),
    mass_check(bill),
)
