"""Single tests of the interference run: two solids, a piece of a cable and a solid, all cables of a pose, one solid.

The key of a test is made from the content of the shapes and their relative position, so its answer is valid wherever
these are the same. Kernel and compiled code are imported inside the functions: a run whose answers are all known does
not need them.
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from mbcdm_cad.errors import GeometryError
from mbcdm_cad.parts.placement import Placement, Row
from mbcdm_cad.routes.cable_path import CablePath
from mbcdm_cad.routes.curves import Piece, cut
from mbcdm_cad.workshop.clash import cable_overlaps
from mbcdm_cad.workshop.trianglemesh import TriangleMesh

if TYPE_CHECKING:
    from mbcdm_cad.workshop.separation import Surface

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
        from mbcdm_cad.workshop.overlap import rod

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
        from mbcdm_cad.workshop.overlap import common, rod

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
        from mbcdm_cad.workshop.validate import validate_faces

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
    from mbcdm_cad.workshop.overlap import common

    volume_mm3, place = common(first, second, placement)
    if abs(volume_mm3) < VOLUME_LIMIT_MM3:
        return []
    x, y, z = (round(value, _FIGURE_DIGITS) for value in place)
    return [(0, 1, round(volume_mm3, _FIGURE_DIGITS), x, y, z)]
