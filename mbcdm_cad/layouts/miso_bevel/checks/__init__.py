"""Gaps between turning and fixed parts: the drum with its terminals and the drives, the collars and their space.

The drum is represented by its swept volume over a full turn, each of its zones by a ring: at radius r from the Y axis
no part of it lies nearer to the frame than the zone's y. Drives are cylinders along Z. Cables are sampled over the
travel.
"""

from math import hypot, sqrt
from typing import NamedTuple

import numpy as np

from mbcdm_cad.checks import drum_sector, fixings, geometry, motors, springs, strength, structure, terminals
from mbcdm_cad.checks.comparison import Check, Family, Findings, check, families
from mbcdm_cad.checks.design_variables import Adjustment, down, up
from mbcdm_cad.checks.input_pulley import CHECKS as PULLEY_CHECKS
from mbcdm_cad.checks.size import box_checks, mass_estimate
from mbcdm_cad.checks.transfer import transfer_checks
from mbcdm_cad.design.paths import at
from mbcdm_cad.layouts.bevel_transfer import bevel_box_mm, wrap_checks
from mbcdm_cad.layouts.miso_bevel.cable_path import FREE
from mbcdm_cad.layouts.miso_bevel.checks import support_fits, support_walls
from mbcdm_cad.layouts.miso_bevel.checks.spans import SPANS, STACKS, stacks
from mbcdm_cad.layouts.miso_bevel.checks.support_fits import in_pocket
from mbcdm_cad.layouts.miso_bevel.checks.transmission import BEARINGS, BENDS, GUIDE_FITS, RATIOS, SURFACES, with_guide
from mbcdm_cad.layouts.miso_bevel.layout import BevelLayout
from mbcdm_cad.parts.coupling import collar_sweep_mm
from mbcdm_cad.parts.part import pocket_corner_mm

# Gap between two bodies that both turn in bearings (estimate).
MOVING_GAP_MM = 0.1


class Upright(NamedTuple):
    """A cylinder with an axis parallel to Z at x = +-``x``, ``y``; ``moves``: it turns in bearings of its own."""

    name: str
    x: float
    y: float
    radius: float
    low: float
    high: float
    moves: bool = False


def _collar_reach_mm(s: BevelLayout) -> float:
    return collar_sweep_mm(s.drive)


def uprights(s: BevelLayout) -> list[Upright]:
    """Drives and pulleys, one of each symmetric pair."""
    drive, v = s.drive, s.levels
    x, y, box = drive.input_x_mm, drive.input_y_mm, s.top_plate.box
    bodies = [
        Upright("gearheads", x, y, drive.gearhead.diameter_mm / 2, v.gearhead_bottom_z, v.gearhead_top_z),
        Upright("motors", x, y, drive.motor.diameter_mm / 2, v.motor_bottom_z, v.motor_top_z),
        Upright("encoders", x, y, drive.encoder.diameter_mm / 2, v.encoder_bottom_z, v.encoder_top_z),
        Upright("clamp collars", x, y, _collar_reach_mm(s), *_heights(s, s.collar.bottom_z, s.collar.top_z), True),
    ]
    if box is not None:
        reach = hypot(box.outer_x, max(box.front_y, -box.back_y))
        bodies.append(Upright("coupling boxes", x, y, reach, v.top_plate_top_z, v.motor_shelf_top_z))
    for p in s.inputs:
        radius = max(c.input_radius_mm for c in s.steps if c.input_name == p.name) + s.flank_mm
        heights = _heights(s, p.land_bottom_z, p.land_top_z)
        bodies.append(Upright(f"{p.name} input pulley", x, y, radius, *heights, True))
    return bodies


def _heights(s: BevelLayout, low: float, high: float) -> tuple[float, float]:
    """Heights in the assembly of what lies between two heights from the gearhead."""
    return (-high, -low) if s.drive.motors_above else (low, high)


