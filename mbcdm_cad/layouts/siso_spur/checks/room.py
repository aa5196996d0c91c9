"""Gaps between turning and fixed parts, and the box compared with its target."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mbcdm_cad.checks.comparison import Check, Comparison, at_least, worst
from mbcdm_cad.checks.design_variables import Adjustment, down, up
from mbcdm_cad.checks.drum_outline import drum_zones, rim_points, wrap_points
from mbcdm_cad.checks.size import box_checks, mass_check
from mbcdm_cad.checks.terminals import bodies_of
from mbcdm_cad.layouts.siso_spur.bill import bill
from mbcdm_cad.layouts.siso_spur.layout import SpurLayout
from mbcdm_cad.layouts.siso_spur.support.dims import YokeDims
from mbcdm_cad.parts.bought.bodies import RING_ENCODER_FLATS
from mbcdm_cad.parts.drum_sector.dims import DrumDims
from mbcdm_cad.parts.motor_head.dims import body_radius_mm

# Points on a full circle of the outline.
_CORNERS = 72


def frame_front(s: SpurLayout) -> Comparison:
    """Gap from all parts that turn with the drum to plate and boss behind them."""
    v, running, found = s.levels, s.drive.clearances.running_mm, []
    for ring in drum_zones(s):
        if ring.name != "drum's hub":
            found.append(at_least(f"{ring.name} from the front of the plate", ring.y - v.front_y, running, "mm"))
        if ring.inner < s.frame.boss.radius and ring.name != "drum's hub":
            found.append(at_least(f"{ring.name} from the front of the boss", ring.y - v.boss_front_y, running, "mm"))
    found.append(at_least("hub from the front of the boss", s.drum.hub_start_y - v.boss_front_y, running, "mm"))
    return worst(found)


def drum_and_input(s: SpurLayout) -> Comparison:
    """Gap between rim and pulley with their cables."""
    drive, pulley = s.drive, s.inputs[0]
    rim = drive.drum_radius_mm + s.flank_mm
    own = max(pulley.lower_land_radius, drive.input_radius_mm + s.flank_mm)
    return at_least(
        "drum's rim from the input pulley, cables on",
        drive.centre_distance_mm - rim - own,
        drive.clearances.running_mm,
        "mm",
    )


def bodies_behind(s: SpurLayout) -> Comparison:
    """Gap between motor or gearhead and the parts of the drum behind the plate: boss and encoder."""
    drive, boss = s.drive, s.frame.boss
    beside = max(boss.reach, drive.drum_encoder.diameter_mm / 2)
    running, servo = drive.clearances.running_mm, drive.servo
    reach = body_radius_mm(drive) if servo is None else servo.ears_mm / 2 - servo.axis_mm
    gap = drive.centre_distance_mm + s.head.beside_y - reach - beside
    behind = s.levels.back_y - s.levels.motor_shelf_bottom_z
    found = [at_least("motor from the drum's boss and encoder, beside or behind them", max(gap, behind), running, "mm")]
    if s.stage is not None:
        # The box of the wheels is wider than a motor.
        box = drive.centre_distance_mm + s.head.back_y - beside
        found.append(at_least("motor head from the drum's boss and encoder", box, running, "mm"))
    return worst(found)


def _head_mm(s: SpurLayout, f: YokeDims) -> tuple[float, float, float]:
    """Of the motor head: its motor beside the input's axis, half its width, and its front in z."""
    return s.head.beside_y, s.head.outer_x, f.axis_z + s.head.front_y


def outline(s: SpurLayout, f: YokeDims, d: DrumDims) -> NDArray[np.float64]:
    """Points (n, 2) in x and z that bound the box of one input with its sector, the input above the drum; mm."""
    drive = s.drive
    # The plate alone bears a motor that carries the pulley.
    beside, wide_head, front = (0.0, f.half_width, f.plate_top_z) if f.motor else _head_mm(s, f)
    sector = [
        rim_points(d),
        wrap_points(d, s.flank_mm),
        *(o for t in d.tensioners for _, o, _, _ in bodies_of(s, t, moved=False)),
    ]
    encoder = drive.drum_encoder.diameter_mm / 2
    bodies = body_radius_mm(drive)
    wide, low = max(f.half_width, f.boss.ear_reach, encoder), max(f.half_width, d.hub_radius)
    flats = encoder * RING_ENCODER_FLATS
    reach = [(-wide, 0.0), (wide, 0.0), (0.0, -low), (0.0, -flats), (0.0, front)]
    # Motor, gearhead and encoder are round, and the frame's upper corners are rounded.
    angle = np.linspace(0.0, 2 * np.pi, _CORNERS + 1)
    circle = np.stack([np.sin(angle), np.cos(angle)], axis=1)
    corner = np.array([f.half_width, f.plate_top_z]) + f.corner_radius * (circle[: _CORNERS // 4 + 1] - 1.0)
    round_bodies = np.array([0.0, f.axis_z]) + drive.encoder.diameter_mm / 2 * circle
    motor = np.array([0.0, f.axis_z + beside]) + bodies * circle
    heads = np.array([(x, front) for x in (-wide_head, wide_head)])
    return np.concatenate(
        [*sector, np.array(reach), corner, corner * np.array([-1.0, 1.0]), round_bodies, motor, heads]
    )


def box_mm(s: SpurLayout) -> tuple[float, float, float]:
    """Box (X, Z, Y) of all parts with the drum centred, computed from the layout; mm."""
    v = s.levels
    cloud = outline(s, s.frame, s.drum)
    wide, high = cloud.max(axis=0) - cloud.min(axis=0)
    return float(wide), float(high), max(v.hub_face_y, v.encoder_top_z) - min(v.motor_bottom_z, v.back_y)


_X: tuple[Adjustment, ...] = (down("drum.sector_half_angle_deg"), up("drum.sector_half_angle_deg"))
_Z: tuple[Adjustment, ...] = (down("transmission.centre_distance_mm"), up("transmission.centre_distance_mm"))
_Y: tuple[Adjustment, ...] = (down("support.coupling_space_mm"), up("support.coupling_space_mm"))
BOX_ADJUSTMENTS = (_X, _Z, _Y)
ROOM = (
    Check(
        "frame_front",
        "Drum clears the frame",
        "clearances.running_mm",
        frame_front,
        advice="choose a smaller drum.tensioner",
    ),
    Check(
        "drum_and_input",
        "Drum and input clear each other",
        "clearances.running_mm",
        drum_and_input,
        adjust=_Z[1:],
    ),
    Check(
        "bodies_behind",
        "Motor clears the drum's boss and encoder",
        "clearances.running_mm",
        bodies_behind,
        adjust=(up("transmission.centre_distance_mm"), up("support.coupling_space_mm")),
    ),
)
CHECKS = (
    *ROOM,
    *box_checks(box_mm, "targets.envelope_mm", BOX_ADJUSTMENTS),
    mass_check(bill),
)
