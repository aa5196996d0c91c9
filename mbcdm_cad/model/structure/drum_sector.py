"""How far a drum sector turns by its own strain under its cables, and the stress in it.

Web and rim are computed as plane stress on :mod:`~mbcdm_cad.model.structure.sector_mesh`. The web stands on the hub as
on springs, whose flexibility is that of a strip of the web's thickness on a thick body (Johnson, Contact Mechanics,
chapter 2: displacements of a half-space under a strip load, which grow with the logarithm of the distance). From the
web's middle to the face the hub is a tube in torsion, softened by its holes. The payload on the face is rigid; the bore
is held on the shaft radially and free to turn. docs/structure.md compares this with solid finite elements.
Units: mm, N, MPa; results in urad per N m and MPa.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import log, pi

import numpy as np

from mbcdm_cad.model.block_rows import Ints
from mbcdm_cad.model.structure.plane_stress import elements, solve, stresses_MPa, von_mises_MPa
from mbcdm_cad.model.structure.sector_mesh import SectorMesh, SectorShape, sector_mesh
from mbcdm_cad.routes import Floats

# Cells from the axis to the rim's surface. With twice as many, the turn of the references rises by 1 % or less.
CELLS = 28
# Parts of a cell over which the load on the land is summed.
_LOAD_STEPS = 8
NMM_PER_NM = 1e3
URAD_PER_RAD = 1e6


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

    ``face_holes``: the payload's holes, ``set_holes``: radial holes of the set screws at ``set_mm``.
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

    def shear_MPa(self, torque_Nm: float) -> float:
        """Shear on the outside under a torque, N m."""
        return 2.0 * torque_Nm * NMM_PER_NM * self.radius_mm / (pi * (self.radius_mm**4 - self.bore_mm**4))

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
        drilled = max(whole - lost, 0.25 * whole)
        low = max(start_mm, min(end_mm, self.face_mm - self.face_depth_mm))
        length = (low - start_mm) / whole + (end_mm - low) / drilled
        if start_mm <= self.set_mm < end_mm:
            around = 2.0 * pi * (self.radius_mm + self.bore_mm) / 2.0
            extra = self.set_holes * pi * self.set_hole_mm**2 / around * 4.0 / (1.0 + material.poisson)
            length += extra / whole
        return length / material.shear_MPa * NMM_PER_NM * URAD_PER_RAD

    def root_mm2_N(self, material: Isotropic, web_mm: tuple[float, float]) -> tuple[float, float]:
        """Local give of the hub under the web's edge: (along the edge, along the radius), mm per (N / mm of edge).

        A strip of the web's thickness t, seen from a distance R inside the body: (ln(R / t) + 3/2) / (pi G) along the
        strip and 2 (1 - nu^2) / (pi E) times the same across it. The hub's back face near the web adds the effect of
        the strip's mirror image. R is half the wall between bore and outside.
        """
        thickness, middle = web_mm[1] - web_mm[0], (web_mm[0] + web_mm[1]) / 2.0
        far = max((self.radius_mm - self.bore_mm) / 2.0, thickness)
        mirrored = max(0.0, log(far / (2.0 * max(middle - self.back_mm, thickness / 2.0))))
        depth = log(far / thickness) + 1.5 + mirrored
        along = depth / (pi * material.shear_MPa)
        return along, 2.0 * (1.0 - material.poisson**2) / (pi * material.modulus_MPa) * depth


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


@dataclass(frozen=True, eq=False)
class SectorStudy:
    """Turn of the cables against the payload for 1 N m, by cause, and stresses (n, 4, 3) of the mesh's elements."""

    web_urad_Nm: float
    hub_to_screws_urad_Nm: float
    hub_to_face_urad_Nm: float
    mesh: SectorMesh
    unit_stress: Floats
    preload_stress: Floats

    def von_mises_MPa(self, torque_Nm: float) -> Floats:
        """Greatest equivalent stress (n,) in each element, for a torque beside the preload."""
        return np.asarray(von_mises_MPa(self.preload_stress + torque_Nm * self.unit_stress).max(axis=1))


def sector_study(
    shape: SectorShape, hub: Hub, pulls: Sequence[LandPull], material: Isotropic, cells: float = CELLS
) -> SectorStudy:
    """Solve one sector. Raises ``ValueError`` if no metal joins rim and hub."""
    mesh = sector_mesh(shape, shape.rings[-1].outer_mm / cells)
    parts = elements(mesh.node_mm, mesh.corner, mesh.thickness_mm, material.modulus_MPa, material.poisson)
    web = shape.rings[0].start_mm, shape.rings[0].end_mm
    stiffness = parts.stiffness + _root_springs(mesh, shape.held_mm, hub.root_mm2_N(material, web))
    load = np.column_stack([_torque_load(mesh, pulls), _preload(mesh, pulls)])
    try:
        moved = solve(mesh.corner, mesh.line, stiffness, load)
    except np.linalg.LinAlgError:
        raise ValueError("drum: nothing joins its rim to its hub") from None
    middle = (web[0] + web[1]) / 2.0
    between = min(max(hub.set_mm, middle), hub.face_mm)
    return SectorStudy(
        float(load[:, 0] @ moved[:, 0]) / NMM_PER_NM * URAD_PER_RAD,
        hub.twist_urad_Nm(material, middle, between),
        hub.twist_urad_Nm(material, between, hub.face_mm),
        mesh,
        stresses_MPa(parts, mesh.corner, moved[:, 0]),
        stresses_MPa(parts, mesh.corner, moved[:, 1]),
    )


