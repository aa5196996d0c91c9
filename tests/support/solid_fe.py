"""Solid finite elements of drawn parts: their STEP meshed by gmsh, quadratic tetrahedra of scikit-fem.

Solved by conjugate gradients, preconditioned by the linear elements of the same mesh, solved directly, and by the
blocks of the single nodes. Shares nothing with the package but the parts' STEP files. Units: mm, N, MPa.
"""

import signal
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import gmsh
import numpy as np
import scipy.sparse as sp
import scipy.sparse.linalg as spla
from numpy.typing import NDArray
from skfem import Basis, BilinearForm, ElementTetP2, ElementVector, FacetBasis, Functional, LinearForm, MeshTet
from skfem.models.elasticity import lame_parameters

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
# Above this number of tetrahedra the mesh is made coarser.
MOST_TETS = 60_000
COARSER = 1.25
# Radial springs that stand for a rigid guide, N/mm a node: far above those of any part here.
RIGID_N_MM = 1e9
# Residual over the load at which the solution stops: the work of the load is then known to some 1e-9.
RESIDUAL, MOST_ROUNDS = 1e-6, 3000


@dataclass(frozen=True)
class Disc:
    """A disc whose edge is imprinted on the solids, so that facets end there."""

    centre_mm: tuple[float, float, float]
    normal: tuple[float, float, float]
    radius_mm: float


def tetrahedra(
    step: Path | Sequence[Path],
    size_mm: float,
    least_mm: float = 0.3,
    discs: Sequence[Disc] = (),
    most: int = MOST_TETS,
) -> MeshTet:
    """Tetrahedra of at most about ``size_mm``; smaller on curved faces, eight for a full turn.

    Several solids that touch are bonded there.
    """
    steps = [step] if isinstance(step, Path) else step
    gmsh.initialize(interruptible=False)
    # gmsh gives a broken pipe back its default, which ends the process: later tests write to workers that were killed.
    signal.signal(signal.SIGPIPE, signal.SIG_IGN)
    try:
        gmsh.option.setNumber("General.Terminal", 0)
        gmsh.option.setNumber("General.NumThreads", 1)
        solids = [solid for path in steps for solid in gmsh.model.occ.importShapes(str(path))]
        plates = [
            (2, gmsh.model.occ.addDisk(*d.centre_mm, d.radius_mm, d.radius_mm, zAxis=list(d.normal))) for d in discs
        ]
        if len(solids) > 1 or plates:
            gmsh.model.occ.fragment(solids, plates)
        gmsh.model.occ.synchronize()
        settings = {"MeshSizeMin": least_mm, "MeshSizeFromCurvature": 8, "Algorithm3D": 10}
        for name, value in settings.items():
            gmsh.option.setNumber(f"Mesh.{name}", value)
        corner = np.empty((0, 4), dtype=np.int64)
        while True:
            gmsh.option.setNumber("Mesh.MeshSizeMax", size_mm)
            try:
                gmsh.model.mesh.generate(3)
            except Exception:  # gmsh has no class of its own
                # Coarse triangles of two faces may cross beside an edge of some micrometres: the finer mesh is kept.
                if len(corner):
                    break
                raise
            tags, places, _ = gmsh.model.mesh.getNodes()
            kinds, _, corners = gmsh.model.mesh.getElements(3)
            corner = corners[list(kinds).index(4)].reshape(-1, 4)
            if len(corner) <= most or least_mm > size_mm:
                break
            size_mm, least_mm = size_mm * COARSER, least_mm * COARSER
            gmsh.option.setNumber("Mesh.MeshSizeMin", least_mm)
            gmsh.model.mesh.clear()
    finally:
        gmsh.finalize()
    number = np.zeros(int(tags.max()) + 1, dtype=np.int64)
    number[tags] = np.arange(len(tags))
    used, inverse = np.unique(corner, return_inverse=True)
    return MeshTet(places.reshape(-1, 3)[number[used]].T.copy(), inverse.reshape(-1, 4).T.copy())


