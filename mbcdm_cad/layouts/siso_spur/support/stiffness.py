"""Rotation of the drum due to the elastic frame: plate and yoke as folded plates on the mounting screws.

By reciprocity the drum turns by f . u for each N m of load: f are the forces on the seats due to the change of tensions
by that load, u the displacements due to these forces (:mod:`mbcdm_cad.model.plate_mesh`). The tension of one side
rises, that of the other falls. Their components along the line of centres cancel and those across it add up: the input
is pushed to one side, the drum to the other, and the gearhead holds the torque about the input's axis. Assumptions as
in docs/decisions/0005. In addition, the motor head's flange lies in the plane of the plate, and the small couple of
both spans, which are a few leads apart, is left out. A motor that carries the pulley itself loads the plate with both
of its bearings, and leaves it the metal beside pocket and holes. A servo loads it round the screws of its ears, which
share the load by statics alone: that its housing stiffens the window is left out. Two such arms in line, one above the
drum and one below, form one mesh.
"""

from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from math import pi

import numpy as np

from mbcdm_cad.layouts.base import FrameCompliance, FrameStudy
from mbcdm_cad.layouts.siso_spur.layout import SpurLayout
from mbcdm_cad.layouts.siso_spur.pulley import MotorSeat
from mbcdm_cad.layouts.siso_spur.support.parts import motor_seat
from mbcdm_cad.layouts.structure import elastic, one_input_loads
from mbcdm_cad.model import plate_mesh as pm
from mbcdm_cad.model.si import MM
from mbcdm_cad.model.stiffness import unit_tensions_N
from mbcdm_cad.model.structure.causes import BossRing
from mbcdm_cad.model.structure.quadrilateral import Ints
from mbcdm_cad.routes import Floats
from mbcdm_cad.routes.route import body_load, two_bearing_reactions_N

# Radius over which the force on a seat is spread, over the radius of the seat.
_SPREAD = 1.5
# The bridge bends this far inside plate and shelf, over its thickness: the metal at its root gives (compared with solid
# elements of six frames, on which it was chosen; a beam on a half-space: 0.3 to 0.6).
ROOT = 0.35


@dataclass(frozen=True)
class Arm:
    """One input's part of a frame: ``way`` is +1 above the drum, -1 below it (turned by half a turn)."""

    layout: SpurLayout
    way: int = 1

    def of(self, panel: str) -> str:
        """Name of a panel of this arm; all arms share the plate."""
        return panel if self.way > 0 or panel == "plate" else f"{panel} below"


def walls(arms: Sequence[Arm]) -> list[pm.Wall]:
    """The walls of the half x >= 0."""
    v, f = arms[0].layout.levels, arms[0].layout.frame
    y_plate, plate_t = (v.plate_back_y + v.front_y) / 2, v.front_y - v.plate_back_y
    z_bridge = (f.bridge_bottom_z + f.top_z) / 2
    # Where the plate ends at the bridge its panel ends in the middle of the bridge, else at its own edge.
    top = f.plate_top_z if f.plate_top_z > f.top_z else z_bridge
    ends = sorted([arm.way * top for arm in arms])
    plate = pm.Wall(
        "plate",
        pm.Y,
        y_plate,
        ((0.0, f.half_width), (min(ends[0], -f.boss.radius), ends[-1])),
        plate_t,
        tuple(_opening(arm, plate_t) for arm in arms),
        embedded=((pm.Z, -f.boss.radius, f.boss.radius),),
    )
    return [plate, *(wall for arm in arms for wall in _yoke(arm, y_plate, z_bridge))]


def _opening(arm: Arm, plate_mm: float) -> pm.Hole:
    """Metal that the plate lacks round the input's axis, or in the window for a servo."""
    f, way = arm.layout.frame, arm.way
    if f.motor is None:
        return pm.Hole(0.0, way * f.axis_z, pi * f.opening_radius**2 * plate_mm)
    if f.motor.window is None:
        return pm.Hole(0.0, way * f.axis_z, sum(taken.volume_mm3() for taken in motor_seat(f, f.motor)))
    half, low, high = f.motor.window
    return pm.Hole(0.0, way * (low + high) / 2, 2 * half * (high - low) * plate_mm, (high - low) / (2 * half))


