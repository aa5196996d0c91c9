"""Dimensions of the input pulley, heights along -Z from the gearhead to the encoder, and angles as seen that way.

    gearhead's shaft in a slit journal |neck|  step 2  |  step 1  |neck|journal| encoder

In the assembly it is turned about X by half a turn: (x, y, z) of the part are (x, -y, -z) there.
"""

from dataclasses import replace

from mbcdm_cad.layouts.sector import coupled_pulley
from mbcdm_cad.layouts.siso_bevel.cable_path import stop_of
from mbcdm_cad.layouts.siso_bevel.drive import DirectDrive, DirectRun
from mbcdm_cad.layouts.siso_bevel.stack import DirectStack
from mbcdm_cad.parts.input_pulley import dims


def _slot(drive: DirectDrive, cable: DirectRun, face_z: float) -> dims.StopSlot:
    stop = stop_of(drive, cable)
    turned = replace(stop, end_angle_rad=-stop.end_angle_rad, away=-stop.away)
    return dims.stop_slot(drive, cable.name, cable.input_radius_mm, turned, -cable.drum_radius_mm, face_z)


def input_pulley(drive: DirectDrive, levels: DirectStack) -> dims.InputPulleyDims:
    """Dimensions of the pulley; its slots are milled from both end faces."""
    small, large = sorted(drive.cables, key=lambda c: c.step)
    flank = drive.cable.diameter_mm / 2
    bearings = drive.bearings
    return coupled_pulley(
        drive,
        levels,
        name=drive.input_names[0],
        x=0.0,
        lower_neck_radius=bearings.input_lower.inner_shoulder_mm / 2,
        land_bottom_z=levels.land_bottom_z,
        lower_surface_radius=large.input_radius_mm - flank,
        wall_z=-(small.drum_radius_mm + large.drum_radius_mm) / 2,
        upper_surface_radius=small.input_radius_mm - flank,
        land_top_z=levels.land_top_z,
        upper_neck_radius=bearings.input_upper.inner_shoulder_mm / 2,
        slots=(_slot(drive, large, levels.land_bottom_z), _slot(drive, small, levels.land_top_z)),
    )
