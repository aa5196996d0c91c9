"""Rotation of the drum by the elastic support: frame and top plate as folded plates on their mounting screws.

By reciprocity the drum turns, for each N m of load, by f . u: f are the forces that the change of tensions by that load
puts on the seats (:func:`seat_loads`), u the displacements they cause. f . u is also twice the strain energy, so that
the shares of the panels add up.

Assumptions, with their effect where solid finite elements of the reference frame show it (docs/decisions/0005):

- tensions share the load as on a rigid support;
- top plate bonded to walls and back plate (to the walls alone: no change); the mounting screws hold the back face under
  their heads, rigidly, and the back plate touches the base nowhere else (held over the 30 degree cone: 15 % less);
- walls are plates at mid-thickness, five times as thick where one runs inside another; holes thin the plate around;
- the boss is rigid but for the ring round its bearings, which bends as a curved beam;
- coupling boxes on the top plate do not stiffen it;
- only the part of the load that changes sign in a mirror at x = 0 is counted (0.4 % less).

On the whole it stays within 12 % of finite elements for ribs, back plate and side walls of 2 to 8 mm.
"""

from dataclasses import dataclass
from math import pi

import numpy as np

from mbcdm_cad.layouts.base import FrameCompliance, FrameStudy
from mbcdm_cad.layouts.miso_bevel.cable_path import GUIDE
from mbcdm_cad.layouts.miso_bevel.layout import BevelLayout
from mbcdm_cad.layouts.structure import elastic
from mbcdm_cad.model.equilibrium import bearing_loads
from mbcdm_cad.model.plate_mesh import (
    URAD_PER_MRAD,
    Hole,
    Mounts,
    PlateMesh,
    Wall,
    X,
    Y,
    Z,
    centred_load,
    plate_mesh,
    shares_urad,
    statically,
)
from mbcdm_cad.model.si import MM
from mbcdm_cad.model.stiffness import unit_tensions_N
from mbcdm_cad.model.structure.causes import BossRing
from mbcdm_cad.model.structure.quadrilateral import Ints
from mbcdm_cad.routes import Floats
from mbcdm_cad.routes.route import two_bearing_reactions_N


def _half_load(layout: BevelLayout, mesh: PlateMesh, loads: "SeatLoads") -> Floats:
    """Nodal loads (6 m,) of the half x >= 0: the part of ``loads`` that changes sign in the mirror."""
    node = mesh.plates.node_mm
    total = np.zeros((len(node), 6))
    points = dict(zip(loads.names, loads.point_mm, strict=True))

    def centre(nodes: Ints, point: Floats, force_x: float) -> None:
        total[nodes, :3] += centred_load(mesh, nodes, point, force_x)

    f = layout.frame
    block = mesh.near("boss block", (0.0, 0.0, f.column_pocket_bottom_z), (1e3, 1e3, 1e3))
    for name in ("drum_rear", "drum_front"):
        centre(block, points[name], loads.at(name)[0])
    around = (3.0 * f.axle_radius, 3.0 * f.axle_radius, 10.0)
    centre(mesh.near("bearing shelf", points["axle_lower"], around), points["axle_lower"], loads.at("axle_lower")[0])
    centre(mesh.near("top plate", points["axle_upper"], around), points["axle_upper"], loads.at("axle_upper")[0])

    left, right = (layout.drive.input_names[layout.drive.input_sides.index(s)] for s in (-1, 1))
    mirrored = np.array([1.0, -1.0, -1.0])
    # The bearings next to the gearheads are the larger ones; both ends are spread over as much.
    reach = f.seat_radius if f.carries_drives else layout.top_plate.seat_radius
    for end, panel in (("lower", "bearing shelf"), ("upper", "top plate")):
        point = points[f"{right}_{end}"]
        force = 0.5 * (loads.at(f"{right}_{end}") + mirrored * loads.at(f"{left}_{end}"))
        nodes = mesh.near(panel, point, (reach, reach, 10.0))
        total[nodes, :3] += statically(node[nodes], point, force, np.zeros(3))
    # The panel that takes the couple of a gearhead, the height of its face there, and the reach of its seat.
    v, box = layout.levels, layout.top_plate.box
    panel, z, reach = "motor shelf", v.motor_shelf_bottom_z, layout.drive.gearhead.diameter_mm / 2
    if box is not None:
        panel, z, reach = "top plate", v.top_plate_top_z, box.outer_x
    at = np.array([max(f.input_x), f.input_y, z])
    nodes = mesh.near(panel, at, (reach, reach, 10.0))
    # N m to N mm.
    couple = np.array([0.0, 0.0, 1e3 * loads.gearhead_torque_Nm.mean()])
    total[nodes, :3] += statically(node[nodes], at, np.zeros(3), couple)
    return total.ravel()


