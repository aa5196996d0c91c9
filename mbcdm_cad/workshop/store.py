"""Parts, assembly files and the interference run: read from the cache, or made and stored in it; cadquery's objects.

The kernel is imported only when something has to be made.
"""

import hashlib
import json
import math
import os
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from mbcdm_cad.design.bought import Material
from mbcdm_cad.design.drive import Drive
from mbcdm_cad.errors import MbcdmError, did_you_mean
from mbcdm_cad.layouts.base import FrameCompliance, Layout, NoFigureError
from mbcdm_cad.layouts.registry import layout_of
from mbcdm_cad.parallel.forks import fork_map, forked
from mbcdm_cad.parts.bill import CABLE, Bill, Item, PartSpec
from mbcdm_cad.parts.part import cq
from mbcdm_cad.storage.cache import Cache, cache_folder, content_key
from mbcdm_cad.workshop.interference import interference_run, scenes
from mbcdm_cad.workshop.mass import PartFiles
from mbcdm_cad.workshop.pairs import Clash, Found, PartShape

Progress = Callable[[str], None]
# The progress message names at most this many parts; more are only counted.
_MOST_NAMED = 6


@dataclass(frozen=True)
class StoredPart:
    """One part's files; ``key`` identifies their content."""

    key: str
    files: PartFiles

    def solid(self) -> Any:
        """The kernel's shape."""
        from mbcdm_cad.workshop.kernel import shape_from_brep

        return shape_from_brep(self.files.brep)


