"""Files of parts that need no kernel: STEP text in canonical form, STL in mm, 3MF for printing, GLB of an assembly.

Five things differ in the kernel's text although the model is the same: the time in the header, the ids of the
NEXT_ASSEMBLY_USAGE_OCCURRENCEs (they count up within a process), the number of an entity, the order of the colour
blocks (it follows memory addresses) and the sign of zero (it is lost when a solid is stored and read). Here the header
is written anew, entities are numbered depth first from the roots in a fixed order, occurrences are counted from 1,
no zero has a sign, and each entity stands on one line.

Written by hand: the format's core is one XML file in a ZIP, and no library keeps time stamps out of both.
"""

import html
import io
import json
import re
import struct
import zipfile
from collections.abc import Iterator, Mapping, Sequence
from itertools import product
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mbcdm_cad.design.bought import Material
from mbcdm_cad.parts.bill import Item, Placement, sorted_items
from mbcdm_cad.workshop.trianglemesh import FloatArray, TriangleMesh, faces, single

# Blocks that nothing refers to, in random order in the kernel's text: sorted by their content.
_UNORDERED = ("MECHANICAL_DESIGN_GEOMETRIC_PRESENTATION_REPRESENTATION", "PROPERTY_DEFINITION_REPRESENTATION")
_OCCURRENCE = re.compile(r"NEXT_ASSEMBLY_USAGE_OCCURRENCE\('[^']*'")
_ENTITY = re.compile(r"#(\d+)\s*=\s*((?:[^';]+|'[^']*')*);")
_TOKEN = re.compile(r"'[^']*'|#(\d+)")
_LAYOUT = re.compile(r"('[^']*')|\s+|-0\.(?=[\s,)])")
_UNIT_ELEMENT = re.compile(r"DERIVED_UNIT_ELEMENT\(#(\d+),[-0-9.]+\)")
_FIXED_TIME = "1970-01-01T00:00:00"


def canonical_step(text: str, name: str, description: str) -> str:
    """The kernel's STEP ``text`` in canonical form, with ``name`` and ``description`` in its header.

    Raises ``ValueError`` if the text has no data section.
    """
    try:
        data = text[text.index("\nDATA;") + len("\nDATA;") : text.rindex("ENDSEC;")]
        schema = text[text.index("FILE_SCHEMA") : text.index("ENDSEC;")]
    except ValueError:
        raise ValueError(f"no STEP data section in {len(text)} characters that start with {text[:40]!r}") from None
    entities = {int(number): _without_layout(body) for number, body in _ENTITY.findall(data)}
    _correct_density_units(entities)
    lines = (f"#{new}={body};" for new, body in _renumbered(entities))
    return "\n".join(
        (
            "ISO-10303-21;",
            *_header(name, description, _without_layout(schema)),
            "DATA;",
            *lines,
            "ENDSEC;",
            "END-ISO-10303-21;",
            "",
        )
    )


def with_description(text: str, description: str) -> str:
    """A canonical STEP text with another description in its header; everything else stays."""
    first = text.index("FILE_DESCRIPTION")
    return text[:first] + _description(description) + text[text.index("\n", first) :]


def _header(name: str, description: str, schema: str) -> list[str]:
    stamp = f"FILE_NAME({_string(name)},'{_FIXED_TIME}',(''),(''),'Open CASCADE','mbcdm_cad','');"
    return ["HEADER;", _description(description), stamp, schema, "ENDSEC;"]


def _description(description: str) -> str:
    return f"FILE_DESCRIPTION(({_string(description)}),'2;1');"


def _string(text: str) -> str:
    r"""A STEP string: quotes and backslashes doubled, other characters than printable ASCII as ``\X4\`` code points."""
    plain = "".join(c if " " <= c <= "~" else f"\\X4\\{ord(c):08X}\\X0\\" for c in text.replace("\\", "\\\\"))
    return "'" + plain.replace("'", "''") + "'"


def _without_layout(body: str) -> str:
    """The body on one line: no white space and no minus zero outside strings, no line break inside them."""
    if body.count("'") == 2 * body.count("''") and "-0." not in body:
        return "".join(body.split())  # most bodies contain no text; this case is three times as fast
    return _LAYOUT.sub(lambda match: match[1].replace("\n", "") if match[1] else match[0].strip().lstrip("-"), body)


