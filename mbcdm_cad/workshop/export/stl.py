"""Binary STL of one part, in mm."""

from __future__ import annotations

import numpy as np

from mbcdm_cad.workshop.trianglemesh import TriangleMesh, single

_HEADER = 80
_RECORD = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])


def stl_bytes(name: str, mesh: TriangleMesh, note: str = "") -> bytes:
    """The mesh as a binary STL; the header says which part it is, in which unit, and ``note``."""
    corners = single(mesh.points_mm)[mesh.triangles]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]).astype(np.float64)
    lengths = np.linalg.norm(normals, axis=1, keepdims=True)
    records = np.zeros(len(corners), _RECORD)
    records["normal"] = np.divide(normals, lengths, out=np.zeros_like(normals), where=lengths > 0.0)
    records["corners"] = corners
    return _header(name, note) + np.uint32(len(records)).tobytes() + records.tobytes()


def with_note(data: bytes, name: str, note: str) -> bytes:
    """An STL from :func:`stl_bytes` with another note in its header."""
    return _header(name, note) + data[_HEADER:]


def _header(name: str, note: str) -> bytes:
    # Readers take a file that starts with "solid" for text, so the header starts with the program's name.
    text = f"mbcdm_cad {name} (mm)" + (f"; {note}" if note else "")
    return text.encode("ascii", "replace")[:_HEADER].ljust(_HEADER)
