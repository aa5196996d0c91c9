"""Frame and top plate as flat panels, for the module ``stiffness``."""

from __future__ import annotations

from math import pi

from mbcdm_cad.layouts.miso_bevel.layout import BevelLayout
from mbcdm_cad.model.plate_mesh import Hole, Mounts, PlateMesh, Wall, X, Y, Z, plate_mesh


def panels(layout: BevelLayout) -> list[Wall]:
    """The walls of the half x >= 0."""
    v, f, t = layout.levels, layout.frame, layout.top_plate
    x_wall, x_rib = (v.side_inner_x + v.side_outer_x) / 2, f.boss_radius - f.rib_thickness / 2
    y_back, y_front = (v.back_y + v.pocket_floor_y) / 2, v.front_y
    z_end = f.column_pocket_bottom_z - f.rib_thickness / 2
    z_low = (v.shelf_bottom_z + v.shelf_top_z) / 2
    z_bearing = (v.bearing_shelf_bottom_z + v.bearing_shelf_top_z) / 2
    z_top = (v.top_plate_bottom_z + v.top_plate_top_z) / 2
    at = max(f.input_x)
    low_t = v.shelf_top_z - v.shelf_bottom_z
    bearing_t = v.bearing_shelf_top_z - v.bearing_shelf_bottom_z
    top_t = v.top_plate_top_z - v.top_plate_bottom_z
    back_t, upper_t = v.pocket_floor_y - v.back_y, f.upper_floor_y - v.back_y
    pilot = Hole(at, f.input_y, pi * f.pilot_radius**2 * low_t)
    depth = min(f.seat_depth, bearing_t)
    seat = Hole(at, f.input_y, pi * (f.seat_radius**2 * depth + f.seat_shoulder_radius**2 * (bearing_t - depth)))
    depth = min(t.seat_depth, top_t)
    upper_seat = Hole(at, f.input_y, pi * (t.seat_radius**2 * depth + t.shoulder_radius**2 * (top_t - depth)))
    deep, wide, narrow = (y_back, y_front), (0.0, x_wall), (0.0, x_rib)
    # Above the drum's bearings the boss is solid from the seat to the column's pocket.
    block_t = f.column_pocket_bottom_z - f.drum_seat_radius
    ends = ((Z, z_end, f.column_pocket_bottom_z), (Z, v.shelf_bottom_z, z_low))
    in_rib = (X, f.boss_radius - f.rib_thickness, x_rib)
    on_rib = (X, f.boss_radius - f.rib_thickness, f.boss_radius)
    wall_t = v.side_outer_x - v.side_inner_x
    lowest = (
        Wall("motor shelf", Z, z_low, (wide, deep), low_t, (pilot,), (on_rib,))
        if f.carries_drives
        else Wall("lowest shelf", Z, z_low, (wide, deep), low_t, embedded=(on_rib,))
    )
    return [
        Wall("column ribs", X, x_rib, (deep, (z_end, z_low)), f.rib_thickness, embedded=ends),
        Wall("column back", Y, y_back, (narrow, (z_end, z_low)), back_t, embedded=(*ends, in_rib)),
        Wall("boss end wall", Z, z_end, (narrow, (y_back, f.encoder_pocket_floor_y)), f.rib_thickness),
        Wall("boss block", Z, z_end, (narrow, (f.encoder_pocket_floor_y, y_front)), block_t),
        lowest,
        Wall("bearing shelf", Z, z_bearing, (wide, deep), bearing_t, (seat,)),
        Wall("top plate", Z, z_top, (wide, deep), top_t, (upper_seat,)),
        Wall("back plate between shelves", Y, y_back, (wide, (z_low, z_bearing)), back_t),
        Wall("back plate above", Y, y_back, (wide, (z_bearing, z_top)), upper_t),
        Wall("side walls", X, x_wall, (deep, (z_low, z_top)), wall_t),
        Wall("stop web", X, 0.0, (deep, (z_low, z_bearing)), 2 * f.web_half_width, share=0.5),
    ]


def mounts(layout: BevelLayout) -> Mounts:
    """The mounting screws."""
    f, v, drive = layout.frame, layout.levels, layout.drive
    seat = drive.support.mount.seat_mm(drive.frame_material.printed)
    return Mounts(f.mounts, seat / 2, f.mount_radius, v.pocket_floor_y - v.back_y)


def support_mesh(layout: BevelLayout) -> PlateMesh:
    """Panels cut into elements along one common grid. Panels without extent in this design are left out.

    Raises ``ValueError`` if a wall has no thickness, or a mounting screw no back plate.
    """
    return plate_mesh(panels(layout), mounts(layout))
