"""Rotation of the drum by the elastic support: frame and top plate as folded plates on their mounting screws.

By reciprocity the drum turns, for each N m of load, by f . u: f are the forces that the change of tensions by that load
puts on the seats (module ``loads``), u the displacements they cause. f . u is also twice the strain energy, so that the
shares of the panels add up.

Assumptions, with their effect where solid finite elements of the reference frame show it (docs/decisions/0005):

- tensions share the load as on a rigid support;
- top plate bonded to walls and back plate (to the walls alone: no change); the mounting screws hold the back face under
  their heads, rigidly, and the back plate touches the base nowhere else (held over the 30 degree cone: 15 % less);
- walls are plates at mid-thickness, five times as thick where one runs inside another; holes thin the plate around;
- the boss is rigid but for the ring round its bearings, which bends as a curved beam;
- coupling boxes on the top plate do not stiffen it;
- only the part of the load that changes sign in a mirror at x = 0 is counted (0.4 % less).

On the whole it stays within 12 % of finite elements for ribs, back plate and side walls of 2 to 8 mm.
"""

from __future__ import annotations

from math import pi

import numpy as np

from mbcdm_cad.design.bought import Material
from mbcdm_cad.layouts.base import FrameCompliance, FrameStudy
from mbcdm_cad.layouts.miso_bevel.layout import BevelLayout
from mbcdm_cad.layouts.miso_bevel.support.loads import SeatLoads, seat_loads
from mbcdm_cad.layouts.miso_bevel.support.panels import mounts, support_mesh
from mbcdm_cad.model.block_rows import Ints
from mbcdm_cad.model.plate_mesh import GPA_TO_MPA, URAD_PER_MRAD, PlateMesh, centred_load, shares_urad, statically
from mbcdm_cad.model.si import to_si
from mbcdm_cad.model.stiffness import unit_tensions_N
from mbcdm_cad.routes import Floats

_SHEAR_FACTOR = 5.0 / 6.0


def _half_load(layout: BevelLayout, mesh: PlateMesh, loads: SeatLoads) -> Floats:
    """Nodal loads (6 m,) of the half x >= 0: the part of ``loads`` that changes sign in the mirror."""
    node = mesh.plates.node_mm
    total = np.zeros((len(node), 6))
    points = dict(zip(loads.names, loads.point_mm, strict=True))

    def centre(nodes: Ints, point: Floats, force_x: float) -> None:
        total[nodes, :3] += centred_load(mesh, nodes, point, force_x)

    f = layout.frame
    block = mesh.near("boss block", (0.0, 0.0, f.column_pocket_bottom_z), (1e3, 1e3, 1e3))
    for name in ("drum_rear", "drum_front"):
        centre(block, points[name], loads.at(name)[0])
    around = (3.0 * f.axle_radius, 3.0 * f.axle_radius, 10.0)
    centre(mesh.near("bearing shelf", points["axle_lower"], around), points["axle_lower"], loads.at("axle_lower")[0])
    centre(mesh.near("top plate", points["axle_upper"], around), points["axle_upper"], loads.at("axle_upper")[0])

    left, right = (layout.drive.input_names[layout.drive.input_sides.index(s)] for s in (-1, 1))
    mirrored = np.array([1.0, -1.0, -1.0])
    # The bearings next to the gearheads are the larger ones; both ends are spread over as much.
    reach = f.seat_radius if f.carries_drives else layout.top_plate.seat_radius
    for end, panel in (("lower", "bearing shelf"), ("upper", "top plate")):
        point = points[f"{right}_{end}"]
        force = 0.5 * (loads.at(f"{right}_{end}") + mirrored * loads.at(f"{left}_{end}"))
        nodes = mesh.near(panel, point, (reach, reach, 10.0))
        total[nodes, :3] += statically(node[nodes], point, force, np.zeros(3))
    panel, z, reach = _seat_of_gearheads(layout)
    at = np.array([max(f.input_x), f.input_y, z])
    nodes = mesh.near(panel, at, (reach, reach, 10.0))
    # N m to N mm.
    couple = np.array([0.0, 0.0, 1e3 * loads.gearhead_torque_Nm.mean()])
    total[nodes, :3] += statically(node[nodes], at, np.zeros(3), couple)
    return total.ravel()


def _seat_of_gearheads(layout: BevelLayout) -> tuple[str, float, float]:
    """The panel that takes the couple of a gearhead, the height of its face there, and the reach of its seat; mm."""
    v, box = layout.levels, layout.top_plate.box
    if box is None:
        return "motor shelf", v.motor_shelf_bottom_z, layout.drive.gearhead.diameter_mm / 2
    return "top plate", v.top_plate_top_z, box.outer_x


