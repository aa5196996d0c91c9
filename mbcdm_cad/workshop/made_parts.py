"""The parts of a design, drawn or from the cache: what all outputs with solids or meshes begin with."""

from __future__ import annotations

import math
import os
from collections.abc import Callable

from mbcdm_cad.design.drive import Drive
from mbcdm_cad.errors import MbcdmError
from mbcdm_cad.parts.bill import Bill, Item, PartSpec
from mbcdm_cad.storage.cache import Cache
from mbcdm_cad.workshop.store import Progress, Store, StoredPart


def drawn(
    drive: Drive, angle_deg: float, cache: Cache, progress: Progress
) -> tuple[tuple[Item, ...], dict[str, StoredPart]]:
    """Items and parts with the drum at ``angle_deg``, without checks: for pictures."""
    refuse_angle(drive, angle_deg)
    posed = drive.layout.bill(angle_deg)
    return posed.items, made_parts(Store(cache, progress), posed, drive.export.mesh_tolerance_mm, os.cpu_count() or 1)


def made_parts(
    store: Store, posed: Bill, mesh_tolerance_mm: float, jobs: int, meanwhile: Callable[[], None] | None = None
) -> dict[str, StoredPart]:
    """All parts of a bill; ``meanwhile`` as in :meth:`Store.parts`."""
    materials = {item.part: item.material for item in posed.items}
    return store.parts(posed.parts, materials, mesh_tolerance_mm, jobs, meanwhile)


def exported_parts(
    store: Store, posed: Bill, parts: dict[str, StoredPart], drive: Drive, jobs: int
) -> dict[str, StoredPart]:
    """The parts as in their single files: tapped holes according to ``export.threads``."""
    if drive.export.threads == "major":
        return parts
    materials = {item.part: item.material for item in posed.items}
    drilled = {name: PartSpec(name, spec.drilled) for name, spec in posed.parts.items() if spec.drilled is not None}
    return parts | store.parts(drilled, materials, drive.export.mesh_tolerance_mm, jobs)


def refuse_angle(drive: Drive, angle_deg: float) -> None:
    """Raise ``MbcdmError`` for an angle of the drum beyond the travel."""
    if not (math.isfinite(angle_deg) and abs(angle_deg) <= drive.half_travel_deg):
        raise MbcdmError(
            f"--angle: beyond the travel (value {angle_deg:g} deg, limit +-{drive.half_travel_deg:g} deg); "
            "choose an angle within it or widen travel.half_angle_deg"
        )
