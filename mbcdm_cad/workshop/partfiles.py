"""The cached files and figures of one part; they are read without the kernel."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

from mbcdm_cad.workshop.export.stl import stl_bytes
from mbcdm_cad.workshop.mass import ShapeProperties
from mbcdm_cad.workshop.trianglemesh import TriangleMesh


@dataclass(frozen=True)
class PartFiles:
    """A drawn part: its solid in the kernel's form, STEP file, mesh and measured figures."""

    name: str
    brep: bytes
    step: bytes
    mesh: TriangleMesh
    shape: ShapeProperties

    @property
    def stl(self) -> bytes:
        """The part's STL file."""
        return stl_bytes(self.name, self.mesh)

    @cached_property
    def mesh_volume_error(self) -> float:
        """Volume of the mesh over that of the solid, minus one."""
        return self.mesh.volume_mm3 / self.shape.volume_mm3 - 1.0

    def to_blobs(self) -> dict[str, bytes]:
        """The part as data for the cache, by name."""
        properties = self.shape.to_json().encode()
        return {"brep": self.brep, "step": self.step, "mesh": self.mesh.to_bytes(), "properties": properties}

    @classmethod
    def from_blobs(cls, name: str, blobs: Mapping[str, bytes]) -> PartFiles:
        """The part from :meth:`to_blobs`."""
        mesh = TriangleMesh.from_bytes(blobs["mesh"])
        return cls(name, blobs["brep"], blobs["step"], mesh, ShapeProperties.from_json(blobs["properties"]))
