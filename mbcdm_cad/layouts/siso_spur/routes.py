"""The way of the cables from the input to the drum: the taut strand of one side, and the routes of the model.

All axes are parallel to the drum's (Y), so that the strand of one side lies in planes of X and Z. It is computed for
the side that lands on the drum at +x; the other one is its mirror image. Along the way to the drum that strand turns
about +Y with the drum, against it on the input, and on an idler in the sense that follows from the side on which it
passes the idler.

From a circle to the next, with D the line of their centres, R = s_2 r_2 - s_1 r_1 and J a quarter turn in the plane,
the tangent has the length L = sqrt(D^2 - R^2) and the direction t = (L D + R J D) / D^2 (derived; as in
:mod:`mbcdm_cad.routes.route`).

The origin is on the drum's axis, in the middle of the winding on the first input. The axis of the first input is at
z = L; the axes of other inputs are turned about Y and moved along it. A continuous cable goes N times round its input,
is anchored nowhere on it, and runs to the drum on both sides as an internal tangent, or, with open spans, as an
external one. As long as a part of it sticks on the input, each side acts as a separate cable. Two anchored cables
replace these sides: they are wound outwards from the points where their spans leave, so that the spans converge along
Y.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from math import cos, sin
from typing import NamedTuple

import numpy as np

from mbcdm_cad.routes import Floats, route

# Sense about +Y in which the cable turns on an idler of the side +x, which it passes at the line of centres.
SENSE = -1
# A wrap is taken from a quarter of a turn back, where the cable would not touch, up to three quarters.
_NO_WRAP = 0.5 * np.pi


def flange_radius_mm(radius_mm: float, rope_mm: float) -> float:
    """Radius of an idler's flanges: they stand half a rope's diameter over the cable, which they keep on the land."""
    return radius_mm + rope_mm


def idler_body(number: int, cable: str) -> str:
    """Name of the body of an idler of a cable, counted from the input."""
    return f"idler_{number}_{cable}"


class Circle(NamedTuple):
    """A pitch circle: centre in x and z, radius, and sense in which the cable turns about +Y on its way to the drum."""

    x: Floats | float
    z: Floats | float
    radius: Floats | float
    sense: int


class Strand(NamedTuple):
    """Taut strand over a row of circles; axis 0 of all arrays is the span, or the circle between two spans.

    Lengths and directions are nan where two circles overlap. ``heading`` is the angle of a direction about +Y, from +Z
    towards +X. ``wraps`` are below zero where the strand does not touch an idler. ``first``: sense on the first circle.
    """

    length: Floats
    heading: Floats
    wraps: Floats
    first: int

    @property
    def leaving_rad(self) -> Floats:
        """Angle on the first circle, from the line towards -Z the way that it turns, at which the strand leaves it."""
        angle = np.arctan2(-np.cos(self.heading[0]), np.sin(self.heading[0]))
        return np.asarray(angle if self.first < 0 else np.pi - angle)

    @property
    def landing_rad(self) -> Floats:
        """Angle on the last circle, from +Z towards +X, at which the strand lands."""
        return np.asarray(np.arctan2(-np.cos(self.heading[-1]), np.sin(self.heading[-1])))


def taut(circles: Sequence[Circle]) -> Strand:
    """The strand over circles in their order; their values broadcast, so that it may be that of many designs."""
    length, heading = [], []
    for one, two in pairwise(circles):
        x, z = np.asarray(two.x) - one.x, np.asarray(two.z) - one.z
        radius = np.asarray(two.sense * two.radius - one.sense * one.radius)
        apart = x**2 + z**2 > np.square(np.asarray(one.radius) + two.radius)
        span = np.sqrt(np.where(apart, x**2 + z**2 - radius**2, np.nan))
        length.append(span)
        # J turns (x, z) into (-z, x).
        heading.append(np.arctan2(span * x - radius * z, span * z + radius * x))
    turned = [
        np.mod(circle.sense * (after - before) + _NO_WRAP, 2 * np.pi) - _NO_WRAP
        for circle, before, after in zip(circles[1:-1], heading[:-1], heading[1:], strict=True)
    ]
    shape = np.broadcast_shapes(*(np.shape(values) for values in (*length, *heading, *turned)))

    def stacked(rows: Sequence[Floats]) -> Floats:
        return np.stack([np.broadcast_to(row, shape) for row in rows]) if rows else np.zeros((0, *shape))

    return Strand(stacked(length), stacked(heading), stacked(turned), circles[0].sense)


def no_strand(found: Strand) -> str:
    """Message for a strand that does not exist: pulleys that overlap, or an idler that the cable does not touch."""
    if np.isnan(found.length).any():
        rows = np.isnan(found.length).reshape(len(found.length), -1).any(axis=1)
        span = int(np.argmax(rows))
        one = "the input" if span == 0 else f"idler {span}"
        two = "the drum" if span == len(found.length) - 1 else f"idler {span + 1}"
        why = "so that the cable has no straight span; move the idlers or the input apart"
        return f"free span: {one} and {two} overlap, {why}"
    least = found.wraps.reshape(len(found.wraps), -1).min(axis=1)
    n = int(np.argmin(least))
    return (
        f"cable off idler {n + 1} of idlers.places: its wrap is {np.degrees(least[n]):.3g} deg (limit above 0); "
        "lower its x_mm, so that it presses the cable aside"
    )


DISTANCE = "centre_distance_m"


DRUM = "drum"


IDLER_RADIUS = "idler_radius_m"


_Y, _Z, _BACK = (0.0, 1.0, 0.0), (0.0, 0.0, 1.0), (0.0, -1.0, 0.0)


@dataclass(frozen=True)
class SpurGeometry(route.AnchoredGeometry):
    """Spans from radii and centre distance. ``drum_side`` and ``outward`` (n_cables,) are those of the runs.

    ``angle_rad`` (n_inputs,): position of each input about Y, from +Z towards +X. ``level_m``: position along Y of each
    pair of runs, which are the sides of one continuous cable and follow each other.
    ``apart_m``: half the distance along Y at which two anchored cables leave an input; None for a continuous cable.
    ``input_sense``: -1 where the spans do not cross.
    ``idlers``: x and z in m of those of the side +x from the input on, with that input at +Z.
    """

    cable_names: tuple[str, ...]
    input_names: tuple[str, ...]
    input_of: tuple[int, ...]
    angle_rad: tuple[float, ...]
    level_m: tuple[float, ...]
    drum_side: tuple[int, ...]
    outward: tuple[int, ...]
    turns: int
    lead_m: float
    apart_m: float | None = None
    idlers: tuple[tuple[float, float], ...] = ()
    input_sense: int = 1
    varied: tuple[route.Varied, ...] = (
        route.Varied(DISTANCE, "centre distance", (67e-3, 70e-3, 75e-3, 85e-3, 100e-3), (68e-3, 80e-3)),
    )

    @property
    def per_cable(self) -> tuple[str, ...]:
        """Radii."""
        return (
            (route.INPUT_RADIUS, route.DRUM_RADIUS, IDLER_RADIUS)
            if self.idlers
            else (route.INPUT_RADIUS, route.DRUM_RADIUS)
        )

    @property
    def passed_radii(self) -> dict[str, str]:
        """The idlers of each cable, from the drum on; they all have one radius."""
        numbers = range(len(self.idlers), 0, -1)
        return {idler_body(n, cable): IDLER_RADIUS for n in numbers for cable in self.cable_names}

    def strand(self, parameters: Mapping[str, Floats]) -> Strand:
        """Paths from input to drum in m, mirrored to the side +x: (n_spans, n_cables, *batch)."""
        return taut(
            [
                Circle(0.0, parameters[DISTANCE], parameters[route.INPUT_RADIUS], -self.input_sense),
                *(Circle(x, z, parameters[IDLER_RADIUS], SENSE) for x, z in self.idlers),
                Circle(0.0, 0.0, parameters[route.DRUM_RADIUS], 1),
            ]
        )

    def free_span_m(self, parameters: Mapping[str, Floats]) -> Floats:
        """L_free, all spans; without idlers sqrt(L^2 - (r_o +- r_i)^2), Eq. (11); minus for open spans.

        NaN where pulleys overlap, or an idler is not touched.
        """
        found = self.strand(parameters)
        return np.where((found.wraps > 0.0).all(axis=0), found.length.sum(axis=0), np.nan)

    def passed_wrap_rad(self, parameters: Mapping[str, Floats]) -> tuple[Floats, ...]:
        """Wrap on each idler, which one cable alone passes."""
        wraps = self.strand(parameters).wraps if self.idlers else np.empty(0)
        found = []
        for n in range(len(self.idlers), 0, -1):
            for j in range(len(self.cable_names)):
                own = np.zeros_like(wraps[n - 1])
                own[j] = wraps[n - 1][j]
                found.append(own)
        return tuple(found)

    def through_wrap_rad(self, parameters: Mapping[str, Floats]) -> Floats | None:
        """N turns less the angles from the line of centres to both spans; (n_cables / 2, *batch). None if anchored."""
        if self.apart_m is not None:
            return None
        leaving = self.strand(parameters).leaving_rad
        return np.asarray(2 * np.pi * self.turns - (leaving[::2] + leaving[1::2]))

    def fault(self, parameters: Mapping[str, Floats]) -> str:
        """Message if the pulleys overlap, or the cable does not touch an idler, else empty."""
        if self.idlers:
            return no_strand(self.strand(parameters))
        reach = parameters[route.DRUM_RADIUS] + parameters[route.INPUT_RADIUS]
        return (
            f"free span: centre distance {np.min(parameters[DISTANCE]):.6g} m does not exceed r_o + r_i = "
            f"{np.max(reach):.6g} m, so the cable has no straight span; raise centre_distance_mm or cut the radii"
        )

    def routes(self, parameters: Mapping[str, Floats]) -> route.DriveRoutes:
        """Bodies and both sides of one design."""
        distance, ratio = float(parameters[DISTANCE]), parameters[route.DRUM_RADIUS] / parameters[route.INPUT_RADIUS]
        bodies = [route.Body(DRUM, "drum", (0.0, 0.0, 0.0), _Y, _Z, 1.0)]
        for i, (name, angle) in enumerate(zip(self.input_names, self.angle_rad, strict=True)):
            turns = float(np.mean(ratio[np.array(self.input_of) == i]))
            # With crossed spans the input turns against the drum, with open ones with it: its angle about this axis has
            # the sign of the drum's.
            axis = _BACK if self.input_sense > 0 else _Y
            at, out = turned(angle, 0.0, distance), turned(angle, 0.0, 1.0)
            bodies.append(route.Body(route.input_body(name), "input", at, axis, out, turns))
        bodies[1:1] = self._idler_bodies(parameters)
        found = self.strand(parameters)
        sides = tuple(self._side(parameters, j, found) for j in range(len(self.cable_names)))
        return route.DriveRoutes(tuple(bodies), sides)

    def _idler_bodies(self, parameters: Mapping[str, Floats]) -> Iterator[route.Body]:
        """The idlers, each turning about +Y against the drum."""
        for n in range(len(self.idlers), 0, -1):
            x, z = self.idlers[n - 1]
            for j, cable in enumerate(self.cable_names):
                angle = self.angle_rad[self.input_of[j]]
                turns = SENSE * float(parameters[route.DRUM_RADIUS][j] / parameters[IDLER_RADIUS][j])
                at, out = turned(angle, self.drum_side[j] * x, z), turned(angle, 0.0, 1.0)
                yield route.Body(idler_body(n, cable), "passed", at, _Y, out, turns)

    def _side(self, parameters: Mapping[str, Floats], j: int, found: Strand) -> route.CableRoute:
        """A side over its idlers, if there are any; it rises along Y by its slope, on all its way."""
        side, cable = self.drum_side[j], self.cable_names[j]
        input_name, level = self.input_names[self.input_of[j]], self.level_m[j // 2]
        r_i, r_o = float(parameters[route.INPUT_RADIUS][j]), float(parameters[route.DRUM_RADIUS][j])
        # Of a continuous cable a side leaves the input at one end of the winding and goes on outwards.
        whole, rises, apart = self.through_wrap_rad(parameters), -self.outward[j], self.apart_m or 0.0
        if whole is not None:
            rises, apart = self.outward[j], self.lead_m * float(whole[j // 2]) / (4 * np.pi)
        through = whole is not None
        slope, at = rises * self.lead_m / (2 * np.pi * r_i), level + self.outward[j] * apart
        name = route.input_body(input_name)
        pieces: list[route.Piece] = [
            route.Anchor(name),
            # Heights count along the input's own axis, -Y, or Y with open spans.
            route.Wrap(name, r_i, np.inf, -self.input_sense * at, side, may_slip_through=through, lead_m=self.lead_m),
        ]
        for n in range(1, len(self.idlers) + 1):
            span, wrap = float(found.length[n - 1, j]), float(found.wraps[n - 1, j])
            r_k = float(parameters[IDLER_RADIUS][j])
            pieces.append(route.Span(span, self._direction(side, found, n - 1, j)))
            at += slope * (span + r_k * wrap / 2)
            pieces.append(route.Wrap(idler_body(n, cable), r_k, wrap, at, side * SENSE, passed=True))
            at += slope * r_k * wrap / 2
        last = float(found.length[-1, j])
        pieces += [
            route.Span(last, self._direction(side, found, -1, j)),
            route.Wrap(DRUM, r_o, np.inf, at + slope * last, side, lead_m=self.lead_m * r_o / r_i),
            route.Terminal(DRUM),
        ]
        return route.CableRoute(cable, input_name, self.sense[j], tuple(pieces))

    def _direction(self, side: int, found: Strand, span: int, j: int) -> tuple[float, float, float]:
        heading = float(found.heading[span, j])
        return turned(self.angle_rad[self.input_of[j]], side * sin(heading), cos(heading))


def turned(angle_rad: float, x: float, z: float) -> tuple[float, float, float]:
    """A vector given with its input above the drum, where the input stands at this angle from +Z towards +X."""
    return x * cos(angle_rad) + z * sin(angle_rad), 0.0, z * cos(angle_rad) - x * sin(angle_rad)
