"""A frame as flat panels on one coarse grid of plate elements, and its deflection under forces on its seats.

Only the half x >= 0 is meshed. Panels lie at mid-thickness and meet at their middle planes.

Each element is a four-node plate parallel to two axes: in its plane bilinear with two bending modes condensed out, out
of it Reissner-Mindlin with assumed shear strains, so that neither thin nor stubby plates lock. Six freedoms a node,
shared by all plates that meet there. Units: mm, N, MPa, rad.
"""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise
from math import pi, sqrt

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from mbcdm_cad.design.bought import Material
from mbcdm_cad.model.structure import quadrilateral
from mbcdm_cad.routes import Floats

# Couples the rotation about a plate's normal to its in-plane rotation: a share of G that keeps the matrix regular.
# Between 0.001 and 1 the windup of the reference frame changes by less than 2 %.
_DRILLING = 0.1


@dataclass(frozen=True, eq=False)
class Plates:
    """Elements: corner nodes (n, 4) counted from the lower corner anticlockwise in (u, v), axis of the normal,
    thickness and the panel each belongs to. All panels share the planes of one grid."""

    node_mm: Floats
    corner: quadrilateral.Ints
    normal: quadrilateral.Ints
    thickness_mm: Floats
    panel: quadrilateral.Ints


def stiffness(sides_mm: Floats, thickness_mm: Floats, modulus_MPa: float, poisson: float) -> Floats:
    """Stiffness (n, 24, 24) of plates with sides (n, 2), freedoms of a corner in the order (u, v, n, turn u, v, n).

    The rotation about the normal is coupled to that of the plate in its own plane.
    """
    count = len(sides_mm)
    corner = np.arange(4 * count).reshape(count, 4)
    node = (sides_mm[:, None] * (quadrilateral.CORNERS + 1.0) / 2.0).reshape(-1, 2)
    body = node, corner, thickness_mm, modulus_MPa, poisson
    freedom = np.arange(24).reshape(4, 6)
    in_plane = freedom[:, :2].ravel()
    # Fibres lean with the corner: u moves by + turn v, v by - turn u, for each mm along the normal.
    leaning, sign = freedom[:, [2, 4, 3]].ravel(), np.tile([1.0, 1.0, -1.0], 4)
    whole = np.zeros((count, 24, 24))
    whole[:, in_plane[:, None], in_plane] = quadrilateral.elements(*body).stiffness
    whole[:, leaning[:, None], leaning] = quadrilateral.plate_elements(*body).stiffness * np.outer(sign, sign)
    at = quadrilateral.jacobian(node[corner], quadrilateral.GAUSS)
    turn = np.zeros((count, 4, 24))
    turn[:, :, 1::6], turn[:, :, 0::6], turn[:, :, 5::6] = (
        at.gradient_x / 2.0,
        -at.gradient_y / 2.0,
        -quadrilateral.AT_GAUSS,
    )
    drilling = modulus_MPa / (2.0 * (1.0 + poisson)) * _DRILLING * thickness_mm[:, None] * at.det
    return np.asarray(whole + turn.transpose(0, 2, 1) @ (turn * drilling[:, :, None]))


def freedoms(plates: Plates) -> quadrilateral.Ints:
    """Global freedoms (n, 24) of each element: 6 node + (x, y, z, turn x, y, z)."""
    # (u, v, n) is a cyclic turn of (x, y, z).
    axes = (plates.normal[:, None] + np.array([1, 2, 0])) % 3
    local = np.concatenate([axes, axes + 3], axis=1)
    return np.asarray((6 * plates.corner[:, :, None] + local[:, None, :]).reshape(len(axes), 24))


def sides(plates: Plates) -> Floats:
    """Lengths (n, 2) of each element along its u and v."""
    diagonal = plates.node_mm[plates.corner[:, 2]] - plates.node_mm[plates.corner[:, 0]]
    axes = (plates.normal[:, None] + np.array([1, 2])) % 3
    return np.take_along_axis(diagonal, axes, axis=1)