def ring_compliance_mm_N(layout: BevelLayout, material: Material) -> float:
    """Lateral compliance of the drum bearing's ring against the block above it, for 1 N per mm of depth along Y.

    The right half is a curved beam from the lowest point, where by antisymmetry only a shear force passes, up into the
    block. Its depth grows there from the round wall to the block's corner. Pressure of the seat is p cos(phi).
    """
    f = layout.frame
    inner, modulus = f.drum_seat_radius, material.youngs_modulus_GPa * GPA_TO_MPA
    shear_modulus = modulus / (2.0 * (1.0 + material.poisson_ratio))
    phi = np.linspace(-pi / 2, pi / 3, 121)
    outer = np.full_like(phi, f.boss_radius)
    up = phi > 0.0
    outer[up] = np.minimum(f.boss_radius / np.cos(phi[up]), f.column_pocket_bottom_z / np.sin(phi[up]))
    wall = outer - inner
    radius = inner + (f.boss_radius - inner) / 2
    step = np.diff(phi)

    def running(values: Floats) -> Floats:
        return np.concatenate([[0.0], np.cumsum((values[1:] + values[:-1]) / 2 * step)])

    # Pressure of unit resultant over both halves.
    push = np.cos(phi) / pi
    force_x, force_z = running(push * np.cos(phi)), running(push * np.sin(phi))
    moment = radius * (np.sin(phi) * force_x - np.cos(phi) * force_z)
    # Columns: from the pressure, from a unit shear force at the lowest point.
    bend = np.stack([moment, radius * np.cos(phi)])
    along = np.stack([-np.sin(phi) * force_x + np.cos(phi) * force_z, np.cos(phi)])
    across = np.stack([np.cos(phi) * force_x + np.sin(phi) * force_z, np.sin(phi)])

    def work(a: int, b: int) -> float:
        density = bend[a] * bend[b] * 12.0 / (modulus * wall**3) + along[a] * along[b] / (modulus * wall)
        density += across[a] * across[b] / (_SHEAR_FACTOR * shear_modulus * wall)
        return float(radius * running(density)[-1])

    # The shear force does no work, since the lowest point does not leave the mirror plane.
    return 2.0 * (work(0, 0) - work(0, 1) ** 2 / work(1, 1))


def _ring_work(layout: BevelLayout, loads: SeatLoads) -> float:
    """f . u of the rings round both drum bearings, which move sideways and shear along the boss, N mm.

    Slices of the ring cannot bend independently: the lower arc connects them and must shear if they move unequally.
    """
    f, material = layout.frame, layout.drive.frame_material
    front, rear = layout.levels.boss_front_y, f.encoder_pocket_floor_y
    length, middle = front - rear, (front + rear) / 2
    at = np.array([loads.point_mm[loads.names.index(n)][1] - middle for n in ("drum_rear", "drum_front")])
    force = np.array([loads.at(n)[0] for n in ("drum_rear", "drum_front")])
    slice_mm_N = ring_compliance_mm_N(layout, material)
    shear_modulus = material.youngs_modulus_GPa * GPA_TO_MPA / (2.0 * (1.0 + material.poisson_ratio))
    arc_N = shear_modulus * (f.boss_radius**2 - f.drum_seat_radius**2) / 2 * pi / 2
    shift = slice_mm_N / length * force.sum() ** 2
    return float(shift + (force @ at) ** 2 / (length**3 / (12.0 * slice_mm_N) + arc_N * length))


def frame_compliance(layout: BevelLayout) -> FrameCompliance:
    """Windup of the drum by the support per N m of external torque, with the share of each part.

    Raises ``ValueError`` if the dimensions leave no frame to compute.
    """
    material = layout.drive.frame_material
    loads = seat_loads(layout, unit_tensions_N(to_si(layout.drive)))
    mesh = support_mesh(layout)
    ground = mounts(layout).springs(mesh, material)
    shares = shares_urad(mesh, material, _half_load(layout, mesh, loads), ground)
    shares["boss ring"] = _ring_work(layout, loads) * URAD_PER_MRAD
    return FrameCompliance(sum(shares.values()), shares)


def frame_study(layout: BevelLayout) -> FrameStudy:
    """The compliance as a study for the cache; infinite if the frame has no metal that carries the load."""

    def compliance() -> FrameCompliance:
        try:
            return frame_compliance(layout)
        except (ValueError, ArithmeticError):
            return FrameCompliance(float("inf"), {})

    drive = layout.drive
    cables = [(c.input_side, c.drum_side, c.input_radius_mm, c.guide_radius_mm, c.drum_radius_mm) for c in drive.cables]
    # Only the positions of the drum shaft's bearings, so that other changes of the shaft do not repeat the study.
    seats = (layout.drum_shaft.rear_bearing_y, layout.drum_shaft.front_bearing_y)
    inputs = (layout.frame, layout.top_plate, seats, drive.support, drive.bearings, cables)
    walls = "support.rib_mm, support.back_plate_mm, support.motor_shelf_mm"
    return FrameStudy(__name__, inputs, compliance, f"thicken the walls that bend most: {walls}")
