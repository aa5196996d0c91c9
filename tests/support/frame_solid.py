"""A frame by solid finite elements of its STEP: how far it lets the drum turn by the forces on its seats.

Frame and what is screwed on it (top plate, motor heads) are bonded, held rigidly on the ring under the head of each
mounting screw on the back, as the model assumes; the cables' forces are put on the seats of the bearings with the
cosine of the angle, pull included, and the gearheads' torque on their faces. Forces follow from the routes by statics
written here; together they must be in equilibrium with the moment of 1 N m about the drum's axis.
Units: mm, N, MPa; results in urad per N m.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from mbcdm_cad.layouts.sector import SectorLayout
from mbcdm_cad.model.stiffness import unit_tensions_N
from tests.support.solid_fe import Disc, Floats, Solid, tetrahedra

# Parts of the frame by the beginning of their name.
PARTS = ("frame", "top_plate", "motor_head")
# Longest tetrahedra, over the frame's largest extent.
SIZE = 1.0 / 28.0
# A seat's facets may reach this far beyond what presses on it; there they carry nothing.
BESIDE_MM = 1.5


@dataclass(frozen=True, eq=False)
class Seat:
    """A bore: middle (3,), axis (3,), radius and length of what presses on it, mm, and the force (3,) on it, N."""

    name: str
    centre: Floats
    axis: Floats
    radius: float
    length: float
    force: Floats


@dataclass(frozen=True, eq=False)
class Face:
    """A gearhead's face: middle (3,), axis (3,), radius, and the couple (N mm) about the axis that it takes."""

    centre: Floats
    axis: Floats
    radius: float
    couple: float


def _pulls(layout: SectorLayout, body: str, tension: Floats) -> Iterator[tuple[Floats, Floats]]:
    """Places (3,) in mm where the cables touch a body, and the forces (3,) of their spans on it there."""
    routes = layout.loads.si.routes
    found = routes.body(body)
    axis, origin = np.array(found.axis), 1e3 * np.array(found.point_m)
    for route, pulled in zip(routes.cables, tension, strict=True):
        for contact in route.contacts():
            wrap = contact.wrap
            if wrap.body != body:
                continue
            for direction, sign in ((contact.leaving, 1.0), (contact.arriving, -1.0)):
                if direction is not None:
                    t = np.array(direction)
                    out = -wrap.turning * wrap.radius_m * np.cross(axis, t)
                    yield origin + 1e3 * (wrap.height_m * axis + out), pulled * sign * t


def _on_supports(layout: SectorLayout, body: str, tension: Floats, places: Floats) -> tuple[Floats, float]:
    """Forces (2, 3) of a body on two supports at ``places`` (2, 3), and the moment about its axis left over, N mm."""
    axis = np.array(layout.loads.si.routes.body(body).axis)
    force, moment = np.zeros(3), np.zeros(3)
    for place, pull in _pulls(layout, body, tension):
        force += pull
        moment += np.cross(place - places[0], pull)
    arm = places[1] - places[0]
    across = moment - (moment @ axis) * axis
    second = np.cross(across, arm) / (arm @ arm)
    return np.stack([force - second, second]), float(moment @ axis)


