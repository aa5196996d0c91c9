"""Meshes of a body for simulators, which refuse fine ones: meshed again where the build's own have too many faces."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from mbcdm_cad.build.partfiles import PartFiles
from mbcdm_cad.build.trianglemesh import TriangleMesh
from mbcdm_cad.errors import MbcdmError

# A body with this many faces or more is refused by MuJoCo.
LARGEST_FACES = 200_000
# Each attempt is this much coarser than the last; on round surfaces it has about half the faces.
_COARSER = 4.0
# The coarsest attempt, mm: a mesh for looking at.
_COARSEST_MM = 2.0


def within_faces(
    body: str, shown: Sequence[str], parts: Mapping[str, PartFiles], tolerance_mm: float
) -> dict[str, TriangleMesh]:
    """A mesh of each part of a body, together below ``LARGEST_FACES``; ``shown``: the part of each of its items.

    The build's meshes where they are few enough; else the parts with the most faces are meshed again with 4, 16, ...
    times ``tolerance_mm``, the build's own. Raises ``MbcdmError`` if that does not help.
    """
    meshes = {name: parts[name].mesh for name in shown}
    while _faces(shown, meshes) >= LARGEST_FACES:
        tolerance_mm *= _COARSER
        if tolerance_mm > _COARSEST_MM:
            raise MbcdmError(
                f"the mesh of {body} has too many faces for simulators (value {_faces(shown, meshes)}, limit "
                f"{LARGEST_FACES - 1}, at {tolerance_mm / _COARSER:g} mm); its {len(shown)} items are too many"
            )
        fair = LARGEST_FACES / len(shown)  # a part below its share is left as it is
        for name in meshes:
            if len(meshes[name].triangles) > fair:
                meshes[name] = _coarser(name, parts[name], tolerance_mm)
    return meshes


def _faces(shown: Sequence[str], meshes: Mapping[str, TriangleMesh]) -> int:
    return sum(len(meshes[name].triangles) for name in shown)


def _coarser(name: str, part: PartFiles, tolerance_mm: float) -> TriangleMesh:
    from mbcdm_cad.build.kernel import shape_from_brep
    from mbcdm_cad.build.meshing import mesh_solid

    return mesh_solid(name, shape_from_brep(part.brep), tolerance_mm)
