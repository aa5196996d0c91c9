"""Cables apart from the package: paths without a gap or a kink, and their equilibrium integrated in slices.

Two cables with a drum: an independent check of the model's law. Pieces of a path: where they join, and how near the
cable comes to its own last turn.
"""

from math import log, sqrt, tau
from typing import Any

import numpy as np

from mbcdm_cad.layouts.miso_bevel.cable_path import cable_path
from mbcdm_cad.layouts.miso_bevel.drive import BevelDrive, BevelRun
from mbcdm_cad.parts.drum_sector.design import SectorDrive
from mbcdm_cad.routes import Floats
from mbcdm_cad.routes.curves import Helix
from mbcdm_cad.routes.route import Body, Triple, Wrap

SLICES = 4000


def stretch_m(tension_N: float, preload_N: float, spans_m: tuple[float, float, float], ea_N: float, mu: float) -> float:
    """Stretch of one cable by summing up slices of its wraps; ``spans_m``: free length, radii of input and drum."""
    free, *radii = spans_m
    total = free * (tension_N - preload_N)
    reach = abs(log(tension_N / preload_N)) / mu
    step = reach / SLICES
    sign = 1.0 if tension_N < preload_N else -1.0
    for radius in radii:
        angles = (np.arange(SLICES) + 0.5) * step
        total += radius * step * float(np.sum(tension_N * np.exp(sign * mu * angles) - preload_N))
    return total / ea_N


def by_bisection(drive: SectorDrive, free_m: float, load_Nm: float) -> tuple[float, list[float]]:
    """(drum angle, tensions) at which both cables carry the load, each tension found from its stretch by bisection."""
    rope, mu = drive.cable, drive.friction_coefficient

    def tension(cable: int, angle: float) -> float:
        c = drive.cables[cable]
        radii = (free_m, c.input_radius_mm * 1e-3, c.drum_radius_mm * 1e-3)
        wanted = -c.sense * angle * c.drum_radius_mm * 1e-3
        low, high = 1e-3 * c.preload_N, 50.0 * c.preload_N
        for _ in range(60):
            middle = sqrt(low * high)
            if stretch_m(middle, c.preload_N, radii, rope.axial_stiffness_N, mu) < wanted:
                low = middle
            else:
                high = middle
        return sqrt(low * high)

    def carried(angle: float) -> float:
        return sum(c.sense * tension(k, angle) * c.drum_radius_mm * 1e-3 for k, c in enumerate(drive.cables))

    low, high = -5e-3, 5e-3
    for _ in range(45):
        middle = (low + high) / 2
        if carried(middle) > load_Nm:
            low = middle
        else:
            high = middle
    return middle, [tension(k, middle) for k in range(2)]


def assert_joined(path: Any) -> None:
    """Each piece of a cable's path begins where the one before ends, in its direction."""
    for (one, before), (two, after) in zip(path.pieces[:-1], path.pieces[1:], strict=True):
        gap = np.abs(before.points(np.array([1.0])) - after.points(np.array([0.0]))).max()
        kink = np.abs(before.tangent(1.0) - after.tangent(0.0)).max()
        assert gap < 1e-9 and kink < 1e-9, f"{path.cable.name}, {one} to {two}: {gap} mm, {kink}"


def self_clearance_mm(drive: BevelDrive, cable: BevelRun, drum_angle_rad: float) -> float:
    """Centre-line distance less d between the leaving span and the turn wound just before it (negative: they overlap).

    The fleet angle leads the span back over its own last turn, most at the fully wound end.
    """
    path = cable_path(drive, cable, 1.0, 1.0, drum_angle_rad)
    helix = path.piece("helix")
    assert isinstance(helix, Helix)
    per_turn = tau / abs(helix.angle_end - helix.angle_start)
    span = path.only(("span_in",)).sample(0.02)
    line = path.piece("span")
    span = np.concatenate([span, line.points(np.linspace(0.0, min(1.0, 8.0 / line.length_mm), 400))])
    span = np.concatenate([helix.points(np.linspace(1.0 - per_turn / 4, 1.0, 200)), span])
    turn = helix.points(np.linspace(max(0.0, 1.0 - 1.5 * per_turn), 1.0 - 0.5 * per_turn, 2000))
    best = np.inf
    for chunk in np.array_split(span, 8):
        gap = np.linalg.norm(chunk[:, None, :] - turn[None, :, :], axis=2).min()
        best = min(best, float(gap))
    return best - drive.cable.diameter_mm


def contact_point_m(body: Body, wrap: Wrap, direction: Triple) -> Floats:
    """Point (3,) at which a span of this direction touches the wrap's pitch circle."""
    axis = np.array(body.axis)
    out = np.cross(axis, direction)
    return np.asarray(np.array(body.point_m) + wrap.height_m * axis - wrap.turning * wrap.radius_m * out)