def boss_ring(layout: BevelLayout) -> BossRing:
    """The ring round the drum's bearings, under the column."""
    f = layout.frame
    ends = f.boss.encoder_pocket_floor_y, layout.levels.boss_front_y
    return BossRing(f.boss.seat_radius, f.boss.radius, f.column_pocket_bottom_z, *ends)


def frame_compliance(layout: BevelLayout) -> FrameCompliance:
    """Windup of the drum by the support per N m of external torque, with the share of each part.

    Raises ``ValueError`` if the dimensions leave no frame to compute.
    """
    material = layout.drive.frame_material
    loads = seat_loads(layout, unit_tensions_N(layout.si))
    mesh = support_mesh(layout)
    ground = mounts(layout).springs(mesh, material)
    shares = shares_urad(mesh, material, _half_load(layout, mesh, loads), ground)
    drum = "drum_rear", "drum_front"
    at = np.array([loads.point_mm[loads.names.index(n)][1] for n in drum])
    force = np.array([loads.at(n)[0] for n in drum])
    shares["boss ring"] = boss_ring(layout).work_Nmm(at, force, elastic(material)) * URAD_PER_MRAD
    return FrameCompliance(sum(shares.values()), shares)


def frame_study(layout: BevelLayout) -> FrameStudy:
    """The compliance as a study for the cache."""
    drive = layout.drive
    cables = [(c.input_side, c.drum_side, c.input_radius_mm, c.guide_radius_mm, c.drum_radius_mm) for c in drive.cables]
    inputs = (layout.frame, layout.top_plate, layout.drum_bearings_mm, drive.support, drive.bearings, cables)
    walls = ("rib_mm", "back_plate_mm", "motor_shelf_mm")
    return FrameStudy(__name__, inputs, lambda: frame_compliance(layout), {w: getattr(drive.support, w) for w in walls})