def _window_ends(mesh: pm.PlateMesh, arm: Arm, seat: MotorSeat) -> Ints:
    """Nodes of the plate round the screws of a servo's ears, at both ends of its window."""
    assert seat.window is not None
    half, low, high = seat.window
    ends = ((z, min(abs(z - low), abs(z - high))) for z in {z for _, z in seat.screws})
    return np.unique(
        np.concatenate([mesh.near("plate", (0.0, 0.0, arm.way * z), (half, 1e3, room)) for z, room in ends])
    )


def _yoke(arm: Arm, y_plate: float, z_bridge: float) -> Iterator[pm.Wall]:
    v, f, way = arm.layout.levels, arm.layout.frame, arm.way
    if f.motor is not None:
        return
    y_shelf, wide = (v.top_plate_bottom_z + v.top_plate_top_z) / 2, (0.0, f.shelf_half_width)
    shelf = v.top_plate_top_z - v.top_plate_bottom_z
    depth = min(f.seat_depth, shelf)
    seat = pi * (f.seat_radius**2 * depth + f.seat_shoulder_radius**2 * (shelf - depth))
    low, high = sorted((way * f.shelf_bottom_z, way * z_bridge))
    thick = f.top_z - f.bridge_bottom_z
    root = ROOT * thick
    ends = ((pm.Y, y_plate, v.front_y - root), (pm.Y, v.top_plate_bottom_z + root, y_shelf))
    yield from _head(arm, y_plate)
    yield pm.Wall(arm.of("bridge"), pm.Z, way * z_bridge, (wide, (y_plate, y_shelf)), thick, embedded=ends)
    hole, under = pm.Hole(0.0, way * f.axis_z, seat), sorted((way * f.bridge_bottom_z, way * z_bridge))
    in_bridge = ((pm.Z, under[0], under[1]),)
    yield pm.Wall(arm.of("encoder shelf"), pm.Y, y_shelf, (wide, (low, high)), shelf, (hole,), embedded=in_bridge)
    for n, stand in enumerate(f.stands, 1):
        y_strap, z_post = (stand.strap_back_y + stand.strap_front_y) / 2, sum(stand.post_z) / 2
        post, strap = stand.post_z[1] - stand.post_z[0], stand.strap_front_y - stand.strap_back_y
        yield pm.Wall(arm.of(f"idlers' posts {n}"), pm.Z, way * z_post, (stand.post_x, (y_plate, y_strap)), post)
        low, high = sorted((way * stand.low_z, way * z_post))
        yield pm.Wall(arm.of(f"idlers' strap {n}"), pm.Y, y_strap, ((0.0, stand.half_width), (low, high)), strap)


def _head(arm: Arm, y_plate: float) -> Iterator[pm.Wall]:
    """The motor head behind the plate: its flange lies on the plate and bridges the opening."""
    v, f, h, way = arm.layout.levels, arm.layout.frame, arm.layout.head, arm.way
    flange_t, walls_t, shelf_t = h.flange_top_z - h.bottom_z, h.outer_x - h.inner_x, h.top_z - h.shelf_bottom_z
    y_shelf, x_wall = (v.motor_shelf_bottom_z + v.motor_shelf_top_z) / 2, (h.inner_x + h.outer_x) / 2

    def high(low: float, top: float) -> tuple[float, float]:
        first, second = sorted((way * (f.axis_z + low), way * (f.axis_z + top)))
        return first, second

    back = h.back_y + walls_t / 2
    inside = ((pm.Y, v.plate_back_y - flange_t, y_plate), (pm.Y, y_shelf, v.motor_shelf_top_z))
    wide, deep, tall = (0.0, x_wall), (y_shelf, y_plate), high(back, h.front_y)
    pilot = pm.Hole(0.0, way * f.axis_z, pi * h.pilot_radius**2 * shelf_t)
    flange = (0.0, h.flange.half_x), high(h.flange.back_y, h.flange.front_y)
    depth = min(h.seat_depth, flange_t)
    bore = pm.Hole(0.0, way * f.axis_z, pi * (h.seat_radius**2 * depth + h.shoulder_radius**2 * (flange_t - depth)))
    yield pm.Wall(arm.of("motor head's flange"), pm.Y, y_plate, flange, flange_t, (bore,))
    yield pm.Wall(arm.of("motor head's walls"), pm.X, x_wall, (deep, tall), walls_t, embedded=inside)
    yield pm.Wall(arm.of("motor head's back"), pm.Z, way * (f.axis_z + back), (wide, deep), walls_t, embedded=inside)
    yield pm.Wall(arm.of("motor shelf"), pm.Y, y_shelf, (wide, tall), shelf_t, (pilot,))


