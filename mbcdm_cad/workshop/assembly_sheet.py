"""The sheet of the whole drive: views and sections that show each part, and the numbers that point to where it is seen.

Which part each point of a view shows is found from the meshes.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import distance_transform_edt

from mbcdm_cad.parts.bill import Item
from mbcdm_cad.parts.sheet import CuttingLine, Label, Linear, Sheet, Table, Vector, View, X, Y, Z, minus
from mbcdm_cad.workshop.trianglemesh import FloatArray

Box = tuple[Vector, Vector]

# Points on the longest side of what is seen; the paper has about one for each millimetre.
_ACROSS = 300
# Length of a step over that of a point: no point between two samples of a triangle is left out.
_STEP = 0.7
_TOUCH_MM = 0.02
# The middle of a meshed body of revolution lies so near its axis.
_AT_PLANE_MM = 0.01
# A part is seen, or seen well, if so many points lie between the end of its leader and its edge.
_SEEN, _WELL_SEEN = 1.5, 4.0
# A part that is too thin for the points is looked for once more, so many points round where it comes nearest to the
# eye, with points so many times as close.
_ROUND, _CLOSER = 6.0, 8
_MOST_SECTIONS = 2
_MOST_PLACES = 8
NOTHING = -1


@dataclass(frozen=True)
class SeenBody:
    """A body at its place: the corners of its triangles, mm, shape (m, 3, 3); the number of its part.

    ``whole``: sections do not cut it, as fasteners and axles; it is left out where its middle lies before the plane.
    """

    number: int
    corners_mm: FloatArray
    whole: bool = False


@dataclass(frozen=True)
class Sight:
    """The number of the part that each point of a view shows, or ``NOTHING``; rows from below."""

    view: View
    numbers: NDArray[np.int64]
    step_mm: float
    corner_mm: tuple[float, float]
    depth_mm: FloatArray

    def best(self, number: int) -> tuple[Vector, float] | None:
        """The point of a part that is furthest from all others, and how far, mm; None if the view shows none of it."""
        own = np.pad(self.numbers == number, 1)
        if not own.any():
            return None
        clear = distance_transform_edt(own)[1:-1, 1:-1]
        row, column = np.unravel_index(int(clear.argmax()), clear.shape)
        return self._point(int(row), int(column)), float(clear.max()) * self.step_mm

    def away_from(self, number: int, taken: Sequence[Vector]) -> Vector:
        """The point of a part that is furthest from points that are taken already."""
        rows, columns = np.nonzero(self.numbers == number)
        uv = np.column_stack((columns, rows)) * self.step_mm + (np.array(self.corner_mm) + self.step_mm / 2)
        others = np.array([self.view.project(point) for point in taken]).reshape(-1, 1, 2)
        apart = np.linalg.norm(others - uv, axis=2).min(axis=0, initial=np.inf)
        n = int(apart.argmax())
        return self._point(int(rows[n]), int(columns[n]))

    def _point(self, row: int, column: int) -> Vector:
        u, v = (self.corner_mm[k] + (n + 0.5) * self.step_mm for k, n in enumerate((column, row)))
        r, up, toward = (np.array(d) for d in (self.view.right, self.view.up, self.view.toward))
        x, y, z = (float(c) for c in u * r + v * up + self.depth_mm[row, column] * toward)
        return x, y, z


class SeenBodies:
    """Bodies as points, which serve all sections that look the same way."""

    def __init__(self, bodies: Sequence[SeenBody], view: View) -> None:
        self._bodies, axes = bodies, np.array([view.right, view.up, view.toward])
        self._flat = flat = [body.corners_mm @ axes.T for body in bodies]
        self._low = np.min([f.min(axis=(0, 1)) for f in flat], axis=0)[:2]
        size = np.max([f.max(axis=(0, 1)) for f in flat], axis=0)[:2] - self._low
        self._step = float(size.max()) / _ACROSS
        self._columns, self._rows = (int(n) + 2 for n in size / self._step)
        self._middles = [(f[..., 2].min() + f[..., 2].max()) / 2 for f in flat]
        self._points = [self._on_grid(_sampled(f, self._step * _STEP)) for f in flat]

    def _on_grid(self, points: FloatArray) -> tuple[NDArray[np.int64], FloatArray]:
        column, row = ((points[:, :2] - self._low) / self._step).astype(np.int64).T
        return row * self._columns + column, points[:, 2]

    def sight(self, view: View, only: int | None = None) -> Sight:
        """What a view or a section shows, of one part if ``only`` that is there."""
        plane = _plane(view)
        nearest = np.full(self._rows * self._columns, -np.inf)
        numbers = np.full(len(nearest), NOTHING)
        for body, middle, (at, depth) in zip(self._bodies, self._middles, self._points, strict=True):
            if only not in (None, body.number) or (body.whole and middle > plane):
                continue
            kept = slice(None) if body.whole else depth <= plane
            own = np.full(len(nearest), -np.inf)
            np.maximum.at(own, at[kept], depth[kept])
            nearer = own > nearest
            nearest[nearer], numbers[nearer] = own[nearer], body.number
        shape = (self._rows, self._columns)
        corner = (float(self._low[0]), float(self._low[1]))
        return Sight(view, numbers.reshape(shape), self._step, corner, nearest.reshape(shape))

    def closer(self, seen: Sight, number: int) -> tuple[Vector, float] | None:
        """As :meth:`Sight.best`, by closer points round where the part comes nearest to the eye."""
        alone = self.sight(seen.view, number)
        there = alone.numbers == number
        if not there.any():
            return None
        behind = np.full(there.shape, np.inf)
        behind[there] = seen.depth_mm[there] - alone.depth_mm[there]
        row, column = np.unravel_index(int(behind.argmin()), behind.shape)
        side, plane = int(2 * _ROUND * _CLOSER), _plane(seen.view)
        step = seen.step_mm / _CLOSER
        low = self._low + (np.array([column, row]) + 0.5 - _ROUND) * seen.step_mm
        shape = (side, side)
        numbers, nearest = np.full(shape, NOTHING), np.full(shape, -np.inf)
        for body, middle, flat in zip(self._bodies, self._middles, self._flat, strict=True):
            if body.whole and middle > plane:
                continue
            own = _depths(flat, low, step, side, np.inf if body.whole else plane)
            nearer = own > nearest
            nearest[nearer], numbers[nearer] = own[nearer], body.number
        found = Sight(seen.view, numbers, step, (float(low[0]), float(low[1])), nearest).best(number)
        return found if found is not None and found[1] > _SEEN * step else None


def _plane(view: View) -> float:
    """How far along the way to the eye bodies are kept."""
    return np.inf if view.cut is None else float(np.dot(view.cut, view.toward)) + _AT_PLANE_MM


def _depths(corners: FloatArray, low: FloatArray, step: float, side: int, plane: float) -> FloatArray:
    """Depth (side, side) of the foremost triangle up to a plane at points ``step`` apart from ``low`` on; -inf at none.

    ``corners``: (m, 3, 3), of which the third coordinate is the depth.
    """
    high = low + side * step
    most, least = corners.max(axis=1), corners.min(axis=1)
    met = (most[:, :2] >= low).all(axis=1) & (least[:, :2] <= high).all(axis=1) & (least[:, 2] <= plane)
    depth = np.full((side, side), -np.inf)
    at = (np.arange(side) + 0.5) * step
    for a, b, c in corners[met]:
        d, e = b - a, c - a
        area = d[0] * e[1] - d[1] * e[0]
        if abs(area) < 1e-12:
            continue
        ends = np.array([a, b, c])[:, :2] - low
        (left, down), (right, top) = ends.min(axis=0), ends.max(axis=0)
        columns = slice(*np.searchsorted(at, (left, right)))
        rows = slice(*np.searchsorted(at, (down, top)))
        u, v = at[columns][None, :] + low[0] - a[0], at[rows][:, None] + low[1] - a[1]
        s, t = (u * e[1] - v * e[0]) / area, (v * d[0] - u * d[1]) / area
        # As in sampling: where two bodies touch, the one that is cut is seen.
        here = a[2] + s * d[2] + t * e[2] + (_TOUCH_MM if area < 0.0 else 0.0)
        inside = (s >= 0.0) & (t >= 0.0) & (s + t <= 1.0) & (here <= plane + _TOUCH_MM)
        np.maximum(depth[rows, columns], np.where(inside, here, -np.inf), out=depth[rows, columns])
    return depth


def _sampled(corners: FloatArray, step: float) -> FloatArray:
    """Points on triangles (m, 3, 3), (n, 3), no further apart than ``step`` in the first two coordinates."""
    lengths = np.linalg.norm(np.roll(corners, -1, axis=1)[..., :2] - corners[..., :2], axis=2)
    longest = lengths.argmax(axis=1)
    rows = np.arange(len(corners))
    a, b, c = (corners[rows, (longest + k) % 3] for k in range(3))
    along = np.ceil(lengths[rows, longest] / step).astype(np.int64) + 1
    d, e = (b - a)[:, :2], (c - a)[:, :2]
    area = np.abs(d[:, 0] * e[:, 1] - d[:, 1] * e[:, 0])
    high = np.ceil(area / np.maximum(lengths[rows, longest], 1e-12) / step).astype(np.int64) + 1
    count = along * high
    of = np.repeat(rows, count)
    n = np.arange(len(of)) - np.repeat(np.cumsum(count) - count, count)
    s = ((n % along[of]) / np.maximum(along[of] - 1, 1))[:, None]
    t = ((n // along[of]) / np.maximum(high[of] - 1, 1))[:, None]
    points: FloatArray = (1 - t) * (a[of] + s * (b - a)[of]) + t * c[of]
    # Where two bodies touch behind a section plane, the one that is left there is cut, and seen.
    inside = d[:, 0] * e[:, 1] < d[:, 1] * e[:, 0]
    points[:, 2] += np.where(inside, _TOUCH_MM, 0.0)[of]
    return points


@dataclass(frozen=True)
class Pointers:
    """Views of an assembly; by part a view and a point in it; the parts that no view shows."""

    views: tuple[View, ...]
    places: dict[int, tuple[str, Vector]]
    hidden: tuple[int, ...]


def pointers(bodies: Sequence[SeenBody], envelope: Box) -> Pointers:
    """Front and top, sections where those hide parts, else the left; where each part is seen best.

    A section is across X through the middle of a hidden part, where most of the hidden ones are seen. A part that no
    view shows has the point of the front view behind which it lies.
    """
    (left, _, low), (right, _, high) = envelope
    middle_x = (left + right) / 2
    front = View("front", minus(X), Z, axes=(((middle_x, 0.0, low), (middle_x, 0.0, high)),))
    top, side = View("top", minus(X), minus(Y), row=-1), View("left", Y, Z, column=1)
    numbers = sorted({body.number for body in bodies})
    scene, above = SeenBodies(bodies, front), SeenBodies(bodies, top)
    sights = [scene.sight(front), above.sight(top)]
    found = _pointed(sights, numbers)
    sections: list[View] = []
    aside = SeenBodies(bodies, side)
    while len(found) < len(numbers) and len(sections) < _MOST_SECTIONS:
        hidden = [body for body in bodies if body.number not in found]
        # Through what is turned, rather than through the screws beside it.
        cut_there = [body for body in hidden if not body.whole] or hidden
        ends = [(float(b.corners_mm[..., 0].min()), float(b.corners_mm[..., 0].max())) for b in cut_there]
        middles = {round(sum(pair) / 2, 2) + 0.0 for pair in ends}
        letter = "AB"[len(sections)]
        trials = []
        for x in sorted(middles, key=lambda x: (abs(x - middle_x), x))[:_MOST_PLACES]:
            cut = replace(side, name=f"section {letter}", column=len(sections) + 1, cut=(x, 0.0, 0.0))
            seen = aside.sight(replace(cut, title=f"{letter}-{letter}"))
            trials.append((len(_pointed([seen], {body.number for body in hidden})), seen))
        most, seen = max(trials, key=lambda trial: trial[0])
        if not most:
            break
        sections.append(seen.view)
        sights.append(seen)
        found = _pointed(sights, numbers)
    if not sections:
        sights.append(aside.sight(side))
        found = _pointed(sights, numbers)
    scenes = (scene, above, *[aside] * len(sights))
    for number in numbers:
        if number not in found:
            thin = ((of.closer(seen, number), seen) for of, seen in zip(scenes, sights, strict=False))
            found |= next(({number: (seen.view.name, at[0])} for at, seen in thin if at is not None), {})
    unseen = tuple(number for number in numbers if number not in found)
    for number in unseen:
        taken = [point for view, point in found.values() if view == front.name]
        found[number] = (front.name, scene.sight(front, number).away_from(number, taken))
    return Pointers((front, *(sections or [side]), top), found, unseen)


def _pointed(sights: Sequence[Sight], numbers: Iterable[int]) -> dict[int, tuple[str, Vector]]:
    """For each part the first view that shows it well, else the one that shows most of it, and the point there."""
    found: dict[int, tuple[str, Vector]] = {}
    for number in numbers:
        best = [(there[1], there[0], s) for s in sights if (there := s.best(number)) and there[1] > _SEEN * s.step_mm]
        if best:
            most = max(clear for clear, _, _ in best)
            _, at, where = next(b for b in best if b[0] >= min(most, _WELL_SEEN * b[2].step_mm))
            found[number] = (where.view.name, at)
    return found


def assembly_sheet(
    name: str, items: Sequence[Item], bodies: Sequence[SeenBody], envelope: Box, names: Mapping[str, str]
) -> Sheet:
    """Views, envelope, numbers and list of parts. ``bodies`` are numbered by :func:`numbers`; ``envelope``: box of the
    whole; ``names``: what to order, by part, where a standard says it. Each number points to where its part is seen."""
    rows = []
    for part, number in numbers(items).items():
        instances = [item for item in items if item.part == part]
        kind = instances[0].material.name if instances[0].kind == "made" else names.get(part, "bought")
        rows.append((str(number), part, str(len(instances)), kind))
    seen = pointers(bodies, envelope)
    (left, back, low), (right, front, high) = envelope
    return Sheet(
        part=name,
        title="Assembly",
        paper="A2",
        views=seen.views,
        dimensions=(
            Linear("front", (right, front, low), (left, front, low), right - left, "below"),
            Linear("front", (right, front, low), (right, front, high), high - low, "left"),
            Linear("top", (right, back, high), (right, front, high), front - back, "left"),
        ),
        labels=tuple(Label(*seen.places[int(row[0])], row[0], clear_mm=3.0, leader=True) for row in rows),
        cutting_lines=tuple(
            CuttingLine("front", (v.cut[0], 0.0, low), (v.cut[0], 0.0, high), v.title[0], minus(X))
            for v in seen.views
            if v.cut is not None
        ),
        tables=(Table("Parts", ("No.", "Part", "Pieces", "Material or standard"), tuple(rows)),),
        notes=(
            "Drum centred. Cables are not drawn; their lengths stand in the report.",
            "Order of assembly: see the report.",
            *([f"Hidden behind what is drawn: {', '.join(map(str, seen.hidden))}."] if seen.hidden else ()),
        ),
    )


def numbers(items: Sequence[Item]) -> dict[str, int]:
    """The number of each part, in the order of the bill."""
    return {part: number for number, part in enumerate(dict.fromkeys(item.part for item in items), 1)}
