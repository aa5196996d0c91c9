"""Parts of a design as files for a 3D printer, read from the cache or made and stored in it."""

from __future__ import annotations

import os

from mbcdm_cad.design.drive import Drive
from mbcdm_cad.errors import MbcdmError
from mbcdm_cad.storage.cache import Cache
from mbcdm_cad.storage.keys import content_key, source_hash
from mbcdm_cad.storage.manifest import versions
from mbcdm_cad.workshop.made_parts import drawn, exported_parts
from mbcdm_cad.workshop.store import Progress, Store, StoredPart


def prints_of(
    drive: Drive, cache: Cache, progress: Progress = lambda name: None, *, every_made_part: bool = False
) -> dict[str, bytes]:
    """The parts of printed materials by file name (``NAME.3mf``), or all made parts.

    Round holes of printed materials are wider by ``printing.hole_allowance_mm``, which the file then states. Raises
    ``GeometryError`` for a part that cannot be drawn, ``MbcdmError`` if no part is printed.
    """
    posed = drive.layout.bill()
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
    code = source_hash(__name__, "mbcdm_cad.workshop.export.threemf", "mbcdm_cad.workshop.wider_holes")
    found = {}
    for name, material in wanted.items():
        wider = drive.printing.hole_allowance_mm if material.printed else 0.0
        key = content_key("3mf", (name, files[name].key, wider, drive.export.mesh_tolerance_mm), code, versions())
        blobs = cache.get(key)
        if blobs is None:
            progress(f"3MF of {name}")
            blobs = {"3mf": _threemf(name, files[name], wider, drive.export.mesh_tolerance_mm)}
            cache.put(key, blobs)
        found[f"{name}.3mf"] = blobs["3mf"]
    return found


def _threemf(name: str, part: StoredPart, wider_mm: float, mesh_tolerance_mm: float) -> bytes:
    from mbcdm_cad.workshop.export.threemf import threemf_bytes

    if not wider_mm:
        return threemf_bytes(name, part.files.mesh)
    from mbcdm_cad.workshop.meshing import mesh_solid
    from mbcdm_cad.workshop.wider_holes import with_wider_holes

    solid = with_wider_holes(name, part.solid(), wider_mm)
    note = f"round holes {wider_mm:g} mm wider than drawn, on the diameter"
    return threemf_bytes(name, mesh_solid(name, solid, mesh_tolerance_mm), note)
