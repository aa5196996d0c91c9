"""A preview of a design before interference and frame are computed, and the process of ``mbcdm watch`` that draws it.

The process keeps the kernel loaded and drops a job when a newer one waits.
"""

import json
import os
import signal
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass
from multiprocessing.connection import Connection
from pathlib import Path

from mbcdm_cad.checks.comparison import CheckResult
from mbcdm_cad.checks.size import envelope_check, mass_check
from mbcdm_cad.design.bought import Material
from mbcdm_cad.design.loader import LoadedDesign
from mbcdm_cad.errors import MbcdmError
from mbcdm_cad.layouts.loader import load_text
from mbcdm_cad.layouts.registry import layout_of
from mbcdm_cad.parallel.forks import allow_processes, forked
from mbcdm_cad.parts.bill import CABLE, PartSpec
from mbcdm_cad.parts.bodies import CableRod
from mbcdm_cad.report.data import Tested, checks_data, design_figures, report_data
from mbcdm_cad.report.explain import fields_data
from mbcdm_cad.report.page import PAGE
from mbcdm_cad.report.page.stage import PageFigures, page_figures, page_of
from mbcdm_cad.storage.cache import Cache, cache_folder
from mbcdm_cad.storage.folders import write_whole
from mbcdm_cad.workshop.mass import PartFiles, rod_shape
from mbcdm_cad.workshop.meshing import drawn_part
from mbcdm_cad.workshop.store import Store, StoredPart
from mbcdm_cad.workshop.trianglemesh import TriangleMesh


class Previewer:
    """Draws one design after the other into ``folder``; a part is written only if it differs from the last one written.

    All solids stay in memory from one design to the next, so only changed parts are drawn. The STEP file is written
    before the mesh is made, and the figures are computed while other processes draw all parts but the pulleys. Cables
    are drawn after the page, without a mesh: the page sweeps them along their centre lines, from which their mass
    follows, too. ``look`` is called regularly and may raise an exception to stop the work.
    """

    def __init__(self, folder: Path, cache: Cache, look: Callable[[], None]) -> None:
        self._folder = folder
        self._cache = cache
        self._look = look
        self._store = Store(cache, lambda name: None)
        self._written: dict[str, str] = {}
        self._lengths: dict[str, int] = {}
        # The hash of the newest design, its parts, and the content of its page that needs none.
        self._drawn: tuple[str, dict[str, StoredPart], PageFigures] | None = None
        # Cables that are not drawn yet, with their keys.
        self._cables: list[tuple[PartSpec, Material, str]] = []

    def preview(self, loaded: LoadedDesign, checks: Sequence[CheckResult]) -> tuple[bytes, tuple[str, ...]]:
        """STEP and STL of each changed part in the folder, and the page with the ``checks`` of the design.

        Gives the page, and the names of the parts whose files were written for it. Raises ``MbcdmError`` for a part
        that cannot be drawn.
        """
        drive = loaded.drive
        layout = layout_of(drive)
        bill = layout.bill()
        materials = {item.part: item.material for item in bill.items}
        keys = self._store.keys(bill.parts, materials, drive.export.mesh_tolerance_mm)
        changed = tuple(name for name, key in keys.items() if self._written.get(name) != key)
        parts = self._store.known(keys)
        self._write({name: parts[name] for name in changed if name in parts})
        shafts = {body.name for body in layout.moving_bodies if body.kind != "drum"}
        pulleys = {item.part for item in bill.items if item.kind == "made" and item.group in shafts}
        missing = self._in_order([name for name in keys if name not in parts], pulleys)
        for name in missing:
            self._written.pop(name, None)  # its file changes even if this job is stopped
        self._cables = [(bill.parts[n], materials[n], keys[n]) for n in missing if n.startswith(CABLE)]
        for spec, _, _ in self._cables:
            for ending in (".step", ".stl"):
                self._stem(spec.name).with_suffix(ending).unlink(missing_ok=True)
        missing = [name for name in missing if not name.startswith(CABLE)]

        def draw(name: str) -> PartFiles:
            return drawn_part(bill.parts[name], materials[name], drive.export.mesh_tolerance_mm, self.write_step)

        with forked(draw, missing, os.cpu_count() or 1) as results:
            # Computing the figures at the same time would slow the pulleys down by a third.
            results(self._look, sum(name in pulleys for name in missing))
            figures, fields = design_figures(layout, bill), fields_data(loaded)
            self._look()
            shown = page_figures(drive, fields["fields"], self._cache)
            drawn = results(self._look)
        made = self._store.keep(keys, drawn)
        self._write(made)
        parts |= made
        for spec, _, key in self._cables:
            # Without files, with the figures that its centre line gives.
            assert isinstance(spec.part, CableRod), f"{spec.name} is no cable"
            shape = rod_shape(spec.part.pieces, spec.part.radius)
            parts[spec.name] = StoredPart(key, PartFiles(spec.name, b"", b"", TriangleMesh.empty(), shape))
        data = report_data(
            layout, bill, parts, Tested(), drum_angle_deg=0.0, design_sha256=loaded.sha256, figures=figures
        )
        mass, size = data["mass"], data["envelope"]["size_mm"]
        whole = (*checks, mass_check(drive, mass["mass_g"], mass["sigma_g"]), envelope_check(drive, size))
        self._drawn = loaded.sha256, parts, shown
        written = tuple(name for name in changed if name in self._written)
        return page_of(drive, data | checks_data(whole) | fields, parts, shown), written

    def draw_cables(self) -> None:
        """Write the STEP files of the cables that changed with the last preview, whose page does not wait for them.

        Raises ``MbcdmError`` for a cable that cannot be drawn.
        """

        with forked(lambda one: drawn_part(one[0], one[1], None), self._cables, os.cpu_count() or 1) as results:
            drawn = zip(self._cables, results(self._look), strict=True)
        self._write({spec.name: StoredPart(key, files) for (spec, _, key), files in drawn})
        self._cables = []

    def complete(self, loaded: LoadedDesign, built: Path, checks: Sequence[CheckResult]) -> bytes:
        """The page of a whole build in the folder ``built``, written there."""
        if self._drawn is None or self._drawn[0] != loaded.sha256:
            self.preview(loaded, checks)
        assert self._drawn is not None
        data = json.loads((built / "report.json").read_text("utf-8"))
        page = page_of(loaded.drive, data, *self._drawn[1:])
        write_whole({built / PAGE: page}, durable=False)
        return page

    def _in_order(self, names: Sequence[str], pulleys: Collection[str]) -> list[str]:
        """Names in the order of drawing: pulleys first, whose files are needed first; in each group the slowest first.

        The length of its last STEP file shows how long a part takes.
        """
        return sorted(names, key=lambda name: (name not in pulleys, -self._lengths.get(name, 0)))

    def write_step(self, name: str, step: bytes) -> None:
        """Write the STEP file of a part, whole."""
        write_whole({self._stem(name).with_suffix(".step"): step}, durable=False)

    def _stem(self, name: str) -> Path:
        return self._folder / "parts" / name

    def _write(self, parts: Mapping[str, StoredPart]) -> None:
        """Write STEP and STL of the parts; for a part without a mesh an old STL is removed."""
        for name, part in parts.items():
            stem = self._stem(name)
            files = {stem.with_suffix(".step"): part.files.step}
            if part.files.mesh.is_empty:
                stem.with_suffix(".stl").unlink(missing_ok=True)
            else:
                files[stem.with_suffix(".stl")] = part.files.stl
            write_whole(files, durable=False)
            self._written[name] = part.key
            self._lengths[name] = len(part.files.step)