def loads(layout: SectorLayout) -> tuple[list[Seat], list[Face]]:
    """The forces on seats and gearheads' faces by the change of tensions for 1 N m on the drum."""
    routes, bearings, drive = layout.loads.si.routes, layout.drive.bearings, layout.drive
    unit = unit_tensions_N(layout.loads.si)
    y = np.array([0.0, 1.0, 0.0])
    seats: list[Seat] = []
    faces: list[Face] = []

    def add(name: str, centre: Floats, axis: Floats, radius: float, length: float, force: Floats) -> None:
        seats.append(Seat(name, centre, axis, radius, length, force))

    places = np.array([y * at for at in layout.drum_bearings_mm])
    forces, torque = _on_supports(layout, routes.drum.name, unit, places)
    assert abs(abs(torque) - 1e3) < 1.0, f"the cables hold {torque:.1f} N mm, not 1 N m"
    for name, centre, force in zip(("rear", "front"), places, forces, strict=True):
        add(f"drum {name}", centre, y, bearings.drum.outer_diameter_mm / 2, bearings.drum.width_mm, force)
    for i, name in enumerate(drive.input_names):
        body = routes.inputs[i].name
        found = routes.body(body)
        along = layout.levels_sense * np.array(found.axis)
        origin = 1e3 * np.array(found.point_m)
        at = [origin + level * along for level in layout.input_bearings_mm(i)]
        forces, torque = _on_supports(layout, body, unit, np.array(at))
        for end, centre, force in zip(("lower", "upper"), at, forces, strict=True):
            spec = bearings.input_lower if end == "lower" else bearings.input_upper
            add(f"{name} {end}", centre, along, spec.outer_diameter_mm / 2, spec.width_mm, force)
        face = origin + layout.levels_of(i).motor_shelf_bottom_z * along
        faces.append(Face(face, along, drive.gearhead.diameter_mm / 2, torque * layout.levels_sense))
    for body in (b.name for b in routes.bodies if b.kind == "passed"):
        low, high = layout.axle_supports_mm
        z = np.array([0.0, 0.0, 1.0])
        forces, _ = _on_supports(layout, body, unit, np.array([low * z, high * z]))
        v = layout.levels
        shelves = (v.bearing_shelf_top_z - v.bearing_shelf_bottom_z, v.top_plate_top_z - v.top_plate_bottom_z)
        for name, at, length, force in zip(("lower", "upper"), (low, high), shelves, forces, strict=True):
            add(f"axle {name}", at * z, z, layout.frame.axle_radius, length, force)
    whole = sum(seat.force for seat in seats)
    turned = sum(np.cross(seat.centre, seat.force) for seat in seats) + sum(f.couple * f.axis for f in faces)
    assert np.abs(whole).max() < 0.05 * max(np.abs(s.force).max() for s in seats), f"net force {whole} N"
    assert np.abs(np.abs(turned) - (0.0, 1e3, 0.0)).max() < 50.0, f"moment {turned} N mm, not 1 N m about the drum"
    return seats, faces


def mounts(layout: SectorLayout) -> tuple[list[tuple[float, float]], float, float]:
    """(x, z) of the mounting screws, the radius of their heads, and the back face's height along Y."""
    frame, head = layout.frame, layout.mounting.seat_mm(layout.mount_washers) / 2
    back = frame.levels.plate_back_y if hasattr(frame.levels, "plate_back_y") else frame.levels.back_y
    star = getattr(layout, "star", None)
    if star is None:
        return list(frame.mounts), head, back
    return [place for k, arm in enumerate(star.arms) for place in star.turned(k, arm.mounts)], head, back


def solid_of(layout: SectorLayout, folder: Path, size: float = SIZE) -> Solid:
    """The frame's parts as drawn, in their places, meshed together."""
    import cadquery as cq

    from mbcdm_cad.workshop.kernel import location

    bill = layout.bill(0.0)
    steps, extent = [], 0.0
    for item in bill.items:
        if item.kind == "made" and item.group == "fixed" and item.name.startswith(PARTS):
            placed = bill.parts[item.part].part.solid().moved(cq.Location(location(item.location)))
            box = placed.BoundingBox()
            extent = max(extent, box.xlen, box.ylen, box.zlen)
            steps.append(folder / f"{item.name}.step")
            placed.exportStep(str(steps[-1]))
    places, head, back = mounts(layout)
    discs = [Disc((x, back, z), (0.0, 1.0, 0.0), head) for x, z in places]
    material = layout.frame_material
    mesh = tetrahedra(steps, size * extent, 0.4, discs)
    return Solid(mesh, material.youngs_modulus_GPa * 1e3, material.poisson_ratio)


