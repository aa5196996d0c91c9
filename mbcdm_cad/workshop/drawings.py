"""The workshop drawings of a design: a sheet for each made part, read from the cache or made and stored in it.

The kernel and the drawing libraries are imported inside: sheets from the cache need neither.
"""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import mbcdm_cad
from mbcdm_cad.design.bought import Material
from mbcdm_cad.design.drive import Drive
from mbcdm_cad.errors import MbcdmError, did_you_mean
from mbcdm_cad.layouts.registry import layout_of
from mbcdm_cad.parallel.forks import fork_map
from mbcdm_cad.parts.bill import Bill, Item
from mbcdm_cad.parts.bodies import CableRod
from mbcdm_cad.parts.making import accuracy, sheet_as_printed
from mbcdm_cad.parts.part import MadePart, Part, StandardPart, cq
from mbcdm_cad.storage.cache import Cache, content_key
from mbcdm_cad.workshop.mass import assembly_mass
from mbcdm_cad.workshop.store import Progress, StoredPart, drawn

if TYPE_CHECKING:
    from mbcdm_cad.drawings.draw import PartFacts

# The solid of a made part with the tolerances of its sheet.
WITH_TOLERANCES = "ap242.step"
# The name of the sheet of the whole drive.
ASSEMBLY = "assembly"


def drawings_folder(out: Path, name: str) -> Path:
    """Where the drawings of a design go, beside the folder of its build."""
    return out / f"{name}-drawings"


def _shown(part: Part, made: StoredPart) -> Any:
    """The kernel's shape of a part for its drawing: as made, or simplified if it says so."""
    if isinstance(part, MadePart) and (simple := part.in_views()) != part:
        return simple.solid().wrapped
    return made.solid()


def _facts(drive: Drive, material: str, mass_g: float, printed: bool = False) -> PartFacts:
    from mbcdm_cad.drawings.draw import PartFacts

    place = accuracy(drive.making, printed).position_mm
    return PartFacts(drive.name, material, mass_g, mbcdm_cad.__version__, place, printed)


@dataclass(frozen=True)
class _Job:
    """One sheet to make."""

    name: str
    part: MadePart
    material: Material
    made: StoredPart
    drive: Drive

    @property
    def key(self) -> str:
        """Names all that the sheet follows from."""
        data = (self.name, self.part, self.material, self.made.key, self.drive.name, self.drive.making)
        return content_key("drawing", data, type(self.part).__module__)

    def make(self) -> dict[str, bytes]:
        """The sheet's files by extension."""
        from mbcdm_cad.drawings.draw import draw_sheet
        from mbcdm_cad.workshop.export.step import part_step_ap242

        mass = self.material.density_g_cm3 * self.made.files.shape.volume_mm3 / 1e3
        facts = _facts(self.drive, self.material.name, mass, self.material.printed)
        sheet = self.part.sheet(self.name)
        if self.material.printed:
            sheet = sheet_as_printed(sheet, accuracy(self.drive.making, True))
        step = part_step_ap242(self.name, self.made.solid(), self.material, sheet)
        return draw_sheet(sheet, _shown(self.part, self.made), facts) | {WITH_TOLERANCES: step}


