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
"""

from dataclasses import dataclass

from mbcdm_cad.layouts.sector import head_frame
from mbcdm_cad.layouts.siso_bevel.drive import DirectDrive
from mbcdm_cad.layouts.siso_bevel.stack import DirectStack, pocket_corner_radius_mm
from mbcdm_cad.parts.boss import boss, column_start_mm
from mbcdm_cad.parts.fits import MOUNT_SCREWS
from mbcdm_cad.parts.motor_head.dims import Flange, HeadFrameDims
from mbcdm_cad.parts.motor_head.dims import flange_screw as screw_of_flange
from mbcdm_cad.parts.turned import DrumShaftDims

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


def corner_radius_mm(drive: DirectDrive, levels: DirectStack) -> float:
    """Corner radius of the frame's pockets."""
    return pocket_corner_radius_mm(drive, levels.front_y - levels.pocket_floor_y)


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
    encoder, flange_screw = drive.encoder, screw_of_flange(drive)
    insert, mount = drive.insert(drive.frame_material, flange_screw.thread_mm), MOUNT_SCREWS[drive.support.mount_screw]
    radius = corner_radius_mm(drive, levels)
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
            flange_screw.length_mm - drive.support.bearing_shelf_mm + 0.5, insert.depth_mm if insert else 0.0
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