def _correct_density_units(entities: dict[int, str]) -> None:
    """Correct the unit of densities: the kernel writes g^3 cm^2 in place of g cm^-3, and reads both as the same."""
    for number, body in entities.items():
        match = _UNIT_ELEMENT.fullmatch(body)
        if match:
            exponent = "1." if "MASS_UNIT" in entities[int(match[1])] else "-3."
            entities[number] = f"DERIVED_UNIT_ELEMENT(#{match[1]},{exponent})"


def _renumbered(entities: dict[int, str]) -> Iterator[tuple[int, str]]:
    """(new number, body) of every entity, depth first: the product structure as it comes, then the sorted blocks."""
    references = {
        number: [int(other) for other in _TOKEN.findall(body) if other] if "#" in body else []
        for number, body in entities.items()
    }
    referred = {target for targets in references.values() for target in targets}
    roots = [number for number in entities if number not in referred]
    new: dict[int, int] = {}

    def visit(root: int) -> None:
        stack = [root]
        while stack:
            number = stack.pop()
            if number not in new:
                new[number] = len(new) + 1
                stack.extend(reversed(references[number]))

    def meaning(number: int) -> str:
        """Content of an unordered block: its text with the numbers given so far, and other entities written out."""
        return _TOKEN.sub(
            lambda m: m[0] if not m[1] else f"#{new[int(m[1])]}" if int(m[1]) in new else meaning(int(m[1])),
            entities[number],
        )

    for root in roots:
        if not entities[root].startswith(_UNORDERED):
            visit(root)
    # The keys are computed before any of these blocks is numbered, so blocks with equal keys are interchangeable.
    for root in sorted((root for root in roots if entities[root].startswith(_UNORDERED)), key=meaning):
        visit(root)

    occurrences = 0
    for number, position in new.items():
        body = entities[number]
        if references[number]:
            body = _TOKEN.sub(lambda m: f"#{new[int(m[1])]}" if m[1] else m[0], body)
        if body.startswith("NEXT_ASSEMBLY_USAGE_OCCURRENCE"):
            occurrences += 1
            body = _OCCURRENCE.sub(f"NEXT_ASSEMBLY_USAGE_OCCURRENCE('{occurrences}'", body, count=1)
        yield position, body


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
    return _stl_header(name, note) + np.uint32(len(records)).tobytes() + records.tobytes()


def with_note(data: bytes, name: str, note: str) -> bytes:
    """An STL from :func:`stl_bytes` with another note in its header."""
    return _stl_header(name, note) + data[_HEADER:]


def _stl_header(name: str, note: str) -> bytes:
    # Readers take a file that starts with "solid" for text, so the header starts with the program's name.
    text = f"mbcdm_cad {name} (mm)" + (f"; {note}" if note else "")
    return text.encode("ascii", "replace")[:_HEADER].ljust(_HEADER)


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
    area, normal = faces(corners)
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
    a, b, c = triangles = index.reshape(-1)[mesh.triangles].T
    triangles = triangles.T[(a != b) & (b != c) & (c != a)]  # without those with two corners in one point
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


_Y_UP = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]])  # (x, y, z) becomes (x, z, -y)
_METRES = 1e-3
_FLOAT, _UINT32 = 5126, 5125
_VERTICES, _INDICES = 34962, 34963
_JSON_CHUNK, _BINARY_CHUNK = 0x4E4F534A, 0x004E4942


def glb_bytes(name: str, items: Sequence[Item], meshes: Mapping[str, TriangleMesh], note: str = "") -> bytes:
    """The assembly as GLB. ``meshes`` maps each part to its mesh in the part's own frame, in mm.

    Same bytes for the same model, whatever the order of ``items``. Colours are linear RGB, as in the catalogue.
    Raises ``ValueError`` as :func:`sorted_items` does.
    """
    writer = _Writer()
    groups: dict[str, list[int]] = {}
    for item in sorted_items(items, meshes):
        mesh = writer.mesh(item.part, meshes[item.part], item.material)
        node = {"name": item.name, "mesh": mesh, "extras": {"part": item.part}, "matrix": _matrix(item.location)}
        groups.setdefault(item.group, []).append(writer.node(node))
    children = [writer.node({"name": group, "children": nodes}) for group, nodes in groups.items()]
    root = writer.node({"name": name, "children": children})
    return writer.bytes(root, note)


