"""GLB (binary glTF 2.0) of an assembly: metres, Y up, one mesh a part, one node an item, below a node for its group."""

from __future__ import annotations

import json
import struct
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mbcdm_cad.design.bought import Material
from mbcdm_cad.parts.bill import Item, sorted_items
from mbcdm_cad.parts.placement import Placement
from mbcdm_cad.workshop.trianglemesh import TriangleMesh

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
