"""The checks of this layout; the families in the order in which they run and are shown."""

from collections.abc import Iterator
from dataclasses import replace
from math import degrees, inf, sqrt

import numpy as np

from mbcdm_cad.checks import bearings, drum_sector, fixings, motor_head, motors, springs, strength, structure, terminals
from mbcdm_cad.checks.comparison import Comparison, Family, Findings, at_least, at_most, check, families
from mbcdm_cad.checks.design_variables import Adjustment, down, up
from mbcdm_cad.checks.geometry import cables_apart, corner_gap, drum_zones, frame_front
from mbcdm_cad.checks.input_pulley import CHECKS as PULLEY_CHECKS
from mbcdm_cad.checks.motor_head import boss_walls, encoder_shelf
from mbcdm_cad.checks.ratios import BENDING, anchor_bend, pair_mismatch, spread, surface_radius
from mbcdm_cad.checks.run import rounded
from mbcdm_cad.checks.size import box_checks, mass_estimate
from mbcdm_cad.checks.transfer import TransferStacks, ratio_contributions, transfer_checks, transmission_error
from mbcdm_cad.design.paths import at
from mbcdm_cad.layouts.bevel_transfer import bevel_box_mm, cut_at_pitch, transfer_stacks, wrap_checks
from mbcdm_cad.layouts.siso_bevel.cable_path import full_input_turn_deg, taken_rad
from mbcdm_cad.layouts.siso_bevel.design_file import DirectDrive
from mbcdm_cad.layouts.siso_bevel.layout import DirectLayout
from mbcdm_cad.layouts.siso_bevel.support import MOUNT_HEAD_ROOM_MM, POCKET_FLAT_MM
from mbcdm_cad.model.tolerance import StackUp, tightest
from mbcdm_cad.parts.motor_head.dims import dowel_length_mm, flange_screw

TURN_DEG = 360.0
# Wrap left before the stop's bend on the unwound pulley, so that the cable never pulls at the bend (estimate).
LEAST_RESERVE_DEG = 15.0
# The slot changes little with the ratio, so a few iterations are enough.
_ROUNDS = 30
_WALL = "material: min_wall_mm"
_SHELVES: tuple[Adjustment, ...] = up(at.support.bearing_shelf_mm, at.support.encoder_shelf_mm)
_DEEPER: tuple[Adjustment, ...] = down(at.support.back_y_mm, at.support.back_plate_mm)


def _radii_that_agree(s: DirectLayout) -> str:
    first = s.steps[0]
    radii = ", ".join(f"{c.drum_radius_mm * first.input_radius_mm / first.drum_radius_mm:.5g}" for c in s.steps)
    return f"with step 1 kept, input_radii_mm: [{radii}] gives both steps one ratio"


@check("Eq. (1): both steps have one ratio", "paper Eq. (1), without a guide", advice=_radii_that_agree)
def eq1_one_ratio(s: DirectLayout) -> Comparison:
    """r_m/r_o is the same for both steps."""
    return spread("r_m/r_o", [c.input_radius_mm / c.drum_radius_mm for c in s.steps], s.steps)


def _ratio_that_fits(s: DirectLayout) -> str:
    """Remedy: the highest ratio for this travel, which the paper calls restricted within the available work space."""
    try:
        ratio = highest_ratio(s.drive)
    except ValueError as error:
        return str(error)
    if ratio <= 0.0:
        return "no ratio fits: lower transmission.reserve_deg"
    return (
        f"a total ratio of at most {rounded(ratio)} for this travel; a guide between input and drum (miso_bevel) "
        "allows more, because its inputs can wind any number of turns"
    )


@check(
    "Wrap on the input stays under a turn",
    "derived: the transfer point stays in its plane; paper section 2.1",
    *down(at.transmission.input_to_drum, at.travel.half_angle_deg, at.transmission.reserve_deg),
    advice=_ratio_that_fits,
)
def input_under_turn(s: DirectLayout) -> Findings:
    """Sum of ratio x full travel, reserve and the angle of the stop's slot, compared with one turn of the input."""
    s.require_geometry()  # without a layout there is no slot
    for c in s.steps:
        ratio, taken = c.drum_radius_mm / c.input_radius_mm, degrees(taken_rad(s.drive, c))
        travel = 2 * s.drive.half_travel_deg
        note = f"{ratio:.4g} x {travel:g} deg of travel + {s.drive.reserve_deg:g} reserve + {taken:.3g} for the slot"
        what = f"turn of the input that {c.name} takes up"
        yield at_most(what, full_input_turn_deg(s.drive, c), TURN_DEG, "deg", note)


