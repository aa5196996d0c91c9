"""Single tests of the interference run: two solids, a piece of a cable and a solid, all cables of a pose, one solid.

The key of a test is made from the content of the shapes and their relative position, so its answer is valid wherever
these are the same. Kernel and compiled code are imported inside the functions: a run whose answers are all known does
not need them.
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import combinations, product
from math import inf
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from numpy.typing import NDArray

from mbcdm_cad.errors import GeometryError
from mbcdm_cad.parts.bill import Placement, Row
from mbcdm_cad.routes.curves import CablePath, Piece, cut
from mbcdm_cad.workshop.trianglemesh import TriangleMesh

if TYPE_CHECKING:
    from mbcdm_cad.workshop.separation import Surface


Points = NDArray[np.float64]
Place = tuple[float, float, float]

_COARSE_MM = 0.2
_FINE_MM = 0.01
# Points of one cable less than this many diameters apart along it belong to the same stretch, not to another turn.
_OWN_STRETCH_DIAMETERS = 4.0


@dataclass(frozen=True)
class Clash:
    """Two bodies that overlap at one drum angle: ``volume_mm3`` for solids, ``overlap_mm`` for two cables."""

    first: str
    second: str
    kind: Literal["solids", "cable and solid", "cables"]
    drum_angle_deg: float
    place_mm: Place
    volume_mm3: float = 0.0
    overlap_mm: float = 0.0

    def __str__(self) -> str:
        x, y, z = self.place_mm
        size = f"{self.overlap_mm:.4f} mm deep" if self.kind == "cables" else f"{self.volume_mm3:.4f} mm^3"
        where = f"at ({x:.2f}, {y:.2f}, {z:.2f}) mm, drum at {self.drum_angle_deg:+.2f} deg"
        return f"{self.first} and {self.second} overlap: {size} {where}"


def _along(points: Points) -> NDArray[np.float64]:
    return np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))])


def _refined(first: Points, second: Points, i: int, j: int) -> tuple[float, Points]:
    """Least distance, mm, between the stretches around two sample points, sampled finely between their neighbours."""

    def fine(points: Points, k: int) -> Points:
        low, high = max(0, k - 2), min(len(points) - 1, k + 2)
        stretch = points[low : high + 1]
        s = _along(stretch)
        at = np.arange(0.0, s[-1], _FINE_MM)
        return np.stack([np.interp(at, s, stretch[:, axis]) for axis in range(3)], axis=1)

    a, b = fine(first, i), fine(second, j)
    m, n = divmod(int(np.argmin(np.linalg.norm(a[:, None] - b, axis=2))), len(b))
    return float(np.linalg.norm(a[m] - b[n])), (a[m] + b[n]) / 2


def centre_line_distance(first: CablePath, second: CablePath, diameter_mm: float) -> tuple[float, Points]:
    """Least distance (mm) between two centre lines, or between the turns of one; and its place.

    Exact to 1e-4 mm if it is under ``diameter_mm``; above that only the nearest of the coarse samples is refined, with
    an error up to 0.01 mm.
    """
    a = first.sample(_COARSE_MM)
    b = a if first is second else second.sample(_COARSE_MM)
    # Two samples half a step from the closest points are further apart by up to this, so others may be nearer.
    near = (diameter_mm**2 + _COARSE_MM**2 / 2) ** 0.5
    pairs = _own_turns(a, diameter_mm, near) if first is second else _between(a, b, near)
    best, done = (inf, a[0]), set[tuple[int, int]]()
    for i, j in pairs.tolist():
        if (i, j) not in done:
            best = min(best, _refined(a, b, i, j), key=lambda found: found[0])
            done.update(product(range(i - 1, i + 2), range(j - 1, j + 2)))
    return best


def _between(a: Points, b: Points, near_mm: float) -> NDArray[np.int64]:
    """Indices (n, 2) of the samples of two cables nearer than this, the nearest first; without one, the nearest two.

    By trees: a table of all distances takes gigabytes for cables with some turns.
    """
    from scipy.spatial import cKDTree  # its import takes longer than reading answers that are known

    tree = cKDTree(b)
    distance, nearest = tree.query(a)
    if distance.min() >= near_mm:
        return np.array([[k := int(np.argmin(distance)), nearest[k]]])
    found = cKDTree(a).sparse_distance_matrix(tree, near_mm, output_type="ndarray")
    order = np.lexsort((found["j"], found["i"], found["v"]))
    return np.column_stack((found["i"], found["j"]))[order]


def _own_turns(a: Points, diameter_mm: float, near_mm: float) -> NDArray[np.int64]:
    """As :func:`_between`, of one cable's stretches that do not follow each other; none of a cable without them."""
    from scipy.spatial import cKDTree

    tree, s, own_mm = cKDTree(a), _along(a), _OWN_STRETCH_DIAMETERS * diameter_mm
    # The stretches next to the own one are no further away than along the cable.
    for within_mm, count in ((near_mm, None), (own_mm + 2.0 * _COARSE_MM, 1)):
        pairs: NDArray[np.int64] = tree.query_pairs(within_mm, output_type="ndarray")
        pairs = pairs[s[pairs[:, 1]] - s[pairs[:, 0]] > own_mm]
        if len(pairs):
            distance = np.linalg.norm(a[pairs[:, 0]] - a[pairs[:, 1]], axis=1)
            pairs = pairs[np.lexsort((pairs[:, 1], pairs[:, 0], distance))][:count]
            break
    return pairs


