"""Geometry that several checks share: gaps in a plane, the space that the drum sweeps, distances between cables."""

from collections.abc import Sequence
from itertools import combinations
from math import cos, hypot, radians, sin, sqrt
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from mbcdm_cad.checks.comparison import Findings, check
from mbcdm_cad.layouts.sector import SectorLayout
from mbcdm_cad.parts.drum_sector.dims import DrumDims
from mbcdm_cad.parts.drum_sector.sizes import nut_corner_radius_mm

Points = NDArray[np.float64]
# Metal between two drilled holes in solid plate, or between a hole and the part's edge (estimate).
HOLE_WEB_MM = 0.5


def corner_gap(x: float, z: float, wall_x: float, floor_z: float, radius: float) -> float:
    """Gap of the point (x, z) to a wall at ``wall_x`` and a floor at ``floor_z`` that meet in a corner of ``radius``.

    The pocket lies at smaller x and larger z. Negative: the point is inside the metal.
    """
    centre_x, centre_z = wall_x - radius, floor_z + radius
    if x > centre_x and z < centre_z:
        return radius - hypot(x - centre_x, z - centre_z)
    return min(wall_x - x, z - floor_z)


def inside_rounded_rectangle(u: float, v: float, half_width: float, low: float, high: float, radius: float) -> float:
    """Distance from (u, v) to the edge of the rectangle |u| <= half_width, low <= v <= high; negative outside."""
    u = abs(u)
    nearest_v = min(v - low, high - v)
    across, along = half_width - u, nearest_v
    if across < radius and along < radius:
        return radius - hypot(radius - across, radius - along)
    return min(across, along)


def box_gap(first: Points, second: Points) -> float:
    """Distance between the boxes of two polygons (n, 2): no less than theirs, and quickly computed."""
    apart = np.maximum(first.min(axis=0) - second.max(axis=0), second.min(axis=0) - first.max(axis=0))
    return float(np.hypot(*np.maximum(apart, 0.0)))


def polygon_gap(first: Points, second: Points) -> float:
    """Distance between two convex polygons (n, 2); 0 where they overlap or touch."""
    for polygon in (first, second):
        edges = np.roll(polygon, -1, axis=0) - polygon
        normals = np.array([edges[:, 1], -edges[:, 0]])
        a, b = first @ normals, second @ normals
        if ((a.max(axis=0) < b.min(axis=0)) | (b.max(axis=0) < a.min(axis=0))).any():
            return min(_vertex_gap(first, second), _vertex_gap(second, first))
    return 0.0


def _vertex_gap(points: Points, polygon: Points) -> float:
    along, away = np.roll(polygon, -1, axis=0) - polygon, points[:, None] - polygon
    squared = np.maximum(np.einsum("jk,jk->j", along, along), 1e-30)
    t = np.clip(np.einsum("ijk,jk->ij", away, along) / squared, 0.0, 1.0)
    return float(np.linalg.norm(away - t[:, :, None] * along, axis=2).min())


def web_between(holes: Sequence[tuple[str, float, float, float, float, float]]) -> list[tuple[str, float]]:
    """Wall between round holes (name, u, v, radius, from, to) whose depths overlap, for every pair."""
    found = []
    for i, (name, u, v, r, low, high) in enumerate(holes):
        for other, ou, ov, other_r, other_low, other_high in holes[i + 1 :]:
            if min(high, other_high) > max(low, other_low) and (u, v) != (ou, ov):
                found.append((f"{name} to {other}", hypot(u - ou, v - ov) - r - other_r))
    return found


# Grid of the rim: 0.1 mm and finer near the outside of the reference design, 0.3 mm along it.
_RADII = 40
_ANGLES = 160


class Ring(NamedTuple):
    """A zone of the drum: radii from the Y axis, the lowest y in it, and how far up it reaches.

    ``top``: largest z over the travel. A terminal's stud runs along the tangent, down from its cable's end, so that
    only its sides stand over the cable's radius while some wrap is left.
    """

    name: str
    inner: float
    outer: float
    y: float
    top: float


def rim_points(d: DrumDims) -> np.ndarray:
    """(x, z) of the rim where no pocket that goes through it takes the metal, on a grid near its edges."""
    outer = d.lands[-1].surface_radius_mm
    # Fine near the outside, which determines the box.
    radii = outer - (outer - d.rim_inner_radius) * np.linspace(0.0, 1.0, _RADII) ** 2
    half = radians(d.half_angle_deg)
    # Widest at the ends or, on a sector of more than half a turn, at right angles to Z.
    side = np.linspace(half / 2, half, _ANGLES)
    side = np.append(side, min(half, np.pi / 2))
    angles = np.concatenate([-side, [0.0], side])
    x = np.multiply.outer(radii, np.sin(angles))
    z = np.multiply.outer(radii, np.cos(angles))
    kept = np.ones_like(x, dtype=bool)
    for t in d.tensioners:
        if t.cut_through:
            sine, cosine = sin(t.anchor_rad), cos(t.anchor_rad)
            out = t.side * x * sine + z * cosine - t.radius_mm
            along = t.side * x * cosine - z * sine
            floor = np.where(along > t.lug_end, -d.nut_pocket, -d.flat_wall)
            kept &= ~((along > t.slack_start) & (along < t.pocket_end) & (out > floor))
    return np.stack([x[kept], z[kept]], axis=1)


