"""Radial loads that the cable tensions put on input pulleys, guide and drum, in the project's frame.

Seen along Z the internal tangent leaves the line of centres by beta = asin((r_g + r_i)/L). A cable of an input on
side s (-1 or +1 along X) that runs on the drum towards side q arrives at the guide along
u = (-s cos beta, -s q sin beta, 0), goes round it to the +y point and leaves along (q, 0, 0). Step k works in the
plane z = r_ok, on the drum in y = r_gk.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mbcdm_cad.model.si import DriveSI, Floats


@dataclass(frozen=True, eq=False)
class BearingLoads:
    """Forces (N) and moments (N m) on the bodies, as vectors (x, y, z).

    ``input_force_N`` (n_inputs, 3); ``input_line_z_m`` (n_inputs,) is the height at which it acts (tension-weighted);
    ``input_moment_Nm`` (n_inputs, 3) is about that point; ``guide_moment_Nm`` is about the middle of its steps on the
    Z axis; ``drum_moment_Nm`` is about the origin and leaves out the Y component, which is the load itself.
    """

    input_force_N: Floats
    input_line_z_m: Floats
    input_moment_Nm: Floats
    guide_force_N: Floats
    guide_moment_Nm: Floats
    drum_force_N: Floats
    drum_moment_Nm: Floats


def span_directions(d: DriveSI) -> Floats:
    """Unit vectors (n_cables, 3) along the free span from input to guide."""
    side = np.array([d.input_side[i] for i in d.input_of], dtype=float)
    towards = -d.sigma
    sine = (d.guide_radius_m + d.input_radius_m) / d.centre_distance_m
    return np.stack([-side * np.sqrt(1.0 - sine**2), -side * towards * sine, np.zeros_like(sine)], axis=1)


def bearing_loads(d: DriveSI, tension_N: Floats) -> BearingLoads:
    """Loads for the free-span tensions of one design and one load, shape (n_cables,)."""
    tension = np.asarray(tension_N, dtype=float)
    arriving = span_directions(d)
    leaving = np.stack([-d.sigma, np.zeros(d.n_cables), np.zeros(d.n_cables)], axis=1)
    height = d.drum_radius_m
    up = np.array([0.0, 0.0, 1.0])
    pull = tension[:, None] * arriving
    forces, lines, moments = [], [], []
    for i in range(d.n_inputs):
        own = np.array([k == i for k in d.input_of])
        line = float(np.average(height[own], weights=np.maximum(tension[own], 1e-12)))
        forces.append(pull[own].sum(axis=0))
        lines.append(line)
        moments.append(np.cross((height[own, None] - line) * up, pull[own]).sum(axis=0))
    on_guide = tension[:, None] * (leaving - arriving)
    from_middle = (height - 0.5 * (height.min() + height.max()))[:, None] * up
    on_drum = -tension[:, None] * leaving
    point = np.stack([np.zeros(d.n_cables), d.guide_radius_m, d.drum_radius_m], axis=1)
    drum_moment = np.cross(point, on_drum).sum(axis=0)
    drum_moment[1] = 0.0
    return BearingLoads(
        np.array(forces), np.array(lines), np.array(moments), on_guide.sum(axis=0),
        np.cross(from_middle, on_guide).sum(axis=0), on_drum.sum(axis=0), drum_moment,
    )  # fmt: skip


def two_bearing_reactions_N(force_N: Floats, moment_Nm: Floats, at_m: float, lower_m: float, upper_m: float) -> Floats:
    """Radial reactions (2, 3) of bearings at ``lower_m`` and ``upper_m`` to a force at height ``at_m`` and a moment."""
    arm = upper_m - lower_m
    # Equilibrium about the lower bearing: z x R_upper arm + z x F (at - lower) + moment = 0.
    from_moment = np.array([moment_Nm[1], -moment_Nm[0], 0.0]) / arm
    upper = -np.asarray(force_N) * (at_m - lower_m) / arm - from_moment
    return np.stack([-np.asarray(force_N) - upper, upper])