@check("Wrap that stays on the input", "15 deg: estimate", *up(at.transmission.reserve_deg))
def input_reserve(s: DirectLayout) -> Comparison:
    """Wrap that stays on the input at the unwound end."""
    return at_least("wrap left on the input, all unwound", s.drive.reserve_deg, LEAST_RESERVE_DEG, "deg")


def highest_ratio(drive: DirectDrive) -> float:
    """The total ratio that uses one turn of the input over this travel, with the same drum radii; 0 if there is none.

    A smaller pulley has a slot of a larger angle, so that both are found together. Raises ValueError if the pulley is
    too small for a stop.
    """
    ratio = 1.0
    for _ in range(_ROUNDS):
        taken = max(
            degrees(taken_rad(drive, replace(c, input_radius_mm=c.drum_radius_mm / ratio))) for c in drive.cables
        )
        ratio = (TURN_DEG - drive.reserve_deg - taken) / (2 * drive.half_travel_deg)
        if ratio <= 0.0:
            return 0.0
    return ratio


_INPUT = TransferStacks("input", "bearings in frame and motor head")


def stacks(s: DirectLayout) -> Iterator[StackUp]:
    """The stack of each gap and of each ratio; of several, the one with the least reserve."""
    for of in (_INPUT.gap, _INPUT.bodies_clear, _INPUT.land_edge):
        yield tightest(of(s))
    for c in s.steps:
        yield StackUp(f"total ratio of {c.name}, relative", np.inf, ratio_contributions(s.drive, c))


@check(
    "Walls of frame and motor head are thick enough",
    _WALL,
    *up(at.support.back_plate_mm, at.support.side_wall_mm, at.support.motor_shelf_mm),
    *_SHELVES,
    *up(at.support.rib_mm),
)
def walls(s: DirectLayout) -> Findings:
    """The thinnest wall of frame and motor head, against the minimum of the material."""
    support, f = s.drive.support, s.frame
    names = ("back_plate_mm", "side_wall_mm", "motor_shelf_mm", "bearing_shelf_mm", "encoder_shelf_mm", "rib_mm")
    limit = s.drive.frame_material.min_wall_mm
    for name in names:
        yield f"support.{name}", getattr(support, name), limit
    pin = (f.stop_shelf_top_z - f.stop_shelf_bottom_z) / 2 - f.stop_pin_radius
    yield "stop shelf over and under its pin", pin, limit
    yield "wall of the motor head", s.head.outer_x - s.head.inner_x, limit


@check("Corners fit frame and pockets", "material: min_internal_radius_mm", *_DEEPER)
def pockets(s: DirectLayout) -> Findings:
    """Frame and pockets are larger than the rounded corners that the milling cutter leaves."""
    v, f = s.levels, s.frame
    for name, size in (
        ("frame's depth", v.front_y - v.back_y),
        ("width of the pulley's box", 2 * v.side_inner_x),
        ("column's pocket", f.encoder_shelf_bottom_z - f.stop_shelf_top_z),
        ("lower pocket", f.stop_shelf_bottom_z - f.low_pocket_bottom_z),
    ):
        yield f"{name} over two corner radii", size - 2 * f.corner_radius, POCKET_FLAT_MM


@check("Shelves take the input's bearings", _WALL, *_SHELVES)
def bearing_seats(s: DirectLayout) -> Findings:
    """Shoulders of the shelves behind their bearings, and walls in front of the seats."""
    drive, v, limit = s.drive, s.levels, s.drive.frame_material.min_wall_mm
    what = "shoulder over the bearing next to the gearhead"
    yield (what, drive.support.bearing_shelf_mm - drive.bearings.input_lower.width_mm, limit)
    yield (
        "shoulder under the bearing next to the encoder",
        drive.support.encoder_shelf_mm - drive.bearings.input_upper.width_mm,
        limit,
    )
    yield "front wall beside the bearing next to the gearhead", v.front_y - s.head.seat_radius, limit
    yield "front wall beside the bearing next to the encoder", v.front_y - s.frame.seat_radius, limit