def cable_overlaps(paths: Sequence[CablePath], diameter_mm: float) -> Iterator[tuple[int, int, float, Place]]:
    """Cables whose centre lines come nearer than their diameter, each pair and each cable with its own turns.

    ``diameter_mm``: of cables that state none; of two cables half the sum of both counts.

    Returns the indices of both, the overlap (mm), and its place.
    """
    count = len(paths)
    for i, j in (*combinations(range(count), 2), *((k, k) for k in range(count))):
        wide = sum(paths[k].diameter_mm or diameter_mm for k in (i, j)) / 2.0
        distance, place = centre_line_distance(paths[i], paths[j], wide)
        if distance < wide - 1e-6:
            yield i, j, wide - distance, (float(place[0]), float(place[1]), float(place[2]))


# Two bodies with a common volume below this touch but do not overlap.
VOLUME_LIMIT_MM3 = 0.01
# The rod tested against solids is thinner by this, because booleans of surfaces that touch along a line fail.
CABLE_UNDERSIZE_MM = 0.01
_CULL_STEP_MM = 0.5
# A boolean of a whole wound cable takes seconds, that of a short part a tenth of one.
_PART_MM = 3.0
# If more of the cable than this share may touch, one boolean of the whole takes less time.
_FEW = 0.5
# Chordal error of the mesh that a wound cable is compared with. It counts twice, because chords across a groove lie
# nearer to the cable than its floor: twice as much must be smaller than the gap of the thinner rod.
_FINE_MESH_MM = 0.004
# The box of a part is exact to rounding.
_BOX_MARGIN_MM = 1e-3
# A motion is rounded to these digits, far below any tolerance, so that pairs that move together have the same key.
_ROTATION_DIGITS, _SHIFT_DIGITS = 12, 9
# The last bits of the kernel's results differ from process to process.
_FIGURE_DIGITS = 9

Box = NDArray[np.float64]  # (2, 3): lowest and highest corner
# Result of a test, one row for each place: index of first and second body, size (mm^3, or mm for cables), place.
Found = list[tuple[int, int, float, float, float, float]]


