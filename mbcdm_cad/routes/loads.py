"""The load of the cables on a body: the vector sum of the tensions of the spans that run on to it and off it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from mbcdm_cad.routes import Floats
from mbcdm_cad.routes.route import DriveRoutes, Triple


@dataclass(frozen=True, eq=False)
class BodyLoad:
    """Force (3,) in N on a body, and the moment (3,) in N m about the point of its axis at ``height_m``.

    The moment leaves out its component along the axis, which is the torque that the body transmits.
    """

    force_N: Floats
    height_m: float
    moment_Nm: Floats


def body_load(routes: DriveRoutes, name: str, tension_N: Floats) -> BodyLoad:
    """Load on the body ``name`` for free-span tensions (n_cables,), which may be differences and negative.

    The moment is about the height of the pull's line of action on an input, the middle of the steps on a body that is
    passed, and the origin of the drum's axis.
    """
    body = routes.body(name)
    tension = np.asarray(tension_N, dtype=float).tolist()
    # Plain numbers: a body has a few contacts, and numpy's calls take several times as long for so few.
    pulls = [(tension[j], height, [tension[j] * part for part in pull]) for j, height, pull in routes.pulls[name]]
    if not pulls:
        return BodyLoad(np.zeros(3), 0.0, np.zeros(3))
    middle = 0.0
    if body.kind == "input":
        weights = [max(pulled, 1e-12) for pulled, _, _ in pulls]
        middle = sum(at * weight for (_, at, _), weight in zip(pulls, weights, strict=True)) / sum(weights)
    elif body.kind == "passed":
        heights = [at for _, at, _ in pulls]
        middle = 0.5 * (min(heights) + max(heights))
    moments = []
    for _, at, (x, y, z) in pulls:
        ax, ay, az = ((at - middle) * part for part in body.axis)
        moments.append((ay * z - az * y, az * x - ax * z, ax * y - ay * x))
    return BodyLoad(_summed([pull for _, _, pull in pulls]), middle, _summed(moments))


def _summed(vectors: Sequence[Sequence[float]]) -> Floats:
    return np.array([sum(parts) for parts in zip(*vectors, strict=True)])


def two_bearing_reactions_N(
    force_N: Floats, moment_Nm: Floats, at_m: float, lower_m: float, upper_m: float, axis: Triple = (0.0, 0.0, 1.0)
) -> Floats:
    """Radial reactions (2, 3) of bearings at ``lower_m`` and ``upper_m`` to a force at height ``at_m`` and a moment.

    Heights count along the unit vector ``axis``.
    """
    arm = upper_m - lower_m
    # Equilibrium about the lower bearing: a x R_upper arm + a x F (at - lower) + moment = 0.
    (ax, ay, az), (mx, my, mz) = axis, moment_Nm
    # Minus the cross product a x moment, written out: numpy's takes several times as long for one vector.
    from_moment = np.array([az * my - ay * mz, ax * mz - az * mx, ay * mx - ax * my]) / arm
    upper = -np.asarray(force_N) * (at_m - lower_m) / arm - from_moment
    return np.stack([-np.asarray(force_N) - upper, upper])