@check("Input pulley turns freely in its box", at.clearances.running_mm, *_DEEPER)
def pulley_room(s: DirectLayout) -> Findings:
    """Gap of pulley and cables to back plate and side walls, whose corners are rounded."""
    v, f, running = s.levels, s.frame, s.drive.clearances.running_mm
    p = s.inputs[0]
    reach = max(c.input_radius_mm for c in s.steps) + s.flank_mm
    yield "input pulley, cables on, from the back plate", -v.pocket_floor_y - reach, running
    edges = [(p.upper_surface_radius, -p.land_top_z)]
    edges += [(c.input_radius_mm + s.flank_mm, c.drum_radius_mm - s.flank_mm) for c in s.steps]
    for x, z in edges:
        gap = corner_gap(x, z, v.side_inner_x, f.encoder_shelf_top_z, f.corner_radius)
        yield "input pulley, cables on, from the box's side and its corner", gap, running


@check("Encoder clears the column", at.clearances.running_mm, *_DEEPER, advice="choose a smaller drive.encoder")
def encoder_room(s: DirectLayout) -> Findings:
    """Gap of the encoder to the corners of the column's pocket, the back plate and the heads of the mounting screws."""
    v, f, encoder = s.levels, s.frame, s.drive.encoder
    radius = encoder.diameter_mm / 2
    heads = v.pocket_floor_y + s.mounting.height_mm(s.mount_washers)
    for name, gap in (
        ("corner of its pocket", f.pocket_half_width - f.corner_radius - radius),
        ("heads of the mounting screws", -radius - heads),
        ("stop shelf", -v.encoder_top_z - f.stop_shelf_top_z),
    ):
        yield f"encoder from the {name}", gap, s.drive.clearances.running_mm


@check(
    "Room for the heads of the mounting screws",
    "heads of ISO 4762; 0.5 mm: estimate",
    *up("all radii of transmission"),
    advice="choose a shorter drive.encoder",
)
def mounts(s: DirectLayout) -> Findings:
    """The heads of the mounting screws fit on the flat floor of both pockets of the column."""
    f, head = s.frame, s.mounting.seat_mm(s.mount_washers) / 2
    _, (x, high), _, (_, low) = f.mounts
    for name, room in (
        ("side of the pocket", f.pocket_half_width - x - head),
        ("height of the upper pocket", f.encoder_shelf_bottom_z - high - head),
        ("height of the lower pocket", f.stop_shelf_bottom_z - low - head),
        ("each other", x - head),
    ):
        yield f"mounting screw's head: {name}", room, MOUNT_HEAD_ROOM_MM


@check(
    "Motor head is held and located",
    "usual rule: one diameter",
    *up(at.support.side_wall_mm),
    *down(at.support.bearing_shelf_mm),
)
def flange(s: DirectLayout) -> Findings:
    """Screws and dowels of the motor head are inside the side walls, engage by their diameter, and are apart."""
    f, drive = s.frame, s.drive
    limit, wall = drive.frame_material.min_wall_mm, drive.support.side_wall_mm
    screw, shelf = flange_screw(drive), drive.support.bearing_shelf_mm
    (x, front), _, (_, back), _ = f.flange_screws
    dowel_y, gap = f.dowels[0][1], f.flange_screw_radius + f.dowel_radius
    heads = abs(x) - screw.head_diameter_mm / 2 - s.head.outer_x
    what = f"side wall beside a flange screw's {'insert' if f.flange_insert else 'thread'}"
    yield (what, wall / 2 - f.flange_screw_radius, f.flange_insert.wall_mm if f.flange_insert else limit)
    yield "side wall beside a dowel", wall / 2 - f.dowel_radius, limit
    yield "metal between flange screw and dowel", min(front - dowel_y, dowel_y - back) - gap, limit
    yield (
        "engaged length of a flange screw over its diameter",
        min(screw.length_mm - shelf, f.flange_insert.length_mm if f.flange_insert else inf) - screw.thread_mm,
        0.0,
    )
    yield "engaged length of a dowel over its diameter", dowel_length_mm(drive) - shelf - 2 * f.dowel_radius, 0.0
    yield "heads of the flange screws from the motor head's wall", heads, 0.1


