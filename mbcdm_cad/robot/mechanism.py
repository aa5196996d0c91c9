"""Links, joints and cables of a design in SI, from its bill and its model; both robot formats are written from them."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from math import radians
from xml.etree import ElementTree as ET

import numpy as np
from numpy.typing import NDArray

from mbcdm_cad.design.drive import Drive
from mbcdm_cad.errors import MbcdmError
from mbcdm_cad.layouts.lumped import axis_friction
from mbcdm_cad.layouts.registry import layout_of
from mbcdm_cad.model.analysis import analyse
from mbcdm_cad.parts.bill import Item, Vector
from mbcdm_cad.robot.elastic import drum_friction
from mbcdm_cad.workshop.interference import MovingGroup, bodies, is_cable
from mbcdm_cad.workshop.mass import MassProperties, PartFiles, combined, item_mass
from mbcdm_cad.workshop.trianglemesh import TriangleMesh

MM = 1e-3
G = 1e-3
G_MM2 = 1e-9
# Speed of the drum where nothing of the catalogue says one: a round value above the usual ones.
SPEED_WITHOUT_FIGURES_RAD_S = 10.0
# A torque that has fallen by less than this share is still the whole one.
_STILL_WHOLE = 1.0 - 1e-6


@dataclass(frozen=True)
class Link:
    """One body in m, kg, kg m^2, in its own frame: origin on the joint's axis, directions of the mechanism's frame.

    ``inertia`` is the tensor about the centre of gravity. ``origin`` is the origin of its frame in the mechanism's.
    """

    name: str
    origin: Vector
    mass: float
    cog: Vector
    inertia: tuple[Vector, Vector, Vector]
    colour: Vector
    mesh: TriangleMesh  # mm, in the mechanism's frame


@dataclass(frozen=True)
class Joint:
    """Joint of a link on the base: turns about ``axis`` by ``ratio`` times the drum; ``armature``: rotor inertia.

    Its zero is that of the output; the links are drawn at ``drawn_rad``, where the drum is in the middle of its travel.
    ``effort_Nm`` and ``speed_rad_s``: the largest torque that it holds continuously, and speed that goes with it.
    ``friction_Nm``: dry friction under the preload, at the drum that of the bodies that cables pass too, at an input
    that of gearhead and motor; the part in proportion to a load is in ``effort_Nm``. ``damping_Nm_s``: at the drum, if
    one was found on the built drive. ``leader``: the input that turns
    it by belt or gears; empty where it follows the drum.
    """

    link: str
    axis: Vector
    ratio: float
    range_rad: tuple[float, float]
    drawn_rad: float
    armature: float  # kg m^2
    effort_Nm: float
    speed_rad_s: float
    friction_Nm: float
    leader: str = ""
    damping_Nm_s: float = 0.0


@dataclass(frozen=True)
class Mechanism:
    """The whole drive. ``base`` is fixed and includes the mass of the cables; ``drum`` is the joint that leads.

    ``inputs``: links of the inputs in the design's order. ``note``: what the file says first, for those who read it.
    """

    name: str
    base: Link
    links: tuple[Link, ...]
    joints: tuple[Joint, ...]
    drum: str
    inputs: tuple[str, ...]
    note: str = ""

    def link(self, name: str) -> Link:
        """The moving link with this name."""
        return next(link for link in self.links if link.name == name)

    def joint(self, name: str) -> Joint:
        """The joint of the link with this name."""
        return next(joint for joint in self.joints if joint.link == name)


def mechanism(drive: Drive, parts: Mapping[str, PartFiles]) -> Mechanism:
    """The drive as links and joints; ``parts`` by name, meshed again where a body has too many faces for simulators."""
    layout = layout_of(drive)
    centred = layout.bill()
    items = {item.name: item for item in centred.items}
    still, *turning = (_named(body) for body in bodies(layout.moving_bodies, centred))
    drum = next(body for body in turning if body.kind == "drum")
    drum_effort, drum_speed = _limits(drive)
    rubs, built = axis_friction(drive), drum_friction(drive)
    of_motor = layout_of(drive).losses.motor_idle_Nm * drive.reduction.ratio
    inputs = [body.name for body in turning if body.kind == "input"]
    friction = {drum.name: max(rubs.drum_Nm + built.constant_Nm, 0.0)}
    friction |= {name: own + of_motor for name, own in zip(inputs, rubs.inputs_Nm, strict=True)}
    damping = {drum.name: max(built.viscous_Nm_s, 0.0)}
    links = tuple(_link(body, [items[name] for name in body.items], parts, drive) for body in turning)
    fixed = [items[name] for name in still.items]
    base = _link(still, fixed, parts, drive, extra=[item for item in centred.items if is_cable(item)])
    return Mechanism(
        name=drive.name,
        base=base,
        links=links,
        joints=tuple(
            replace(
                _joint(body, drive, (drum_effort, drum_speed), friction.get(body.name, 0.0)),
                damping_Nm_s=damping.get(body.name, 0.0),
            )
            for body in turning
        ),
        drum=drum.name,
        inputs=tuple(inputs),
    )


def _named(body: MovingGroup) -> MovingGroup:
    """A driving wheel as ``stage_INPUT``: pinocchio goes through joints by alphabet, and must meet the drum first."""
    return replace(body, name=body.name.replace("driver_", "stage_", 1)) if body.kind == "stage" else body


def _link(
    body: MovingGroup, shown: list[Item], parts: Mapping[str, PartFiles], drive: Drive, extra: Sequence[Item] = ()
) -> Link:
    """A link of the body; items of ``extra`` add their mass but are not drawn."""
    whole = combined(item_mass(item, parts[item.part].shape) for item in [*shown, *extra])
    origin = np.array(body.point_mm)
    heaviest = max(shown, key=lambda item: item_mass(item, parts[item.part].shape).mass_g)
    meshes = within_faces(body.name, [item.part for item in shown], parts, drive.export.mesh_tolerance_mm)
    return Link(
        name=body.name,
        origin=_metres(origin),
        mass=whole.mass_g * G,
        cog=_metres(np.array(whole.cog_mm) - origin),
        inertia=_inertia(whole),
        colour=heaviest.material.colour,
        mesh=_joined([(item, meshes[item.part]) for item in shown]),
    )


def _limits(drive: Drive) -> tuple[float, float]:
    """Torque (N m) and speed (rad/s) of the drum, those of ``analyse``.

    The torque that the motors hold continuously in the weaker direction, with all losses, or see
    :func:`_effort_of_duty`; the highest speed at which the bus voltage still gives the continuous torque, or a round
    one where the catalogue has no electrical values of the motor.
    """
    found = analyse(layout_of(drive))
    effort = min(found.peak_torque_with_losses_Nm)
    if layout_of(drive).duty.stated:
        effort = _effort_of_duty(drive)
    if found.motor is None:
        return effort, SPEED_WITHOUT_FIGURES_RAD_S
    still = found.motor.curve[0].continuous_Nm
    whole = [point.drum_speed_deg_s for point in found.motor.curve if point.continuous_Nm >= _STILL_WHOLE * still]
    return effort, radians(max(whole))


def _effort_of_duty(drive: Drive) -> float:
    """Torque at the drum, N m: the largest load of a stated duty, as much larger or smaller as the windings stand it.

    At most what motors and gearheads move for a short time, with all losses.
    """
    layout = layout_of(drive)
    duty, train = layout.duty, layout.losses
    stands = min(day.stands_share for day in layout.motor_days)
    most = min(float(train.output_Nm(drive.motor.peak_torque_mNm * 1e-3)), drive.reduction.max_torque_mNm * 1e-3)
    return min(stands * duty.peak_torque_Nm, *(float(train.raised_Nm(most, way).min()) for way in (1, -1)))


def _joint(body: MovingGroup, drive: Drive, drum_limits: tuple[float, float], friction_Nm: float) -> Joint:
    drum_effort_Nm, drum_speed_rad_s = drum_limits
    turns, drawn = abs(body.ratio), radians(body.ratio * drive.middle_deg)
    half = radians(turns * (drive.half_travel_deg + drive.stop_clearance_deg))
    effort = drum_effort_Nm / turns
    if body.kind == "input":
        # Torque at a gearhead's output: at the motor's continuous torque, or what a stated duty's effort needs there.
        train, motor_Nm = layout_of(drive).losses, drive.motor.rated_torque_mNm * 1e-3
        if layout_of(drive).duty.stated:
            moved = train.moving(np.array([drum_effort_Nm, -drum_effort_Nm]), 1)
            motor_Nm = float(moved.motor_Nm.max()) - train.motor_idle_Nm
        effort = min(float(train.output_Nm(motor_Nm)), drive.reduction.max_torque_mNm * 1e-3)
    return Joint(
        body.name,
        body.axis,
        body.ratio,
        (drawn - half, drawn + half),
        drawn,
        armature=drive.rotor_at_input_kg_m2 if body.kind == "input" else 0.0,
        effort_Nm=effort,
        speed_rad_s=drum_speed_rad_s * turns,
        friction_Nm=friction_Nm,
        leader=body.name.replace("stage_", "input_", 1) if body.kind == "stage" else "",
    )


def _joined(pieces: list[tuple[Item, TriangleMesh]]) -> TriangleMesh:
    """One mesh of several, each at its placement."""
    points, normals, triangles, count = [], [], [], 0
    for item, mesh in pieces:
        points.append(item.location.apply(mesh.points_mm))
        normals.append(mesh.normals @ item.location.rotation.T)
        triangles.append(mesh.triangles + np.int32(count))
        count += len(mesh.points_mm)
    return TriangleMesh(
        np.concatenate(points),
        np.concatenate(normals),
        np.concatenate(triangles),
        np.empty((0, 2), np.int32),
        max(mesh.deviation_mm for _, mesh in pieces),
    )


def _inertia(whole: MassProperties) -> tuple[Vector, Vector, Vector]:
    first, second, third = (_vector(np.array(row) * G_MM2) for row in whole.inertia_g_mm2)
    return first, second, third


def _metres(values_mm: NDArray[np.float64]) -> Vector:
    return _vector(values_mm * MM)


def _vector(values: NDArray[np.float64]) -> Vector:
    x, y, z = (float(v) + 0.0 for v in values)
    return x, y, z


def document(root: ET.Element, note: str = "") -> bytes:
    """The file, indented, with a note as its first comment; the same tree gives the same bytes."""
    if note:
        root.insert(0, ET.Comment(f" {note.replace('--', '-')} "))
    ET.indent(root)
    return bytes(ET.tostring(root, encoding="utf-8", xml_declaration=True)) + b"\n"


def numbers(values: Iterable[float]) -> str:
    """Values with ten digits, between spaces."""
    return " ".join(f"{value:.10g}" for value in values)


def triangle(inertia: tuple[tuple[float, ...], ...]) -> dict[str, float]:
    """The six terms of a symmetric tensor by name."""
    (xx, xy, xz), (_, yy, yz), (_, _, zz) = inertia
    return {"ixx": xx, "ixy": xy, "ixz": xz, "iyy": yy, "iyz": yz, "izz": zz}


# A body with this many faces or more is refused by MuJoCo.
LARGEST_FACES = 200_000
# Each attempt is this much coarser than the last; on round surfaces it has about half the faces.
_COARSER = 4.0
# The coarsest attempt, mm: a mesh for looking at.
_COARSEST_MM = 2.0


def within_faces(
    body: str, shown: Sequence[str], parts: Mapping[str, PartFiles], tolerance_mm: float
) -> dict[str, TriangleMesh]:
    """A mesh of each part of a body, together below ``LARGEST_FACES``; ``shown``: the part of each of its items.

    The build's meshes where they are few enough; else the parts with the most faces are meshed again with 4, 16, ...
    times ``tolerance_mm``, the build's own. Raises ``MbcdmError`` if that does not help.
    """
    meshes = {name: parts[name].mesh for name in shown}
    while _faces(shown, meshes) >= LARGEST_FACES:
        tolerance_mm *= _COARSER
        if tolerance_mm > _COARSEST_MM:
            raise MbcdmError(
                f"the mesh of {body} has too many faces for simulators (value {_faces(shown, meshes)}, limit "
                f"{LARGEST_FACES - 1}, at {tolerance_mm / _COARSER:g} mm); its {len(shown)} items are too many"
            )
        fair = LARGEST_FACES / len(shown)  # a part below its share is left as it is
        for name in meshes:
            if len(meshes[name].triangles) > fair:
                from mbcdm_cad.workshop.kernel import shape_from_brep
                from mbcdm_cad.workshop.meshing import mesh_solid

                meshes[name] = mesh_solid(name, shape_from_brep(parts[name].brep), tolerance_mm)
    return meshes


def _faces(shown: Sequence[str], meshes: Mapping[str, TriangleMesh]) -> int:
    return sum(len(meshes[name].triangles) for name in shown)