class Store:
    """Makes what is not in the cache. ``progress`` gets the name of each item while it is made."""

    def __init__(self, cache: Cache, progress: Progress) -> None:
        self._cache = cache
        self._progress = progress
        self._solids: dict[str, Any] = {}
        self._held: dict[str, StoredPart] = {}
        self._assemblies: dict[str, dict[str, bytes]] = {}
        self.made: list[str] = []

    def parts(
        self,
        specs: Mapping[str, PartSpec],
        materials: Mapping[str, Material],
        mesh_tolerance_mm: float,
        jobs: int,
        meanwhile: Callable[[], None] | None = None,
    ) -> dict[str, StoredPart]:
        """All parts; only those that the cache lacks for these dimensions, material and code are drawn.

        ``meanwhile`` is called, if anything is drawn, while other processes draw; an error in drawing comes before one
        in it.
        """
        keys = self.keys(specs, materials, mesh_tolerance_mm)
        found = self.known(keys)
        missing = [name for name in specs if name not in found]
        if missing:
            from mbcdm_cad.workshop.meshing import drawn_part

            self._note(*missing)
            with forked(lambda n: drawn_part(specs[n], materials[n], mesh_tolerance_mm), missing, jobs) as results:
                try:
                    if meanwhile is not None:
                        meanwhile()
                finally:
                    drawn = results()
            found |= self.keep(keys, drawn)
        return {name: found[name] for name in specs}

    def keys(
        self, specs: Mapping[str, PartSpec], materials: Mapping[str, Material], mesh_tolerance_mm: float
    ) -> dict[str, str]:
        """The cache key of each part, from dimensions, material, tolerance and code."""
        return {
            name: content_key("part", (spec, materials[name], mesh_tolerance_mm), type(spec.part).__module__)
            for name, spec in specs.items()
        }

    def known(self, keys: Mapping[str, str]) -> dict[str, StoredPart]:
        """The parts by name that need not be drawn; the last ones read stay in memory."""
        found: dict[str, StoredPart] = {}
        for name, key in keys.items():
            if key in self._held:
                found[name] = self._held[key]
            elif (blobs := self._cache.get(key)) is not None:
                found[name] = StoredPart(key, PartFiles.from_blobs(name, blobs))
        self._held = {part.key: part for part in found.values()}
        return found

    def keep(self, keys: Mapping[str, str], drawn: Iterable[PartFiles]) -> dict[str, StoredPart]:
        """Store the parts that were drawn."""
        made = {files.name: StoredPart(keys[files.name], files) for files in drawn}
        for part in made.values():
            self._cache.put(part.key, part.files.to_blobs())
            self._held[part.key] = part
        return made

    def assembly(
        self, items: tuple[Item, ...], parts: dict[str, StoredPart], name: str, note: str = ""
    ) -> dict[str, bytes]:
        """STEP and GLB of the assembly, by these names; both carry ``note``."""
        key, make = self._assembly(items, parts, name, note)
        if key not in self._assemblies:
            self._note("assembly")
            self._hold(key, make())
        return self._assemblies[key]

    def _hold(self, key: str, files: dict[str, bytes]) -> None:
        self._assemblies[key] = files
        self._cache.put(key, files)

    def _assembly(
        self, items: tuple[Item, ...], parts: dict[str, StoredPart], name: str, note: str
    ) -> tuple[str, Callable[[], dict[str, bytes]]]:
        """The key of an assembly's files, which are read if the cache has them, and the function that makes them."""
        key = content_key("assembly", (name, note, items, {name: part.key for name, part in parts.items()}))
        if key not in self._assemblies and (blobs := self._cache.get(key)) is not None:
            self._assemblies[key] = blobs

        def make() -> dict[str, bytes]:
            from mbcdm_cad.workshop.export.files import glb_bytes
            from mbcdm_cad.workshop.export.step import assembly_step

            return {
                "step": assembly_step(name, items, self.solids(parts), note),
                "glb": glb_bytes(name, items, {n: p.files.mesh for n, p in parts.items()}, note),
            }

        return key, make

    def judged(
        self,
        layout: Layout,
        parts: dict[str, StoredPart],
        poses_deg: tuple[float, ...],
        jobs: int,
        assembly: tuple[Item, ...] = (),
    ) -> tuple[tuple[Clash, ...], FrameCompliance | None]:
        """Interference run over ``poses_deg`` and compliance of the frame, in parallel if both must be computed.

        With the items of the ``assembly`` its files are made beside them, for :meth:`assembly` without a note.
        """
        bodies = {name: _body(part) for name, part in parts.items() if not name.startswith(CABLE)}
        half = layout.drive.half_travel_deg
        seen = scenes(layout, (0.0, -half, half, *poses_deg))
        run = interference_run(seen, bodies, poses_deg, half, layout.drive.cable.diameter_mm)
        known = KnownTests(self._cache)
        missing = run.missing(known)
        study = layout.frame_study
        frame_key = content_key("frame", study.inputs, study.module) if study else ""
        frame = self._cache.get(frame_key) if study else None
        pending: dict[str, Callable[[], Any]] = {}  # the longest first
        if study and frame is None:
            pending[frame_key] = study.compliance
            self._note("stiffness of the frame")
        assembly_key = ""
        if assembly:
            assembly_key, make = self._assembly(assembly, parts, layout.drive.name, "")
            if assembly_key not in self._assemblies:
                pending[assembly_key] = make
                self._note("assembly")
        if missing:
            from mbcdm_cad.workshop.separation import prepare

            prepare()
            self._note(f"interference at {len(poses_deg)} poses")
            pending |= {key: run.tests[key].test for key in missing}
        found = dict(zip(pending, fork_map(lambda key: pending[key](), list(pending), jobs), strict=True))
        if frame_key in found:
            frame = {"compliance": json.dumps(asdict(found[frame_key])).encode()}
            self._cache.put(frame_key, frame)
        if assembly_key in found:
            self._hold(assembly_key, found[assembly_key])
        known.add({key: found[key] for key in missing}, run.tests)
        return run.clashes(known), FrameCompliance(**json.loads(frame["compliance"])) if frame else None

    def solids(self, parts: dict[str, StoredPart]) -> dict[str, Any]:
        """Kernel shapes of ``parts``, each read once."""
        for name, part in parts.items():
            if name not in self._solids:
                self._solids[name] = part.solid()
        return {name: self._solids[name] for name in parts}

    def _note(self, *names: str) -> None:
        self.made += names
        few = len(names) <= _MOST_NAMED
        self._progress(", ".join(names) if few else f"{len(names)} parts, {names[0]} to {names[-1]}")


