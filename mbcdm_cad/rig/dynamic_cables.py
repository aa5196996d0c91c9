"""The cables as the dynamic rig sees them: for the angles of inputs and drum, what each pulls.

For now each is the plain spring of its free span; friction on the wraps follows with the chain.
"""

from __future__ import annotations

from math import sqrt

import numpy as np

from mbcdm_cad.design.drive import CableRun, Drive
from mbcdm_cad.rig.dynamic_compiled import Floats, compiled


def free_span_m(drive: Drive, cable: CableRun) -> float:
    """Internal tangent between input pulley and guide, m."""
    return sqrt(drive.centre_distance_mm**2 - (cable.guide_radius_mm + cable.input_radius_mm) ** 2) * 1e-3


def chains(drive: Drive) -> tuple[Floats, ...]:
    """The cables of ``drive`` at their preload, all angles zero."""
    rows = []
    for c in drive.cables:
        stiffness = drive.cable.axial_stiffness_N / free_span_m(drive, c)
        radii = (c.sigma * c.input_radius_mm * 1e-3, c.sigma * c.drum_radius_mm * 1e-3)
        rows.append([stiffness, *radii, c.preload_N, drive.input_names.index(c.input_name)])
    return (np.array(rows),)


@compiled
def pull(chains: tuple[Floats, ...], angles: Floats, tension: Floats) -> None:
    """Bring the cables to ``angles`` (inputs, then drum, rad) and fill ``tension`` (n_cables,), N."""
    table = chains[0]
    for j in range(table.shape[0]):
        row = table[j]
        stretch = row[1] * angles[int(row[4])] - row[2] * angles[angles.size - 1]
        tension[j] = max(row[3] + row[0] * stretch, 0.0)