def solve(plates: Plates, element: Floats, held: NDArray[np.bool_], ground: Floats, load: Floats) -> Floats:
    """Displacements (6 m,) under ``load`` (6 m,); ``held`` freedoms stay zero, ``ground`` are springs to the base.

    Raises ``numpy.linalg.LinAlgError`` if the plates are not held.
    """
    free, where = ~held, freedoms(plates)
    row, column = np.broadcast_arrays(where[:, :, None], where[:, None, :])
    whole = sparse.coo_array((element.ravel(), (row.ravel(), column.ravel())), shape=(len(load),) * 2).tocsc()
    whole = (whole + sparse.diags_array(ground, format="csc"))[free][:, free]
    # Pivots of the diagonal in the order of least degree: Cholesky's, a fourth of the time that a band takes.
    options = {"diag_pivot_thresh": 0.0, "options": {"SymmetricMode": True}}
    displacement = np.zeros(len(load))
    try:
        with quadrilateral.linear_algebra().limit(limits=1, user_api="blas"):
            factors = sparse.linalg.splu(whole, "MMD_AT_PLUS_A", **options)
    except RuntimeError:
        raise np.linalg.LinAlgError("a pivot is zero") from None
    if not (factors.U.diagonal() > 0.0).all():
        raise np.linalg.LinAlgError("the plates are not held")
    displacement[free] = factors.solve(load[free])
    return displacement


# Elements longer than this are split. Elements of 3 mm raise the reference frame's windup by 3 % and cost five times as
# long.
CELL_MM = 12.0
# Grid lines closer than this are merged.
MERGED_MM = 1.0
# Factor on the thickness of a wall where it lies inside or along another wall, so that the walls of the column bend
# only between the faces. The metal there is about this many times as thick as the wall; with a factor of 3 the windup
# of the reference frame rises by 4 %, with 10 it falls by 6 %.
EMBEDDED = 5.0
# A cell of which a hole leaves less than this share is left out.
EMPTY = 0.05
X, Y, Z = 0, 1, 2
GPA_TO_MPA = 1e3
# Frames whose solution is kept: sizing, the search that asked for it and the checks meet the same one.
KEPT = 64
# N mm of work per (N m)^2 is a compliance in mrad per N m.
URAD_PER_MRAD = 1e3
_solved: dict[tuple[object, ...], dict[str, float]] = {}


@dataclass(frozen=True)
class Hole:
    """A hole in a panel: its middle on the two in-plane axes (in the order x, y, z) and its volume.

    ``aspect``: its length along the second of these axes over that along the first.
    """

    u: float
    v: float
    volume_mm3: float
    aspect: float = 1.0


@dataclass(frozen=True)
class Wall:
    """A wall: axis of its normal, position along it, its box on the other two axes (order x, y, z), thickness."""

    name: str
    normal: int
    at: float
    box: tuple[tuple[float, float], tuple[float, float]]
    thickness_mm: float
    holes: tuple[Hole, ...] = ()
    embedded: tuple[tuple[int, float, float], ...] = ()  # (axis, from, to): inside another wall
    share: float = 1.0  # 0.5 for a panel that the mirror plane halves

    @property
    def axes(self) -> tuple[int, int]:
        """The two in-plane axes in the order x, y, z."""
        u, v = (a for a in (X, Y, Z) if a != self.normal)
        return u, v

    def half_sides_mm(self, hole: Hole) -> tuple[float, float]:
        """Half the sides of the square, or of the rectangle of this aspect, that has the hole's mean area."""
        half = sqrt(hole.volume_mm3 / self.thickness_mm / hole.aspect) / 2.0
        return half, half * hole.aspect


@dataclass(frozen=True, eq=False)
class PlateMesh:
    """Plates with their grid. ``names`` are the panels, ``weight`` (n,) is 0.5 for halved elements."""

    plates: Plates
    names: tuple[str, ...]
    weight: Floats
    mounted: tuple[quadrilateral.Ints, ...]  # nodes under the head of each mounting screw of this half
    middle: NDArray[np.bool_]  # (m,) nodes in the mirror plane

    def near(self, panel: str, point: Iterable[float], reach: tuple[float, float, float]) -> quadrilateral.Ints:
        """Nodes of a panel within ``reach`` of ``point`` on each axis."""
        own = np.unique(self.plates.corner[self.plates.panel == self.names.index(panel)])
        off = np.abs(self.plates.node_mm[own] - np.array(tuple(point)))
        found = own[(off <= np.array(reach) + 1e-6).all(axis=1)]
        if not found.size:
            raise ValueError(
                f"frame: the {panel} has no metal at {tuple(round(float(c), 2) for c in point)} mm to carry its load"
            )
        return np.asarray(found)


