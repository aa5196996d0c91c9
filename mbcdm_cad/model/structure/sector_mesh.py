"""A drum sector in its own plane as a grid of quadrilaterals in polar coordinates that follows rim, web and openings.

Every opening is an annular sector with round corners; a slot with round ends is one whose corners are half its width.
Lines of the grid run along all edges. Inside a round corner of radius R they lie at R (1 - cos a) from the edges, for
equal steps of a: then the arc passes through nodes and halves the cells between them, which are triangles there.
Angles are from +Z towards +X, lengths in mm.
"""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from itertools import pairwise
from math import ceil, inf, pi, sqrt

import numpy as np
from numpy.typing import NDArray

from mbcdm_cad.model.structure.quadrilateral import AT_GAUSS, Ints, solve
from mbcdm_cad.routes import Floats

Bools = NDArray[np.bool_]

# Straight pieces along the quarter circle of a corner.
CORNER_PIECES = 3
# Lines nearer than this to a line that is already there are left out.
MERGED_MM = 0.06
# A node that lies less than this inside an opening, over its corner's radius, counts as one of its edge.
ON_EDGE = 0.07
# Samples of a cell along each direction by which a pocket's share of it is found.
SAMPLES = 4


@dataclass(frozen=True)
class Opening:
    """An opening of the web: an annular sector, its corners rounded by ``corner_mm``."""

    inner_mm: float
    outer_mm: float
    start_rad: float
    end_rad: float
    corner_mm: float


@dataclass(frozen=True)
class RimStep:
    """A ring of web or rim that ends at ``outer_mm``; it reaches along the axis from ``start_mm`` to ``end_mm``."""

    outer_mm: float
    start_mm: float
    end_mm: float


@dataclass(frozen=True)
class Pocket:
    """A box milled in along the axis, ``taken_mm`` from low to high, on one side of the middle (+1 or -1).

    It is open below or above. It reaches along the tangent, outwards to that side, and outwards from ``radius_mm``,
    both at the angle ``at_rad`` from the middle.
    """

    side: int
    at_rad: float
    radius_mm: float
    along_mm: tuple[float, float]
    out_mm: tuple[float, float]
    taken_mm: tuple[float, float]


@dataclass(frozen=True)
class SectorShape:
    """A sector of +-``half_angle_rad``, held at ``held_mm``; rings in the order of their radii, from there outwards.

    The web ends and the rim begins at ``rim_mm``.
    """

    half_angle_rad: float
    held_mm: float
    rings: tuple[RimStep, ...]
    openings: tuple[Opening, ...] = ()
    pockets: tuple[Pocket, ...] = ()
    rim_mm: float = inf


@dataclass(frozen=True, eq=False)
class SectorMesh:
    """Quadrilaterals in the plane: nodes (m, 2) as (x, z), corners (n, 4) anticlockwise, the first two further in.

    A triangle repeats its last corner. ``middle_mm`` (n,) is the height along the axis of the middle of the metal.
    ``line`` (m,) is the number of the node's radial line, ascending; ``radius_mm``, ``angle_rad`` (m,) its polar
    coordinates. ``grid`` are the radii and angles of all lines, ``cell`` (n, 2) the element's number along both.
    """

    node_mm: Floats
    corner: Ints
    thickness_mm: Floats
    middle_mm: Floats
    line: Ints
    radius_mm: Floats
    angle_rad: Floats
    grid: tuple[Floats, Floats]
    cell: Ints

    def solved(self, stiffness: Floats, load: Floats) -> Floats:
        """Freedoms (f m, k) under the loads (f m, k) by the elements' stiffness (n, 4 f, 4 f).

        Both ends of a mesh that goes all round are joined there: rows then hold the lines at the same distance from
        the seam on either side, so that elements still reach from one row to the next at most.
        """
        lines = len(self.grid[1]) - 1
        if self.grid[1][-1] - self.grid[1][0] < 2.0 * pi - 1e-9:
            return solve(self.corner, stiffness, load)
        count, stands = len(self.node_mm), np.arange(len(self.node_mm))
        first, last = (np.flatnonzero(self.line == end) for end in (0, lines))
        place = np.minimum(np.searchsorted(self.radius_mm[first], self.radius_mm[last] - 1e-9), len(first) - 1)
        met = np.abs(self.radius_mm[first[place]] - self.radius_mm[last]) < 1e-9
        stands[last[met]] = first[place[met]]
        row = np.minimum(self.line % lines, lines - self.line % lines)
        kept = np.flatnonzero(np.bincount(stands))
        order = kept[np.argsort(row[kept], kind="stable")]
        number = np.zeros(count, dtype=int)
        number[order] = np.arange(len(order))
        number = number[stands]
        each = len(load) // count
        freedom = (each * number[:, None] + np.arange(each)).ravel()
        joined = np.zeros((each * len(order), load.shape[1]))
        np.add.at(joined, freedom, load)
        return solve(number[self.corner], stiffness, joined)[freedom]

    def quarters(self, other: "SectorMesh") -> Ints:
        """Of each Gauss point (4 n,) of ``other`` the quarter of an element here that it lies in: 4 element + corner.

        -1 where there is no metal here.
        """
        number = np.full([len(lines) - 1 for lines in self.grid], -1)
        number[tuple(self.cell.T)] = np.arange(len(self.cell))
        at, upper = [], []
        for lines, of_node in zip(self.grid, (other.radius_mm, other.angle_rad), strict=True):
            place = (of_node[other.corner] @ AT_GAUSS.T).ravel()
            found = np.clip(np.searchsorted(lines, place) - 1, 0, len(lines) - 2)
            at.append(found)
            upper.append(place > (lines[found] + lines[found + 1]) / 2.0)
        element, (out, on) = number[tuple(at)], upper
        return np.where(element < 0, -1, 4 * element + np.where(out, 3 - on, on))


