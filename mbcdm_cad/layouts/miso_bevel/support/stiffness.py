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

import numpy as np

from mbcdm_cad.layouts.base import FrameCompliance, FrameStudy
from mbcdm_cad.layouts.miso_bevel.layout import BevelLayout
from mbcdm_cad.layouts.miso_bevel.support.loads import SeatLoads, seat_loads
from mbcdm_cad.layouts.miso_bevel.support.panels import mounts, support_mesh
from mbcdm_cad.layouts.structure import elastic
from mbcdm_cad.model.block_rows import Ints
from mbcdm_cad.model.plate_mesh import URAD_PER_MRAD, PlateMesh, centred_load, shares_urad, statically
from mbcdm_cad.model.si import to_si
from mbcdm_cad.model.stiffness import unit_tensions_N
from mbcdm_cad.model.structure.boss import BossRing
from mbcdm_cad.routes import Floats


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


def boss_ring(layout: BevelLayout) -> BossRing:
    """The ring round the drum's bearings, under the column."""
    f = layout.frame
    ends = f.encoder_pocket_floor_y, layout.levels.boss_front_y
    return BossRing(f.drum_seat_radius, f.boss_radius, f.column_pocket_bottom_z, *ends)


def frame_compliance(layout: BevelLayout) -> FrameCompliance:
    """Windup of the drum by the support per N m of external torque, with the share of each part.

    Raises ``ValueError`` if the dimensions leave no frame to compute.
    """
    material = layout.drive.frame_material
    loads = seat_loads(layout, unit_tensions_N(to_si(layout.drive)))
    mesh = support_mesh(layout)
    ground = mounts(layout).springs(mesh, material)
    shares = shares_urad(mesh, material, _half_load(layout, mesh, loads), ground)
    drum = "drum_rear", "drum_front"
    at = np.array([loads.point_mm[loads.names.index(n)][1] for n in drum])
    force = np.array([loads.at(n)[0] for n in drum])
    shares["boss ring"] = boss_ring(layout).work_Nmm(at, force, elastic(material)) * URAD_PER_MRAD
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