class PartShape:
    """A part's shape.

    ``key`` identifies its content; ``load`` returns its solid and is called only when a boolean needs it. Without a
    mesh no pair can be proven apart."""

    def __init__(self, key: str, box: Box, load: Callable[[], Any], mesh: TriangleMesh | None = None) -> None:
        self.key = key
        self.box = box
        self.mesh = mesh
        self._load = load

    @cached_property
    def solid(self) -> Any:
        """The solid in the part's own frame."""
        return self._load()

    @cached_property
    def surface(self) -> Surface | None:
        """The mesh, prepared for comparisons."""
        from mbcdm_cad.workshop.separation import Surface

        return None if self.mesh is None else Surface.of_mesh(self.mesh)

    @cached_property
    def fine_surface(self) -> Surface | None:
        """A finer mesh of the solid, prepared for comparisons; None if the kernel cannot make it."""
        from mbcdm_cad.workshop.meshing import mesh_solid
        from mbcdm_cad.workshop.separation import Surface

        if self.mesh is None:
            return None
        try:
            return Surface.of_mesh(mesh_solid("part", self.solid, _FINE_MESH_MM))
        except GeometryError:
            return None

    def box_at(self, placement: Placement) -> Box:
        """An axis-parallel box around the part at a placement, from its own box after the rotation."""
        corners = placement.apply(np.array(np.meshgrid(*self.box.T)).reshape(3, -1).T)
        return np.stack([corners.min(axis=0) - _BOX_MARGIN_MM, corners.max(axis=0) + _BOX_MARGIN_MM])


class RodShape:
    """A stretch of a cable as a rod, drawn and sampled once for all its tests."""

    def __init__(self, path: CablePath, diameter_mm: float) -> None:
        self.pieces = path.line
        self.length_mm = path.length_mm
        self.radius_mm = diameter_mm / 2 - CABLE_UNDERSIZE_MM
        self.key = digest(self.pieces, self.radius_mm)
        self._points = path.sample(_CULL_STEP_MM)

    @cached_property
    def surface(self) -> Surface:
        """The rod, prepared for comparisons with meshes."""
        from mbcdm_cad.workshop.separation import Surface

        return Surface.of_rod(self.pieces, self.radius_mm)

    @cached_property
    def solid(self) -> Any:
        """The solid of the rod."""
        from mbcdm_cad.workshop.kernel import rod

        return rod(self.pieces, self.radius_mm)

    def parts_near(self, body: PartShape, placement: Placement) -> list[Piece]:
        """The short parts of the line at which the rod is not proven apart from a body, by the body's finer mesh."""
        from mbcdm_cad.workshop.separation import Surface

        def near(piece: Piece, crossed_only: bool) -> bool:
            return not _apart(Surface.of_rod((piece,), self.radius_mm), body.fine_surface, placement, crossed_only)

        found: list[Piece] = []
        for piece in self.pieces:
            if not near(piece, False):
                continue
            # Whether a short part lies inside takes long to tell, and need not be told: where its piece enters the
            # body, other parts are near, and where the piece does not, all of it lies inside.
            parts = [part for part in cut(piece, _PART_MM) if near(part, True)]
            found += parts or [piece]
        return found

    def is_near(self, box: Box) -> bool:
        """Whether the rod may reach into a box."""
        margin = self.radius_mm + _CULL_STEP_MM
        return bool(np.any(np.all((self._points > box[0] - margin) & (self._points < box[1] + margin), axis=1)))


@dataclass(frozen=True)
class Pair:
    """Two solids; ``placement`` leads from the second's frame to the first's."""

    first: PartShape
    second: PartShape
    placement: Placement

    @property
    def key(self) -> str:
        """The test's name."""
        return digest("pair", self.first.key, self.second.key, self.placement.rows)

    @property
    def work(self) -> float:
        """Rough measure of how long the test takes."""
        return float(sum(len(body.mesh.triangles) for body in (self.first, self.second) if body.mesh is not None))

    def test(self) -> Found:
        """What the two share, in the frame of the first."""
        if _apart(self.first.surface, self.second.surface, self.placement):
            return []
        return _shared(self.first.solid, self.second.solid, self.placement)