def sector_mesh(shape: SectorShape, cell_mm: float, corner_pieces: int = CORNER_PIECES) -> SectorMesh:
    """The mesh. Its cells are at most ``cell_mm`` long at the rim, and shorter inwards, where spokes are narrow.

    Raises ``ValueError`` if no web is left at the held edge, or the radii of hub, rim and lands descend.
    """
    steps = [shape.held_mm, *(ring.outer_mm for ring in shape.rings)]
    if steps[1] <= steps[0] or any(outer < inner for inner, outer in pairwise(steps)):
        outwards = ", ".join(f"{r:.4g}" for r in steps)
        raise ValueError(
            f"no web is left between the drum's hub and its lands (radii outwards {outwards} mm): "
            "choose a larger drum, or less of what widens the hub (torque, payload, drum.bearing)"
        )
    radii, angles = _grid(shape, cell_mm, corner_pieces)
    count = len(radii)
    r = np.tile(radii, len(angles))
    a = np.repeat(angles, count)
    i, j = (k.ravel() for k in np.meshgrid(np.arange(len(angles) - 1), np.arange(count - 1), indexing="ij"))
    low = i * count + j
    # Anticlockwise in (x, z), since angles count from z towards x.
    corner = np.stack([low, low + count, low + count + 1, low + 1], axis=1)
    corner, metal = _cut(shape, r, a, corner)
    corner, i, j = corner[metal], i[metal], j[metal]
    ring = np.searchsorted(np.array([ring.outer_mm for ring in shape.rings]), r[corner].mean(axis=1))
    start = np.array([ring.start_mm for ring in shape.rings])[ring]
    end = np.array([ring.end_mm for ring in shape.rings])[ring]
    if shape.pockets:
        start, end = _left(shape.pockets, (radii, angles), (j, i), (start, end))
    thick = end - start
    kept = thick > 1e-3
    corner, thick, end, cell = corner[kept], thick[kept], end[kept], np.stack([j, i], axis=1)[kept]
    if not (r[corner] < shape.held_mm + 1e-9).any():
        raise ValueError("drum: its windows leave no web at the hub")
    among = np.bincount(corner.ravel(), minlength=len(r)) > 0
    used, number = np.flatnonzero(among), np.cumsum(among) - 1
    node = np.stack([r[used] * np.sin(a[used]), r[used] * np.cos(a[used])], axis=1)
    corner, middle, line = number[corner], end - thick / 2.0, used // count
    return SectorMesh(node, corner, thick, middle, line, r[used], a[used], (radii, angles), cell)


def _grid(shape: SectorShape, cell_mm: float, corner_pieces: int) -> tuple[Floats, Floats]:
    half, outer = shape.half_angle_rad, shape.rings[-1].outer_mm
    steps = 1.0 - np.cos(np.arange(1, corner_pieces + 1) * pi / 2 / corner_pieces)
    hard_r = [shape.held_mm, *(ring.outer_mm for ring in shape.rings)]
    soft_r: list[float] = []
    hard_a: list[float] = [-half, half]
    soft_a: list[float] = []
    for o in shape.openings:
        hard_r += [o.inner_mm, o.outer_mm]
        hard_a += [o.start_rad, o.end_rad]
        for step in steps * o.corner_mm:
            soft_r += [o.inner_mm + step, o.outer_mm - step]
            for radius in (o.inner_mm, o.outer_mm):
                # Across a corner the radius changes little; that of its middle is taken.
                at = radius + (0.4 if radius == o.inner_mm else -0.4) * o.corner_mm
                soft_a += [o.start_rad + step / at, o.end_rad - step / at]
    radii = _filled(_merged([*hard_r, *soft_r], MERGED_MM, (shape.held_mm, outer)), lambda r: cell_mm * sqrt(r / outer))
    narrow = min([o.inner_mm for o in shape.openings], default=outer)
    angles = _merged([*hard_a, 0.0, *soft_a], MERGED_MM / narrow, (-half, half))
    return radii, _filled(angles, lambda _: cell_mm / outer)


