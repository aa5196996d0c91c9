"""Parts of a design as files for a 3D printer, and how printable they are: thinnest wall, overhanging faces.

Round holes are enlarged, because a printer makes them too narrow.
"""

from __future__ import annotations

import os
from math import pi
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from mbcdm_cad.design.drive import Drive
from mbcdm_cad.errors import MbcdmError
from mbcdm_cad.layouts.registry import layout_of
from mbcdm_cad.parts.bill import Vector
from mbcdm_cad.parts.milled import one_solid
from mbcdm_cad.parts.part import cq
from mbcdm_cad.storage.cache import Cache, content_key
from mbcdm_cad.workshop.export.files import lying, threemf_bytes
from mbcdm_cad.workshop.store import Progress, Store, drawn, exported_parts
from mbcdm_cad.workshop.trianglemesh import FloatArray, TriangleMesh, faces

if TYPE_CHECKING:
    from mbcdm_cad.workshop.kernel import Shape

# Distance of the rays that find walls, and least number of rays that must find the same wall.
RAYS_MM, RAYS = 0.25, 4
# Both faces of a wall must be nearly perpendicular to the ray through it (cosine of the angle).
_SQUARE = 0.9
# A face that overhangs by more than this angle from the vertical needs a support (usual rule for filament).
OVERHANG_DEG = 45.0
# A face counts as lying on the bed within this height.
_ON_BED_MM = 0.01


class ThinWall(NamedTuple):
    """The thinnest wall found, and the place of its middle, mm."""

    thickness_mm: float
    at_mm: Vector


def thinnest_wall(mesh: TriangleMesh) -> ThinWall | None:
    """Thinnest wall that is square to an axis of the part, by rays along all three; None if there is none.

    An oblique wall is found only where its faces are perpendicular to an axis, as on a cylinder.
    """
    found: list[ThinWall] = []
    _, normals = faces(mesh.corners_mm)
    for axis in range(3):
        first, second = (axis + 1) % 3, (axis + 2) % 3
        enters, leaves = (
            _hits(mesh.corners_mm[sign * normals[:, axis] > _SQUARE][:, :, (first, second, axis)]) for sign in (-1, 1)
        )
        thickness, rays, start = _pairs(enters, leaves)
        order = np.argsort(thickness, kind="stable")
        if len(order) >= RAYS:
            n = order[RAYS - 1]
            at = np.zeros(3)
            at[first], at[second] = rays[n] * RAYS_MM
            at[axis] = start[n] + thickness[n] / 2
            found.append(ThinWall(float(thickness[n]), (float(at[0]), float(at[1]), float(at[2]))))
    return min(found, default=None)


def overhang_mm2(mesh: TriangleMesh) -> float:
    """Area, mm^2, that overhangs by more than ``OVERHANG_DEG`` from the vertical, with the part on the bed."""
    corners = mesh.corners_mm @ lying(mesh).T
    area, normals = faces(corners)
    down = normals[:, 2] < -np.sin(np.radians(OVERHANG_DEG)) - 1e-6
    on_bed = corners[:, :, 2].max(axis=1) < corners[:, :, 2].min() + _ON_BED_MM
    return float(area[down & ~on_bed].sum())


