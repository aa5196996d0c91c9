"""Rotation of the drum by the elastic frame: column, box and motor head as folded plates on their mounting screws.

By reciprocity the drum turns, for each N m of load, by f . u: f are the forces that the change of tensions by that load
puts on the seats, u the displacements they cause (:mod:`mbcdm_cad.model.plate_mesh`). The two cables pull the pulley
with the difference of their tensions along x, and the drum in the opposite direction; their torque about the input's
axis goes through the gearhead into the motor head. Assumptions as in docs/decisions/0005, and the boss is rigid; the
column's foot from the boss to its lower pocket counts as one block.
"""

from math import pi

import numpy as np

from mbcdm_cad.layouts.base import FrameCompliance, FrameStudy
from mbcdm_cad.layouts.siso_bevel.layout import DirectLayout
from mbcdm_cad.layouts.structure import elastic, one_input_loads
from mbcdm_cad.model.plate_mesh import URAD_PER_MRAD, Hole, Mounts, Wall, X, Y, Z, centred_load, plate_mesh, shares_urad
from mbcdm_cad.model.si import MM
from mbcdm_cad.model.stiffness import unit_tensions_N
from mbcdm_cad.model.structure.causes import BossRing
from mbcdm_cad.routes import Floats

# A force on a seat spreads over this many of its radii.
_SPREAD = 1.5


def walls(layout: DirectLayout) -> list[Wall]:
    """The walls of the half x >= 0, heights as in the assembly."""
    v, f, h = layout.levels, layout.frame, layout.head
    back_t, wall_t = v.pocket_floor_y - v.back_y, v.side_outer_x - v.side_inner_x
    rib_t, shelf_t = f.column_half_width - f.pocket_half_width, f.encoder_shelf_top_z - f.encoder_shelf_bottom_z
    flange_t, motor_t, head_t = h.flange_top_z - h.bottom_z, h.top_z - h.shelf_bottom_z, v.head_outer_x - v.head_inner_x
    x_wall, x_rib = (v.side_inner_x + v.side_outer_x) / 2, (f.column_half_width + f.pocket_half_width) / 2
    x_head, y_head = (v.head_inner_x + v.head_outer_x) / 2, (h.back_y - v.head_inner_x) / 2
    y_back, deep = (v.back_y + v.pocket_floor_y) / 2, ((v.back_y + v.pocket_floor_y) / 2, v.front_y)
    block_t = f.low_pocket_bottom_z - f.boss.seat_radius
    z_foot = f.low_pocket_bottom_z - block_t / 2
    z_stop, z_shelf = (
        (f.stop_shelf_top_z + f.stop_shelf_bottom_z) / 2,
        (f.encoder_shelf_top_z + f.encoder_shelf_bottom_z) / 2,
    )
    z_flange, z_motor = (h.bottom_z + h.flange_top_z) / 2, (h.shelf_bottom_z + h.top_z) / 2
    wide, narrow, box = (0.0, x_wall), (0.0, x_rib), (0.0, x_head)
    head_y = (y_head, h.front_y)

    def seat(radius: float, depth: float, shoulder: float, thickness: float) -> Hole:
        return Hole(0.0, 0.0, pi * (radius**2 * depth + shoulder**2 * (thickness - depth)))

    # Where one wall runs inside another.
    column = (
        (Z, z_foot, f.low_pocket_bottom_z),
        (Z, f.stop_shelf_bottom_z, f.stop_shelf_top_z),
        (Z, f.encoder_shelf_bottom_z, z_shelf),
    )
    above = ((Z, z_shelf, f.encoder_shelf_top_z), (Z, f.top_z, z_flange))
    in_head = ((Z, z_flange, h.flange_top_z), (Z, h.shelf_bottom_z, z_motor))
    in_rib, in_back = (X, f.pocket_half_width, f.column_half_width), (Y, y_back, v.pocket_floor_y)
    return [
        Wall("column ribs", X, x_rib, (deep, (z_foot, z_shelf)), rib_t, embedded=(*column, in_back)),
        Wall("column back", Y, y_back, (narrow, (z_foot, z_shelf)), back_t, embedded=(*column, in_rib)),
        Wall("foot", Z, z_foot, (narrow, deep), block_t),
        Wall(
            "stop shelf",
            Z,
            z_stop,
            (narrow, deep),
            f.stop_shelf_top_z - f.stop_shelf_bottom_z,
            embedded=(in_rib, in_back),
        ),
        Wall(
            "encoder shelf",
            Z,
            z_shelf,
            (wide, deep),
            shelf_t,
            (seat(f.seat_radius, min(f.seat_depth, shelf_t), f.seat_shoulder_radius, shelf_t),),
            embedded=(in_rib, in_back),
        ),
        Wall("box back", Y, y_back, (wide, (z_shelf, z_flange)), back_t, embedded=above),
        Wall("side walls", X, x_wall, (deep, (z_shelf, z_flange)), wall_t, embedded=(*above, in_back)),
        Wall(
            "motor head's flange",
            Z,
            z_flange,
            (wide, deep),
            flange_t,
            (seat(h.seat_radius, min(h.seat_depth, flange_t), h.shoulder_radius, flange_t),),
        ),
        Wall("motor head's walls", X, x_head, (head_y, (z_flange, z_motor)), head_t, embedded=in_head),
        Wall("motor head's back", Y, y_head, (box, (z_flange, z_motor)), head_t, embedded=in_head),
        Wall("motor shelf", Z, z_motor, (box, head_y), motor_t, (Hole(0.0, 0.0, pi * h.pilot_radius**2 * motor_t),)),
    ]


