"""The interference run on solids that the tests draw and move."""

import hashlib
from collections.abc import Mapping, MutableMapping, Sequence
from typing import Any

import numpy as np

from mbcdm_cad.layouts.base import Layout
from mbcdm_cad.workshop.interference import InterferenceRun, answers, interference_run, scenes
from mbcdm_cad.workshop.kernel import bounding_box, brep_bytes
from mbcdm_cad.workshop.meshing import mesh_solid
from mbcdm_cad.workshop.pairs import Clash, Found, PartShape
from mbcdm_cad.workshop.trianglemesh import TriangleMesh

# As builds mesh a part; one test compares a run with meshes to one without.
MESH_TOLERANCE_MM = 0.01
# By content of the solid and tolerance: the tests move a few solids and keep the others.
_MESHES: dict[tuple[str, float], TriangleMesh] = {}


def body(name: str, solid: Any, mesh_tolerance_mm: float | None = None) -> PartShape:
    """A solid for the run; without a mesh tolerance every pair whose boxes meet is left to a boolean."""
    mesh = None if mesh_tolerance_mm is None else mesh_of(name, solid, mesh_tolerance_mm)
    return PartShape(_key(solid), np.array(bounding_box(solid)), lambda: solid, mesh)


def mesh_of(name: str, solid: Any, tolerance_mm: float = MESH_TOLERANCE_MM) -> TriangleMesh:
    """The mesh of a solid, made once."""
    key = (_key(solid), tolerance_mm)
    if key not in _MESHES:
        _MESHES[key] = mesh_solid(name, solid, tolerance_mm)
    return _MESHES[key]


def _key(solid: Any) -> str:
    return hashlib.sha256(brep_bytes(solid)).hexdigest()


def run_of(dims: Layout, bodies: Mapping[str, PartShape], poses_deg: Sequence[float]) -> InterferenceRun:
    """The run of a design with these bodies in place of its parts."""
    half = dims.drive.half_travel_deg
    seen = scenes(dims, (0.0, -half, half, *poses_deg))
    return interference_run(seen, bodies, poses_deg, half, dims.drive.cable.diameter_mm)


def interferences(
    dims: Layout,
    solids: Mapping[str, Any],
    poses_deg: Sequence[float],
    jobs: int = 1,
    known: MutableMapping[str, Found] | None = None,
) -> tuple[Clash, ...]:
    """All overlaps at the given drum angles. ``solids``: part name to solid in the part's own frame.

    Pairs whose answer is in ``known`` are not tested again, and answers are added to it; without it every pair is
    tested.
    """
    bodies = {name: body(name, solid, MESH_TOLERANCE_MM) for name, solid in solids.items()}
    run = run_of(dims, bodies, poses_deg)
    found = answers(run, known or {}, jobs)
    if known is not None:
        known.update(found)
    return run.clashes(found)