def _root_springs(mesh: SectorMesh, held_mm: float, give: tuple[float, float]) -> Floats:
    """Stiffness (n, 8, 8) of the ground under the elements at the hub, half of each edge on either corner."""
    springs = np.zeros((len(mesh.corner), 8, 8))
    edge = np.flatnonzero(mesh.radius_mm[mesh.corner[:, 0]] < held_mm + 1e-9)
    length = held_mm * np.abs(mesh.angle_rad[mesh.corner[edge, 1]] - mesh.angle_rad[mesh.corner[edge, 0]])
    along, across = give
    for k in (0, 1):
        angle = mesh.angle_rad[mesh.corner[edge, k]]
        radial = np.stack([np.sin(angle), np.cos(angle)], axis=1)
        tangent = np.stack([np.cos(angle), -np.sin(angle)], axis=1)
        block = radial[:, :, None] * radial[:, None, :] / across + tangent[:, :, None] * tangent[:, None, :] / along
        springs[edge, 2 * k : 2 * k + 2, 2 * k : 2 * k + 2] += block * (length / 2.0)[:, None, None]
    return springs


def _land(mesh: SectorMesh, pull: LandPull) -> Ints:
    """Nodes of the land's surface in the order of their angles, from the transfer to the anchor's side."""
    on = np.flatnonzero(np.abs(mesh.radius_mm - pull.surface_mm) < 1e-6)
    return np.asarray(on[np.argsort(pull.side * mesh.angle_rad[on])])


def _spread(mesh: SectorMesh, pull: LandPull, tension_N: float, friction_N_rad: float) -> Floats:
    """Forces (2 m,) on the land under a tension that friction lowers by ``friction_N_rad`` from the transfer on."""
    nodes = _land(mesh, pull)
    force = np.zeros(2 * len(mesh.node_mm))
    start, end = (pull.side * mesh.angle_rad[n] for n in (nodes[:-1], nodes[1:]))
    at = (np.arange(_LOAD_STEPS) + 0.5) / _LOAD_STEPS
    angle = start[:, None] + (end - start)[:, None] * at
    wrapped = (angle > 0.0) & (angle < pull.anchor_rad)
    step = (end - start)[:, None] / _LOAD_STEPS * wrapped
    inwards, back = -(tension_N - friction_N_rad * angle) * step, -friction_N_rad * step
    sine, cosine = pull.side * np.sin(angle), np.cos(angle)
    pressed = np.stack(
        [inwards * sine + back * pull.side * cosine, inwards * cosine - back * pull.side * sine], axis=-1
    )
    for node, weight in ((nodes[:-1], 1.0 - at), (nodes[1:], at)):
        for axis in (0, 1):
            np.add.at(force, 2 * node + axis, (pressed[:, :, axis] * weight).sum(axis=1))
    return force


def _torque_load(mesh: SectorMesh, pulls: Sequence[LandPull]) -> Floats:
    """Forces (2 m,) of the changes of tension for a torque of 1 N m."""
    force = np.zeros(2 * len(mesh.node_mm))
    for pull in pulls:
        change = pull.side * pull.share * NMM_PER_NM / pull.surface_mm
        force += _spread(mesh, pull, change, change / pull.anchor_rad)
    about = force[0::2] @ mesh.node_mm[:, 1] - force[1::2] @ mesh.node_mm[:, 0]
    # The polygon of the land's nodes and lands that a pocket cuts leave a little of it out.
    return np.asarray(force * (-NMM_PER_NM * sum(pull.share for pull in pulls) / about))


def _preload(mesh: SectorMesh, pulls: Sequence[LandPull]) -> Floats:
    """Forces (2 m,) of the preloads: pressure on the lands, and the pull of each anchor."""
    force = np.zeros(2 * len(mesh.node_mm))
    for pull in pulls:
        force += _spread(mesh, pull, pull.tension_N, 0.0)
        nodes = _land(mesh, pull)
        anchor = nodes[np.argmin(np.abs(pull.side * mesh.angle_rad[nodes] - pull.anchor_rad))]
        tangent = np.array([-pull.side * np.cos(pull.anchor_rad), np.sin(pull.anchor_rad)])
        force[2 * anchor : 2 * anchor + 2] += pull.tension_N * tangent
    return force
