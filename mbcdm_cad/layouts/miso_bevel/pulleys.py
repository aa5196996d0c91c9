"""Dimensions of the input pulleys (with stop slots and coupling) and of the guide pulley with its axle.

Input pulley, axis parallel to Z:

    encoder end  |journal|neck|  upper step  |  lower step  |neck|journal, bored for the gearhead's shaft|

The swaged stop of each cable sits in a slot milled from the end face next to its dead turn. With motors above, the part
is turned about Y by half a turn: (x, y, z) of the part are (-x, y, -z) there, and its lower end is above.
"""

from dataclasses import dataclass, replace
from itertools import pairwise
from math import hypot, pi, radians, tau

from mbcdm_cad.layouts.miso_bevel.cable_path import stop_of, winding
from mbcdm_cad.layouts.miso_bevel.drive import BevelDrive, BevelRun
from mbcdm_cad.layouts.miso_bevel.stack import Band, Stack, band, outward_of
from mbcdm_cad.layouts.sector import coupled_pulley
from mbcdm_cad.parts.drum_sector import sizes
from mbcdm_cad.parts.drum_sector.dims import DrumDims
from mbcdm_cad.parts.drum_sector.sizes import TerminalWay, furthest_anchor_rad
from mbcdm_cad.parts.input_pulley import dims
from mbcdm_cad.parts.terminal import terminal_travel_mm
from mbcdm_cad.parts.turned import AxleDims, IdlerDims


def smallest_lead_mm(drive: BevelDrive) -> float:
    """Least lead of the helix on the input pulleys: turns side by side, or grooves with crests between them."""
    d = drive.cable.diameter_mm
    return dims.GROOVE_LEAD * dims.GROOVE_RADIUS * d if drive.input_pulleys.grooved else d


@dataclass(frozen=True)
class _Wound:
    """One cable on its pulley, in the frame of the part."""

    cable: BevelRun
    band: Band
    stop: dims.StopGeometry
    wound_rad: float  # what it winds at most


def _wound(drive: BevelDrive, name: str) -> tuple[_Wound, _Wound]:
    """The cables of the input ``name``, the one towards its gearhead first."""
    found = []
    for cable in sorted((c for c in drive.cables if c.input_name == name), key=lambda c: c.step):
        on_pulley, stop = band(drive, cable, outward_of(drive, cable)), stop_of(drive, cable)
        if drive.motors_above:
            on_pulley = Band(-on_pulley.high_mm, -on_pulley.low_mm, -on_pulley.dead_end_mm)
            stop = replace(stop, end_angle_rad=pi - stop.end_angle_rad, away=-stop.away)
        wound = tau * drive.dead_turns + 2 * winding(drive, cable).reduction * radians(drive.half_travel_deg)
        found.append(_Wound(cable, on_pulley, stop, wound))
    low, high = reversed(found) if drive.motors_above else found
    return low, high


def input_pulley(drive: BevelDrive, in_assembly: Stack, name: str) -> dims.InputPulleyDims:
    """Dimensions of the input pulley called ``name``; its place is that in the assembly."""
    low, high = _wound(drive, name)
    levels = in_assembly.from_gearhead
    flank = drive.cable.diameter_mm / 2
    bearings = drive.bearings
    beyond = dims.helix_stop_land_mm(drive)
    land_bottom = low.band.low_mm - beyond
    land_top = high.band.high_mm + beyond
    slots = tuple(
        dims.stop_slot(drive, w.cable.name, w.cable.input_radius_mm, w.stop, w.band.dead_end_mm, face)
        for w, face in ((low, land_bottom), (high, land_top))
    )
    grooves = tuple(
        dims.anchored_groove(drive, slot, w.stop, w.wound_rad)
        for w, slot in zip((low, high), slots, strict=True)
        if drive.input_pulleys.grooved
    )
    return coupled_pulley(
        drive,
        levels,
        name=name,
        x=low.cable.input_side * drive.input_x_mm,
        y=drive.input_y_mm,
        lower_neck_radius=dims.neck_radius_mm(bearings.input_lower.inner_shoulder_mm, low.stop),
        land_bottom_z=land_bottom,
        lower_surface_radius=low.cable.input_radius_mm - flank,
        wall_z=(low.band.high_mm + high.band.low_mm) / 2,
        upper_surface_radius=high.cable.input_radius_mm - flank,
        land_top_z=land_top,
        upper_neck_radius=dims.neck_radius_mm(bearings.input_upper.inner_shoulder_mm, high.stop),
        slots=slots,
        grooves=grooves,
    )


def guide(drive: BevelDrive, levels: Stack) -> IdlerDims:
    """Guide pulley: walls in the middle between the steps, so that the landing point may move in both directions."""
    cables = sorted(drive.cables, key=lambda c: c.step)
    flank = drive.cable.diameter_mm / 2
    bearing = drive.bearings.guide
    return IdlerDims(
        bottom_z=levels.guide_bottom_z,
        top_z=levels.guide_top_z,
        surface_radii=tuple(c.guide_radius_mm - flank for c in cables),
        walls_z=tuple((a.drum_radius_mm + b.drum_radius_mm) / 2 for a, b in pairwise(cables)),
        seat_radius=bearing.outer_diameter_mm / 2,
        seat_depth=bearing.width_mm,
        shoulder_radius=bearing.outer_shoulder_mm / 2,
    )


def axle(drive: BevelDrive, levels: Stack) -> AxleDims:
    """Guide axle between bearing shelf and top plate, with the spacer above the upper bearing."""
    bearing = drive.bearings.guide
    return AxleDims(
        radius=bearing.bore_mm / 2,
        bottom_z=levels.bearing_shelf_bottom_z,
        top_z=levels.top_plate_top_z,
        collar_radius=bearing.inner_shoulder_mm / 2,
        collar_bottom_z=levels.bearing_shelf_top_z,
        collar_top_z=levels.guide_bottom_z,
        spacer_bottom_z=levels.guide_top_z,
        spacer_top_z=levels.top_plate_bottom_z,
    )


STOP_PIN_WALL_MM = 1.5


def stop_pin_z(drive: BevelDrive, levels: Stack) -> float:
    """Height of the stop pin: low in the web between the shelves, with metal below it."""
    return levels.shelf_bottom_z + drive.drum.stop_pin_mm / 2 + STOP_PIN_WALL_MM


def longest_mm(drive: BevelDrive, cable: BevelRun, anchor_rad: float) -> float:
    """Length of a cable that leaves its land at ``anchor_rad``, by its pieces; slightly more than the drawn path."""
    w = winding(drive, cable)
    turns = tau * drive.dead_turns + w.reduction * radians(drive.half_travel_deg)
    helix = turns * hypot(cable.input_radius_mm, drive.helix_lead_mm / tau)
    # The bend inward to the stop and the straight end in the terminal: a quarter turn and three diameters each.
    ends = pi / 2 * cable.input_radius_mm + 6.0 * drive.cable.diameter_mm
    return helix + w.free_span_mm + cable.guide_radius_mm * w.guide_wrap_rad + cable.drum_radius_mm * anchor_rad + ends


def terminal_way(drive: BevelDrive) -> TerminalWay:
    """Take-up of all terminals, and the part of it that each uses, mm, for cables anchored as far out as possible."""
    furthest = furthest_anchor_rad(drive)
    return terminal_travel_mm(drive, {c.name: longest_mm(drive, c, furthest) for c in drive.cables})


def drum(drive: BevelDrive, levels: Stack) -> DrumDims:
    """Dimensions of the drum."""
    return sizes.drum(drive, levels, stop_pin_z(drive, levels), terminal_way(drive))
