"""The true centre line of the cable at a given drum angle, from one terminal to the other.

One helix angle all the way: the turns walk along the input by one lead a turn, each span leaves in line with them, and
on the drum the cable lies on a helix of the same slope. So nothing bends sideways at any angle of the drum, and the
landing points walk with the input. Past the last point that ever leaves the drum it goes over into the plane of its
terminal.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from math import cos, radians, sin, tan

import numpy as np

from mbcdm_cad.configurations.siso_spur.drive import CHANGE_RAD, SpurDrive, SpurRun, contact_rad
from mbcdm_cad.routes.cable_path import CablePath, Stretch
from mbcdm_cad.routes.curves import Arc, Coil, Line, Parabola, Piece, Triple, Vector, reverse

ON_INPUT = ("wound",)
_Y, _Z = (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)
_SIDE = ("span", "drum", "lay", "dead", "tail")


def input_wrap_rad(drive: SpurDrive, cable: SpurRun, drum_angle_rad: float) -> float:
    """Wrap of one side on the input, from the cable's middle; a side that runs to +x leaves it as the drum turns.

    Below zero where the cable's middle has left the input.
    """
    return drive.wrap_rad / 2 - cable.drum_side * drive.total_ratio * drum_angle_rad


def walked_mm(drive: SpurDrive, drum_angle_rad: float) -> float:
    """How far the turns, the spans and the landing points have walked along y from the centred drum."""
    return drive.input_radius_mm * drive.slope * drive.total_ratio * drum_angle_rad


def _t(v: Vector) -> Triple:
    return (float(v[0]), float(v[1]), float(v[2]))


def side_pieces(drive: SpurDrive, cable: SpurRun, anchor_rad: float, tail_mm: float, angle_rad: float) -> list[Piece]:
    """Pieces of one side at a drum angle, from where it leaves the input to its terminal.

    ``anchor_rad``: angle on the drum, from +Z towards the cable's side, where the cable leaves its land with the drum
    centred; ``tail_mm``: straight length from there into the terminal.
    """
    side, r_i, r_o = cable.drum_side, cable.input_radius_mm, cable.drum_radius_mm
    middle = drive.level_mm + walked_mm(drive, angle_rad)
    leave, land = (middle + cable.outward * y for y in (drive.leave_mm, drive.land_mm))
    at = contact_rad(drive, side)

    def on_drum(angle: float, y: float, radius: float = r_o) -> Triple:
        return (side * radius * sin(angle), y, radius * cos(angle))

    # Angles on the drum from +Z towards the cable's side.
    moved, landing = side * angle_rad, drive.landing_rad
    start = landing + radians(drive.half_travel_deg) + CHANGE_RAD + moved
    last, end = start + CHANGE_RAD, start + 2 * CHANGE_RAD
    plane = cable.terminal_y_mm
    start_y = plane - cable.outward * r_o * drive.slope * tan(CHANGE_RAD)
    anchor = anchor_rad + moved
    along = np.array([side * cos(anchor), 0.0, -sin(anchor)])
    leaving = np.array(on_drum(anchor, plane))
    return [
        Line((r_i * sin(at), leave, drive.centre_distance_mm + r_i * cos(at)), on_drum(landing, land)),
        Coil((0.0, 0.0, 0.0), _Y, _Z, r_o, side * landing, side * start, land, start_y),
        Parabola(on_drum(start, start_y), on_drum(last, plane, r_o / cos(CHANGE_RAD)), on_drum(end, plane)),
        Arc((0.0, plane, 0.0), _Z, (float(side), 0.0, 0.0), r_o, end, anchor),
        Line(_t(leaving), _t(leaving + tail_mm * along)),
    ]


def cable_path(drive: SpurDrive, anchors: Mapping[str, tuple[float, float]], angle_rad: float) -> CablePath:
    """Centre line of the whole cable at a drum angle; ``anchors``: (anchor_rad, tail_mm) of each side by its name.

    It is named as the input that it goes round.
    """
    first, second = drive.cables
    ends = [side_pieces(drive, c, *anchors[c.name], angle_rad) for c in (first, second)]
    at = contact_rad(drive, first.drum_side)
    middle = drive.level_mm + walked_mm(drive, angle_rad)
    leave = [middle + c.outward * drive.leave_mm for c in (first, second)]
    wound = Coil(
        (0.0, 0.0, drive.centre_distance_mm),
        _Y,
        _Z,
        drive.input_radius_mm,
        at,
        at + first.drum_side * drive.wrap_rad,
        leave[0],
        leave[1],
    )
    names = [[f"{name}_{c.name}" for name in _SIDE] for c in (first, second)]
    pieces: tuple[tuple[str, Piece], ...] = (
        *((name, reverse(piece)) for name, piece in zip(names[0][::-1], ends[0][::-1], strict=True)),
        (ON_INPUT[0], wound),
        *zip(names[1], ends[1], strict=True),
    )
    stretches = (
        Stretch("drum", tuple(names[0][:0:-1])),
        Stretch(None, (names[0][0],)),
        Stretch(f"input_{first.input_name}", ON_INPUT),
        Stretch(None, (names[1][0],)),
        Stretch("drum", tuple(names[1][1:])),
    )
    return CablePath(replace(first, name=first.input_name), angle_rad, pieces, stretches)


def side_length_mm(drive: SpurDrive, cable: SpurRun, anchor_rad: float, tail_mm: float) -> float:
    """Length of one side, from the middle of the cable to the bottom of the swage's bore."""
    wound = drive.input_radius_mm * drive.stretched * drive.wrap_rad / 2
    return wound + sum(piece.length_mm for piece in side_pieces(drive, cable, anchor_rad, tail_mm, 0.0))


def longest_mm(drive: SpurDrive, anchor_rad: float) -> float:
    """Length of a side that leaves its land at ``anchor_rad``, a little more than the drawn path."""
    wound = drive.input_radius_mm * drive.wrap_rad / 2 + drive.free_span_mm
    on_drum = drive.drum_radius_mm * max(anchor_rad - drive.landing_rad, 0.0)
    return (wound + on_drum) * drive.stretched + 6.0 * drive.cable.diameter_mm
