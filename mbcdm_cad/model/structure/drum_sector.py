"""How far a drum sector turns by its own strain under its cables, and the stress in it.

Web and rim are computed as plane stress on :mod:`~mbcdm_cad.model.structure.sector_mesh`, and as plates that cables
beside their middle bend out of that plane. The web stands on the hub as on springs: along its edge those of a ring on a
tube in torsion, across it those of a strip of the web's thickness on a thick body (Johnson, Contact Mechanics, chapter
2: displacements of a half-space under a strip load, which grow with the logarithm of the distance). From near the web's
front to the face the hub is a tube in torsion, softened by its holes. The payload on the face is rigid; the bore is
held on the shaft radially and free to turn. docs/structure.md compares this with solid finite elements.
Units: mm, N, MPa; results in urad per N m and MPa.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from math import ceil, log, pi, sin

import numpy as np

from mbcdm_cad.model.structure.quadrilateral import (
    FREEDOMS,
    LEAN,
    LEANS,
    Ints,
    eccentric,
    elements,
    freedoms,
    plane_law,
    plate_elements,
    stresses_MPa,
    von_mises_MPa,
)
from mbcdm_cad.model.structure.sector_mesh import SectorMesh, SectorShape, sector_mesh
from mbcdm_cad.routes import Floats

# Cells from the axis to the rim's surface. With twice as many, the turn of the references rises by 1 % or less.
CELLS = 28
# The same of the mesh on which bending out of the plane is solved, and straight pieces of its corners: with 28 and 3
# turns differ by less than 0.5 %, stresses of the web by 6 %.
BENDING_CELLS, BENDING_PIECES = 8, 2
# Stress of the hub's outside over that of an even tube: the web stands on one side of it and over a part of its turn.
# Solid elements give 2.1 to 2.9 (docs/structure.md).
BESIDE_WEB = 2.5
# Flow of torque per length of the web's edge, largest over mean; solid elements give 1.3 to 1.7 where the hub is wide
# for its length, so that the torque passes to the face within a layer under its outside (docs/structure.md).
UNEVEN = 1.5
# Part of the web's thickness t, from its middle, over which it keeps the hub from twisting; the local give of the hub
# along the web's edge times G, by ln(R / t), and near the hub's back. Fitted to finite differences of a ring on a tube
# in torsion, within 0.06, for t from 0.06 to 0.8 and bores from 0.3 to 0.5 of the hub's radius R.
STIFFENED, ALONG, NEAR_BACK, LEAST_ALONG = 0.3, (0.18, 0.23), (0.2, 0.36), 0.05
# Lean of a plate's edge on a thick body over M / (pi E t^2), plane strain apart (O'Donnell 1960).
EDGE_LEAN = 16.67
# Sectors whose solution is kept: a few MB each.
KEPT = 12
_NO_BENDING = (np.zeros(()), np.zeros(()))
# Parts of a cell over which the load on the land is summed.
_LOAD_STEPS = 8
NMM_PER_NM = 1e3
URAD_PER_RAD = 1e6
TURN = 2.0 * pi


@dataclass(frozen=True)
class Isotropic:
    """An elastic material."""

    modulus_MPa: float
    poisson: float

    @property
    def shear_MPa(self) -> float:
        """Shear modulus G."""
        return self.modulus_MPa / (2.0 * (1.0 + self.poisson))


@dataclass(frozen=True)
class Hub:
    """The hub, a tube along the axis from ``back_mm`` to ``face_mm``, which the payload is screwed to.

    ``face_holes``: the payload's holes, ``set_holes``: radial holes of the set screws at ``set_mm``. The web stands on
    it from ``edge_mm[0]`` to ``edge_mm[1]``, ``half_angle_rad`` to each side; ``web_mm``: its thickness further out.
    """

    radius_mm: float
    bore_mm: float  # its radius
    back_mm: float
    face_mm: float
    set_mm: float
    set_hole_mm: float  # radius
    set_holes: int
    face_hole_mm: float  # radius
    face_holes: int
    face_circle_mm: float  # radius of the circle that they lie on
    face_depth_mm: float
    edge_mm: tuple[float, float]
    web_mm: float
    half_angle_rad: float

    def shear_MPa(self, torque_Nm: float) -> float:
        """Largest shear on the outside, ``web_mm`` beside the web, under a torque, N m.

        That of a tube, or, in a hub that is wide for its length L from the web's middle to the face, that of a layer:
        a force q per length of the edge, which enters a strip at its free corner and leaves at its held end, shears the
        outside at y from the corner by q / (L sin(pi y / 2 L)) (antiplane shear, by conformal mapping).
        """
        torque = torque_Nm * NMM_PER_NM
        even = 2.0 * torque * self.radius_mm / (pi * (self.radius_mm**4 - self.bore_mm**4))
        middle = sum(self.edge_mm) / 2.0
        length = max(self.face_mm - middle, self.web_mm / 2.0)
        at = min((self.edge_mm[1] - middle + self.web_mm) / length, 1.0)
        layer = torque / (2.0 * self.half_angle_rad * self.radius_mm**2 * length * sin(pi / 2.0 * at))
        return max(BESIDE_WEB * even, UNEVEN * layer)

    def twist_urad_Nm(self, material: Isotropic, start_mm: float, end_mm: float) -> float:
        """Twist from ``start_mm`` to ``end_mm`` along the axis.

        Holes count by what a single hole loses in a field of shear: an axial one twice the torsion of its own area, a
        radial one as much as 4 / (1 + nu) times its share of the wall's surface (Peterson, Stress Concentration
        Factors; energy of a round hole in pure shear). Raises ``ValueError`` for a hub without a wall.
        """
        whole = pi / 2.0 * (self.radius_mm**4 - self.bore_mm**4)
        if whole <= 0.0:
            raise ValueError(f"the hub of radius {self.radius_mm:g} mm has a bore of {self.bore_mm:g} mm")
        lost = self.face_holes * 2.0 * pi * self.face_hole_mm**2 * self.face_circle_mm**2
        low = max(start_mm, min(end_mm, self.face_mm - self.face_depth_mm))
        length = end_mm - start_mm + (end_mm - low) * lost / whole
        if start_mm <= self.set_mm < end_mm:
            around = 2.0 * pi * (self.radius_mm + self.bore_mm) / 2.0
            length += self.set_holes * pi * self.set_hole_mm**2 / around * 4.0 / (1.0 + material.poisson)
        return length / whole / material.shear_MPa * NMM_PER_NM * URAD_PER_RAD

    def root_mm2_N(self, material: Isotropic, web_mm: tuple[float, float]) -> tuple[float, float]:
        """Local give of the hub under the web's edge: (along the edge, along the radius), mm per (N / mm of edge).

        Along the edge that of a ring on a tube in torsion, beside the tube's twist from :data:`STIFFENED` of the web's
        thickness before its middle on; a line through solutions of such bodies of revolution, near the back of the hub
        a second one. Across, that of a strip of the web's thickness t on a thick body, from a distance R inside:
        2 (1 - nu^2) / (pi E) times ln(R / t) + 3/2. The hub's back face near the web adds the effect of the strip's
        mirror image. R is half the wall between bore and outside.
        """
        thickness, middle = web_mm[1] - web_mm[0], (web_mm[0] + web_mm[1]) / 2.0
        to_back = 2.0 * max(middle - self.back_mm, thickness / 2.0)
        along = ALONG[0] + ALONG[1] * log(self.radius_mm / thickness)
        along += max(0.0, NEAR_BACK[0] * log(NEAR_BACK[1] * self.radius_mm / to_back))
        far = max((self.radius_mm - self.bore_mm) / 2.0, thickness)
        depth = log(far / thickness) + 1.5 + max(0.0, log(far / to_back))
        across = 2.0 * (1.0 - material.poisson**2) / (pi * material.modulus_MPa) * depth
        return max(along, LEAST_ALONG) / material.shear_MPa, across


def least_hub_mm(bore_mm: float, torque_Nm: float, shear_MPa: float) -> float:
    """Radius of the hub in which a torque causes this shear (:meth:`Hub.shear_MPa`), for a bore of this radius.

    r^4 = b^4 + c r with c > 0 has one root above b. The repetition falls to it from above and leaves
    at most a quarter of the error each time, since r^3 >= c there.
    """
    c = BESIDE_WEB * 2.0 * torque_Nm * NMM_PER_NM / (pi * shear_MPa)
    radius = bore_mm + float(np.cbrt(c))
    for _ in range(40):
        radius = (bore_mm**4 + c * radius) ** 0.25
    return radius


@dataclass(frozen=True)
class LandPull:
    """A cable on its land: the side it runs to, the surface's radius, the angle from the transfer to its anchor.

    ``share``: part of the torque on the drum that the change of its tension carries. Friction takes the change up
    evenly along the land. ``tension_N``: its preload, which the anchor holds.
    """

    side: int
    surface_mm: float
    anchor_rad: float
    share: float
    tension_N: float
    at_mm: float


@dataclass(frozen=True, eq=False)
class SectorStudy:
    """Turn of the cables against the payload for 1 N m, by cause, and stresses (n, 4, 3) of the mesh's elements.

    ``unit_stress`` for 1 N m and ``preload_stress`` in the middle of the metal; ``unit_bending`` and
    ``preload_bending`` are added to them on its front, taken off on its back.
    """

    web_urad_Nm: float
    hub_to_screws_urad_Nm: float
    hub_to_face_urad_Nm: float
    mesh: SectorMesh
    unit_stress: Floats
    preload_stress: Floats
    unit_bending: Floats
    preload_bending: Floats

    def faces_MPa(self, torque_Nm: float) -> tuple[Floats, Floats]:
        """Stresses (n, 4, 3) on front and back, for a torque beside the preload."""
        middle = self.preload_stress + torque_Nm * self.unit_stress
        bending = self.preload_bending + torque_Nm * self.unit_bending
        return middle + bending, middle - bending

    def von_mises_MPa(self, torque_Nm: float) -> Floats:
        """Greatest equivalent stress (n,) in each element, for a torque beside the preload."""
        return np.asarray(np.max([von_mises_MPa(face).max(axis=1) for face in self.faces_MPa(torque_Nm)], axis=0))


@lru_cache(maxsize=KEPT)
def sector_study(
    shape: SectorShape,
    hub: Hub,
    pulls: tuple[LandPull, ...],
    material: Isotropic,
    cells: float = CELLS,
    *,
    flat: bool = False,
) -> SectorStudy:
    """Solve one sector; the last few are kept, since sizing, the search that asked for it and the checks meet the same
    drum. ``flat``: without bending out of the plane, 2 to 13 % stiffer, which takes most of the time.

    Raises ``ValueError`` if no metal joins rim and hub, or a cable's land has none.
    """
    mesh = sector_mesh(shape, shape.rings[-1].outer_mm / cells)
    load = np.sum([_torque_loads(mesh, pulls), _preloads(mesh, pulls)], axis=1).T
    parts = elements(mesh.node_mm, mesh.corner, mesh.thickness_mm, material.modulus_MPa, material.poisson)
    web = shape.rings[0].start_mm, shape.rings[0].end_mm
    stiffness = parts.stiffness + _root_springs(mesh, shape.held_mm, hub.root_mm2_N(material, web))
    try:
        moved = mesh.solved(stiffness, load)
    except np.linalg.LinAlgError:
        raise ValueError("drum: nothing joins its rim to its hub") from None
    in_plane = [stresses_MPa(parts, column[freedoms(mesh.corner, 2)]) for column in moved.T]
    bent = (
        _Bent(0.0, _NO_BENDING, _NO_BENDING)
        if flat
        else _bent(shape, hub, pulls, material, _InPlane(mesh, parts.area_mm2, in_plane))
    )
    start = min((web[0] + web[1]) / 2.0 + STIFFENED * (web[1] - web[0]), hub.face_mm)
    between = min(max(hub.set_mm, start), hub.face_mm)
    return SectorStudy(
        (float(load[:, 0] @ moved[:, 0]) + bent.twice_Nmm) / NMM_PER_NM * URAD_PER_RAD,
        hub.twist_urad_Nm(material, start, between),
        hub.twist_urad_Nm(material, between, hub.face_mm),
        mesh,
        *(stress + change for stress, change in zip(in_plane, bent.middle_MPa, strict=True)),
        *bent.front_MPa,
    )


@dataclass(frozen=True, eq=False)
class _InPlane:
    """A sector solved in its own plane: areas (n, 4) of the mesh's points, stresses (n, 4, 3) by each load."""

    mesh: SectorMesh
    area_mm2: Floats
    stress_MPa: Sequence[Floats]


