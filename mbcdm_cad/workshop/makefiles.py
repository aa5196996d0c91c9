"""Draw a part from its entry in the bill, and compute everything that a build needs from its solid."""

from collections.abc import Callable
from dataclasses import replace

from mbcdm_cad.design.bought import Material
from mbcdm_cad.errors import GeometryError
from mbcdm_cad.parts.bill import PartSpec
from mbcdm_cad.parts.bodies import ROD_MESH_RADII, CableRod
from mbcdm_cad.workshop.export.step import part_step
from mbcdm_cad.workshop.kernel import Shape, brep_bytes, measure, validate_solid
from mbcdm_cad.workshop.mass import PartFiles
from mbcdm_cad.workshop.meshing import mesh_solid
from mbcdm_cad.workshop.trianglemesh import TriangleMesh, rod_mesh

# Called with a part's name and its STEP file as soon as the file exists, before its mesh is made.
OnStep = Callable[[str, bytes], None]


def _nothing(name: str, step: bytes) -> None:
    pass


def drawn_part(
    spec: PartSpec, material: Material, mesh_tolerance_mm: float | None, on_step: OnStep = _nothing
) -> PartFiles:
    """All files of one part; the mesh is empty if no tolerance is given.

    Raises ``GeometryError``, naming the part, if the result is not one valid solid.
    """
    try:
        solid = spec.part.solid()
    except Exception as error:  # the kernel raises its own types, with texts such as StdFail_NotDone
        raise GeometryError(f"{spec.name}: cannot be drawn with these dimensions") from error
    if mesh_tolerance_mm is None or not isinstance(rope := spec.part, CableRod):
        return make_part_files(spec.name, solid, material, mesh_tolerance_mm, on_step)
    files = make_part_files(spec.name, solid, material, None, on_step)
    tolerance_mm = max(mesh_tolerance_mm, ROD_MESH_RADII * rope.radius)
    return replace(files, mesh=rod_mesh(rope.pieces, rope.radius, tolerance_mm))


def make_part_files(
    name: str, solid: Shape, material: Material, mesh_tolerance_mm: float | None, on_step: OnStep = _nothing
) -> PartFiles:
    """Validate, translate, mesh (where a tolerance is given) and measure one solid.

    Raises ``GeometryError`` as :func:`validate_solid` and :func:`mesh_solid` do. The interference run finds faces that
    intersect each other.
    """
    validate_solid(name, solid)
    step = part_step(name, solid, material)
    on_step(name, step)
    mesh = TriangleMesh.empty() if mesh_tolerance_mm is None else mesh_solid(name, solid, mesh_tolerance_mm)
    return PartFiles(name=name, brep=brep_bytes(solid), step=step, mesh=mesh, shape=measure(solid))
