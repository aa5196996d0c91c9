"""Dimensions of the input pulley, heights along +Y from the gearhead to the encoder, and angles as seen that way.

    gearhead's shaft in a slit journal |neck|  land with its groove  |neck|journal| encoder

Turned about X by a quarter it stands in the assembly: (x, y, z) of the part are (x, z, -y) there.
"""

from __future__ import annotations

from math import pi

from mbcdm_cad.configurations.siso_spur.drive import SpurDrive, contact_rad
from mbcdm_cad.configurations.siso_spur.stack import END_PLAY_MM, SpurStack, groove_depth_mm, groove_run_out_rad
from mbcdm_cad.parts.collar.dims import collar_width_mm
from mbcdm_cad.parts.input_pulley.dims import (
    ENCODER_INSERTION_MM,
    GROOVE_RADIUS,
    JOURNAL_SLIT_MM,
    Groove,
    InputPulleyDims,
)


def _groove(drive: SpurDrive) -> Groove:
    """One groove: the turns, the walk at both ends of the travel, and where a span has risen out of it."""
    beyond = drive.input_travel_rad / 2 + groove_run_out_rad(drive)
    start = contact_rad(drive, 1) - pi / 2
    per_rad = drive.input_radius_mm * drive.slope
    return Groove(
        cable_name=drive.input_names[0],
        root_radius=drive.input_radius_mm - drive.cable.diameter_mm / 2,
        radius=GROOVE_RADIUS * drive.cable.diameter_mm,
        depth=groove_depth_mm(drive),
        start_angle_rad=start - beyond,
        end_angle_rad=start + drive.wrap_rad + beyond,
        start_z=drive.level_mm - drive.leave_mm - per_rad * beyond,
        end_z=drive.level_mm + drive.leave_mm + per_rad * beyond,
    )


def input_pulley(drive: SpurDrive, levels: SpurStack) -> InputPulleyDims:
    """Dimensions of the pulley: one land."""
    bearings, gear = drive.bearings, drive.gearhead
    journal_bottom = levels.motor_shelf_top_z + drive.screw(gear.screw).head_height_mm + 0.5
    surface = drive.input_radius_mm - drive.cable.diameter_mm / 2
    return InputPulleyDims(
        name=drive.input_names[0],
        x=0.0,
        journal_bottom_z=journal_bottom,
        lower_journal_radius=bearings.input_lower.bore_mm / 2,
        lower_neck_bottom_z=levels.bearing_shelf_top_z,
        lower_neck_radius=bearings.input_lower.inner_shoulder_mm / 2,
        land_bottom_z=levels.land_bottom_z,
        lower_surface_radius=surface,
        wall_z=drive.level_mm,
        upper_surface_radius=surface,
        land_top_z=levels.land_top_z,
        upper_neck_radius=bearings.input_upper.inner_shoulder_mm / 2,
        upper_neck_top_z=levels.top_plate_bottom_z - END_PLAY_MM,
        upper_journal_radius=bearings.input_upper.bore_mm / 2,
        journal_top_z=levels.top_plate_top_z + ENCODER_INSERTION_MM,
        bore_radius=gear.shaft_diameter_mm / 2,
        bore_top_z=levels.motor_shelf_bottom_z + gear.shaft_length_mm + 0.5,
        slit_width=JOURNAL_SLIT_MM,
        slit_top_z=journal_bottom + collar_width_mm(drive, drive.input_pulleys.collar_screw) + 1.0,
        slots=(),
        grooves=(_groove(drive),) if drive.input_pulleys.grooved else (),
    )