@dataclass(frozen=True, eq=False)
class _Bent:
    """What bending out of the plane adds: twice the energy for 1 N m; stresses (n, 4, 3) in the middle of the metal,
    and beside it on its front, by each load."""

    twice_Nmm: float
    middle_MPa: Sequence[Floats]
    front_MPa: Sequence[Floats]


def _bent(shape: SectorShape, hub: Hub, pulls: Sequence[LandPull], material: Isotropic, plane: _InPlane) -> _Bent:
    """Bending out of the plane, for 1 N m and for the preload.

    Forces beside the middle of the metal bend it: those of the cables, and, where rings of other height meet, those in
    the plane. Let the metal lean by x under these moments g, while the plane follows: the turn by the whole is that in
    the plane plus g x, both stiffnesses in one solution, on a coarser mesh. Only the web's stress is given: the rim,
    which bends as a whole, is no plate round the pockets and lugs of its terminals.
    """
    mesh, first = plane.mesh, shape.rings[0]
    level = (first.start_mm + first.end_mm) / 2.0
    coarse = sector_mesh(shape, shape.rings[-1].outer_mm / BENDING_CELLS, BENDING_PIECES)
    body = coarse.node_mm, coarse.corner, coarse.thickness_mm, material.modulus_MPa, material.poisson
    flat, plates = elements(*body), plate_elements(*body)
    where, quarter = freedoms(coarse.corner, FREEDOMS), coarse.quarters(mesh)
    met = quarter >= 0
    arm = (plane.area_mm2 * (mesh.thickness_mm * (mesh.middle_mm - level))[:, None]).ravel()[met]
    cables = _torque_loads(coarse, pulls), _preloads(coarse, pulls)
    load = np.zeros((FREEDOMS * len(coarse.node_mm), len(cables)))
    for k, (forces, stress) in enumerate(zip(cables, plane.stress_MPa, strict=True)):
        couples = np.array([pull.at_mm - level for pull in pulls]) @ np.array(forces)
        load[LEAN::FREEDOMS, k], load[LEAN + 1 :: FREEDOMS, k] = couples[0::2], couples[1::2]
        acting = arm * stress.reshape(-1, 3)[met].T
        moment = np.stack([np.bincount(quarter[met], one, 4 * len(where)) for one in acting], axis=1)
        beside = moment.reshape(-1, 1, 12) @ plates.curvature.reshape(-1, 12, 12)
        load[:, k] -= np.bincount(where[:, 8:].ravel(), beside.ravel(), len(load))
    web = first.start_mm, first.end_mm
    held = _root_springs(coarse, shape.held_mm, hub.root_mm2_N(material, web))
    clamp = _clamp(coarse, shape.held_mm, hub, material, web)
    height = coarse.middle_mm - level
    stiffness = eccentric(flat.stiffness, plates.stiffness + clamp, height)
    stiffness[:, :8, :8] += held
    moved = coarse.solved(stiffness, load)
    law = plane_law(material.modulus_MPa, material.poisson)
    in_web = np.repeat(mesh.radius_mm[mesh.corner].mean(axis=1) < shape.rim_mm, 4) & met
    half = np.where(in_web, np.repeat(mesh.thickness_mm / 2.0, 4), 0.0)[:, None]
    middle, front = [], []
    for column in moved.T:
        leaning = column[where[:, 8:]]
        curved = (plates.curvature.reshape(-1, 12, 12) @ leaning[:, :, None]).reshape(-1, 3) @ law
        follows = column[where[:, :8]] + height[:, None] * column[where[:, LEANS]]
        own = stresses_MPa(flat, follows).reshape(-1, 3)
        middle.append(np.where(in_web[:, None], own[quarter], 0.0).reshape(-1, 4, 3))
        front.append((curved[quarter] * half).reshape(-1, 4, 3))
    return _Bent(float(load[:, 0] @ moved[:, 0]), middle, front)