def panels(layout: BevelLayout) -> list[Wall]:
    """The walls of the half x >= 0."""
    v, f, t = layout.levels, layout.frame, layout.top_plate
    x_wall, x_rib = (v.side_inner_x + v.side_outer_x) / 2, f.boss.radius - f.rib_thickness / 2
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
    block_t = f.column_pocket_bottom_z - f.boss.seat_radius
    ends = ((Z, z_end, f.column_pocket_bottom_z), (Z, v.shelf_bottom_z, z_low))
    in_rib = (X, f.boss.radius - f.rib_thickness, x_rib)
    on_rib = (X, f.boss.radius - f.rib_thickness, f.boss.radius)
    wall_t = v.side_outer_x - v.side_inner_x
    lowest = (
        Wall("motor shelf", Z, z_low, (wide, deep), low_t, (pilot,), (on_rib,))
        if f.carries_drives
        else Wall("lowest shelf", Z, z_low, (wide, deep), low_t, embedded=(on_rib,))
    )
    return [
        Wall("column ribs", X, x_rib, (deep, (z_end, z_low)), f.rib_thickness, embedded=ends),
        Wall("column back", Y, y_back, (narrow, (z_end, z_low)), back_t, embedded=(*ends, in_rib)),
        Wall("boss end wall", Z, z_end, (narrow, (y_back, f.boss.encoder_pocket_floor_y)), f.rib_thickness),
        Wall("boss block", Z, z_end, (narrow, (f.boss.encoder_pocket_floor_y, y_front)), block_t),
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
    f, v = layout.frame, layout.levels
    seat = layout.mounting.seat_mm(layout.mount_washers)
    middle_y = (v.back_y + v.pocket_floor_y) / 2  # a thick plate is not the rearmost: the end of the boss is
    return Mounts(f.mounts, seat / 2, f.mount_radius, v.pocket_floor_y - v.back_y, middle_y)


def support_mesh(layout: BevelLayout) -> PlateMesh:
    """Panels cut into elements along one common grid. Panels without extent in this design are left out.

    Raises ``ValueError`` if a wall has no thickness, or a mounting screw no back plate.
    """
    return plate_mesh(panels(layout), mounts(layout))


@dataclass(frozen=True, eq=False)
class SeatLoads:
    """Forces on the support (N), rows of (x, y, z), at points (mm), in the order of ``names``; and the couple about Z
    (N m) that each gearhead, which holds its input, puts on the motor shelf."""

    names: tuple[str, ...]
    point_mm: Floats
    force_N: Floats
    gearhead_torque_Nm: Floats

    def at(self, name: str) -> Floats:
        """Force (3,) on the seat called ``name``."""
        return np.asarray(self.force_N[self.names.index(name)])


def seat_points_mm(layout: BevelLayout) -> dict[str, tuple[float, float, float]]:
    """Where drum bearings, guide axle and input bearings press on frame and top plate: the middles of the seats."""
    v, frame, plate = layout.levels, layout.frame, layout.top_plate
    rear, front = layout.drum_bearings_mm
    lower, upper = layout.axle_supports_mm
    points = {
        "drum_rear": (0.0, rear, 0.0),
        "drum_front": (0.0, front, 0.0),
        "axle_lower": (0.0, 0.0, lower),
        "axle_upper": (0.0, 0.0, upper),
    }
    for pulley in layout.inputs:
        points[f"{pulley.name}_lower"] = (pulley.x, pulley.y, v.bearing_shelf_top_z - frame.seat_depth / 2)
        points[f"{pulley.name}_upper"] = (pulley.x, pulley.y, v.top_plate_bottom_z + plate.seat_depth / 2)
    return points


def seat_loads(layout: BevelLayout, tension_N: Floats) -> SeatLoads:
    """Forces of the given tensions (n_cables,), which may be differences and negative, on the support's seats."""
    d = layout.si
    loads = bearing_loads(d, tension_N)
    points = seat_points_mm(layout)
    forces: dict[str, Floats] = {}

    def share(body: str, low: str, high: str, force: Floats, moment: Floats, at_m: float) -> None:
        lower, upper = (points[f"{body}_{end}"][2] * MM for end in (low, high))
        reaction = two_bearing_reactions_N(force, moment, at_m, lower, upper)
        forces[f"{body}_{low}"], forces[f"{body}_{high}"] = -reaction

    guide = loads.bodies[GUIDE]
    share("axle", "lower", "upper", guide.force_N, guide.moment_Nm, guide.height_m)
    for name, load in zip(layout.drive.input_names, loads.inputs, strict=True):
        share(name, "lower", "upper", load.force_N, load.moment_Nm, load.height_m)
    # The drum's axis is Y: moments about x and z are taken by the couple of its bearings, as forces along z and x.
    rear, front = points["drum_rear"][1] * MM, points["drum_front"][1] * MM
    force, moment = loads.drum.force_N, loads.drum.moment_Nm
    couple = np.array([-moment[2], 0.0, moment[0]])
    forces["drum_front"] = (couple - rear * force) / (front - rear)
    forces["drum_rear"] = force - forces["drum_front"]
    names = tuple(points)
    pull = d.sigma * np.asarray(tension_N, dtype=float) * d.input_radius_m
    torque = np.array([-(pull * d.of_input(i)).sum() for i in range(d.n_inputs)])
    return SeatLoads(names, np.array([points[n] for n in names]), np.array([forces[n] for n in names]), torque)
