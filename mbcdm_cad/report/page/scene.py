"""The 3D scene of the page, as plain data and one block of binary numbers: meshes, places, bodies and cables.

The data describe everything (bodies with axis and ratio, cables as sampled centre lines), so the page knows no
configuration. Lengths in mm, in the frame of the mechanism.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from math import ceil, radians, sqrt
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mbcdm_cad.design.drive import Drive
from mbcdm_cad.layouts.registry import layout_of
from mbcdm_cad.parts.bill import Bill, cable_item
from mbcdm_cad.parts.bodies import CableRod
from mbcdm_cad.routes.curves import CablePath, Piece
from mbcdm_cad.workshop.interference import MovingGroup, bodies, is_cable
from mbcdm_cad.workshop.mass import PartFiles, item_mass
from mbcdm_cad.workshop.trianglemesh import TriangleMesh

# Largest deviation of the chords of a centre line from the curve, and largest error of the linear interpolation between
# two drum angles. Both are too small to be visible on a screen.
CHORD_ERROR_MM = 0.02
POSE_ERROR_MM = 0.03
_POSES = (9, 19, 37, 71, 141, 281)
_SHORTS = 65535


Paths = Callable[[float], Sequence[CablePath]]
# Centre lines by cable name, (angles, points, 3).
Lines = Mapping[str, NDArray[np.float64]]


@dataclass(frozen=True)
class Scene:
    """``data`` is written into the page as JSON, ``binary`` beside it; arrays in ``data`` state their place in it."""

    data: dict[str, Any]
    binary: bytes


class _Binary:
    """Arrays one after the other, each starting at a multiple of four bytes."""

    def __init__(self) -> None:
        self._bytes = bytearray()

    def add(self, values: NDArray[Any]) -> dict[str, Any]:
        self._bytes += b"\0" * (-len(self._bytes) % 4)
        start = len(self._bytes)
        little = np.ascontiguousarray(values.astype(values.dtype.newbyteorder("<"), copy=False))
        self._bytes += little.tobytes()
        return {"type": values.dtype.name, "start": start, "count": int(values.size)}

    def quantised(self, points: NDArray[np.float64]) -> dict[str, Any]:
        """Points (..., 3) as 16-bit steps of their own box: within a hundred-thousandth of its size."""
        flat = points.reshape(-1, 3)
        low = flat.min(axis=0)
        step = np.maximum(flat.max(axis=0) - low, 1e-9) / _SHORTS
        shorts = np.round((flat - low) / step).astype(np.uint16)
        return {**self.add(shorts), "low": _figures(low), "step": [float(f"{v:.9g}") for v in step]}

    def bytes(self) -> bytes:
        return bytes(self._bytes)


def design_scene(drive: Drive, parts: Mapping[str, PartFiles], lines: Lines) -> Scene:
    """The scene of one design from its configuration; ``parts`` by name, ``lines`` from :func:`cable_lines`."""
    layout = layout_of(drive)
    centred = layout.bill()
    return scene(centred, bodies(layout.moving_bodies, centred), parts, lines, drive)


def scene(
    centred: Bill, moving: Sequence[MovingGroup], parts: Mapping[str, PartFiles], lines: Lines, drive: Drive
) -> Scene:
    """The scene of bodies, parts and cables.

    ``centred`` is the bill with the drum centred; ``lines`` are the cables' centre lines over the travel.
    """
    binary = _Binary()
    body_of = {item: body.name for body in moving for item in body.items}
    rigid = [item for item in centred.items if not is_cable(item)]
    cables = {item.name: item for item in centred.items if is_cable(item)}
    data: dict[str, Any] = {
        "half_travel_deg": drive.half_travel_deg,
        "middle_deg": drive.middle_deg,
        "bodies": [{"name": b.name, "axis": list(b.axis), "point": list(b.point_mm), "ratio": b.ratio} for b in moving],
        "parts": {name: _mesh(binary, parts[name].mesh) for name in sorted({item.part for item in rigid})},
        "items": [
            {
                "name": item.name,
                "part": item.part,
                "body": body_of[item.name],
                "kind": item.kind,
                "material": item.material.name,
                "colour": _figures(item.material.colour),
                "mass_g": _figure(item_mass(item, parts[item.part].shape).mass_g),
                "place": _figures(np.array(item.location.rows).ravel(), 9),
            }
            for item in sorted(rigid, key=lambda item: (body_of[item.name], item.name))
        ],
        "cables": [],
    }
    for name, points in lines.items():
        item = cables[cable_item(name)]
        rod = centred.parts[item.part].part
        data["cables"].append(
            {
                "name": item.name,
                "part": item.part,
                "kind": item.kind,
                "material": item.material.name,
                "colour": _figures(item.material.colour),
                "mass_g": _figure(item_mass(item, parts[item.part].shape).mass_g),
                "radius_mm": rod.radius if isinstance(rod, CableRod) else drive.cable.diameter_mm / 2,
                "angles": len(points),
                "points": points.shape[1],
                "line": binary.quantised(points),
            }
        )
    return Scene(data, binary.bytes())


def _mesh(binary: _Binary, mesh: TriangleMesh) -> dict[str, Any]:
    small = len(mesh.points_mm) <= _SHORTS
    kind = np.uint16 if small else np.uint32
    return {
        "points": binary.quantised(mesh.points_mm),
        "normals": binary.add(np.round(mesh.normals * 127.0).astype(np.int8)),
        "triangles": binary.add(mesh.triangles.astype(kind)),
        "edges": binary.add(mesh.edges.astype(kind)),
    }


def cable_lines(paths_at: Paths, half_travel_deg: float) -> tuple[dict[str, NDArray[np.float64]], NDArray[np.float64]]:
    """Centre lines by cable name, (angles, points, 3), and the drum angles (deg) they are sampled at.

    The number of points on a piece is the same at every angle, so points correspond and a surface swept along them
    keeps its topology. There are as many angles as ``POSE_ERROR_MM`` needs.
    """
    ends = [paths_at(radians(angle)) for angle in (-half_travel_deg, 0.0, half_travel_deg)]
    counts = [
        [max(_chords(piece) for piece in same) for same in zip(*(_pieces(p) for p in path), strict=True)]
        for path in zip(*ends, strict=True)
    ]
    least = 0.0
    for poses in _POSES:
        if poses < least:
            continue
        angles = np.linspace(-half_travel_deg, half_travel_deg, poses)
        at = [_sampled(paths_at(radians(angle)), counts) for angle in angles]
        lines = {name: np.array([pose[name] for pose in at]) for name in at[0]}
        error_mm = _pose_error(paths_at, lines, angles, counts)
        if poses == _POSES[-1] or error_mm <= POSE_ERROR_MM:
            break
        # The error falls with the square of the step; a tenth less than that needs is tried, since the next may do.
        least = 0.9 * (poses - 1) * sqrt(error_mm / POSE_ERROR_MM)
    return lines, angles


def _pieces(path: CablePath) -> list[Piece]:
    return [piece for _, piece in path.pieces]


def _chords(piece: Piece) -> int:
    """Chords that keep within ``CHORD_ERROR_MM`` of the piece."""
    points = piece.points(np.linspace(0.0, 1.0, 257))
    bend = float(np.linalg.norm(np.diff(points, n=2, axis=0), axis=1).max()) * 256.0**2
    # A chord over a share h of a curve with second derivative b leaves it by b h^2 / 8.
    return max(1, ceil(sqrt(bend / (8.0 * CHORD_ERROR_MM))))


def _sampled(paths: Sequence[CablePath], counts: Sequence[Sequence[int]]) -> dict[str, NDArray[np.float64]]:
    """Points of every cable; where two pieces meet there is one point, so that no chord has length zero."""
    lines = {}
    for path, chords in zip(paths, counts, strict=True):
        runs = [p.points(np.linspace(0.0, 1.0, n + 1)) for p, n in zip(_pieces(path), chords, strict=True)]
        lines[path.cable.name] = np.concatenate([runs[0], *(run[1:] for run in runs[1:])])
    return lines


def _pose_error(
    paths_at: Paths,
    lines: Mapping[str, NDArray[np.float64]],
    angles: NDArray[np.float64],
    counts: Sequence[Sequence[int]],
) -> float:
    """Largest error of linear interpolation, evaluated in the middle of the first, middle and last interval."""
    worst = 0.0
    for k in (0, len(angles) // 2, len(angles) - 2):
        true = _sampled(paths_at(radians((angles[k] + angles[k + 1]) / 2)), counts)
        for name, points in lines.items():
            between = (points[k] + points[k + 1]) / 2
            worst = max(worst, float(np.linalg.norm(between - true[name], axis=1).max()))
    return worst


def _figure(value: float, digits: int = 6) -> float:
    return float(f"{value:.{digits}g}")


def _figures(values: Any, digits: int = 6) -> list[float]:
    return [_figure(float(v), digits) for v in values]