def _clamp(mesh: SectorMesh, held_mm: float, hub: Hub, material: Isotropic, web_mm: tuple[float, float]) -> Floats:
    """Stiffness (n, 12, 12) of the hub under the edge of the plates, as springs.

    A moment M along the edge of a plate of thickness t leans it on a thick body by 16.67 (1 - nu^2) M / (pi E t^2)
    (O'Donnell 1960); across, the hub gives as under the web's pull.
    """
    springs = np.zeros((len(mesh.corner), 12, 12))
    edge, length = _held_edges(mesh, held_mm)
    _, across = hub.root_mm2_N(material, web_mm)
    thickness = web_mm[1] - web_mm[0]
    lean = EDGE_LEAN * (1.0 - material.poisson**2) / (pi * material.modulus_MPa * thickness**2)
    for k, give in ((0, across), (1, lean), (2, lean)):
        springs[edge, k, k] = springs[edge, 3 + k, 3 + k] = length / 2.0 / give
    return springs


def _held_edges(mesh: SectorMesh, held_mm: float) -> tuple[Ints, Floats]:
    """Elements that stand on the hub, and the lengths of their edges there, between their first two corners."""
    edge = np.flatnonzero(mesh.radius_mm[mesh.corner[:, 0]] < held_mm + 1e-9)
    angle = mesh.angle_rad[mesh.corner[edge]]
    return edge, held_mm * np.abs(angle[:, 1] - angle[:, 0])


