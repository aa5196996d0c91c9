"""Dimensions of the input pulleys (with stop slots and coupling) and of the guide pulley with its axle.

Input pulley, axis parallel to Z:

    encoder end  |journal|neck|  upper step  |  lower step  |neck|journal, bored for the gearhead's shaft|

The swaged stop of each cable sits in a slot milled from the end face next to its dead turn: the slot leads the cable
inward around a radius and ends in a pocket that holds the stop.
"""

from __future__ import annotations

from itertools import pairwise
from math import acos, radians, tau

from mbcdm_cad.configurations.miso_bevel.cable_path import StopGeometry, stop_geometry, winding
from mbcdm_cad.configurations.miso_bevel.drive import BevelDrive, BevelRun
from mbcdm_cad.configurations.miso_bevel.stack import BAND_MARGIN_MM, END_PLAY_MM, Stack, band, outward_of
from mbcdm_cad.parts.axle.dims import AxleDims
from mbcdm_cad.parts.collar.dims import collar_width_mm
from mbcdm_cad.parts.idler_pulley.dims import IdlerDims
from mbcdm_cad.parts.input_pulley.dims import (
    ENCODER_INSERTION_MM,
    GROOVE_DEPTH,
    GROOVE_LEAD,
    GROOVE_RADIUS,
    JOURNAL_SLIT_MM,
    NECK_GAP_MM,
    SLOT_PLAY_MM,
    Groove,
    InputPulleyDims,
    StopSlot,
)


def smallest_lead_mm(drive: BevelDrive) -> float:
    """Least lead of the helix on the input pulleys: turns side by side, or grooves with crests between them."""
    d = drive.cable.diameter_mm
    return GROOVE_LEAD * GROOVE_RADIUS * d if drive.input_pulleys.grooved else d


def _groove(drive: BevelDrive, cable: BevelRun, stop: StopGeometry, dead_end_z: float) -> Groove:
    """The groove, from just beyond the winding's end in the stop's slot to the point where the span has left it."""
    d = drive.cable.diameter_mm
    w = winding(drive, cable)
    depth, r = GROOVE_DEPTH * d, cable.input_radius_mm
    into_slot = d / 2 / r
    # At this angle beyond its last contact the straight span has risen by the groove's depth.
    out = acos(r / (r + depth))
    wound = tau * drive.dead_turns + 2 * w.reduction * radians(drive.half_travel_deg) + out
    per_rad = w.outward * drive.helix_lead_mm / tau
    return Groove(
        cable_name=cable.name,
        root_radius=r - d / 2,
        radius=GROOVE_RADIUS * d,
        depth=depth,
        start_angle_rad=stop.end_angle_rad + stop.away * into_slot,
        end_angle_rad=stop.end_angle_rad - stop.away * wound,
        start_z=dead_end_z + per_rad * into_slot,
        end_z=dead_end_z - per_rad * wound,
    )


def input_pulley(drive: BevelDrive, levels: Stack, name: str) -> InputPulleyDims:
    """Dimensions of the input pulley called ``name``."""
    cables = sorted((c for c in drive.cables if c.input_name == name), key=lambda c: c.step)
    low, high = cables
    low_band = band(drive, low, outward_of(drive, low))
    high_band = band(drive, high, outward_of(drive, high))
    flank = drive.cable.diameter_mm / 2
    bearings = drive.bearings
    stops = [stop_geometry(drive, c) for c in cables]
    land_bottom = low_band.low_mm - BAND_MARGIN_MM
    land_top = high_band.high_mm + BAND_MARGIN_MM
    slots = tuple(
        StopSlot(
            cable_name=c.name,
            end_angle_rad=g.end_angle_rad,
            away=g.away,
            end_z=b.dead_end_mm,
            chord_z=b.dead_end_mm + outward_of(drive, c) * g.chord_rise_mm,
            chord_offset=g.chord_offset_mm,
            face_z=land_bottom if c is low else land_top,
            pitch_radius=c.input_radius_mm,
            bend_radius=g.bend_radius_mm,
            width=drive.cable.diameter_mm + SLOT_PLAY_MM,
            stop_radius=g.stop_radius_mm,
            stop_start=g.stop_start_mm,
            stop_end=g.stop_end_mm,
        )
        for c, g, b in zip(cables, stops, (low_band, high_band), strict=True)
    )

    grooves = tuple(
        _groove(drive, c, g, b.dead_end_mm)
        for c, g, b in zip(cables, stops, (low_band, high_band), strict=True)
        if drive.input_pulleys.grooved
    )

    def neck(shoulder_mm: float, bend_radius: float, stop_radius: float) -> float:
        return min(shoulder_mm / 2, bend_radius - stop_radius - NECK_GAP_MM)

    gear = drive.gearhead
    shaft_end = levels.motor_shelf_bottom_z + gear.shaft_length_mm
    journal_bottom = levels.motor_shelf_top_z + drive.screw(gear.screw).head_height_mm + 0.5
    return InputPulleyDims(
        name=name,
        x=low.input_side * drive.input_x_mm,
        y=drive.input_y_mm,
        journal_bottom_z=journal_bottom,
        lower_journal_radius=bearings.input_lower.bore_mm / 2,
        lower_neck_bottom_z=levels.bearing_shelf_top_z,
        lower_neck_radius=neck(
            bearings.input_lower.inner_shoulder_mm, stops[0].bend_radius_mm, stops[0].stop_radius_mm
        ),
        land_bottom_z=land_bottom,
        lower_surface_radius=low.input_radius_mm - flank,
        wall_z=(low_band.high_mm + high_band.low_mm) / 2,
        upper_surface_radius=high.input_radius_mm - flank,
        land_top_z=land_top,
        upper_neck_radius=neck(
            bearings.input_upper.inner_shoulder_mm, stops[1].bend_radius_mm, stops[1].stop_radius_mm
        ),
        upper_neck_top_z=levels.top_plate_bottom_z - END_PLAY_MM,
        upper_journal_radius=bearings.input_upper.bore_mm / 2,
        journal_top_z=levels.top_plate_top_z + ENCODER_INSERTION_MM,
        bore_radius=gear.shaft_diameter_mm / 2,
        bore_top_z=shaft_end + 0.5,
        slit_width=JOURNAL_SLIT_MM,
        slit_top_z=journal_bottom + collar_width_mm(drive, drive.input_pulleys.collar_screw) + 1.0,
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
