"""Levels along the axes, all parallel to Y, that all parts share; mm.

From the back to the front; y = 0 is the middle of the winding on the input with the drum centred:

    motor | gearhead | motor shelf | coupling space | flange | plate | pulley | encoder shelf | encoder
                                        drum encoder | bearings in the boss | hub and sector

Along the input's axis y counts as height from the gearhead (names in ``_z``), because its parts are drawn upright.
"""

from dataclasses import dataclass
from math import inf

from mbcdm_cad.layouts.siso_spur.drive import SpurDrive, boss_front_y_mm, drum_inner_y_mm, run_out_mm
from mbcdm_cad.layouts.siso_spur.overhung import hub_length_mm
from mbcdm_cad.parts.drum_sector.design import END_PLAY_MM, SHELF_GAP_MM, LandLevels
from mbcdm_cad.parts.drum_sector.sizes import terminal_half_mm
from mbcdm_cad.parts.input_pulley.dims import helix_stop_land_mm

# Land beyond the cable at each end of its walk.
BAND_MARGIN_MM = 0.5
# Thickness of an idler's flanges, and least length of the collar between plate and idler.
FLANGE_MM, COLLAR_MM = 1.0, 1.0


@dataclass(frozen=True, kw_only=True)
class SpurStack(LandLevels):
    """Levels, all along Y: ``bearing_shelf_top_z`` is the plate's back, ``back_y`` the end of the drum's encoder."""

    plate_back_y: float


def reach_mm(drive: SpurDrive) -> float:
    """Half the length of the input that cables, grooves and walk use."""
    if drive.anchored:
        return drive.dead_end_mm + drive.cable.diameter_mm / 2
    return drive.leave_mm + drive.walk_mm / 2 + run_out_mm(drive)


def idlers_back_mm(drive: SpurDrive) -> float:
    """Lowest y of any idler with the collar behind it; infinite without idlers."""
    half = drive.idlers.width_mm / 2 + FLANGE_MM + COLLAR_MM if drive.idlers else 0.0
    return min((-abs(level) - half for level in drive.idler_levels_mm), default=inf)


def spur_stack(drive: SpurDrive) -> SpurStack:
    """Compute the levels of a design, without validation: the checks find levels that are impossible."""
    running, s = drive.clearances.running_mm, drive.support
    land = reach_mm(drive) + (helix_stop_land_mm(drive) if drive.anchored else BAND_MARGIN_MM)
    # The last of several cables side by side.
    last = drive.level_mm + drive.band_mm + land
    plane = abs(drive.terminal_mm)
    drum_inner = drum_inner_y_mm(drive)
    hub = hub_length_mm(drive) if drive.overhung else 0.0
    # Heads on the flange of a servo's horn stay behind the rim too.
    land_or_rim = min(-land, drum_inner - running) if drive.servo is not None else -land
    front = min(-plane - terminal_half_mm(drive), drum_inner, land_or_rim - hub, idlers_back_mm(drive)) - running
    plate_back = front - s.plate_mm
    if drive.overhung:
        # The motor's face lies on the back of the plate; nothing is in front of the pulley.
        bearing_bottom = motor_bottom = plate_back
        motor_top = plate_back + s.motor_shelf_mm
        end = last
        if drive.servo is None:
            end = max(end, plate_back + drive.gearhead.shaft_length_mm)
        shelf_bottom = shelf_top = end
    else:
        bearing_bottom = plate_back - s.bearing_shelf_mm
        motor_top = bearing_bottom - s.coupling_space_mm
        motor_bottom = motor_top - s.motor_shelf_mm
        shelf_bottom = last + SHELF_GAP_MM + END_PLAY_MM
        shelf_top = shelf_bottom + s.encoder_shelf_mm
    # The motor of a first stage is not behind it.
    motor = drive.motor.length_mm if drive.cable_stage is None else 0.0
    return SpurStack(
        motor_bottom_z=motor_bottom - drive.gearhead.length_mm - motor,
        gearhead_bottom_z=motor_bottom - drive.gearhead.length_mm,
        motor_shelf_bottom_z=motor_bottom,
        motor_shelf_top_z=motor_top,
        bearing_shelf_bottom_z=bearing_bottom,
        bearing_shelf_top_z=plate_back,
        land_bottom_z=drive.level_mm - land,
        land_top_z=last,
        top_plate_bottom_z=shelf_bottom,
        top_plate_top_z=shelf_top,
        encoder_top_z=shelf_top + drive.encoder.length_mm,
        back_y=s.back_y_mm,
        plate_back_y=plate_back,
        front_y=front,
        drum_inner_y=drum_inner,
        drum_outer_y=drive.drum.outer_face_y_mm,
        hub_face_y=drive.drum.hub_face_y_mm,
        boss_front_y=boss_front_y_mm(drive),
    )


def least_wall_z_mm(drive: SpurDrive) -> float:
    """Least distance of the encoder shelf from the drum's axis: it must clear the rim with its cables."""
    return drive.drum_radius_mm + drive.cable.diameter_mm / 2 + drive.clearances.running_mm