def mounts(layout: DirectLayout) -> Mounts:
    """The mounting screws."""
    f, v = layout.frame, layout.levels
    seat, back = layout.mounting.seat_mm(layout.mount_washers), (v.back_y + v.pocket_floor_y) / 2
    # Behind the column the back of a wide motor head may lie.
    return Mounts(f.mounts, seat / 2, f.mount_radius, v.pocket_floor_y - v.back_y, back)


def seat_forces(layout: DirectLayout, tension_N: Floats) -> list[tuple[str, tuple[float, float, float], float, float]]:
    """(panel, point in mm, force along x in N, couple about z in N mm) on the frame's seats by the tensions."""
    (lower, upper), (rear, front) = layout.input_bearings_mm(0), layout.drum_bearings_mm
    on = one_input_loads(layout, tension_N)
    return [
        ("motor head's flange", (0.0, 0.0, -lower), on.lower_N, 0.0),
        ("encoder shelf", (0.0, 0.0, -upper), on.upper_N, 0.0),
        ("motor shelf", (0.0, 0.0, layout.head.top_z), 0.0, on.torque_Nm / MM),
        ("foot", (0.0, rear, 0.0), on.rear_N, 0.0),
        ("foot", (0.0, front, 0.0), on.front_N, 0.0),
    ]


def frame_compliance(layout: DirectLayout) -> FrameCompliance:
    """Windup of the drum by the frame per N m of external torque, with the share of each part.

    Raises ``ValueError`` if the dimensions leave no frame to compute.
    """
    held = mounts(layout)
    mesh = plate_mesh(walls(layout), held)
    material = layout.drive.frame_material
    reach = {
        "motor head's flange": _SPREAD * layout.head.seat_radius,
        "encoder shelf": _SPREAD * layout.frame.seat_radius,
        "motor shelf": layout.drive.gearhead.diameter_mm / 2,
        "foot": 1e3,
    }
    total = np.zeros((len(mesh.plates.node_mm), 6))
    forces = seat_forces(layout, unit_tensions_N(layout.si))
    for panel, point, force_x, couple_z in forces:
        nodes = mesh.near(panel, point, (reach[panel], reach[panel], 1e3))
        total[nodes, :3] += centred_load(mesh, nodes, np.array(point), force_x, couple_z)
    shares = shares_urad(mesh, material, total.ravel(), held.springs(mesh, material))
    boss = layout.frame.boss
    ring = BossRing(
        boss.seat_radius, boss.radius, layout.frame.low_pocket_bottom_z, boss.encoder_pocket_floor_y, boss.front_y
    )
    on_boss = [(point[1], force_x) for panel, point, force_x, _ in forces if panel == "foot"]
    at, force = (np.array(values) for values in zip(*on_boss, strict=True))
    shares["boss ring"] = ring.work_Nmm(at, force, elastic(material)) * URAD_PER_MRAD
    return FrameCompliance(sum(shares.values()), shares)


def frame_study(layout: DirectLayout) -> FrameStudy:
    """The compliance as a study for the cache."""
    drive = layout.drive
    cables = [(c.drum_side, c.input_radius_mm, c.drum_radius_mm, c.preload_N) for c in drive.cables]
    inputs = (layout.frame, layout.head, layout.drum_bearings_mm, drive.support, drive.bearings, cables)
    walls = ("back_plate_mm", "rib_mm", "side_wall_mm")
    return FrameStudy(__name__, inputs, lambda: frame_compliance(layout), {w: getattr(drive.support, w) for w in walls})