def _root_springs(mesh: SectorMesh, held_mm: float, give: tuple[float, float]) -> Floats:
    """Stiffness (n, 8, 8) of the ground under the elements at the hub, half of each edge on either corner."""
    springs = np.zeros((len(mesh.corner), 8, 8))
    edge, length = _held_edges(mesh, held_mm)
    along, across = give
    for k in (0, 1):
        angle = mesh.angle_rad[mesh.corner[edge, k]]
        radial = np.stack([np.sin(angle), np.cos(angle)], axis=1)
        tangent = np.stack([np.cos(angle), -np.sin(angle)], axis=1)
        block = radial[:, :, None] * radial[:, None, :] / across + tangent[:, :, None] * tangent[:, None, :] / along
        springs[edge, 2 * k : 2 * k + 2, 2 * k : 2 * k + 2] += block * (length / 2.0)[:, None, None]
    return springs


def _land(mesh: SectorMesh, pull: LandPull) -> Ints:
    """Nodes of the land's surface in the order of their angles, from the transfer to the anchor's side.

    Raises ``ValueError`` for a land without metal: a sum over none would call the drum free of stress.
    """
    on = np.flatnonzero(np.abs(mesh.radius_mm - pull.surface_mm) < 1e-6)
    if not on.size:
        raise ValueError(f"drum: no metal under the cable on the land of radius {pull.surface_mm:.4g} mm")
    return np.asarray(on[np.argsort(pull.side * mesh.angle_rad[on])])