def _merged(wished: Iterable[float], apart: float, ends: tuple[float, float]) -> list[float]:
    """The values between ``ends``, without those that lie close to one that stands before them."""
    kept = list(ends)
    for value in wished:
        if ends[0] < value < ends[1] and min(abs(value - other) for other in kept) > apart:
            kept.append(value)
    return sorted(kept)


def _filled(lines: Sequence[float], longest: Callable[[float], float]) -> Floats:
    """The lines with others between them, at most ``longest`` of the middle apart."""
    pieces = [np.linspace(a, b, max(1, ceil((b - a) / longest((a + b) / 2))) + 1)[1:] for a, b in pairwise(lines)]
    return np.concatenate([lines[:1], *pieces])


def _depth(o: Opening, r: Floats, a: Floats) -> Floats:
    """How far a point lies inside an opening (mm), negative outside."""
    across = np.minimum(r - o.inner_mm, o.outer_mm - r)
    along = np.minimum(a - o.start_rad, o.end_rad - a) * r
    corner = o.corner_mm
    off = np.hypot(corner - np.minimum(across, corner), corner - np.minimum(along, corner))
    return np.where((across < corner) & (along < corner), corner - off, np.minimum(across, along))


def _cut(shape: SectorShape, r: Floats, a: Floats, corner: Ints) -> tuple[Ints, Bools]:
    """Corners of the cells with triangles where an edge halves one, and which of them are metal."""
    metal = np.ones(len(corner), dtype=bool)
    corner = corner.copy()
    for o in shape.openings:
        near = (r[corner].max(axis=1) > o.inner_mm) & (r[corner].min(axis=1) < o.outer_mm)
        near &= (a[corner].max(axis=1) > o.start_rad) & (a[corner].min(axis=1) < o.end_rad)
        cells = np.flatnonzero(near & metal)
        inside = _depth(o, r[corner[cells]], a[corner[cells]]) > ON_EDGE * o.corner_mm
        count = inside.sum(axis=1)
        middle = _depth(o, r[corner[cells]].mean(axis=1), a[corner[cells]].mean(axis=1)) > 0.0
        halved = (count == 1) & middle
        metal[cells] = (count == 0) & ~middle | halved | (count == 1) & ~middle
        # The three corners after the one that is gone, the last of them twice.
        left = (np.argmax(inside[halved], axis=1)[:, None] + np.array([1, 2, 3, 3])) % 4
        corner[cells[halved]] = np.take_along_axis(corner[cells[halved]], left, axis=1)
    return corner, metal


def _left(
    pockets: Sequence[Pocket], lines: tuple[Floats, Floats], cells: tuple[Ints, Ints], ends: tuple[Floats, Floats]
) -> tuple[Floats, Floats]:
    """Mean heights (n,) at which the metal of each cell starts and ends; ``lines``, ``cells`` are (radial, angular)."""
    (radii, angles), (j, i), (start, end) = lines, cells, ends
    at = (np.arange(SAMPLES) + 0.5) / SAMPLES
    below, wide = np.diff(radii)[j], np.diff(angles)[i]
    low, high = start.copy(), end.copy()
    # Only cells that a pocket may reach: beyond its least radius, and within the angle of its furthest corner.
    reached = np.zeros(len(j), dtype=bool)
    for p in pockets:
        corner = np.arctan2(np.array(p.along_mm), p.radius_mm + np.array(p.out_mm)[:, None]) + p.at_rad
        turned = p.side * (angles[i] + wide / 2.0)
        near = (turned > corner.min() - wide) & (turned < corner.max() + wide)
        reached |= near & (radii[j] + below > p.radius_mm + p.out_mm[0])
    near = np.flatnonzero(reached)
    r = radii[j[near]][:, None, None] + below[near][:, None, None] * at[None, :, None]
    a = angles[i[near]][:, None, None] + wide[near][:, None, None] * at[None, None, :]
    below_mm, above_mm = (
        np.broadcast_to(side[near][:, None, None], np.broadcast_shapes(r.shape, a.shape)).copy() for side in ends
    )
    for p in pockets:
        turn = p.side * a - p.at_rad
        out, along = r * np.cos(turn) - p.radius_mm, r * np.sin(turn)
        inside = (along > p.along_mm[0]) & (along < p.along_mm[1]) & (out > p.out_mm[0]) & (out < p.out_mm[1])
        # Open below where it begins there, else above.
        from_below = p.taken_mm[0] <= below_mm
        np.maximum(below_mm, p.taken_mm[1], out=below_mm, where=inside & from_below)
        np.minimum(above_mm, p.taken_mm[0], out=above_mm, where=inside & ~from_below)
    low[near] = np.minimum(below_mm, above_mm).mean(axis=(1, 2))
    lowered = (above_mm < end[near][:, None, None]).any(axis=(1, 2))
    high[near[lowered]] = above_mm[lowered].mean(axis=(1, 2))
    return np.minimum(low, high), high