def _body(part: StoredPart) -> PartShape:
    """A part for the interference run. Its key depends on the solid only, so a new material or mesh repeats no test."""
    shape = part.files.shape
    key = hashlib.sha256(part.files.brep).hexdigest()
    return PartShape(key, np.array([shape.low_mm, shape.high_mm]), part.solid, part.files.mesh)


# A design has about a thousand tests; beyond this number the answers that were not used for longest are removed.
MOST_ANSWERS = 30_000
_KEY_DIGITS = 32


class KnownTests(Mapping[str, Found]):
    """Answers by the key of the test.

    Almost all tests find no overlap: of these only the keys are stored. If two processes write at the same time, the
    answers of one are lost and are computed again later.
    """

    def __init__(self, cache: Cache) -> None:
        self._cache = cache
        self._key = content_key("interference answers", ())
        self._found = self._stored()

    def __getitem__(self, key: str) -> Found:
        return self._found[key]

    def __iter__(self) -> Iterator[str]:
        return iter(self._found)

    def __len__(self) -> int:
        return len(self._found)

    def add(self, answers: Mapping[str, Found], used: Iterable[str]) -> None:
        """Add new answers and store all; ``used`` are the keys of this run, which are removed last."""
        self._found |= answers
        if not answers:
            return
        # Answers that other processes stored since this run began are kept too, in the order of the last use.
        latest = {**self._stored(), **self._found}
        for key in used:
            latest[key] = latest.pop(key)
        kept = dict(list(latest.items())[-MOST_ANSWERS:])
        hits = {key: found for key, found in kept.items() if found}
        self._cache.put(self._key, {"keys": "".join(kept).encode(), "found": json.dumps(hits).encode()})

    def _stored(self) -> dict[str, Found]:
        blobs = self._cache.get(self._key)
        if blobs is None:
            return {}
        keys, found = blobs["keys"].decode(), json.loads(blobs["found"])
        every = (keys[start : start + _KEY_DIGITS] for start in range(0, len(keys), _KEY_DIGITS))
        return {key: found.get(key, []) for key in every}


def drawn(
    drive: Drive, angle_deg: float, cache: Cache, progress: Progress
) -> tuple[tuple[Item, ...], dict[str, StoredPart]]:
    """Items and parts with the drum at ``angle_deg``, without checks: for pictures."""
    refuse_angle(drive, angle_deg)
    posed = layout_of(drive).bill(angle_deg)
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


def part_names(drive: Drive) -> tuple[str, ...]:
    """Names of all parts, as their files have them. Raises ``MbcdmError`` where the dimensions have no solution."""
    return tuple(_bill(drive).parts)


def part_solid(drive: Drive, name: str) -> Any:
    """One part in its own frame, in mm. Raises ``MbcdmError`` for a name that no part has."""
    parts = _bill(drive).parts
    if name not in parts:
        raise MbcdmError(f"{name}: no such part; {did_you_mean(name, parts)}")
    return parts[name].part.solid()


def assembled(drive: Drive, angle_deg: float) -> Any:
    """All parts in their places with the drum at ``angle_deg``, a sub-assembly for each group that moves together.

    Parts come from the cache if it has them. Raises ``MbcdmError`` for an angle beyond the travel.
    """
    from mbcdm_cad.workshop.kernel import location

    items, parts = drawn(drive, angle_deg, Cache(cache_folder()), lambda name: None)
    shapes = {name: cq.Shape.cast(part.solid()) for name, part in parts.items()}
    # cadquery requires names that are unique in the whole tree, but the drum is a part in a group of the same name.
    groups = {item.group: cq.Assembly(name=f"{item.group}_group") for item in items}
    for item in items:
        place = cq.Location(location(item.location))
        groups[item.group].add(shapes[item.part], loc=place, name=item.name, color=cq.Color(*item.material.colour, 1.0))
    whole = cq.Assembly(name=f"{drive.name}_assembly")
    for group in groups.values():
        whole.add(group)
    return whole


def _bill(drive: Drive) -> Bill:
    try:
        return layout_of(drive).bill()
    except NoFigureError as error:
        raise MbcdmError(f"{drive.name}: {error}; 'mbcdm check' says more") from None
