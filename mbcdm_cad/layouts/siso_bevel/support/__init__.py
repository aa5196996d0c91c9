"""Dimensions of the support: a column milled from one block, pockets from the front, and a separate motor head.

Seen from the front (x across, z up), heights as in the assembly:

        | motor |
        |gearhead|
      ==============  motor head: motor shelf,
      | coupling   |    coupling space, open to the front,
    ==================  bearing shelf as a flange on the side walls
    |     pulley     |  upper pocket, open at the top
    |================|  encoder shelf
      |  encoder   |    column's pocket
      |============|    stop shelf: the stop pin in its front
      |   pocket   |
       (   boss   )     drum bearings, drum encoder from behind

Heights of the levels are measured along -Z, from the motor (lowest) to the encoder (highest), since the motor is above
the pulley and its parts are drawn with the gearhead below:

    motor | gearhead | motor shelf | coupling space | bearing shelf | pulley | encoder shelf | encoder

The drum's axis intersects the input's at height 0; the steps are at -r_o. The pulley ends just beyond its cables, the
shelves follow from the pulley, the drive from the shelves. All mm.
"""

from dataclasses import dataclass
from math import sqrt

from mbcdm_cad.layouts.sector import head_frame
from mbcdm_cad.layouts.siso_bevel.design_file import DirectDrive
from mbcdm_cad.parts.boss import boss, column_start_mm
from mbcdm_cad.parts.drum_sector.design import END_PLAY_MM, SHELF_GAP_MM, LandLevels
from mbcdm_cad.parts.drum_sector.sizes import terminal_half_mm
from mbcdm_cad.parts.fits import MOUNT_SCREWS
from mbcdm_cad.parts.input_pulley.dims import stop_land_mm
from mbcdm_cad.parts.motor_head.dims import TOOL_SLENDERNESS, Flange, HeadFrameDims, flange_screw, inner_half_width_mm
from mbcdm_cad.parts.turned import DrumShaftDims

# Between the heads of the flange's screws and the motor head's wall.
HEAD_ROOM_MM = 0.1

# Corners of a printed frame's pockets (estimate).
PRINTED_CORNER_MM = 2.0


@dataclass(frozen=True, kw_only=True)
class DirectStack(LandLevels):
    """Levels; ``_z`` along -Z."""

    pocket_floor_y: float  # front surface of the back plate
    side_inner_x: float
    side_outer_x: float
    head_inner_x: float
    head_outer_x: float


def pocket_corner_radius_mm(drive: DirectDrive, depth_mm: float) -> float:
    """Corner radius of the frame's pockets: an end mill no longer than four times its diameter reaches the floor.

    No cutter has to reach into a printed frame, whose corners are rounded only for strength.
    """
    metal, cutter = drive.frame_material, depth_mm / TOOL_SLENDERNESS / 2
    return max(metal.min_internal_radius_mm, min(cutter, PRINTED_CORNER_MM) if metal.printed else cutter)


def direct_stack(drive: DirectDrive) -> DirectStack:
    """Compute the levels of a design without tests; the checks find impossible levels."""
    flank, running = drive.cable.diameter_mm / 2, drive.clearances.running_mm
    steps = sorted(c.drum_radius_mm for c in drive.cables)
    beyond = stop_land_mm(drive)
    land_bottom = -steps[-1] - flank - beyond
    land_top = -steps[0] + flank + beyond
    s = drive.support
    bearing_top = land_bottom - SHELF_GAP_MM
    bearing_bottom = bearing_top - s.bearing_shelf_mm
    motor_top = bearing_bottom - s.coupling_space_mm
    motor_bottom = motor_top - s.motor_shelf_mm
    shelf_bottom = land_top + SHELF_GAP_MM + END_PLAY_MM
    shelf_top = shelf_bottom + s.encoder_shelf_mm

    smallest, largest = (f(c.input_radius_mm for c in drive.cables) for f in (min, max))
    drum_inner = smallest - flank + drive.clearances.transfer_gap_mm
    front = min(smallest - terminal_half_mm(drive), drum_inner) - running
    head_inner = inner_half_width_mm(drive)
    head_outer = head_inner + s.side_wall_mm / 2
    # The flange's screws are in the middle of the side walls, with their heads clear of the motor head.
    beside_head = head_outer + flange_screw(drive).head_diameter_mm / 2 + HEAD_ROOM_MM - s.side_wall_mm / 2
    side_inner = max(largest + flank + running, drive.encoder.diameter_mm / 2 + running, beside_head)
    # The rounded corners of the box begin at the encoder's shelf.
    corner = pocket_corner_radius_mm(drive, front - s.back_y_mm - s.back_plate_mm)
    edges = [(c.input_radius_mm + flank, c.drum_radius_mm - flank) for c in drive.cables]
    for x, z in (*edges, (smallest - flank, -land_top)):
        above = max(corner - (z + shelf_bottom), 0.0)
        room = max((corner - running) ** 2 - above**2, 0.0)
        side_inner = max(side_inner, x + corner - sqrt(room))
    return DirectStack(
        motor_bottom_z=motor_bottom - drive.gearhead.length_mm - drive.motor.length_mm,
        gearhead_bottom_z=motor_bottom - drive.gearhead.length_mm,
        motor_shelf_bottom_z=motor_bottom,
        motor_shelf_top_z=motor_top,
        bearing_shelf_bottom_z=bearing_bottom,
        bearing_shelf_top_z=bearing_top,
        land_bottom_z=land_bottom,
        land_top_z=land_top,
        top_plate_bottom_z=shelf_bottom,
        top_plate_top_z=shelf_top,
        encoder_top_z=shelf_top + drive.encoder.length_mm,
        back_y=s.back_y_mm,
        pocket_floor_y=s.back_y_mm + s.back_plate_mm,
        front_y=front,
        drum_inner_y=drum_inner,
        drum_outer_y=drive.drum.outer_face_y_mm,
        hub_face_y=drive.drum.hub_face_y_mm,
        boss_front_y=drum_inner - 3 * running,
        side_inner_x=side_inner,
        side_outer_x=side_inner + s.side_wall_mm,
        head_inner_x=head_inner,
        head_outer_x=head_outer,
    )