def _spread(mesh: SectorMesh, pull: LandPull, tension_N: float, friction_N_rad: float) -> Floats:
    """Forces (2 m,) on the land under a tension that friction lowers by ``friction_N_rad`` from the transfer on."""
    nodes = _land(mesh, pull)
    force = np.zeros(2 * len(mesh.node_mm))
    start, end = (pull.side * mesh.angle_rad[n] for n in (nodes[:-1], nodes[1:]))
    at = (np.arange(_LOAD_STEPS) + 0.5) / _LOAD_STEPS
    angle = start[:, None] + (end - start)[:, None] * at
    inwards, back = np.zeros_like(angle), np.zeros_like(angle)
    # The cable may pass a place more than once.
    for along in (angle + TURN * k for k in range(ceil(max(0.0, pull.anchor_rad - pi) / TURN) + 1)):
        wrapped = (along > 0.0) & (along < pull.anchor_rad)
        step = (end - start)[:, None] / _LOAD_STEPS * wrapped
        inwards -= (tension_N - friction_N_rad * along) * step
        back -= friction_N_rad * step
    sine, cosine = pull.side * np.sin(angle), np.cos(angle)
    pressed = np.stack(
        [inwards * sine + back * pull.side * cosine, inwards * cosine - back * pull.side * sine], axis=-1
    )
    for node, weight in ((nodes[:-1], 1.0 - at), (nodes[1:], at)):
        for axis in (0, 1):
            np.add.at(force, 2 * node + axis, (pressed[:, :, axis] * weight).sum(axis=1))
    return force


def _torque_loads(mesh: SectorMesh, pulls: Sequence[LandPull]) -> list[Floats]:
    """Forces (2 m,) of the change of each cable's tension for a torque of 1 N m."""
    forces = []
    for pull in pulls:
        change = pull.side * pull.share * NMM_PER_NM / pull.surface_mm
        forces.append(_spread(mesh, pull, change, change / pull.anchor_rad))
    whole = np.sum(forces, axis=0)
    about = whole[0::2] @ mesh.node_mm[:, 1] - whole[1::2] @ mesh.node_mm[:, 0]
    # The polygon of the land's nodes and lands that a pocket cuts leave a little of it out.
    scale = -NMM_PER_NM * sum(pull.share for pull in pulls) / about
    return [force * scale for force in forces]


def _preloads(mesh: SectorMesh, pulls: Sequence[LandPull]) -> list[Floats]:
    """Forces (2 m,) of each cable's preload: pressure on its land, and the pull of its anchor."""
    forces = []
    for pull in pulls:
        force = _spread(mesh, pull, pull.tension_N, 0.0)
        nodes = _land(mesh, pull)
        at = pi - (pi - pull.anchor_rad) % TURN
        anchor = nodes[np.argmin(np.abs(pull.side * mesh.angle_rad[nodes] - at))]
        tangent = np.array([-pull.side * np.cos(pull.anchor_rad), np.sin(pull.anchor_rad)])
        force[2 * anchor : 2 * anchor + 2] += pull.tension_N * tangent
        forces.append(force)
    return forces