# The browser loads the new page meanwhile, for which it needs a core.
_CABLES_AFTER_S = 1.2


@dataclass(frozen=True)
class Job:
    """Draw the design of ``text``, which has passed its ``checks``; ``number`` counts the saves.

    With ``built``, the folder of its whole build, the page is made from that build's report instead.
    """

    number: int
    path: Path
    text: str
    checks: tuple[CheckResult, ...]
    built: Path | None = None


@dataclass(frozen=True)
class Drawn:
    """The result of a job: a page, or ``problem`` in words."""

    number: int
    page: bytes = b""
    written: tuple[str, ...] = ()
    problem: str = ""
    whole: bool = False


class _SupersededError(Exception):
    """Raised to stop a job when a newer one waits."""


def work(connection: Connection, folder: Path, use_cache: bool) -> None:
    """Draw the jobs that arrive through ``connection`` until None arrives or the other end is closed."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is for the process that watches; it closes the connection
    allow_processes()

    def look() -> None:
        if connection.poll():
            raise _SupersededError

    previewer = Previewer(folder, Cache(cache_folder() if use_cache else None), look)
    try:
        while (job := _newest(connection)) is not None:
            try:
                loaded = load_text(job.text, job.path)
                if job.built is not None:
                    page = previewer.complete(loaded, job.built, job.checks)
                    connection.send(Drawn(job.number, page, whole=True))
                else:
                    connection.send(Drawn(job.number, *previewer.preview(loaded, job.checks)))
                    if not connection.poll(_CABLES_AFTER_S):
                        previewer.draw_cables()
            except _SupersededError:
                continue
            except (MbcdmError, OSError) as error:
                connection.send(Drawn(job.number, problem=str(error)))
    except (EOFError, BrokenPipeError):
        return


def _newest(connection: Connection) -> Job | None:
    job: Job | None = connection.recv()
    while job is not None and connection.poll():
        job = connection.recv()
    return job
