"""Box and mass against their targets: from the layout, before anything is drawn."""

from __future__ import annotations

import numpy as np

from mbcdm_cad.checks.box import box_checks
from mbcdm_cad.checks.design_variables import Adjustment, down, up
from mbcdm_cad.checks.drum_outline import rim_points, wrap_points
from mbcdm_cad.checks.estimated_mass import mass_check
from mbcdm_cad.checks.terminals import bodies_of
from mbcdm_cad.layouts.miso_bevel.bill import bill
from mbcdm_cad.layouts.miso_bevel.layout import BevelLayout
from mbcdm_cad.parts.bought.bodies import RING_ENCODER_FLATS


def box_mm(s: BevelLayout) -> tuple[float, float, float]:
    """Box (X, Z, Y) of all parts with the drum centred, computed from the layout; mm."""
    v, drive = s.levels, s.drive
    d, f, pitch = s.drum, s.frame, drive.input_x_mm
    points = [rim_points(d), wrap_points(d, s.flank_mm)]
    # The cable on the largest step of an input pulley may extend beyond frame and drum on both sides.
    on_input = max(step.input_radius_mm for step in s.steps) + s.flank_mm
    body = max(drive.encoder.diameter_mm, drive.gearhead.diameter_mm, drive.motor.diameter_mm) / 2
    ys = [
        v.back_y,
        drive.input_y_mm - body,
        drive.input_y_mm + body,
        v.hub_face_y,
        d.lands[-1].y_end,
        d.web_end_y + 0.5,
        drive.input_y_mm + on_input,
        drive.input_y_mm - on_input,
    ]
    box = s.top_plate.box
    if box is not None:
        ys += [drive.input_y_mm + box.front_y, drive.input_y_mm + box.back_y]
    for t in d.tensioners:
        for _, outline, _, high in bodies_of(s, t, moved=False):
            points.append(outline)
            ys.append(high)
    cloud = np.concatenate(points)
    widest = max(
        v.side_outer_x,
        f.ear_reach,
        drive.drum_encoder.diameter_mm / 2,
        pitch + body,
        pitch + on_input,
    )
    outermost = s.steps[-1].drum_radius_mm + s.flank_mm
    encoder_half = drive.drum_encoder.diameter_mm / 2 * RING_ENCODER_FLATS
    left = min(float(cloud[:, 0].min()), -widest)
    right = max(float(cloud[:, 0].max()), widest)
    bottom = min(
        float(cloud[:, 1].min()), v.motor_bottom_z, v.encoder_bottom_z, -f.boss_radius, -d.hub_radius, -encoder_half
    )
    top = max(v.encoder_top_z, v.motor_top_z, outermost)
    return right - left, top - bottom, max(ys) - min(ys)


_SOURCE = "targets.envelope_mm; paper section 4.1"
_X: tuple[Adjustment, ...] = (
    down("drum.sector_half_angle_deg"),
    up("drum.sector_half_angle_deg"),
    down("support.side_wall_mm"),
)
_Z: tuple[Adjustment, ...] = (
    down("support.coupling_space_mm"),
    up("support.coupling_space_mm"),
    down("support.top_plate_mm"),
    up("support.top_plate_mm"),
)
_Y: tuple[Adjustment, ...] = (down("drum.hub_face_y_mm"), up("drum.hub_face_y_mm"), up("support.back_y_mm"))
CHECKS = (
    *box_checks(box_mm, _SOURCE, (_X, _Z, _Y)),
    mass_check(bill),
)