def _pressed(solid: Solid, seat: Seat) -> Floats:
    """Nodal forces of a seat: pressure with the cosine of the angle, corrected so that force and moment are right."""

    def out(p: Floats) -> tuple[Floats, Floats]:
        off = p - seat.centre.reshape(3, *[1] * (p.ndim - 1))
        along = np.tensordot(seat.axis, off, 1)
        radial = off - seat.axis.reshape(3, *[1] * (p.ndim - 1)) * along
        return radial, along

    def on(p: Floats) -> Floats:
        radial, along = out(p)
        near = np.abs(np.linalg.norm(radial, axis=0) - seat.radius) < 0.05
        return near & (np.abs(along) < seat.length / 2 + BESIDE_MM)

    facets = solid.facets(on)
    assert facets.size, f"no surface at the seat {seat.name}"

    def cosine(p: Floats, force: Floats) -> tuple[Floats, ...]:
        radial, along = out(p)
        n = radial / np.linalg.norm(radial, axis=0)
        inside = (np.abs(along) <= seat.length / 2) * 1.0
        return tuple(n * np.tensordot(force, n, 1) * inside)

    def tilting(p: Floats, force: Floats) -> tuple[Floats, ...]:
        _, along = out(p)
        return tuple(np.array(cosine(p, force)) * along)

    across = [axis - (axis @ seat.axis) * seat.axis for axis in np.eye(3)]
    across = [a for a in across if np.linalg.norm(a) > 0.5]
    shapes = np.stack(
        [solid.traction(facets, lambda p, a=a, f=f: f(p, a)) for f in (cosine, tilting) for a in across], axis=1
    )
    wrench = np.array([resultant(solid, shape, seat.centre) for shape in shapes.T]).T
    wanted = np.concatenate([seat.force, np.zeros(3)])
    share = np.linalg.lstsq(wrench, wanted, rcond=None)[0]
    left = wrench @ share - wanted
    assert np.abs(left[:3]).max() < 0.02 * max(np.linalg.norm(seat.force), 1.0), f"{seat.name}: {left}"
    return shapes @ share


def _twisted(solid: Solid, face: Face) -> Floats:
    """Nodal forces of a couple on a gearhead's face, along the circles about its axis."""

    def on(p: Floats) -> Floats:
        off = p - face.centre[:, None]
        along = face.axis @ off
        return (np.abs(along) < 1e-3) & (np.linalg.norm(off - np.outer(face.axis, along), axis=0) < face.radius)

    facets = solid.facets(on)
    assert facets.size, "no surface at a gearhead's face"

    def round_it(p: Floats) -> tuple[Floats, ...]:
        return tuple(np.cross(face.axis, p - face.centre[:, None, None], axisb=0, axisc=0))

    load = solid.traction(facets, round_it)
    return load * (face.couple / (resultant(solid, load, face.centre)[3:] @ face.axis))


def resultant(solid: Solid, load: Floats, about: Floats) -> Floats:
    """Force and moment (6,) of nodal forces."""
    force = np.zeros((3, load.size))
    force[solid.direction, np.arange(load.size)] = load
    arm = solid.place - about[:, None]
    return np.concatenate([force.sum(axis=1), np.cross(arm, force, axis=0).sum(axis=1)])


def frame_by_solids(layout: SectorLayout, folder: Path, size: float = SIZE) -> tuple[float, int]:
    """Turn of the drum by the frame, urad per N m; and the number of tetrahedra."""
    solid = solid_of(layout, folder, size)
    seats, faces = loads(layout)
    load = sum(_pressed(solid, seat) for seat in seats) + sum(_twisted(solid, face) for face in faces)
    places, head, back = mounts(layout)
    at = solid.place
    held = np.zeros(at.shape[1], dtype=bool)
    for x, z in places:
        held |= (np.abs(at[1] - back) < 1e-4) & (np.hypot(at[0] - x, at[2] - z) < head + 1e-3)
    assert held.any(), "no mounting screw holds the frame"
    moved = solid.moved(load, np.flatnonzero(held))
    return float(load @ moved) * 1e3, solid.mesh.t.shape[1]