@dataclass(eq=False)
class Solid:
    """A meshed part: its stiffness, and the place (3, n) and direction (n,) of each freedom."""

    mesh: MeshTet
    modulus_MPa: float
    poisson: float

    def __post_init__(self) -> None:
        self.basis = Basis(self.mesh, ElementVector(ElementTetP2()), intorder=2)
        self.stiffness = self._assembled()
        self.place = self.basis.doflocs
        self.direction = np.zeros(self.place.shape[1], dtype=np.int64)
        for axis in range(3):
            self.direction[self.basis.nodal_dofs[axis]] = axis
            self.direction[self.basis.edge_dofs[axis]] = axis
        bounding = np.zeros(self.mesh.facets.shape[1], dtype=bool)
        bounding[self.mesh.boundary_facets()] = True
        self.bounding = bounding

    def _assembled(self) -> sp.csr_matrix:
        """Elasticity from the nine products of the shapes' derivatives: all blocks of nodes have one pattern."""
        scalar = Basis(self.mesh, ElementTetP2(), intorder=2)
        products, n = {}, scalar.N
        for a in range(3):
            for b in range(a, 3):
                found = BilinearForm(lambda u, v, _, a=a, b=b: u.grad[b] * v.grad[a]).coo_data(scalar)
                products[a, b] = found.data
        row, column = found.indices
        order = np.lexsort((column, row))
        row, column = row[order], column[order]
        first = np.flatnonzero(np.append(True, (np.diff(row) > 0) | (np.diff(column) > 0)))
        row, column = row[first], column[first]
        products = {key: np.add.reduceat(data[order], first) for key, data in products.items()}
        mirror = np.lexsort((row, column))
        products |= {(b, a): data[mirror] for (a, b), data in products.items() if a != b}
        lam, mu = lame_parameters(self.modulus_MPa, self.poisson)
        block = np.empty((len(first), 3, 3))
        whole = mu * sum(products[a, a] for a in range(3))
        for a in range(3):
            for b in range(3):
                block[:, a, b] = lam * products[a, b] + mu * products[b, a] + (whole if a == b else 0.0)
        start = np.append(0, np.cumsum(np.bincount(row, minlength=n)))
        return sp.bsr_matrix((block, column, start), shape=(3 * n, 3 * n)).tocsr()

    def facets(self, on: Callable[[Floats], NDArray[np.bool_]]) -> Ints:
        """Facets of the surface with all corners (3, 3, n) where ``on`` of (3, n) says so."""
        corners = self.mesh.p[:, self.mesh.facets]
        return np.flatnonzero(self.bounding & np.all([on(corners[:, k]) for k in range(3)], axis=0))

    def traction(self, facets: Ints, of: Callable[[Floats], tuple[Floats, ...]]) -> Floats:
        """Forces of a traction (N/mm^2), three components of the places (3, ...)."""
        basis = FacetBasis(self.mesh, ElementVector(ElementTetP2()), facets=facets, intorder=4)
        return np.asarray(LinearForm(lambda v, w: sum(f * v[k] for k, f in enumerate(of(w.x)))).assemble(basis))

    def area(self, facets: Ints, where: Callable[[Floats], Floats]) -> float:
        """Area of facets, weighted."""
        basis = FacetBasis(self.mesh, ElementVector(ElementTetP2()), facets=facets, intorder=4)
        return float(Functional(lambda w: where(w.x)).assemble(basis))

    def guided(self, freedoms: Ints) -> sp.csr_matrix:
        """Springs that hold these freedoms radially about the Y axis only."""
        x, z = (freedoms[self.direction[freedoms] == axis] for axis in (0, 2))
        x, z = (k[np.lexsort(self.place[:, k].round(7))] for k in (x, z))
        assert np.allclose(self.place[:, x], self.place[:, z])
        out = self.place[[0, 2]][:, x] / np.hypot(*self.place[[0, 2]][:, x])
        pairs = np.stack([x, z])
        rows, columns = np.broadcast_arrays(pairs[:, None], pairs[None, :])
        values = RIGID_N_MM * out[:, None] * out[None, :]
        return sp.csr_matrix((values.ravel(), (rows.ravel(), columns.ravel())), shape=self.stiffness.shape)

    def moved(self, load: Floats, held: Ints, springs: sp.csr_matrix | None = None) -> Floats:
        """Displacements under a load (n,) or loads (n, k), with some freedoms held."""
        free = np.ones(len(load))
        free[held] = 0.0
        keep = sp.diags(free)
        whole = (self.stiffness if springs is None else self.stiffness + springs).tocsr()
        whole = (keep @ whole @ keep + sp.diags(1.0 - free)).tocsr()
        corners, edges = self.basis.nodal_dofs, self.basis.edge_dofs
        ends = self.mesh.edges
        rows = np.concatenate([corners.ravel(), edges.ravel(), edges.ravel()])
        columns = np.concatenate([corners.ravel(), corners[:, ends[0]].ravel(), corners[:, ends[1]].ravel()])
        weights = np.concatenate([np.ones(corners.size), np.full(2 * edges.size, 0.5)])
        linear = keep @ sp.csr_matrix((weights, (rows, columns)), shape=(len(load), corners.size))
        linear = linear[:, free[: corners.size] > 0.0].tocsr()
        coarse = spla.splu(
            (linear.T @ whole @ linear).tocsc(),
            permc_spec="MMD_AT_PLUS_A",
            diag_pivot_thresh=0.0,
            options={"SymmetricMode": True},
        )
        blocks = whole.tobsr((3, 3))
        own = np.repeat(np.arange(len(load) // 3), np.diff(blocks.indptr)) == blocks.indices
        inverse = np.linalg.inv(blocks.data[own])

        def smoothed(r: Floats) -> Floats:
            return linear @ coarse.solve(linear.T @ r) + (inverse @ r.reshape(-1, 3, 1)).ravel()

        before = spla.LinearOperator(whole.shape, smoothed)
        found = []
        for one in (load[:, None] if load.ndim == 1 else load).T:
            answer, failed = spla.cg(whole, one * free, rtol=RESIDUAL, maxiter=MOST_ROUNDS, M=before)
            assert not failed, f"no solution after {MOST_ROUNDS} rounds"
            found.append(answer)
        return np.array(found).T.reshape(load.shape)

    @cached_property
    def _points(self) -> Basis:
        return Basis(self.mesh, ElementVector(ElementTetP2()), intorder=5)

    def stress_MPa(self, moved: Floats) -> tuple[Floats, Floats, Floats]:
        """Stress (3, 3, n) at fifteen points of each element, their places (3, n) and volumes (n,)."""
        points = self._points
        gradient = points.interpolate(moved).grad
        strain = (gradient + np.swapaxes(gradient, 0, 1)) / 2.0
        lam, mu = lame_parameters(self.modulus_MPa, self.poisson)
        stress = 2.0 * mu * strain
        for k in range(3):
            stress[k, k] += lam * (strain[0, 0] + strain[1, 1] + strain[2, 2])
        return stress.reshape(3, 3, -1), np.asarray(points.global_coordinates()).reshape(3, -1), points.dx.ravel()


def about_y_Nmm(solid: Solid, load: Floats) -> float:
    """Moment of nodal forces about the Y axis."""
    x, z = (solid.direction == axis for axis in (0, 2))
    return float((load[x] * solid.place[2, x]).sum() - (load[z] * solid.place[0, z]).sum())


@dataclass(frozen=True)
class Pull:
    """A cable on a land of a drum: side, surface radius and y range of the land, y of the cable, wrap, torque share."""

    side: int
    surface_mm: float
    land_y_mm: tuple[float, float]
    cable_y_mm: float
    wrap_rad: float
    share: float


@dataclass(frozen=True, eq=False)
class OnLand:
    """Where a cable presses on its land: facets, and by place (3, ...) its weight between two angles from the transfer,
    so spread over the height that the resultant lies at the cable's; ``area_mm2`` between such angles."""

    solid: Solid
    pull: Pull
    facets: Ints

    def angle(self, p: Floats) -> Floats:
        """From the transfer to the anchor."""
        return np.asarray(self.pull.side * np.arctan2(p[0], p[2]))

    def area_mm2(self, start_rad: float, end_rad: float) -> float:
        """Area between the angles."""
        return self.solid.area(self.facets, lambda p: self._between(p, start_rad, end_rad)) if len(self.facets) else 0.0

    def weight(self, start_rad: float, end_rad: float) -> Callable[[Floats], Floats]:
        """One on the average between the angles, zero elsewhere, a straight line over the height."""

        def mean(of: Callable[[Floats], Floats]) -> float:
            return self.solid.area(self.facets, lambda p: of(p) * self._between(p, start_rad, end_rad)) / area

        area = self.area_mm2(start_rad, end_rad)
        middle = mean(lambda p: p[1])
        slope = (self.pull.cable_y_mm - middle) / mean(lambda p: (p[1] - middle) ** 2)
        return lambda p: (1.0 + slope * (p[1] - middle)) * self._between(p, start_rad, end_rad)

    def _between(self, p: Floats, start_rad: float, end_rad: float) -> Floats:
        at = self.angle(p)
        return np.asarray(((at >= start_rad) & (at < end_rad)) * 1.0)


def on_land(solid: Solid, pull: Pull) -> OnLand:
    """The strip of a land two millimetres to each side of a cable, or the whole land where no facets end there."""

    def between(low: float, high: float) -> OnLand:
        def on(p: Floats) -> NDArray[np.bool_]:
            near = np.abs(np.hypot(p[0], p[2]) - pull.surface_mm) < 0.03
            return near & (p[1] > low - 1e-6) & (p[1] < high + 1e-6)

        return OnLand(solid, pull, solid.facets(on))

    low, high = pull.land_y_mm
    low, high = max(low, pull.cable_y_mm - 2.0), min(high, pull.cable_y_mm + 2.0)
    strip = between(low, high)
    enough = strip.area_mm2(0.0, pull.wrap_rad) > 0.5 * pull.wrap_rad * pull.surface_mm * (high - low)
    return strip if enough else between(*pull.land_y_mm)


def drum_load(solid: Solid, pulls: Sequence[Pull]) -> Floats:
    """Forces of the changes of tension for 1 N m.

    The change falls evenly along the land: pressure inwards, and friction along the land.
    """
    load = np.zeros(solid.place.shape[1])
    for pull in pulls:
        land = on_land(solid, pull)
        weight, area = land.weight(0.0, pull.wrap_rad), land.area_mm2(0.0, pull.wrap_rad)
        change = pull.side * pull.share * 1e3 / pull.surface_mm

        def pressed(
            p: Floats,
            pull: Pull = pull,
            land: OnLand = land,
            change: float = change,
            area: float = area,
            weight: Callable[[Floats], Floats] = weight,
        ) -> tuple[Floats, Floats, Floats]:
            r, on = np.hypot(p[0], p[2]), weight(p)
            inwards = -change * (1.0 - land.angle(p) / pull.wrap_rad) * on * pull.wrap_rad / area
            along = -pull.side * change * on / area
            return inwards * p[0] / r + along * p[2] / r, 0.0 * r, inwards * p[2] / r - along * p[0] / r

        load += solid.traction(land.facets, pressed)
    return load * (-1e3 * sum(pull.share for pull in pulls) / about_y_Nmm(solid, load))