def ring_gap(ring: geometry.Ring, body: Upright, want: float) -> float:
    """Gap of a swept ring of the drum to a cylinder along Z: along y, else radially if the ring could reach it."""
    along_y = ring.y - body.y - body.radius
    if along_y >= want:
        return along_y
    # The part of the body that reaches the ring's y: |x| within its chord there.
    chord = sqrt(max(body.radius**2 - max(ring.y - body.y - want, 0.0) ** 2, 0.0))
    far_x, near_x = body.x + chord, max(body.x - chord, 0.0)
    near_z = 0.0 if body.low <= 0.0 <= body.high else min(abs(body.low), abs(body.high))
    furthest = hypot(far_x, max(abs(body.low), abs(body.high)))
    return max(along_y, ring.inner - furthest, hypot(near_x, near_z) - ring.outer)


@check(
    "Drum clears drives and pulleys",
    "clearances.running_mm; 0.1 mm between turning bodies: estimate",
    *up(at.transmission.input_setback_mm),
    *down(at.transmission.centre_distance_mm),
    *up(at.transmission.centre_distance_mm, "all radii of transmission", at.support.coupling_space_mm),
    *down(at.support.coupling_space_mm),
    *up(at.drum.rim_inner_radius_mm),
)
def drum_sweep(s: BevelLayout) -> Findings:
    """Gap from drum, terminals and wound cables to drives and pulleys over the whole travel."""
    running = s.drive.clearances.running_mm
    for body in uprights(s):
        for ring in geometry.drum_zones(s):
            want = min(MOVING_GAP_MM, running) if body.moves else running
            yield f"{ring.name} to the {body.name}", ring_gap(ring, body, want), want


@check(
    "Clamp collars turn freely",
    at.clearances.running_mm,
    *up(at.transmission.centre_distance_mm),
    *down(at.support.back_plate_mm, at.support.back_y_mm),
)
def collar_space(s: BevelLayout) -> Findings:
    """Gap from the clamp collars to web, side walls, back plate and the mounting screws' heads, or to their boxes."""
    v, running = s.levels, s.drive.clearances.running_mm
    reach, box, c = _collar_reach_mm(s), s.top_plate.box, s.collar
    if box is None:
        yield from in_pocket(s, "clamp collar", reach)
        return
    low, high = v.from_gearhead.motor_shelf_top_z, v.from_gearhead.bearing_shelf_bottom_z
    corner = pocket_corner_mm(box.corner_radius, 2 * box.inner_x, high - low)
    heads = box.gear_bolt_circle + s.drive.screw(s.drive.gearhead.screw).head_diameter_mm / 2
    for what, gap in (
        ("clamp collar from walls and motor shelf", geometry.corner_gap(reach, c.bottom_z, box.inner_x, low, corner)),
        ("clamp collar from walls and top plate", geometry.corner_gap(reach, -c.top_z, box.inner_x, -high, corner)),
        (f"{s.drive.mounted} screws' heads from the corner", box.inner_x - corner - heads),
    ):
        yield what, gap, running


def _free(s: BevelLayout) -> list[tuple[float, np.ndarray]]:
    """(drum angle in deg, points of all free stretches) at centre and both ends of travel."""
    step = geometry.step_mm(s)
    return [
        (float(np.degrees(angle)), np.concatenate([path.only(FREE).sample(step) for path in paths]))
        for angle, paths in s.extreme_paths
    ]


@check(
    "Free spans clear the terminals",
    "derived; 0.1 mm: estimate",
    *down(at.travel.half_angle_deg),
    *up(at.drum.sector_half_angle_deg, "all radii of transmission"),
)
def spans_clear(s: BevelLayout) -> Findings:
    """Gap from free spans and cables on the guide to the terminals, drum centred and at both ends of travel."""
    d, step = s.drum, geometry.step_mm(s)
    keep = hypot(d.lug_half_width, max(d.nut_pocket, d.lug_half_width)) + s.flank_mm
    for angle, free in _free(s):
        lines, cosine, sine = geometry.in_pieces(free), np.cos(np.radians(angle)), np.sin(np.radians(angle))
        turn = np.array([[cosine, 0.0, sine], [0.0, 1.0, 0.0], [-sine, 0.0, cosine]])
        for t in d.tensioners:
            along = np.linspace(t.slack_start, t.last_tip, int(t.last_tip / step) + 2)
            axis = np.array([(x, t.y_mm, z) for x, z in (t.at(a) for a in along)]) @ turn.T
            what = f"terminal of {t.cable_name} from the free spans with the drum at {angle:+.4g} deg"
            yield what, geometry.nearest_mm(lines, geometry.in_pieces(axis), step) - keep, geometry.CABLE_GAP_MM


