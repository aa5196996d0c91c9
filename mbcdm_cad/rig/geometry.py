"""Where each cable runs: tangent points and directions, from two circles and the sense of turning alone.

Seen from +z, guide at the origin, input pulley at C = (side L, 0). A cable travelling from input to drum turns round
the guide in the sense rho = -drum_side (it leaves the top of the guide along drum_side x), and round the input pulley
in the sense -rho. A line of direction t, with l = t turned left by 90 degrees, touches a circle of centre P, radius r
and sense s at P - s r l. Asking that guide and input be joined by t gives t itself; all else follows.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import atan2, pi, sqrt

import numpy as np
from numpy.typing import NDArray

from mbcdm_cad.design.drive import CableRun, Drive

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class CablePath:
    """One cable's path. Lengths in m; ``direction`` is the unit vector of its free span, from input to guide."""

    rho: int
    drum_side: int
    centre_m: tuple[float, float]
    radius_sum_m: float
    free_span_m: float
    direction: tuple[float, float]
    guide_wrap_rad: float

    def moved_m(self, guide_m: Floats, input_m: Floats, drum_m: Floats) -> Floats:
        """Exact change of the path's length, (n,), when the centres are displaced.

        ``guide_m`` and ``input_m`` (2, n) are (x, y) displacements; ``drum_m`` (n,) is the drum's along x, which is the
        direction of the rope at the transfer point. To first order guide: e.(t - drum_side x), input: -e.t. The second
        order is the turning of the span, of some nm for 10 um.
        """
        dx = self.centre_m[0] + input_m[0] - guide_m[0]
        dy = self.centre_m[1] + input_m[1] - guide_m[1]
        square = dx * dx + dy * dy
        span = np.sqrt(square - self.radius_sum_m**2)
        # The line of centres turns by the first term, the span against it by the second.
        turned = np.arctan2(dy, dx) - atan2(self.centre_m[1], self.centre_m[0])
        turned = np.arctan2(np.sin(turned), np.cos(turned))
        inclination = np.arctan2(self.radius_sum_m, span) - atan2(self.radius_sum_m, self.free_span_m)
        # A span turned by beta in the guide's sense takes rope off both wraps: rho beta = rho turned - inclination.
        wraps = -self.radius_sum_m * (self.rho * turned - inclination)
        return np.asarray(span - self.free_span_m + wraps + self.drum_side * (drum_m - guide_m[0]))


def cable_path(drive: Drive, cable: CableRun) -> CablePath:
    """The path of ``cable``; ValueError where guide and input pulley overlap, so that there is no span."""
    distance = drive.centre_distance_mm * 1e-3
    radii = (cable.guide_radius_mm + cable.input_radius_mm) * 1e-3
    if radii >= distance:
        raise ValueError(f"{cable.name}: r_g + r_i = {radii:.6g} m reaches the centre distance {distance:.6g} m")
    side, rho = cable.input_side, -cable.drum_side
    t_y = side * rho * radii / distance
    t_x = -side * sqrt(1.0 - t_y * t_y)
    # Landing point on the guide is -rho r_g l with l = (-t_y, t_x); the wrap ends at the top.
    landing = atan2(-rho * t_x, rho * t_y)
    wrap = (rho * (pi / 2.0 - landing)) % (2.0 * pi)
    return CablePath(
        rho=rho,
        drum_side=cable.drum_side,
        centre_m=(side * distance, 0.0),
        radius_sum_m=radii,
        free_span_m=sqrt(distance**2 - radii**2),
        direction=(t_x, t_y),
        guide_wrap_rad=wrap,
    )