def wrap_points(d: DrumDims, flank_mm: float) -> np.ndarray:
    """(x, z) of the outside of the cables on the drum, from the top to the anchors: it may overhang the rim."""
    share = np.linspace(0.0, 1.0, _ANGLES)
    return np.concatenate(
        [
            (t.radius_mm + flank_mm)
            * np.stack([t.side * np.sin(t.anchor_rad * share), np.cos(t.anchor_rad * share)], axis=1)
            for t in d.tensioners
        ]
    )


def drum_zones(s: SectorLayout) -> list[Ring]:
    """Rings that together enclose everything that turns with the drum in front of the frame."""
    d = s.drum
    spec = s.drive.tensioner
    half = max(nut_corner_radius_mm(s.drive), d.lug_half_width, spec.swage_diameter_mm / 2)
    zones = [
        _disc("drum's rim", d.rim_inner_radius, d.lands[-1].surface_radius_mm, d.lands[0].y_start),
        _disc("drum's web", d.spigot_radius, d.rim_inner_radius, d.web_start_y),
        _disc("drum's hub", 0.0, d.hub_radius, d.spigot_y),
    ]
    for t in d.tensioners:
        name = f"terminal of {t.cable_name}"
        below = max(half, d.lug_root(t))
        top = t.radius_mm + half
        zones.append(Ring(name, t.radius_mm - below, hypot(top, t.last_tip), t.y_mm - half, top))
    for c in s.steps:
        radii = (c.drum_radius_mm - s.flank_mm, c.drum_radius_mm + s.flank_mm)
        zones.append(_disc(f"{c.name} on the drum", *radii, c.land_y_mm - s.flank_mm))
    return zones


def _disc(name: str, inner: float, outer: float, y: float) -> Ring:
    return Ring(name, inner, outer, y, outer)


@check("Drum clears the frame", "clearances.running_mm", advice="choose a smaller drum.tensioner")
def frame_front(s: SectorLayout) -> Findings:
    """Gap from all parts that turn with the drum to frame and boss behind them."""
    v, running = s.levels, s.drive.clearances.running_mm
    for ring in drum_zones(s):
        if ring.name != "drum's hub":
            yield f"{ring.name} from the front of the {s.frame_name}", ring.y - v.front_y, running
            if ring.inner < s.frame.boss.radius:
                yield f"{ring.name} from the front of the boss", ring.y - v.boss_front_y, running
    yield "hub from the front of the boss", s.drum.hub_start_y - v.boss_front_y, running


# Gap between a cable's flank and a wall or another cable that it must not rub on (estimate).
CABLE_GAP_MM = 0.1
_SAMPLE_MM = 1.0
_MOST_SAMPLES = 500
# Samples in a piece of a line: pieces so short that only few of them are near each other.
_PIECE = 8


def step_mm(s: SectorLayout) -> float:
    """Sampling step along cables, mm: it grows with the design, so that a large design does not take long."""
    longest = max(path.length_mm for _, paths in s.extreme_paths for path in paths)
    return max(_SAMPLE_MM, longest / _MOST_SAMPLES)


def sampled(s: SectorLayout) -> list[tuple[float, list[np.ndarray]]]:
    """(drum angle in deg, points of every cable) at centre and both ends of travel."""
    step = step_mm(s)
    return [(float(np.degrees(angle)), [path.sample(step) for path in paths]) for angle, paths in s.extreme_paths]


class Sampled(NamedTuple):
    """Points (n, 3) of a line in short pieces of equal length (the last filled up with its last point), and of each
    piece the sphere that encloses it."""

    pieces: np.ndarray
    centre: np.ndarray
    radius: np.ndarray


def in_pieces(points: np.ndarray) -> Sampled:
    """The points of a line, ready for :func:`nearest_mm`."""
    short = -len(points) % _PIECE
    pieces = np.concatenate([points, np.repeat(points[-1:], short, axis=0)]).reshape(-1, _PIECE, 3)
    centre = pieces.mean(axis=1)
    return Sampled(pieces, centre, np.sqrt(_squared(pieces - centre[:, None]).max(axis=1)))


def nearest_mm(a: Sampled, b: Sampled, step: float) -> float:
    """Lower bound of the distance, mm, between two lines sampled every ``step``, the parts between samples included.

    Only points of pieces whose enclosing spheres are near enough are compared: at most a twentieth of all pairs.
    """
    between = np.sqrt(_squared(a.centre[:, None] - b.centre[None, :]))
    reach = a.radius[:, None] + b.radius[None, :]
    # The small share is for rounding.
    first, second = np.nonzero(between - reach <= (between + reach).min() * (1.0 + 1e-9))
    squared = float(_squared(a.pieces[first][:, :, None, :] - b.pieces[second][:, None, :, :]).min())
    return sqrt(max(squared - step**2 / 2, 0.0))


def _squared(vectors: np.ndarray) -> np.ndarray:
    return np.asarray(np.einsum("...x,...x->...", vectors, vectors))


@check("Gaps between cables", "derived; 0.1 mm: estimate")
def cables_apart(s: SectorLayout) -> Findings:
    """Gap between different cables with the drum centred and at both ends of travel."""
    d, step, names = s.drive.cable.diameter_mm, step_mm(s), [c.name for c in s.drive.cables]
    for angle, lines in s.once("sampled", sampled):
        for (i, first), (j, second) in combinations(enumerate(map(in_pieces, lines)), 2):
            what = f"gap of {names[i]} and {names[j]} with the drum at {angle:+.4g} deg"
            yield what, nearest_mm(first, second, step) - d, CABLE_GAP_MM
