"""Draw a part from its entry in the bill and make all its files."""

from __future__ import annotations

from mbcdm_cad.build.errors import GeometryError
from mbcdm_cad.build.makefiles import make_part_files
from mbcdm_cad.build.partfiles import PartFiles
from mbcdm_cad.design.bought import Material
from mbcdm_cad.parts.bill import CABLE, PartSpec
from mbcdm_cad.parts.make import make


def drawn_part(spec: PartSpec, material: Material, mesh_tolerance_mm: float) -> PartFiles:
    """All files of one part. Raises ``GeometryError``, naming the part, if what is drawn is not one sound solid."""
    try:
        solid = make(spec.maker, spec.args)
    except Exception as error:  # the kernel raises its own types, with texts such as StdFail_NotDone
        raise GeometryError(f"{spec.name}: cannot be drawn with these dimensions") from error
    # A swept rod that cuts itself takes a second to find here, and the interference run finds it by distance.
    is_cable = spec.name.startswith(CABLE)
    return make_part_files(spec.name, solid, material, mesh_tolerance_mm, self_intersection=not is_cable)
