"""The workshop drawings of a design: a sheet for each made part, fetched from the cache or made and put there."""

from __future__ import annotations

import os
from collections.abc import Callable
from dataclasses import dataclass
from importlib import metadata

import mbcdm_cad
from mbcdm_cad.build.run import drawn
from mbcdm_cad.build.store import MadePart, Progress
from mbcdm_cad.configurations.registry import configuration
from mbcdm_cad.design.bought import Material
from mbcdm_cad.design.drive import Drive
from mbcdm_cad.errors import MbcdmError, did_you_mean
from mbcdm_cad.parts.bill import Bill, PartSpec
from mbcdm_cad.parts.sheets.lookup import has_sheet, sheet_module, sheet_of
from mbcdm_cad.storage.cache import Cache
from mbcdm_cad.storage.keys import content_key, source_hash
from mbcdm_cad.storage.manifest import versions
from mbcdm_cad.storage.parallel import fork_map

FORMATS = ("dxf", "pdf", "svg")
# Libraries whose version decides what a drawing's bytes are.
_LIBRARIES = ("ezdxf", "matplotlib")


@dataclass(frozen=True)
class _Job:
    """One sheet to make."""

    spec: PartSpec
    material: Material
    made: MadePart
    design: str

    @property
    def key(self) -> str:
        """Names all that the sheet follows from."""
        source = source_hash(sheet_module(self.spec.maker), "mbcdm_cad.drawings.draw")
        with_libraries = versions() | {name: metadata.version(name) for name in _LIBRARIES}
        return content_key("drawing", (self.spec, self.material, self.made.key, self.design), source, with_libraries)

    def make(self) -> dict[str, bytes]:
        """The sheet's files by extension."""
        from mbcdm_cad.drawings.draw import PartFacts, draw_sheet

        mass = self.material.density_g_cm3 * self.made.files.shape.volume_mm3 / 1e3
        facts = PartFacts(self.design, self.material.name, mass, mbcdm_cad.__version__)
        return draw_sheet(sheet_of(self.spec.name, self.spec.maker, self.spec.args), self.made.solid(), facts)


def _centred(drive: Drive) -> Bill:
    kind = configuration(drive.configuration)
    return kind.bill(kind.layout(drive))


def drawn_parts(drive: Drive) -> tuple[str, ...]:
    """Names of the made parts that have a sheet."""
    whole = _centred(drive)
    made = dict.fromkeys(item.part for item in whole.items if item.kind == "made")
    return tuple(name for name in made if has_sheet(whole.parts[name].maker))


def drawings_of(
    drive: Drive,
    cache: Cache,
    *,
    part: str | None = None,
    jobs: int | None = None,
    progress: Progress = lambda name: None,
) -> dict[str, bytes]:
    """Drawings of all made parts, or of ``part``, by file name (``NAME.dxf``, ``NAME.pdf``, ``NAME.svg``).

    Raises ``MbcdmError`` for a part that the design does not make.
    """
    names = drawn_parts(drive)
    if part is not None and part not in names:
        raise MbcdmError(
            f"--part: no such made part (value {part}, limit one of {', '.join(names)}); "
            f"{did_you_mean(part, names) or 'choose one of them'}"
        )
    _, parts = drawn(drive, 0.0, cache, progress)
    posed = _centred(drive)
    materials = {item.part: item.material for item in posed.items}
    wanted = [
        _Job(posed.parts[name], materials[name], parts[name], drive.name) for name in ((part,) if part else names)
    ]
    sheets = {job.spec.name: cache.get(job.key) for job in wanted}
    missing = [job for job in wanted if sheets[job.spec.name] is None]
    if missing:
        progress(", ".join(f"drawing of {job.spec.name}" for job in missing))
        make: Callable[[_Job], dict[str, bytes]] = _Job.make
        for job, files in zip(missing, fork_map(make, missing, jobs or os.cpu_count() or 1), strict=True):
            cache.put(job.key, files)
            sheets[job.spec.name] = files
    return {f"{name}.{kind}": found[kind] for name, found in sheets.items() if found is not None for kind in FORMATS}