@dataclass(frozen=True)
class Mounts:
    """Screws that hold the back plate from behind: (x, z) of each, radii of head and hole, thickness under the head.

    ``back_y_mm``: middle of that plate along Y; left out, it is the rearmost wall.
    """

    places: Sequence[tuple[float, float]]
    head_radius: float
    hole_radius: float
    plate_mm: float
    back_y_mm: float | None = None

    @property
    def pad_mm(self) -> float:
        """Half the side of the square whose corners replace the ring under a screw's head.

        That is the ring's radius of gyration about a diameter, sqrt(R^2 + r^2) / 2: four points there have its area and
        its second moment.
        """
        return sqrt(self.head_radius**2 + self.hole_radius**2) / 2.0

    def springs(self, mesh: PlateMesh, material: Material) -> Floats:
        """Springs (6 m,) to the base: from the ring held under a screw's head up to the middle of the plate.

        The load spreads in the plate as a cone of 30 degrees, the usual one for screwed joints, so that the layer's
        area is pi ((R + z tan 30)^2 - r^2) at height z; its flexibility is the integral of 1 / (modulus x area).
        """
        outer, hole, slope = self.head_radius, self.hole_radius, np.tan(pi / 6)
        above = outer + slope * self.plate_mm / 2
        spread = (above - hole) * (outer + hole) / ((above + hole) * (outer - hole))
        depth_over_area = np.log(spread) / (2.0 * pi * hole * slope)
        normal = material.youngs_modulus_GPa * GPA_TO_MPA / depth_over_area
        sliding = normal / (2.0 * (1.0 + material.poisson_ratio))
        springs = np.zeros((len(mesh.plates.node_mm), 6))
        for nodes in mesh.mounted:
            # Four points replace the ring; of a screw in the mirror plane two are in this half.
            springs[nodes, :3] = np.array([sliding, normal, sliding]) / 4.0
        return springs.ravel()


def _lines(wished: Iterable[float], low: float, high: float) -> Floats:
    """Grid lines through ``wished`` (the earlier one where two are close) and the ends, at most CELL_MM apart."""
    kept = [low, high]
    for p in wished:
        if low < p < high and min(abs(p - q) for q in kept) > MERGED_MM:
            kept.append(p)
    kept.sort()
    pieces = [np.linspace(a, b, max(1, round((b - a) / CELL_MM)) + 1)[1:] for a, b in pairwise(kept)]
    return np.concatenate([[kept[0]], *pieces])


def _wished(walls: list[Wall], mounts: Mounts) -> Iterator[tuple[int, float]]:
    for wall in walls:
        yield wall.normal, wall.at
        for axis, span in zip(wall.axes, wall.box, strict=True):
            yield axis, span[0]
            yield axis, span[1]
    pad = mounts.pad_mm
    for x, z in mounts.places:
        for d in (-pad, pad):
            yield X, x + d
            yield Z, z + d
    for wall in walls:
        for axis, low, high in wall.embedded:
            yield axis, low
            yield axis, high
    for wall in walls:
        for hole in wall.holes:
            half_u, half_v = wall.half_sides_mm(hole)
            for sign in (-1, 1):
                yield wall.axes[0], hole.u + sign * half_u
                yield wall.axes[1], hole.v + sign * half_v
    yield Y, 0.0


def _thickness(wall: Wall, u: Floats, v: Floats) -> Floats:
    """Thickness (n_u, n_v) of the cells between the lines ``u`` and ``v``."""
    middle = ((u[:-1] + u[1:]) / 2, (v[:-1] + v[1:]) / 2)
    thickness = np.full((len(u) - 1, len(v) - 1), wall.thickness_mm)
    for axis, low, high in wall.embedded:
        inside = (middle[wall.axes.index(axis)] > low) & (middle[wall.axes.index(axis)] < high)
        thickness[inside if axis == wall.axes[0] else (slice(None), inside)] = EMBEDDED * wall.thickness_mm
    area = np.outer(np.diff(u), np.diff(v))
    for hole in wall.holes:
        half_u, half_v = wall.half_sides_mm(hole)
        cells = np.ix_(np.abs(middle[0] - hole.u) < half_u, np.abs(middle[1] - hole.v) < half_v)
        if area[cells].size:
            thickness[cells] = np.maximum(0.0, thickness[cells] - hole.volume_mm3 / area[cells].sum())
    return thickness


