"""Dimensions of the input pulley, heights along -Z from the gearhead to the encoder, and angles as seen that way.

    gearhead's shaft in a slit journal |neck|  step 2  |  step 1  |neck|journal| encoder

In the assembly it is turned about X by half a turn: (x, y, z) of the part are (x, -y, -z) there.
"""

from mbcdm_cad.layouts.siso_bevel.cable_path import TRANSFER_RAD, input_wrap_rad, stop_bend
from mbcdm_cad.layouts.siso_bevel.drive import DirectDrive, DirectRun
from mbcdm_cad.layouts.siso_bevel.stack import DirectStack
from mbcdm_cad.parts.coupling import collar_width_mm
from mbcdm_cad.parts.input_pulley import dims


def _slot(drive: DirectDrive, cable: DirectRun, face_z: float) -> dims.StopSlot:
    stop = stop_bend(drive, cable)
    end = TRANSFER_RAD + cable.drum_side * input_wrap_rad(drive, cable, 0.0)
    return dims.StopSlot(
        cable_name=cable.name,
        end_angle_rad=-end,
        away=-cable.drum_side,
        end_z=-cable.drum_radius_mm,
        chord_z=-cable.drum_radius_mm,
        chord_offset=stop.bend_radius_mm,
        face_z=face_z,
        pitch_radius=cable.input_radius_mm,
        bend_radius=stop.bend_radius_mm,
        width=drive.cable.diameter_mm + dims.SLOT_PLAY_MM,
        stop_radius=stop.stop_radius_mm,
        stop_start=stop.stop_start_mm,
        stop_end=stop.stop_end_mm,
    )


def input_pulley(drive: DirectDrive, levels: DirectStack) -> dims.InputPulleyDims:
    """Dimensions of the pulley; its slots are milled from both end faces."""
    small, large = sorted(drive.cables, key=lambda c: c.step)
    flank = drive.cable.diameter_mm / 2
    bearings, gear = drive.bearings, drive.gearhead
    journal_bottom = levels.motor_shelf_top_z + drive.screw(gear.screw).head_height_mm + 0.5
    return dims.InputPulleyDims(
        name=drive.input_names[0],
        x=0.0,
        journal_bottom_z=journal_bottom,
        lower_journal_radius=bearings.input_lower.bore_mm / 2,
        lower_neck_bottom_z=levels.bearing_shelf_top_z,
        lower_neck_radius=bearings.input_lower.inner_shoulder_mm / 2,
        land_bottom_z=levels.land_bottom_z,
        lower_surface_radius=large.input_radius_mm - flank,
        wall_z=-(small.drum_radius_mm + large.drum_radius_mm) / 2,
        upper_surface_radius=small.input_radius_mm - flank,
        land_top_z=levels.land_top_z,
        upper_neck_radius=bearings.input_upper.inner_shoulder_mm / 2,
        upper_neck_top_z=levels.upper_neck_top_z,
        upper_journal_radius=bearings.input_upper.bore_mm / 2,
        journal_top_z=levels.top_plate_top_z + dims.ENCODER_INSERTION_MM,
        bore_radius=gear.shaft_diameter_mm / 2,
        bore_top_z=levels.motor_shelf_bottom_z + gear.shaft_length_mm + 0.5,
        slit_width=dims.JOURNAL_SLIT_MM,
        slit_top_z=journal_bottom + collar_width_mm(drive, drive.input_pulleys.collar_screw) + 1.0,
        slots=(_slot(drive, large, levels.land_bottom_z), _slot(drive, small, levels.land_top_z)),
    )