def seat_forces(layout: SpurLayout, tension_N: Floats) -> list[tuple[str, tuple[float, float, float], float, float]]:
    """(panel, point in mm, force along x in N, couple about y in N mm) on the frame's seats due to the tensions."""
    z, (lower, upper), (rear, front) = layout.frame.axis_z, layout.input_bearings_mm(0), layout.drum_bearings_mm
    # Heights of the routes count along the axis of the input, which points to the back.
    on = one_input_loads(layout, tension_N, height_sign=-1)
    seats = [
        ("motor head's flange", (0.0, lower, z), on.lower_N, 0.0),
        ("motor shelf", (0.0, layout.levels.motor_shelf_bottom_z, z), 0.0, on.torque_Nm / MM),
        ("encoder shelf", (0.0, upper, z), on.upper_N, 0.0),
    ]
    if layout.frame.motor is not None:
        seats = [("plate", (0.0, lower, z), on.lower_N, on.torque_Nm / MM), ("plate", (0.0, upper, z), on.upper_N, 0.0)]
    return [
        *seats,
        ("plate", (0.0, rear, 0.0), on.rear_N, 0.0),
        ("plate", (0.0, front, 0.0), on.front_N, 0.0),
        *_idler_forces(layout, tension_N),
    ]


def _idler_forces(
    layout: SpurLayout, tension_N: Floats
) -> Iterator[tuple[str, tuple[float, float, float], float, float]]:
    """What the idlers of each pair put on plate and strap: their forces along z are a couple about y."""
    routes = layout.si.routes
    for n, stand in enumerate(layout.frame.stands, 1):
        supports = stand.supports_mm
        pairs = np.zeros((2, 3))
        couples = np.zeros(2)
        for body, own, _, number in layout.idlers:
            if number != n - 1:
                continue
            load, middle = body_load(routes, body, tension_N), (own.bottom_z + own.top_z) / 2
            pair = -two_bearing_reactions_N(load.force_N, np.zeros(3), middle, *supports, (0.0, 1.0, 0.0))
            pairs += pair
            # About y, z is x and x is -z.
            couples -= routes.body(body).point_m[0] / MM * pair[:, 2]
        for panel, y, force, couple in zip(("plate", f"idlers' strap {n}"), supports, pairs, couples, strict=True):
            yield panel, (0.0, y, stand.z), float(force[0]), float(couple)


def frame_compliance(layout: SpurLayout) -> FrameCompliance:
    """Windup of the drum due to the frame per N m of external torque, with the share of each part.

    Two opposite arms are one frame with two yokes, on which the forces on the drum cancel. Four inputs are two such
    pairs; with three inputs every arm is computed alone. Each carries its share of the load. Connected to the others an
    arm can only bend less (a structure with more constraints stores less energy under the same forces), so that with
    more than two inputs the sum is an upper bound. Raises ``ValueError`` if the dimensions leave no frame to compute.
    """
    units = layout.input_units
    half, shares = len(units) // 2, Counter[str]()
    parts = [[Arm(unit)] for unit in units]
    if len(units) % 2 == 0:
        parts = [[Arm(one), Arm(other, -1)] for one, other in zip(units[:half], units[half:], strict=True)]
    for arms in parts:
        # The work of a part is its rotation of the drum under its share of the load, times that share.
        shares.update(_arms_urad_Nm(arms, 1.0 / len(units)))
    return FrameCompliance(sum(shares.values()), dict(shares))