def plate_mesh(walls: list[Wall], mounts: Mounts) -> PlateMesh:
    """Panels cut into elements along one common grid. Panels without extent in this design are left out.

    Raises ``ValueError`` if a wall has no thickness, or a mounting screw no back plate.
    """
    thin = [f"{wall.name} {wall.thickness_mm:.3g} mm" for wall in walls if not wall.thickness_mm > 0.0]
    if thin:
        raise ValueError(f"frame: walls must have a thickness above 0, got {', '.join(thin)}")
    found = list(_wished(walls, mounts))
    own = [[p for a, p in found[: 5 * len(walls)] if a == k] for k in (X, Y, Z)]
    lines = tuple(_lines((p for a, p in found if a == k), min(own[k]), max(own[k])) for k in (X, Y, Z))

    def index(axis: int, at: float) -> int:
        return int(np.argmin(np.abs(lines[axis] - at)))

    corners, normals, thicknesses, owners, weights = [], [], [], [], []
    shape = tuple(len(line) for line in lines)
    for number, wall in enumerate(walls):
        a, b = wall.axes
        span = [(index(axis, low), index(axis, high)) for axis, (low, high) in zip(wall.axes, wall.box, strict=True)]
        (a0, a1), (b0, b1) = span
        if a1 <= a0 or b1 <= b0:
            continue
        thickness = _thickness(wall, lines[a][a0 : a1 + 1], lines[b][b0 : b1 + 1])
        i, j = np.nonzero(thickness > EMPTY * wall.thickness_mm)
        # Element axes are the cyclic successors of the normal: for a normal along y that is (z, x).
        turn = ((0, 0), (1, 0), (1, 1), (0, 1)) if wall.normal != Y else ((0, 0), (0, 1), (1, 1), (1, 0))
        grid = np.empty((3, len(i), 4), dtype=np.int64)
        grid[wall.normal] = index(wall.normal, wall.at)
        grid[a] = a0 + i[:, None] + np.array([p for p, _ in turn])
        grid[b] = b0 + j[:, None] + np.array([q for _, q in turn])
        corners.append(np.ravel_multi_index(tuple(grid), shape))
        thicknesses.append(thickness[i, j])
        normals.append(np.full(len(i), wall.normal))
        owners.append(np.full(len(i), number))
        weights.append(np.full(len(i), wall.share))
    used, corner = np.unique(np.concatenate(corners), return_inverse=True)
    where = np.unravel_index(used, shape)
    node = np.stack([lines[k][where[k]] for k in (X, Y, Z)], axis=1)
    back = where[Y] == (0 if mounts.back_y_mm is None else index(Y, mounts.back_y_mm))
    mounted = []
    pad = mounts.pad_mm
    for x, z in mounts.places:
        if x > -pad:
            columns = [index(X, p) for p in (x - pad, x + pad) if p > 0.0]
            levels = [index(Z, p) for p in (z - pad, z + pad)]
            mounted.append(np.flatnonzero(back & np.isin(where[X], columns) & np.isin(where[Z], levels)))
            if not mounted[-1].size:
                raise ValueError(f"frame: no back plate under the mounting screw at x {x:.3g}, z {z:.3g} mm")
    plates = Plates(
        node, corner.reshape(-1, 4), np.concatenate(normals), np.concatenate(thicknesses), np.concatenate(owners)
    )
    return PlateMesh(plates, tuple(w.name for w in walls), np.concatenate(weights), tuple(mounted), where[X] == 0)


def statically(points: Floats, at: Floats, force: Floats, moment: Floats) -> Floats:
    """Forces (n, 3) on nodes that have the given resultant at ``at``, the least in sum of squares."""
    off = points - at
    wrench = np.zeros((6, len(points), 3))
    wrench[:3] = np.eye(3)[:, None, :]
    wrench[3:] = np.cross(np.eye(3)[:, None, :], off)
    rows = wrench.reshape(6, -1)
    return np.asarray(np.linalg.lstsq(rows, np.concatenate([force, moment]), rcond=None)[0].reshape(-1, 3))


