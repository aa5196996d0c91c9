"""A part as 3MF for printing: millimetres, the part's name, lying on its largest flat face. Same mesh, same bytes.

Written by hand: the format's core is one XML file in a ZIP, and no library keeps time stamps out of both.
"""

from __future__ import annotations

import html
import io
import zipfile
from itertools import product

import numpy as np
from numpy.typing import NDArray

from mbcdm_cad.workshop.trianglemesh import FloatArray, TriangleMesh

_MODEL = "3D/3dmodel.model"
_CORE = "http://schemas.microsoft.com/3dmanufacturing/core/2015/02"
_CONTENT_TYPES = """<?xml version="1.0" encoding="UTF-8"?>
<Types xmlns="http://schemas.openxmlformats.org/package/2006/content-types">
 <Default Extension="rels" ContentType="application/vnd.openxmlformats-package.relationships+xml"/>
 <Default Extension="model" ContentType="application/vnd.ms-package.3dmanufacturing-3dmodel+xml"/>
</Types>
"""
_RELATIONS = f"""<?xml version="1.0" encoding="UTF-8"?>
<Relationships xmlns="http://schemas.openxmlformats.org/package/2006/relationships">
 <Relationship Target="/{_MODEL}" Id="rel0" Type="http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel"/>
</Relationships>
"""
# Decimals of a coordinate in mm: far below any mesh tolerance, and points that agree in single precision agree here.
_DECIMALS = 5
# A face counts as lying on the bed within this distance (mm) and with its normal this near to straight down.
_ON_BED_MM, _STRAIGHT = 0.01, 0.999
_EARLIEST = (1980, 1, 1, 0, 0, 0)
_READ_WRITE = 0o644 << 16


def lying(mesh: TriangleMesh) -> FloatArray:
    """Rotation (3, 3) that lays the part on the bed, one of the six along its axes.

    The one with the largest flat area below; of equal ones the lowest, then the first in a fixed order.
    """
    corners = mesh.corners_mm
    across = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    area = np.linalg.norm(across, axis=1) / 2.0
    normal = across / np.maximum(2.0 * area, 1e-30)[:, None]
    best: tuple[float, float, int] | None = None
    chosen = np.eye(3)
    for order, (axis, sign) in enumerate(product((2, 1, 0), (1.0, -1.0))):
        up = np.zeros(3)
        up[axis] = sign
        height = corners @ up
        low = height.min()
        flat = (normal @ up < -_STRAIGHT) & (height.max(axis=1) < low + _ON_BED_MM)
        rank = (-round(float(area[flat].sum()), 3), round(float(height.max() - low), 3), order)
        if best is None or rank < best:
            best = rank
            right = np.zeros(3)
            right[(axis + 1) % 3] = 1.0
            chosen = np.stack([right, np.cross(up, right), up])
    return chosen


def threemf_bytes(name: str, mesh: TriangleMesh, note: str = "") -> bytes:
    """The 3MF file of one part: on the bed at z = 0, its middle above the origin. ``note`` is its description."""
    points = mesh.points_mm @ lying(mesh).T
    low, high = points.min(axis=0), points.max(axis=0)
    points = points - np.array([(low[0] + high[0]) / 2, (low[1] + high[1]) / 2, low[2]])
    rounded = np.round(points.astype(np.float32).astype(np.float64), _DECIMALS) + 0.0
    vertices, index = np.unique(rounded, axis=0, return_inverse=True)
    triangles = _sound(index.reshape(-1)[mesh.triangles])
    text = io.StringIO()
    text.write('<?xml version="1.0" encoding="UTF-8"?>\n')
    text.write(f'<model unit="millimeter" xml:lang="en" xmlns="{_CORE}">\n')
    text.write(
        f' <metadata name="Title">{html.escape(name)}</metadata>\n <metadata name="Application">mbcdm_cad</metadata>\n'
    )
    if note:
        text.write(f' <metadata name="Description">{html.escape(note)}</metadata>\n')
    text.write(f' <resources>\n  <object id="1" type="model" name="{html.escape(name)}">\n   <mesh>\n    <vertices>\n')
    text.writelines(f'     <vertex x="{_number(x)}" y="{_number(y)}" z="{_number(z)}"/>\n' for x, y, z in vertices)
    text.write("    </vertices>\n    <triangles>\n")
    text.writelines(f'     <triangle v1="{a}" v2="{b}" v3="{c}"/>\n' for a, b, c in triangles)
    text.write("    </triangles>\n   </mesh>\n  </object>\n </resources>\n")
    text.write(' <build>\n  <item objectid="1"/>\n </build>\n</model>\n')
    return _zipped({"[Content_Types].xml": _CONTENT_TYPES, "_rels/.rels": _RELATIONS, _MODEL: text.getvalue()})


def _sound(triangles: NDArray[np.int64]) -> NDArray[np.int64]:
    """Without triangles that have two corners in one point."""
    a, b, c = triangles.T
    kept: NDArray[np.int64] = triangles[(a != b) & (b != c) & (c != a)]
    return kept


def _number(value: float) -> str:
    return f"{value:.{_DECIMALS}f}".rstrip("0").rstrip(".")


def _zipped(files: dict[str, str]) -> bytes:
    out = io.BytesIO()
    with zipfile.ZipFile(out, "w", zipfile.ZIP_DEFLATED, compresslevel=9) as archive:
        for name, text in files.items():
            entry = zipfile.ZipInfo(name, _EARLIEST)
            entry.compress_type = zipfile.ZIP_DEFLATED
            entry.create_system = 3
            entry.external_attr = _READ_WRITE
            archive.writestr(entry, text)
    return out.getvalue()