SWEEPS = (
    drum_sweep,
    geometry.frame_front,
    collar_space,
    geometry.cables_apart.but(
        adjust=(
            *up(at.transmission.centre_distance_mm, "all radii of transmission"),
            *down(at.travel.half_angle_deg, "rope diameter_mm"),
        )
    ),
    spans_clear,
)


def box_mm(s: BevelLayout) -> tuple[float, float, float]:
    """Box (X, Z, Y) of all parts with the drum centred, computed from the layout; mm."""
    v, drive, box = s.levels, s.drive, s.top_plate.box
    # The cable on the largest step of an input pulley may extend beyond frame and drum on both sides.
    on_input = max(step.input_radius_mm for step in s.steps) + s.flank_mm
    body = max(drive.encoder.diameter_mm, drive.gearhead.diameter_mm, drive.motor.diameter_mm) / 2
    beside = (-body, body, on_input, -on_input, *([] if box is None else [box.front_y, box.back_y]))
    heights = min(v.motor_bottom_z, v.encoder_bottom_z), max(v.encoder_top_z, v.motor_top_z)
    wide = drive.input_x_mm + max(body, on_input)
    return bevel_box_mm(s, wide, heights, [drive.input_y_mm + y for y in beside])


_SOURCE = "targets.envelope_mm; paper section 4.1"
_X: tuple[Adjustment, ...] = (
    *down(at.drum.sector_half_angle_deg),
    *up(at.drum.sector_half_angle_deg),
    *down(at.support.side_wall_mm),
)
_Z: tuple[Adjustment, ...] = (
    *down(at.support.coupling_space_mm),
    *up(at.support.coupling_space_mm),
    *down(at.support.top_plate_mm),
    *up(at.support.top_plate_mm),
)
_Y: tuple[Adjustment, ...] = (*down(at.drum.hub_face_y_mm), *up(at.drum.hub_face_y_mm, at.support.back_y_mm))
ENVELOPE = (*box_checks(box_mm, _SOURCE, (_X, _Z, _Y)), mass_estimate)


__all__ = ["CHECKS", "FAMILIES", "stacks"]

# First the checks of the mechanism, then those of the parts.
FAMILIES = families(
    Family("Eq. (1) row by row, equal total ratio of both inputs, and the tension that a difference causes", RATIOS),
    Family(
        "Pitch radii and surface radii: the surface is cut at r - d/2, which must be a radius that can be machined",
        SURFACES,
    ),
    Family("Bend ratio D/d of the cable: on the pulleys, and at the stop inside the input pulley", BENDS),
    Family(
        "The transfer point: four step planes on one pitch line, lands wide enough, "
        "guide and drum close but not touching",
        transfer_checks("guide", "keep r_o/r_g equal for all steps, as transmission.ratios does"),
    ),
    Family(
        "Free spans between input pulleys and guide: distance, fleet angle, and gap between a span and its last turn.",
        SPANS,
    ),
    Family(
        "Gaps against the sum of the tolerances of the parts: a gap smaller than this sum may vanish in a built drive.",
        STACKS,
    ),
    Family(
        "Wrap on the drum over the travel: more than zero, less than a turn, and compared with the model's slip zones.",
        wrap_checks("guide"),
    ),
    strength,
    motors,
    Family(
        "Bearing loads against static ratings, and the deflection at the gearhead that the pulley's own bearings leave",
        BEARINGS,
    ),
    fixings,
    Family(
        "Input pulley, its stops and its coupling: bores, walls, and room for the parts on and around it",
        with_guide(PULLEY_CHECKS),
    ),
    Family("Guide pulley and its axle: bearings inside, walls round them, bending of the axle", GUIDE_FITS),
    drum_sector,
    structure,
    terminals,
    springs,
    support_walls,
    support_fits,
    Family(
        "Gaps between turning and fixed parts: the drum with its terminals and the drives, the collars and their space",
        SWEEPS,
    ),
    Family("Box and mass against their targets: from the layout, before anything is drawn", ENVELOPE),
)
CHECKS: tuple[Check, ...] = tuple(check for family in FAMILIES for check in family.checks)