def _matrix(placement: Placement) -> list[float]:
    """The placement in metres and Y up, column by column."""
    matrix = np.eye(4)
    matrix[:3, :3] = _Y_UP @ placement.rotation @ _Y_UP.T
    matrix[:3, 3] = _Y_UP @ placement.shift_mm * _METRES
    columns: list[float] = (matrix.T.ravel() + 0.0).tolist()
    return columns


class _Writer:
    """Collects the lists of a glTF and the bytes they point into."""

    def __init__(self) -> None:
        self._lists: dict[str, list[dict[str, Any]]] = {
            key: [] for key in ("nodes", "meshes", "materials", "accessors", "bufferViews")
        }
        self._binary = bytearray()
        self._meshes: dict[str, int] = {}
        self._materials: dict[Material, int] = {}

    def node(self, node: dict[str, Any]) -> int:
        return self._add("nodes", node)

    def mesh(self, part: str, mesh: TriangleMesh, material: Material) -> int:
        if part not in self._meshes:
            points = (mesh.points_mm @ _Y_UP.T * _METRES).astype("<f4") + np.float32(0.0)
            normals = (mesh.normals @ _Y_UP.T).astype("<f4") + np.float32(0.0)
            bounds = {"min": points.min(axis=0).tolist(), "max": points.max(axis=0).tolist()}
            primitive = {
                "attributes": {
                    "POSITION": self._accessor(points, "VEC3", _VERTICES, **bounds),
                    "NORMAL": self._accessor(normals, "VEC3", _VERTICES),
                },
                "indices": self._accessor(mesh.triangles.astype("<u4").ravel(), "SCALAR", _INDICES),
                "material": self._material(material),
            }
            self._meshes[part] = self._add("meshes", {"name": part, "primitives": [primitive]})
        return self._meshes[part]

    def _material(self, material: Material) -> int:
        if material not in self._materials:
            surface = {"baseColorFactor": [*material.colour, 1.0], "metallicFactor": 0.2, "roughnessFactor": 0.6}
            extras = {"density_g_cm3": material.density_g_cm3}
            entry = {"name": material.name, "pbrMetallicRoughness": surface, "extras": extras}
            self._materials[material] = self._add("materials", entry)
        return self._materials[material]

    def _accessor(self, values: NDArray[Any], shape: str, target: int, **bounds: list[float]) -> int:
        data = values.tobytes()
        view = {"buffer": 0, "byteOffset": len(self._binary), "byteLength": len(data), "target": target}
        self._binary += data
        accessor = {
            "bufferView": self._add("bufferViews", view),
            "componentType": _UINT32 if values.dtype.kind == "u" else _FLOAT,
            "count": len(values),
            "type": shape,
            **bounds,
        }
        return self._add("accessors", accessor)

    def _add(self, key: str, entry: dict[str, Any]) -> int:
        self._lists[key].append(entry)
        return len(self._lists[key]) - 1

    def bytes(self, root: int, note: str) -> bytes:
        asset = {"version": "2.0", "generator": "mbcdm_cad", **({"extras": {"note": note}} if note else {})}
        scenes = [{"nodes": [root]}]
        document = {
            "asset": asset,
            "scene": 0,
            "scenes": scenes,
            "buffers": [{"byteLength": len(self._binary)}],
            **self._lists,
        }
        text = json.dumps(document, separators=(",", ":"), allow_nan=False).encode()
        chunks = _chunk(_JSON_CHUNK, text, b" ") + _chunk(_BINARY_CHUNK, bytes(self._binary), b"\0")
        return struct.pack("<4sII", b"glTF", 2, 12 + len(chunks)) + chunks


def _chunk(kind: int, data: bytes, filler: bytes) -> bytes:
    padded = data + filler * (-len(data) % 4)
    return struct.pack("<II", len(padded), kind) + padded