# Where the drum leaves less height, down to what the walls over and under its pin need.
STOP_SHELF_MM = 6.0
STOP_PIN_DEPTH_MM = 10.0
# Between encoder and stop shelf.
ENCODER_ROOM_MM = 1.0
# A pocket is higher than the two corners that its cutter leaves by this much.
POCKET_FLAT_MM = 0.1
# Room beside a mounting screw's head for its washer face (estimate).
MOUNT_HEAD_ROOM_MM = 0.5
MOUNT_ROOM_MM = 0.6


@dataclass(frozen=True, kw_only=True)
class ColumnDims(HeadFrameDims):
    """The frame (mm), heights as in the assembly; flange screws and dowels at (x, y)."""

    levels: DirectStack
    top_z: float
    encoder_shelf_top_z: float
    encoder_shelf_bottom_z: float
    stop_shelf_top_z: float
    stop_shelf_bottom_z: float
    low_pocket_bottom_z: float
    post_bottom_z: float  # below it the column is as wide as the boss
    column_half_width: float
    pocket_half_width: float
    column_start_z: float  # behind the boss: the encoder's pocket leaves less than a wall beside it below
    stop_pin_start_y: float
    flange_screw_depth: float


def flange(levels: DirectStack) -> Flange:
    """The motor head's flange on the side walls, into which its screws and dowels go."""
    x = (levels.side_inner_x + levels.side_outer_x) / 2
    front, back = levels.front_y - 3.5, levels.back_y + 3.5
    middle = (front + back) / 2
    return Flange(
        half_x=levels.side_outer_x,
        back_y=levels.back_y,
        front_y=levels.front_y,
        screws=((-x, front), (x, front), (-x, back), (x, back)),
        dowels=((-x, middle), (x, middle)),
    )


def column(drive: DirectDrive, levels: DirectStack, shaft: DrumShaftDims) -> ColumnDims:
    """Dimensions of the frame."""
    round_boss = boss(drive, shaft, levels.back_y, levels.boss_front_y)
    encoder, screw = drive.encoder, flange_screw(drive)
    insert, mount = drive.insert(drive.frame_material, screw.thread_mm), MOUNT_SCREWS[drive.support.mount_screw]
    radius = pocket_corner_radius_mm(drive, levels.front_y - levels.pocket_floor_y)
    shelf_bottom = -levels.top_plate_top_z
    stop_top = min(-levels.encoder_top_z - ENCODER_ROOM_MM, shelf_bottom - 2 * radius - POCKET_FLAT_MM)
    low = max(round_boss.radius, round_boss.encoder_pocket_radius) + drive.support.rib_mm
    lowest_pocket = max(2 * radius + POCKET_FLAT_MM, mount.head_mm + 2 * MOUNT_HEAD_ROOM_MM)
    least_shelf = drive.drum.stop_pin_mm + 2 * drive.frame_material.min_wall_mm
    stop_bottom = stop_top - max(least_shelf, min(STOP_SHELF_MM, stop_top - low - lowest_pocket))
    # The encoder's end must clear the rounded corner of the pocket.
    pocket = encoder.diameter_mm / 2 + drive.clearances.running_mm + radius
    head_flange = flange(levels)
    mount_x = pocket - mount.head_mm / 2 - MOUNT_ROOM_MM
    return ColumnDims(
        levels=levels,
        boss=round_boss,
        top_z=-levels.bearing_shelf_top_z,
        encoder_shelf_top_z=-levels.top_plate_bottom_z,
        encoder_shelf_bottom_z=shelf_bottom,
        stop_shelf_top_z=stop_top,
        stop_shelf_bottom_z=stop_bottom,
        low_pocket_bottom_z=low,
        post_bottom_z=low - drive.support.rib_mm,
        column_half_width=pocket + drive.support.rib_mm,
        pocket_half_width=pocket,
        column_start_z=column_start_mm(round_boss),
        corner_radius=radius,
        stop_pin_z=(stop_top + stop_bottom) / 2,
        stop_pin_start_y=levels.front_y - STOP_PIN_DEPTH_MM,
        flange_screw_depth=max(
            screw.length_mm - drive.support.bearing_shelf_mm + 0.5, insert.depth_mm if insert else 0.0
        ),
        flange_screws=head_flange.screws,
        dowels=head_flange.dowels,
        mounts=(
            *((s * mount_x, (shelf_bottom + stop_top) / 2) for s in (-1, 1)),
            *((s * mount_x, (stop_bottom + low) / 2) for s in (-1, 1)),
        ),
        mount_radius=mount.hole_mm / 2,
        **head_frame(drive),
    )