def _arms_urad_Nm(arms: Sequence[Arm], share: float) -> dict[str, float]:
    """Windup by part of a frame with one arm or two, each with this share of the torque."""
    first = arms[0].layout
    f, material = first.frame, first.drive.frame_material
    mesh, held = _mesh(arms)
    total = np.zeros((len(mesh.plates.node_mm), 6))
    on_boss: dict[float, float] = {}
    for arm in arms:
        tension = share * unit_tensions_N(arm.layout.si)
        for panel, (x, y, z), force_x, couple_y in seat_forces(arm.layout, tension):
            # The bearings of the drum load the boss, those of the input the metal round their seats, and those of
            # idlers the metal from one axle to the other.
            seat = f.motor.pocket_radius if f.motor else _SPREAD * max(f.seat_radius, first.head.seat_radius)
            reach = f.boss.radius if z == 0.0 else seat
            stand = next((stand for stand in f.stands if stand.z == z), None)
            reach = reach if stand is None else stand.x + 2 * stand.axle_radius
            if panel == "motor shelf":
                reach = first.drive.gearhead.diameter_mm / 2
            point = (arm.way * x, y, arm.way * z)
            if z == 0.0:
                on_boss[y] = on_boss.get(y, 0.0) + arm.way * force_x
            if f.motor is not None and f.motor.window is not None and z != 0.0:
                nodes = _window_ends(mesh, arm, f.motor)
            else:
                nodes = mesh.near(arm.of(panel), point, (reach, 1e3, reach))
            load = pm.centred_load(mesh, nodes, np.array(point), arm.way * force_x, couple_y=couple_y)
            total[nodes, :3] += load
    shares = pm.shares_urad(mesh, material, total.ravel(), held.springs(mesh, material))
    # The ring round the drum's bearings, as high as boss and plate are on the average.
    boss = f.boss
    outer = (boss.radius + max(f.half_width, boss.radius)) / 2
    ring = BossRing(boss.seat_radius, outer, outer, boss.encoder_pocket_floor_y, boss.front_y)
    at, force = (np.array(tuple(values)) for values in (on_boss.keys(), on_boss.values()))
    shares["boss ring"] = ring.work_Nmm(at, force, elastic(material)) * pm.URAD_PER_MRAD
    return shares


def _mesh(arms: Sequence[Arm]) -> tuple[pm.PlateMesh, pm.Mounts]:
    first = arms[0].layout
    f, v, screw = first.frame, first.levels, first.drive.screw(first.drive.support.mount_bolt)
    places = [(arm.way * x, arm.way * z) for arm in arms for x, z in f.mounts]
    held = pm.Mounts(
        places, screw.head_diameter_mm / 2, f.mount_radius, v.front_y - v.plate_back_y, (v.plate_back_y + v.front_y) / 2
    )
    return pm.plate_mesh(walls(arms), held), held


def out_of_line_mrad(layout: SpurLayout, lower_N: float, upper_N: float) -> tuple[float, float]:
    """Angles between seats and shaft at an input's (lower, upper) bearing, whose loads pull towards the drum.

    The shaft counts as straight. Raises ``ValueError`` if the dimensions leave no frame to compute.
    """
    f, ends = layout.frame, layout.input_bearings_mm(0)
    mesh, held = _mesh([Arm(layout)])
    reach = _SPREAD * max(f.seat_radius, layout.head.seat_radius)
    load, seats = np.zeros((len(mesh.plates.node_mm), 6)), []
    for panel, y, force in zip(("motor head's flange", "encoder shelf"), ends, (lower_N, upper_N), strict=True):
        point = np.array([0.0, y, f.axis_z])
        seats.append(mesh.near(panel, tuple(point), (reach, 1e3, reach)))
        load[seats[-1], :3] += pm.centred_load(mesh, seats[-1], point, 0.0, force_z=-force)
    moved = pm.pulled(mesh, layout.drive.frame_material, load.ravel(), held.springs(mesh, layout.drive.frame_material))
    lower, upper = (moved[nodes].mean(axis=0) for nodes in seats)
    tilt = (upper[2] - lower[2]) / (ends[1] - ends[0])
    return abs(float(lower[3] - tilt)) * 1e3, abs(float(upper[3] - tilt)) * 1e3


def frame_study(layout: SpurLayout) -> FrameStudy:
    """The compliance as a study for the cache."""
    # Of the drum's shaft only the positions of its bearings: other changes of it must not make the study run again.
    inputs = tuple(
        (
            unit.frame,
            (None if unit.frame.motor else unit.head, unit.drive.gearhead.diameter_mm),
            (unit.drum_shaft.rear_bearing_y, unit.drum_shaft.front_bearing_y),
            unit.drive.support,
            unit.drive.bearings,
            unit.drive.cables,
            unit.drive.centre_distance_mm,
            unit.drive.idlers,
        )
        for unit in layout.input_units
    )
    walls = ("bridge_mm", "plate_mm", "encoder_shelf_mm", "side_wall_mm")
    return FrameStudy(
        __name__, inputs, lambda: frame_compliance(layout), {w: getattr(layout.drive.support, w) for w in walls}
    )