@dataclass(frozen=True)
class _Assembly:
    """The sheet of the whole drive without its cables, which are not made parts."""

    posed: Bill
    parts: dict[str, StoredPart]
    drive: Drive

    @property
    def items(self) -> tuple[Item, ...]:
        """Items that are drawn."""
        return tuple(item for item in self.posed.items if not isinstance(self.posed.parts[item.part].part, CableRod))

    @property
    def key(self) -> str:
        """Names all that the sheet follows from."""
        keys = {item.part: self.parts[item.part].key for item in self.posed.items}
        return content_key("assembly drawing", (self.posed.items, keys, self.drive.name, self.drive.making))

    def make(self) -> dict[str, bytes]:
        """The sheet's files by extension."""
        import numpy as np

        from mbcdm_cad.drawings.draw import draw_sheet
        from mbcdm_cad.workshop.assembly_sheet import SeenBody, assembly_sheet, numbers
        from mbcdm_cad.workshop.kernel import location

        shapes = {name: made.files.shape for name, made in self.parts.items()}
        solids = {
            name: cq.Shape.cast(_shown(self.posed.parts[name].part, self.parts[name])) for name in numbers(self.items)
        }

        def together(cut: bool) -> cq.Compound:
            chosen = [i for i in self.items if self.posed.parts[i.part].part.cut_in_sections == cut]
            return cq.Compound.makeCompound(
                [cq.Shape.cast(solids[i.part].wrapped.Moved(location(i.location))) for i in chosen]
            )

        number = numbers(self.items)
        bodies = [
            SeenBody(
                number[i.part],
                i.location.apply(self.parts[i.part].files.mesh.corners_mm.reshape(-1, 3)).reshape(-1, 3, 3),
                not self.posed.parts[i.part].part.cut_in_sections,
            )
            for i in self.items
        ]
        # The box of the report: that of the meshes.
        ends = np.array([(b.corners_mm.min(axis=(0, 1)), b.corners_mm.max(axis=(0, 1))) for b in bodies])
        low, high = ends[:, 0].min(axis=0), ends[:, 1].max(axis=0)
        envelope = ((low[0], low[1], low[2]), (high[0], high[1], high[2]))
        parts = {name: spec.part for name, spec in self.posed.parts.items()}
        designations = {name: part.designation for name, part in parts.items() if isinstance(part, StandardPart)}
        sheet = assembly_sheet(ASSEMBLY, self.items, bodies, envelope, designations)
        mass = assembly_mass(self.posed.items, shapes).mass_g
        facts = _facts(self.drive, "see list of parts", mass)
        return draw_sheet(sheet, together(cut=True), facts, together(cut=False))


def drawn_parts(drive: Drive) -> tuple[str, ...]:
    """Names of the made parts that have a sheet."""
    return tuple(layout_of(drive).bill().made)


def drawings_of(
    drive: Drive,
    cache: Cache,
    *,
    part: str | None = None,
    jobs: int | None = None,
    progress: Progress = lambda name: None,
) -> dict[str, bytes]:
    """Drawings of the assembly and all made parts, or of ``part``, by file name (``NAME.dxf``, ``.pdf``, ``.svg``).

    A made part has its solid with tolerances too (``NAME.ap242.step``).

    ``part`` may be ``assembly``. Raises ``MbcdmError`` for a part that the design does not make.
    """
    names = (ASSEMBLY, *drawn_parts(drive))
    if part is not None and part not in names:
        raise MbcdmError(
            f"--part: no such made part (value {part}, limit one of {', '.join(names)}); "
            f"{did_you_mean(part, names) or 'choose one of them'}"
        )
    _, parts = drawn(drive, 0.0, cache, progress)
    posed = layout_of(drive).bill()
    materials = {item.part: item.material for item in posed.items}
    wanted: dict[str, _Job | _Assembly] = {
        name: _Assembly(posed, parts, drive)
        if name == ASSEMBLY
        else _Job(name, posed.made[name], materials[name], parts[name], drive)
        for name in ((part,) if part else names)
    }
    sheets = {name: cache.get(job.key) for name, job in wanted.items()}
    missing = [name for name, found in sheets.items() if found is None]
    if missing:
        progress(", ".join(f"drawing of {name}" for name in missing))
        made = fork_map(lambda name: wanted[name].make(), missing, jobs or os.cpu_count() or 1)
        for name, files in zip(missing, made, strict=True):
            cache.put(wanted[name].key, files)
            sheets[name] = files
    return {f"{name}.{kind}": found[kind] for name, found in sheets.items() if found is not None for kind in found}
