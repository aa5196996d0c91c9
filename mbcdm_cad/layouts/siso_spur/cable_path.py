"""The drawn line of the cables.

The centre line is drawn at a given drum angle: of one cable from terminal to terminal, of two from their stops. Input,
span and drum have the same helix angle: the turns move along the input by one lead a turn, each span leaves in line
with them, and on the drum the cable lies on a helix of the same slope. The cable therefore bends in no other direction
at any angle of the drum, and the landing points move along the drum together with the turns on the input. Beyond the
last point that ever leaves the drum, the cable changes into the plane of its terminal.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from math import cos, pi, radians, sin, tan, tau

import numpy as np

from mbcdm_cad.layouts.siso_spur.drive import CHANGE_RAD, SpurDrive, SpurRun, contact_rad
from mbcdm_cad.layouts.siso_spur.routes import SENSE
from mbcdm_cad.parts.drum_sector import design, sizes
from mbcdm_cad.parts.input_pulley.dims import STOP_PIECES, StopGeometry, stop_geometry, stop_pieces
from mbcdm_cad.routes import curves
from mbcdm_cad.routes.curves import Piece as Drawn

_Y, _Z = (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)


# Way of a terminal that a whole drum's cable counts as drawn in (estimate: more than any of the catalogue has).
DRAWN_IN_MM = 10.0
ON_INPUT = ("wound",)
_ON_DRUM = ("drum", "lay", "dead", "tail")


def led_names(drive: SpurDrive) -> tuple[str, ...]:
    """Names of the pieces between input and drum: spans and, between them, wraps on idlers."""
    between = tuple(name for n in range(1, len(drive.idler_places) + 1) for name in (f"idler_{n}", f"span_{n + 1}"))
    return ("span", *between)


def input_wrap_rad(drive: SpurDrive, cable: design.SectorRun, drum_angle_rad: float) -> float:
    """Wrap of one side on the input, from the cable's middle or stop, at a drum angle.

    It decreases with the drum angle for a side that runs to +x. Negative if the middle has left the input.
    """
    return drive.wound_rad - cable.drum_side * drive.total_ratio * drum_angle_rad


def walked_mm(drive: SpurDrive, drum_angle_rad: float) -> float:
    """Movement of turns, spans and landing points along y since the centred drum."""
    return drive.input_radius_mm * drive.slope * drive.total_ratio * drum_angle_rad


def side_pieces(drive: SpurDrive, cable: SpurRun, anchor_rad: float, tail_mm: float, angle_rad: float) -> list[Drawn]:
    """Pieces of one side at a drum angle, from the point where it leaves the input to its terminal.

    ``anchor_rad``: angle on the drum, from +Z towards the cable's side, at which the cable leaves its land with the
    drum centred; ``tail_mm``: straight length from there into the terminal.
    """
    side, r_i, r_o = cable.drum_side, cable.input_radius_mm, cable.drum_radius_mm
    middle = drive.level_mm + walked_mm(drive, angle_rad)
    leave, land = (middle + cable.outward * y for y in (drive.leave_mm, drive.land_mm))
    at = contact_rad(drive, side)
    off = (r_i * sin(at), leave, drive.centre_distance_mm + r_i * cos(at))

    def on_drum(angle: float, y: float, radius: float = r_o) -> curves.Triple:
        return (side * radius * sin(angle), y, radius * cos(angle))

    # Angles on the drum from +Z towards the cable's side.
    moved, landing = side * angle_rad, drive.landing_rad
    start = landing + radians(drive.half_travel_deg) + CHANGE_RAD + moved
    last, end = start + CHANGE_RAD, start + 2 * CHANGE_RAD
    plane = cable.terminal_y_mm
    # Direction along y in which the helix continues: away from the middle, or for two anchored cables across it.
    onward = -cable.outward if drive.anchored else cable.outward
    start_y = plane - onward * r_o * drive.slope * tan(CHANGE_RAD)
    anchor = anchor_rad + moved
    along = np.array([side * cos(anchor), 0.0, -sin(anchor)])
    leaving = np.array(on_drum(anchor, plane))
    return [
        *_led(drive, side, off, on_drum(landing, land)),
        curves.Coil((0.0, 0.0, 0.0), _Y, _Z, r_o, side * landing, side * start, land, start_y),
        curves.Parabola(on_drum(start, start_y), on_drum(last, plane, r_o / cos(CHANGE_RAD)), on_drum(end, plane)),
        curves.Arc((0.0, plane, 0.0), _Z, (float(side), 0.0, 0.0), r_o, end, anchor),
        curves.Line(curves.triple(leaving), curves.triple(leaving + tail_mm * along)),
    ]


def _led(drive: SpurDrive, side: int, off: curves.Triple, on: curves.Triple) -> list[Drawn]:
    """Spans and wraps on idlers between the points where a side leaves the input and lands on the drum."""
    found, r, pieces, start = drive.strand, drive.idler_mm, list[Drawn](), off
    for place, before, span, wrap in zip(drive.idler_places, found.heading, found.length, found.wraps, strict=False):
        slope = (on[1] - off[1]) / drive.strand_mm
        y = start[1] + slope * float(span)
        end_y = y + slope * r * float(wrap)
        # Where the span touches: the axis and a quarter of a turn from its direction.
        first = float(before) - SENSE * pi / 2
        last = first + SENSE * float(wrap)
        centre, ends = (side * place.x_mm, 0.0, place.z_mm), []
        for angle, at_y in ((first, y), (last, end_y)):
            ends.append((centre[0] + side * r * sin(angle), at_y, centre[2] + r * cos(angle)))
        pieces += [curves.Line(start, ends[0]), curves.Coil(centre, _Y, _Z, r, side * first, side * last, y, end_y)]
        start = ends[1]
    return [*pieces, curves.Line(start, on)]


def cable_paths(
    drive: SpurDrive, anchors: Mapping[str, tuple[float, float]], angle_rad: float
) -> tuple[curves.CablePath, ...]:
    """Centre lines at a drum angle; ``anchors``: (anchor_rad, tail_mm) of each side by its name."""
    if drive.anchored:
        return tuple(anchored_path(drive, c, anchors[c.name], angle_rad) for c in drive.cables)
    return (cable_path(drive, anchors, angle_rad),)


def stop_of(drive: SpurDrive, cable: SpurRun) -> StopGeometry:
    """End of an anchored cable in the input pulley; its angle is in the frame of the pulley."""
    end = contact_rad(drive, cable.drum_side) - pi / 2 + cable.drum_side * drive.wound_rad
    return stop_geometry(drive, cable.input_radius_mm, end, cable.drum_side)


# A stretch of a path: the body that it lies on, and its pieces by their names.
_Part = tuple[str | None, list[tuple[str, Drawn]]]


def _path(run: SpurRun, angle_rad: float, parts: Sequence[_Part]) -> curves.CablePath:
    pieces = tuple(piece for _, named in parts for piece in named)
    stretches = tuple(curves.Stretch(body, tuple(name for name, _ in named)) for body, named in parts)
    return curves.CablePath(run, angle_rad, pieces, stretches)


def _side(drive: SpurDrive, cable: SpurRun, end: tuple[float, float], angle_rad: float, mark: str = "") -> list[_Part]:
    """A side from the input on; ``mark`` follows the names of its pieces."""
    led = led_names(drive)
    pieces = zip((*led, *_ON_DRUM), side_pieces(drive, cable, *end, angle_rad), strict=True)
    named = [(f"{name}{mark}", piece) for name, piece in pieces]
    return [(None, named[: len(led)]), ("drum", named[len(led) :])]


def anchored_path(drive: SpurDrive, cable: SpurRun, end: tuple[float, float], angle_rad: float) -> curves.CablePath:
    """Centre line of one of two anchored cables, from the end of its stop; ``end``: (anchor_rad, tail_mm)."""
    axis = (0.0, 0.0, drive.centre_distance_mm)
    leave = drive.level_mm + walked_mm(drive, angle_rad) + cable.outward * drive.leave_mm
    wrap = input_wrap_rad(drive, cable, angle_rad)
    at = contact_rad(drive, cable.drum_side)
    stop, stop_y = at + cable.drum_side * wrap, leave + cable.outward * drive.helix_lead_mm * wrap / tau
    wound = curves.Coil(axis, _Y, _Z, cable.input_radius_mm, stop, at, stop_y, leave)
    start = wound.points(np.array([0.0]))[0]
    radial = np.array([sin(stop), 0.0, cos(stop)])
    ends = stop_pieces(start, radial, -wound.tangent(0.0), cable.input_radius_mm, stop_of(drive, cable))
    on_input = list(zip((*STOP_PIECES, *ON_INPUT), (*ends, wound), strict=True))
    return _path(cable, angle_rad, [(f"input_{cable.input_name}", on_input), *_side(drive, cable, end, angle_rad)])


def cable_path(drive: SpurDrive, anchors: Mapping[str, tuple[float, float]], angle_rad: float) -> curves.CablePath:
    """Centre line of the one cable, which has the name of its input; arguments as of :func:`cable_paths`."""
    first, second = drive.cables
    back, on = (_side(drive, c, anchors[c.name], angle_rad, f"_{c.name}") for c in (first, second))
    at, axis = contact_rad(drive, first.drum_side), (0.0, 0.0, drive.centre_distance_mm)
    end = at + drive.input_sense * first.drum_side * drive.wrap_rad
    middle = drive.level_mm + walked_mm(drive, angle_rad)
    leave = [middle + c.outward * drive.leave_mm for c in (first, second)]
    wound = curves.Coil(axis, _Y, _Z, drive.input_radius_mm, at, end, *leave)
    to_input = [(body, [(name, curves.reverse(piece)) for name, piece in named[::-1]]) for body, named in back[::-1]]
    parts: list[_Part] = [*to_input, (f"input_{first.input_name}", [(ON_INPUT[0], wound)]), *on]
    return _path(replace(first, name=first.input_name), angle_rad, parts)


def side_length_mm(drive: SpurDrive, cable: SpurRun, anchor_rad: float, tail_mm: float) -> float:
    """Length of one side, from the middle of the cable or the end of its stop to the bottom of the swage's bore."""
    wound = drive.input_radius_mm * drive.stretched * drive.wound_rad
    if drive.anchored:
        wound += stop_length_mm(stop_of(drive, cable), cable.input_radius_mm)
    return wound + sum(piece.length_mm for piece in side_pieces(drive, cable, anchor_rad, tail_mm, 0.0))


def stop_length_mm(stop: StopGeometry, radius_mm: float) -> float:
    """Length of bend and chord in the input pulley."""
    return pi / 2 * stop.bend_radius_mm + (radius_mm - stop.bend_radius_mm) - stop.stop_end_mm


def longest_mm(drive: SpurDrive, anchor_rad: float) -> float:
    """Upper estimate of the length of a side that leaves its land at ``anchor_rad``."""
    wound = drive.input_radius_mm * drive.wound_rad + drive.strand_mm
    if drive.anchored:
        first = drive.cables[0]
        wound += stop_length_mm(stop_of(drive, first), first.input_radius_mm)
    on_drum = drive.drum_radius_mm * max(anchor_rad - drive.landing_rad, 0.0)
    tail = 6.0 * drive.cable.diameter_mm
    if drive.whole_drum:
        # The terminal lies at ``anchor_rad`` itself, not before it: the rope in the sleeve counts, drawn in.
        tail = max(tail, sizes.SWAGE_START_MM + drive.tensioner.swage_length_mm + DRAWN_IN_MM)
    return (wound + on_drum) * drive.stretched + tail