@check("Boss takes drum bearings and encoder", _WALL, *down(at.support.back_y_mm))
def boss(s: DirectLayout) -> Findings:
    """Walls of the boss round both drum bearings and their shoulder, and of its ears round the encoder's screws."""
    f, limit = s.frame, s.drive.frame_material.min_wall_mm
    yield "lower pocket above the boss", f.low_pocket_bottom_z - f.boss.radius, limit
    yield from boss_walls(s)


@check(
    "Drum clears motor and gearhead",
    at.clearances.running_mm,
    *up("all radii of transmission"),
    *down(at.transmission.input_to_drum),
)
def drum_sweep(s: DirectLayout) -> Findings:
    """Gap of drum and terminals to encoder, motor head, gearhead and motor behind them, where they reach their height.

    The encoder is a cylinder about z below the pulley; the others are above it.
    """
    drive, v, head, running = s.drive, s.levels, s.head, s.drive.clearances.running_mm
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
            yield f"{ring.name} before the encoder", ring.y - deep, running
        for name, z, y in above:
            if ring.top > z:
                yield f"{ring.name} before the {name}", ring.y - y, running


def box_mm(s: DirectLayout) -> tuple[float, float, float]:
    """Box (X, Z, Y) of all parts with the drum centred, computed from the layout; mm."""
    v, drive = s.levels, s.drive
    bodies = max(drive.gearhead.diameter_mm, drive.motor.diameter_mm) / 2
    reach = max(c.input_radius_mm for c in s.steps) + s.flank_mm
    return bevel_box_mm(s, max(s.frame.column_half_width, bodies), (inf, -v.motor_bottom_z), (reach,))


_RADII = up("all radii of transmission")
_X = (*down(at.drum.sector_half_angle_deg), *up(at.drum.sector_half_angle_deg))
_Z = (*down(at.support.coupling_space_mm), *up(at.support.coupling_space_mm))
_Y = (*down(at.drum.hub_face_y_mm), *up(at.drum.hub_face_y_mm, at.support.back_y_mm))
# First the checks of the mechanism, then those of the parts.
FAMILIES = families(
    Family(
        "Radii: one ratio of both steps (Eq. (1) without a guide), surfaces that can be cut, permissible bends of the "
        "rope.",
        (
            eq1_one_ratio,
            pair_mismatch.but(advice=_radii_that_agree),
            surface_radius,
            cut_at_pitch,
            *BENDING,
            anchor_bend,
        ),
    ),
    Family(
        "Wrap on the input under one turn: the cable stays in the plane of its transfer point, so it has no second "
        "turn.",
        (input_under_turn, input_reserve),
    ),
    Family(
        "The transfer point: both step planes on one pitch line, lands wide enough, "
        "input and drum close but not touching",
        transfer_checks("input pulley", "keep r_o/r_m equal for both steps, as transmission.input_to_drum does"),
    ),
    Family(
        "Gaps at the transfer compared with the tolerances of the parts, and the transmission error.",
        (*transfer_stacks(_INPUT), transmission_error),
    ),
    Family(
        "Wrap on the drum over the travel: more than zero, less than a turn, clear of the input, compared with the "
        "slip zones.",
        wrap_checks("input"),
    ),
    strength,
    motors,
    bearings,
    fixings,
    Family(
        "Input pulley, its stops and its coupling: bores, walls, and room for the parts on and around it", PULLEY_CHECKS
    ),
    drum_sector,
    structure,
    terminals,
    springs,
    Family(
        "Frame: walls thick enough to be made, metal round its holes, space for the encoder and the heads of the "
        "screws.",
        (walls, pockets, bearing_seats, encoder_shelf, pulley_room, encoder_room, mounts, flange, boss),
    ),
    motor_head,
    Family(
        "Gaps between turning and fixed parts, distance between cables, and the box compared with its target.",
        (
            frame_front,
            drum_sweep,
            cables_apart.but(adjust=(_RADII, *down("rope diameter_mm"))),
            *box_checks(box_mm, at.targets.envelope_mm, (_X, _Z, _Y)),
            mass_estimate,
        ),
    ),
)