def centred_load(
    mesh: PlateMesh,
    nodes: quadrilateral.Ints,
    point: Floats,
    force_x: float,
    couple_z: float = 0.0,
    couple_y: float = 0.0,
    force_z: float = 0.0,
) -> Floats:
    """Forces (n, 3) on ``nodes`` of this half by a force along x, couples about z and y (N mm), in the mirror plane.

    Or by a force along z, alone, for :func:`pulled`.
    """
    node = mesh.plates.node_mm
    off_plane = nodes[~mesh.middle[nodes]]
    both = np.concatenate([node[nodes], node[off_plane] * (-1.0, 1.0, 1.0)])
    spread = statically(both, point, np.array([force_x, 0.0, force_z]), np.array([0.0, couple_y, couple_z]))[
        : len(nodes)
    ]
    # Half of the force on a node in the mirror plane belongs to each side.
    return np.asarray(spread * np.where(mesh.middle[nodes], 0.5, 1.0)[:, None])


def shares_urad(mesh: PlateMesh, material: Material, load: Floats, ground: Floats) -> dict[str, float]:
    """f . u of each panel and of the mounts under ``load`` (6 m,) on this half, for the whole frame, in N mm x 1e3.

    With the forces of a load of 1 N m this is the rotation of the loaded body by the strain of each, in urad per N m.
    Raises ``ValueError`` if the walls are not connected.
    """
    p = mesh.plates
    arrays = (p.node_mm, p.corner, p.normal, p.thickness_mm, p.panel, mesh.weight, mesh.middle, load, ground)
    asked = (*(array.tobytes() for array in arrays), mesh.names, material)
    if asked not in _solved:
        if len(_solved) == KEPT:
            _solved.clear()
        _solved[asked] = _shares_urad(mesh, material, load, ground)
    return dict(_solved[asked])


def _shares_urad(mesh: PlateMesh, material: Material, load: Floats, ground: Floats) -> dict[str, float]:
    plates = mesh.plates
    # A field that changes sign in the mirror: u_y, u_z and the turn about x vanish in its plane.
    displacement, element = _moved(mesh, material, load, ground, (1, 2, 3))
    local = displacement[freedoms(plates)]
    work = 2.0 * ((element @ local[:, :, None])[:, :, 0] * local).sum(axis=1)
    by_panel = np.bincount(plates.panel, work, len(mesh.names))
    shares = {name: float(w) * URAD_PER_MRAD for name, w in zip(mesh.names, by_panel, strict=True)}
    shares["mounts"] = 2.0 * float(ground @ displacement**2) * URAD_PER_MRAD
    return shares


def pulled(mesh: PlateMesh, material: Material, load: Floats, ground: Floats) -> Floats:
    """Displacements and turns (m, 6) of the nodes under a load (6 m,) on this half that both halves bear alike.

    Raises ``ValueError`` if the walls are not connected.
    """
    # A field that is its own mirror image: u_x and the turns about y and z vanish in the mirror plane.
    return _moved(mesh, material, load, ground, (0, 4, 5))[0].reshape(-1, 6)


def _moved(
    mesh: PlateMesh, material: Material, load: Floats, ground: Floats, held_middle: tuple[int, int, int]
) -> tuple[Floats, Floats]:
    """Displacements (6 m,), and the stiffness of the elements; ``held_middle``: freedoms held in the mirror plane."""
    plates = mesh.plates
    modulus = material.youngs_modulus_GPa * GPA_TO_MPA
    # Many elements are identical, so each different stiffness matrix is computed once.
    shape = np.column_stack([sides(plates), plates.thickness_mm])
    kinds, kind = np.unique(shape.round(9), axis=0, return_inverse=True)
    unlike = stiffness(kinds[:, :2], kinds[:, 2], modulus, material.poisson_ratio)
    element = unlike[kind.ravel()] * mesh.weight[:, None, None]
    held = np.zeros((len(plates.node_mm), 6), dtype=bool)
    held[np.ix_(mesh.middle, np.array(held_middle))] = True
    try:
        return solve(plates, element, held.ravel(), ground, load), element
    except np.linalg.LinAlgError:
        raise ValueError("frame: its walls are hardly connected, so their deflection cannot be computed") from None