def _hits(triangles: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Rays (n, 2) as whole numbers of the grid, and the depth at which each meets one of the triangles (m, 3, 3)."""
    rays, depths = [np.empty((0, 2))], [np.empty(0)]
    for triangle in triangles:
        flat = triangle[:, :2] / RAYS_MM
        low, high = np.ceil(flat.min(axis=0)), np.floor(flat.max(axis=0))
        if (high < low).any():
            continue
        u, v = np.meshgrid(np.arange(low[0], high[0] + 1), np.arange(low[1], high[1] + 1), indexing="ij")
        a, b, c = flat
        e, f, p = b - a, c - a, np.stack([u.ravel(), v.ravel()], axis=1) - a
        area = e[0] * f[1] - e[1] * f[0]
        if abs(area) < 1e-12:
            continue
        s = (p[:, 0] * f[1] - p[:, 1] * f[0]) / area
        t = (e[0] * p[:, 1] - e[1] * p[:, 0]) / area
        inside = (s >= 0.0) & (t >= 0.0) & (s + t <= 1.0)
        rays.append((p + a)[inside])
        start, one, other = triangle[:, 2]
        depths.append((start + s * (one - start) + t * (other - start))[inside])
    grid: FloatArray = np.rint(np.concatenate(rays))
    return grid, np.concatenate(depths)


def _pairs(
    enters: tuple[FloatArray, FloatArray], leaves: tuple[FloatArray, FloatArray]
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Thickness, ray and start of each stretch of a ray from the face where it enters to that where it leaves."""
    rays = np.concatenate([enters[0], leaves[0]])
    depth = np.concatenate([enters[1], leaves[1]])
    into = np.concatenate([np.ones(len(enters[1]), bool), np.zeros(len(leaves[1]), bool)])
    order = np.lexsort((depth, rays[:, 1], rays[:, 0]))
    rays, depth, into = rays[order], depth[order], into[order]
    wall = into[:-1] & ~into[1:] & (rays[:-1] == rays[1:]).all(axis=1)
    thickness = (depth[1:] - depth[:-1])[wall]
    # If an edge of the solid lies on the ray, the two faces that meet there have no wall between them.
    real = thickness > 1e-3
    return thickness[real], rays[:-1][wall][real], depth[:-1][wall][real]


def prints_of(
    drive: Drive, cache: Cache, progress: Progress = lambda name: None, *, every_made_part: bool = False
) -> dict[str, bytes]:
    """The parts of printed materials by file name (``NAME.3mf``), or all made parts.

    Round holes of printed materials are wider by ``printing.hole_allowance_mm``, which the file then states. Raises
    ``GeometryError`` for a part that cannot be drawn, ``MbcdmError`` if no part is printed.
    """
    posed = layout_of(drive).bill()
    made = {item.part: item.material for item in posed.items if item.kind == "made"}
    wanted = {name: material for name, material in made.items() if every_made_part or material.printed}
    if not wanted:
        raise MbcdmError(
            f"no part is printed (value {', '.join(sorted({m.process for m in made.values()}))}, limit printed or "
            "sintered: the process of its material); give a part such a material ('mbcdm catalogue materials') or ask "
            "for every made part with --all"
        )
    _, parts = drawn(drive, 0.0, cache, progress)
    files = exported_parts(Store(cache, progress), posed, parts, drive, os.cpu_count() or 1)
    found = {}
    for name, material in wanted.items():
        wider = drive.printing.hole_allowance_mm if material.printed else 0.0
        key = content_key("3mf", (name, files[name].key, wider, drive.export.mesh_tolerance_mm))
        blobs = cache.get(key)
        if blobs is None:
            progress(f"3MF of {name}")
            mesh, note = files[name].files.mesh, ""
            if wider:
                from mbcdm_cad.workshop.meshing import mesh_solid

                solid = with_wider_holes(name, files[name].solid(), wider)
                mesh = mesh_solid(name, solid, drive.export.mesh_tolerance_mm)
                note = f"round holes {wider:g} mm wider than drawn, on the diameter"
            blobs = {"3mf": threemf_bytes(name, mesh, note)}
            cache.put(key, blobs)
        found[f"{name}.3mf"] = blobs["3mf"]
    return found


# A bore counts as a hole if at least this share of its wall exists: slits and crossing holes may remove the rest.
LEAST_WALL = 0.75
# Coordinates, directions and radii that differ by less than this count as equal.
_DIGITS = 4


class RoundHole(NamedTuple):
    """A round bore from ``low_mm`` to ``high_mm`` along its axis, which passes through ``foot_mm``."""

    foot_mm: tuple[float, float, float]
    direction: tuple[float, float, float]
    radius_mm: float
    low_mm: float
    high_mm: float


def round_holes(solid: Shape, least_wall: float = LEAST_WALL) -> list[RoundHole]:
    """Round bores with at least this share of their wall, in a fixed order."""
    from OCP.BRepAdaptor import BRepAdaptor_Surface

    walls: dict[tuple[float, ...], list[tuple[float, float, float]]] = {}
    for face in cq.Shape.cast(solid).Faces():
        if face.geomType() != "CYLINDER":
            continue
        surface = BRepAdaptor_Surface(face.wrapped)
        cylinder, reversed_ = surface.Cylinder(), face.wrapped.Orientation().name.endswith("REVERSED")
        # The normal of a wall points to the axis; that of a left-handed surface is reversed.
        if cylinder.Position().Direct() != reversed_:
            continue
        axis = cylinder.Axis()
        d = cq.Vector(axis.Direction())
        if (round(d.x, _DIGITS), round(d.y, _DIGITS), round(d.z, _DIGITS)) < (0.0, 0.0, 0.0):
            d = -d
        at = cq.Vector(axis.Location())
        foot = at - d * at.dot(d)
        # A wall that ends in a curved face extends beyond its vertices along the axis.
        *_, low, high = face._uvBounds()
        ends = sorted((at + cq.Vector(axis.Direction()) * v).dot(d) for v in (low, high))
        key = tuple(round(v, _DIGITS) + 0.0 for v in (*foot.toTuple(), *d.toTuple(), cylinder.Radius()))
        walls.setdefault(key, []).append((ends[0], ends[1], face.Area()))
    holes = []
    for key in sorted(walls):
        radius = key[6]
        for low, high, area in _together(walls[key]):
            if area > least_wall * 2 * pi * radius * (high - low):
                holes.append(RoundHole((key[0], key[1], key[2]), (key[3], key[4], key[5]), radius, low, high))
    return holes


def _together(pieces: list[tuple[float, float, float]]) -> list[tuple[float, float, float]]:
    """Pieces of one bore's wall whose stretches of the axis overlap, their areas added."""
    whole: list[tuple[float, float, float]] = []
    for low, high, area in sorted(pieces):
        if whole and low < whole[-1][1] - 1e-6:
            before = whole.pop()
            low, high, area = before[0], max(high, before[1]), area + before[2]
        whole.append((low, high, area))
    return whole


def with_wider_holes(name: str, solid: Shape, allowance_mm: float) -> Shape:
    """The solid with all its round holes wider by ``allowance_mm`` on the diameter. Raises ``ValueError`` naming it."""
    body = cq.Shape.cast(solid)
    for hole in round_holes(solid):
        start = cq.Vector(*hole.foot_mm) + cq.Vector(*hole.direction) * hole.low_mm
        length, along = hole.high_mm - hole.low_mm, cq.Vector(*hole.direction)
        outer = cq.Solid.makeCylinder(hole.radius_mm + allowance_mm / 2, length, start, along)
        # A ring-shaped tool, so that a solid inside the bore that does not touch its wall remains.
        inner = cq.Solid.makeCylinder(hole.radius_mm * 0.95, length, start, along)
        body = body.cut(outer.cut(inner))
    return one_solid(body, name).wrapped