@dataclass(frozen=True)
class Rod:
    """A stretch of a cable and a solid; ``placement`` leads from the solid's frame to the cable's."""

    rod: RodShape
    body: PartShape
    placement: Placement

    @property
    def key(self) -> str:
        """The test's name."""
        return digest("rod", self.rod.key, self.body.key, self.placement.rows)

    @property
    def work(self) -> float:
        """Rough measure of how long the test takes: the kernel is slow where a helix touches a cylinder."""
        return 1e6 * self.rod.length_mm

    def test(self) -> Found:
        """What the two share, in the frame of the cable."""
        if _apart(self.rod.surface, self.body.surface, self.placement):
            return []
        # A boolean of a helix along a cylinder takes seconds, a finer mesh of the cylinder only a quarter of a second.
        near = self.rod.parts_near(self.body, self.placement)
        few = sum(part.length_mm for part in near) < _FEW * self.rod.length_mm
        if few and self._volume_mm3(near) < VOLUME_LIMIT_MM3:
            return []
        return _shared(self.rod.solid, self.body.solid, self.placement)

    def _volume_mm3(self, parts: Sequence[Piece]) -> float:
        """Volume that the body shares with the rod along some parts of the line."""
        if not parts:
            return 0.0
        from mbcdm_cad.workshop.kernel import common, rod

        rods = [rod((part,), self.rod.radius_mm) for part in parts]
        return sum(abs(common(solid, self.body.solid, self.placement)[0]) for solid in rods)


@dataclass(frozen=True)
class Cables:
    """All cables of one pose, each against each and each against its own other turns."""

    paths: tuple[CablePath, ...]
    diameter_mm: float
    work: float = 1e5

    @property
    def key(self) -> str:
        """The test's name."""
        return digest("cables", self.diameter_mm, *((path.pieces, path.diameter_mm) for path in self.paths))

    def test(self) -> Found:
        """Places at which centre lines are nearer than the diameter, and the overlaps."""
        from threadpoolctl import threadpool_limits

        # Tests run in parallel processes; additional threads of the linear algebra would only slow them down.
        with threadpool_limits(1, "blas"):
            found = list(cable_overlaps(self.paths, self.diameter_mm))
        return [(i, j, round(depth_mm, _FIGURE_DIGITS), *place) for i, j, depth_mm, place in found]


@dataclass(frozen=True)
class Faces:
    """The faces of one part against each other."""

    part: str
    body: PartShape

    @property
    def key(self) -> str:
        """The test's name."""
        return digest("faces", self.body.key)

    @property
    def work(self) -> float:
        """Rough measure of how long the test takes."""
        return 0.0 if self.body.mesh is None else 1e4 * len(self.body.mesh.triangles)

    def test(self) -> Found:
        """An empty result. Raises ``GeometryError`` if faces intersect each other."""
        from mbcdm_cad.workshop.kernel import validate_faces

        validate_faces(self.part, self.body.solid)
        return []


Test = Pair | Rod | Cables | Faces


def rounded(placement: Placement) -> Placement:
    """A motion rounded to the significant digits, so that motions that differ only by rounding errors are equal."""

    def row(values: Row) -> Row:
        a, b, c = (round(value, _ROTATION_DIGITS) + 0.0 for value in values[:3])
        return a, b, c, round(values[3], _SHIFT_DIGITS) + 0.0

    first, second, third = placement.rows
    return Placement((row(first), row(second), row(third)))


def digest(*content: Any) -> str:
    """Hash of plain data, 32 hexadecimal digits."""
    return hashlib.blake2b(repr(content).encode(), digest_size=16).hexdigest()


def _apart(first: Surface | None, second: Surface | None, placement: Placement, crossed_only: bool = False) -> bool:
    from mbcdm_cad.workshop.separation import apart

    return first is not None and second is not None and apart(first, second, placement, crossed_only)


def _shared(first: Any, second: Any, placement: Placement) -> Found:
    from mbcdm_cad.workshop.kernel import common

    volume_mm3, place = common(first, second, placement)
    if abs(volume_mm3) < VOLUME_LIMIT_MM3:
        return []
    x, y, z = (round(value, _FIGURE_DIGITS) for value in place)
    return [(0, 1, round(volume_mm3, _FIGURE_DIGITS), x, y, z)]
