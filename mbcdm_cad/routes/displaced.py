"""Change of a cable's path when bodies are displaced from their axes, for example by an eccentric groove.

Displacing a body by e, where the cable arrives along u_in and leaves along u_out, changes its path by
e . (u_in - u_out) to first order; at an anchored end one of the two is missing. The exact change is a sum over the
spans. With D the line of centres of its two bodies in their plane, R = s_2 r_2 - s_1 r_1 and beta the turn of the span,

    L = sqrt(D^2 - R^2),  change = L' - L - R beta,

the last term being the rope that both wraps gain. Where the axes are not parallel, or the cable changes to the next
body at a point, only the first order is used; the second order is the rotation of the span, some nm for 10 um.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from mbcdm_cad.routes import Floats
from mbcdm_cad.routes.route import Body, CableRoute, DriveRoutes, Span, Wrap


def offset_m(body: Body, eccentricity_m: float, angle_rad: Floats) -> Floats:
    """Displacement (3, n), m, of a groove's centre at ``angle_rad`` (n,) about the axis from the reference."""
    first = np.array(body.reference)
    second = np.cross(body.axis, first)
    angle = np.asarray(angle_rad, dtype=float)
    return np.asarray(eccentricity_m * (first[:, None] * np.cos(angle) + second[:, None] * np.sin(angle)))


def path_slope(route: CableRoute, body: str) -> Floats:
    """u_in - u_out (3,): growth of the path per displacement of ``body``; zero if the cable does not run on it."""
    total = np.zeros(3)
    for contact in route.contacts():
        if contact.wrap.body == body:
            total = total + (0.0 if contact.arriving is None else np.array(contact.arriving))
            total = total - (0.0 if contact.leaving is None else np.array(contact.leaving))
    return total


def path_change_m(routes: DriveRoutes, route: CableRoute, offsets_m: Mapping[str, Floats]) -> Floats:
    """Exact change (n,) of the path's length for displacements (3, n) of bodies, by name."""
    n = next(iter(offsets_m.values())).shape[1]
    total = np.zeros(n)
    wraps = route.wraps
    for k, span in enumerate(route.spans):
        first, second = wraps[k], wraps[k + 1]
        apart = np.zeros((3, n))
        if second.body in offsets_m:
            apart = apart + offsets_m[second.body]
        if first.body in offsets_m:
            apart = apart - offsets_m[first.body]
        if apart.any():
            total = total + _span_change_m(routes, (first, second), span, apart)
    return total


def _span_change_m(routes: DriveRoutes, ends: tuple[Wrap, Wrap], span: Span, apart_m: Floats) -> Floats:
    """Change of one span, and of the rope that its rotation winds on or off at both ends, m (n,)."""
    one, two = (routes.body(wrap.body) for wrap in ends)
    axis = np.array(one.axis)
    parallel = float(np.dot(axis, two.axis))
    if span.length_m == 0.0 or abs(parallel) < 1.0 - 1e-12:
        return np.asarray(np.array(span.direction) @ apart_m)
    x = np.array(one.reference)
    plane = np.stack([x, np.cross(axis, x)])
    centres = plane @ (np.array(two.point_m) - np.array(one.point_m))
    radius = ends[1].turning * np.sign(parallel) * ends[1].radius_m - ends[0].turning * ends[0].radius_m
    moved = centres[:, None] + plane @ apart_m
    length = np.sqrt((moved * moved).sum(axis=0) - radius**2)
    turned = np.arctan2(moved[1], moved[0]) - np.arctan2(centres[1], centres[0])
    turned = np.arctan2(np.sin(turned), np.cos(turned))
    inclination = np.arctan2(radius, length) - np.arctan2(radius, span.length_m)
    return np.asarray(length - span.length_m - radius * (turned - inclination))
