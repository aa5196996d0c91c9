"""Pictures for the person who assembles the drive: each assembly step, exploded view, section through the transfer."""

import os
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from mbcdm_cad.design.drive import Drive
from mbcdm_cad.layouts.base import Layout
from mbcdm_cad.layouts.registry import layout_of
from mbcdm_cad.parallel.forks import fork_map
from mbcdm_cad.parts.bill import CABLE, Item, Placement, Vector
from mbcdm_cad.storage.cache import Cache, content_key
from mbcdm_cad.workshop.mass import vector
from mbcdm_cad.workshop.store import Progress, StoredPart, drawn
from mbcdm_cad.workshop.trianglemesh import TriangleMesh

# Factor on the distance of each part from the middle in the exploded view.
EXPLODED = 1.1
# Colours (linear RGB) of parts from earlier steps and of parts that join; cables keep their own.
BEFORE: Vector = (0.5, 0.5, 0.5)
NEW: Vector = (0.1, 0.4, 0.9)
VIEW = "output"
# Rope diameters around the transfer points that a section shows.
_AROUND_DIAMETERS = 12.0
_SMALLEST_RADIUS_MM = 1e-6


def pictures_of(
    drive: Drive, cache: Cache, progress: Progress = lambda name: None, jobs: int | None = None
) -> dict[str, bytes]:
    """PNG files by name: ``step_01.png`` for each step that adds parts, ``exploded.png``, ``section.png``.

    Pictures whose parts, places and code have not changed come from the cache. Raises ``OutputError`` if the machine
    cannot draw.
    """
    layout = layout_of(drive)
    items, parts = drawn(drive, 0.0, cache, progress)
    by_name = {item.name: item for item in items}
    there: list[Item] = []
    wanted: dict[str, tuple[Sequence[Item], dict[str, Any]]] = {}
    for number, step in enumerate(layout.assembly_order, 1):
        if step.items:
            new = [by_name[name] for name in step.items]
            there = there + new
            wanted[f"step_{number:02d}"] = (tuple(there), {"new": frozenset(step.items)})
    wanted["exploded"] = (exploded(items, {name: part.files.mesh for name, part in parts.items()}), {})
    section = transfer_section(layout)
    if section is not None:
        wanted["section"] = (items, {"section": section})
    keys = {name: _key(shown, parts, how) for name, (shown, how) in wanted.items()}
    found = {name: cache.get(key) for name, key in keys.items()}
    missing = [name for name, blobs in found.items() if blobs is None]
    if missing:
        progress(", ".join(f"picture {name}" for name in missing))
        made = fork_map(lambda name: _png(parts, *wanted[name]), missing, jobs or os.cpu_count() or 1)
        for name, png in zip(missing, made, strict=True):
            found[name] = {"png": png}
            cache.put(keys[name], {"png": png})
    return {f"{name}.png": blobs["png"] for name, blobs in found.items() if blobs is not None}


def _key(shown: Sequence[Item], parts: Mapping[str, StoredPart], how: dict[str, Any]) -> str:
    keys = {item.part: parts[item.part].key for item in shown}
    plain = {key: sorted(value) if isinstance(value, frozenset) else value for key, value in how.items()}
    return content_key("picture for the builder", (shown, keys, plain))


def _png(parts: Mapping[str, StoredPart], shown: Sequence[Item], how: dict[str, Any]) -> bytes:
    from mbcdm_cad.workshop.export.picture import CutPlane, picture_png

    meshes = {item.part: parts[item.part].files.mesh for item in shown}
    new = how.get("new")
    cut = CutPlane(*how["section"]) if "section" in how else None

    def colour(item: Item) -> Vector:
        if new is None or item.name.startswith(CABLE):
            return item.material.colour
        return NEW if item.name in new else BEFORE

    return picture_png(shown, meshes, VIEW, colour_of=colour, cut=cut)


def exploded(items: Sequence[Item], meshes: Mapping[str, TriangleMesh]) -> tuple[Item, ...]:
    """The items moved away from their common middle, each in proportion to its distance from it."""
    middles = [np.mean(meshes[item.part].box_mm(item.location), axis=0) for item in items]
    low, high = np.min(middles, axis=0), np.max(middles, axis=0)
    apart = EXPLODED * (np.array(middles) - (low + high) / 2.0)
    return tuple(
        replace(item, location=Placement.translation(*(float(v) for v in shift)) @ item.location)
        for item, shift in zip(items, apart, strict=True)
    )


def transfer_section(layout: Layout) -> tuple[Vector, Vector, float] | None:
    """Centre, normal and half height of the plane through the drum's axis and the points where cables reach the drum.

    None where a configuration does not say which stretch of a cable lies on the drum.
    """
    drum = next(body for body in layout.moving_bodies if body.kind == "drum")
    reached = []
    for path in layout.cable_paths(0.0):
        for before, stretch, after in zip(
            (None, *path.stretches), path.stretches, (*path.stretches[1:], None), strict=False
        ):
            if stretch.body != drum.name or not stretch.pieces:
                continue
            if before is not None:
                reached.append(path.piece(stretch.pieces[0]).points(np.array([0.0]))[0])
            elif after is not None:
                reached.append(path.piece(stretch.pieces[-1]).points(np.array([1.0]))[0])
    if not reached:
        return None
    points = np.array(reached)
    axis, origin = np.array(drum.axis), np.array(drum.origin_mm)
    normal = np.cross(axis, points[0] - origin)
    length = float(np.linalg.norm(normal))
    if length < _SMALLEST_RADIUS_MM:
        return None
    low, high = points.min(axis=0), points.max(axis=0)
    half = float(np.linalg.norm(high - low)) / 2.0 + _AROUND_DIAMETERS * layout.drive.cable.diameter_mm
    centre, unit = (low + high) / 2.0, normal / length
    return vector(centre), vector(unit), half
