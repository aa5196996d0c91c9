"""From a drawn solid to all that a build needs of it."""

from __future__ import annotations

from mbcdm_cad.build.export.step import part_step
from mbcdm_cad.build.kernel import Shape, brep_bytes
from mbcdm_cad.build.measure import measure
from mbcdm_cad.build.meshing import mesh_solid
from mbcdm_cad.build.partfiles import PartFiles
from mbcdm_cad.build.validate import validate_solid
from mbcdm_cad.design.bought import Material


def make_part_files(
    name: str, solid: Shape, material: Material, mesh_tolerance_mm: float, self_intersection: bool = True
) -> PartFiles:
    """Validate, measure, mesh and translate one solid.

    Raises ``GeometryError`` as :func:`validate_solid` (see there for ``self_intersection``) and :func:`mesh_solid` do.
    """
    validate_solid(name, solid, self_intersection)
    return PartFiles(
        name=name,
        brep=brep_bytes(solid),
        step=part_step(name, solid, material),
        mesh=mesh_solid(name, solid, mesh_tolerance_mm),
        shape=measure(solid),
    )
