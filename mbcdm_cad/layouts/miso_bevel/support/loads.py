"""Forces of the cables' tensions on the support, at the seats of its bearings and of the guide's axle.

Each pulley is a rigid body on two supports, so that equilibrium alone gives the forces. The drum's shaft lies in two
bearings in the boss, each input pulley and the guide's axle between the bearing shelf and the top plate.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mbcdm_cad.layouts.miso_bevel.layout import BevelLayout
from mbcdm_cad.layouts.miso_bevel.routes import GUIDE
from mbcdm_cad.model.equilibrium import bearing_loads, two_bearing_reactions_N
from mbcdm_cad.model.si import MM, to_si
from mbcdm_cad.routes import Floats


@dataclass(frozen=True, eq=False)
class SeatLoads:
    """Forces on the support (N), rows of (x, y, z), at points (mm), in the order of ``names``; and the couple about Z
    (N m) that each gearhead, which holds its input, puts on the motor shelf."""

    names: tuple[str, ...]
    point_mm: Floats
    force_N: Floats
    gearhead_torque_Nm: Floats

    def at(self, name: str) -> Floats:
        """Force (3,) on the seat called ``name``."""
        return np.asarray(self.force_N[self.names.index(name)])


def seat_points_mm(layout: BevelLayout) -> dict[str, tuple[float, float, float]]:
    """Where drum bearings, guide axle and input bearings press on frame and top plate: the middles of the seats."""
    v, frame, plate = layout.levels, layout.frame, layout.top_plate
    rear, front = layout.drum_bearings_mm
    lower, upper = layout.axle_supports_mm
    points = {
        "drum_rear": (0.0, rear, 0.0),
        "drum_front": (0.0, front, 0.0),
        "axle_lower": (0.0, 0.0, lower),
        "axle_upper": (0.0, 0.0, upper),
    }
    for pulley in layout.inputs:
        points[f"{pulley.name}_lower"] = (pulley.x, pulley.y, v.bearing_shelf_top_z - frame.seat_depth / 2)
        points[f"{pulley.name}_upper"] = (pulley.x, pulley.y, v.top_plate_bottom_z + plate.seat_depth / 2)
    return points


def seat_loads(layout: BevelLayout, tension_N: Floats) -> SeatLoads:
    """Forces of the given tensions (n_cables,), which may be differences and negative, on the support's seats."""
    d = to_si(layout.drive)
    loads = bearing_loads(d, tension_N)
    points = seat_points_mm(layout)
    forces: dict[str, Floats] = {}

    def share(body: str, low: str, high: str, force: Floats, moment: Floats, at_m: float) -> None:
        lower, upper = (points[f"{body}_{end}"][2] * MM for end in (low, high))
        reaction = two_bearing_reactions_N(force, moment, at_m, lower, upper)
        forces[f"{body}_{low}"], forces[f"{body}_{high}"] = -reaction

    guide = loads.bodies[GUIDE]
    share("axle", "lower", "upper", guide.force_N, guide.moment_Nm, guide.height_m)
    for name, load in zip(layout.drive.input_names, loads.inputs, strict=True):
        share(name, "lower", "upper", load.force_N, load.moment_Nm, load.height_m)
    # The drum's axis is Y: moments about x and z are taken by the couple of its bearings, as forces along z and x.
    rear, front = points["drum_rear"][1] * MM, points["drum_front"][1] * MM
    force, moment = loads.drum.force_N, loads.drum.moment_Nm
    couple = np.array([-moment[2], 0.0, moment[0]])
    forces["drum_front"] = (couple - rear * force) / (front - rear)
    forces["drum_rear"] = force - forces["drum_front"]
    names = tuple(points)
    pull = d.sigma * np.asarray(tension_N, dtype=float) * d.input_radius_m
    torque = np.array([-(pull * d.of_input(i)).sum() for i in range(d.n_inputs)])
    return SeatLoads(names, np.array([points[n] for n in names]), np.array([forces[n] for n in names]), torque)
