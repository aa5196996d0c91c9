"""Idlers that lead the cable to an input away from the joint: their block of the design file, and the taut strand.

All axes are parallel to the drum's (Y), so that the strand of one side lies in planes of X and Z. It is computed for
the side that lands on the drum at +x; the other one is its mirror image. Along the way to the drum that strand turns
about +Y with the drum, against it on the input, and on an idler in the sense that follows from the side on which it
passes the idler.

From a circle to the next, with D the line of their centres, R = s_2 r_2 - s_1 r_1 and J a quarter turn in the plane,
the tangent has the length L = sqrt(D^2 - R^2) and the direction t = (L D + R J D) / D^2 (derived; as in
:mod:`mbcdm_cad.routes.route`).
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from mbcdm_cad.design.fields import EntryName, Integer, Number, PlainBlock, choice, quantity
from mbcdm_cad.routes import Floats

# Sense about +Y in which the cable turns on an idler of the side +x, which it passes at the line of centres.
SENSE = -1
# A wrap is taken from a quarter of a turn back, where the cable would not touch, up to three quarters.
_NO_WRAP = 0.5 * np.pi


@dataclass(frozen=True, kw_only=True)
class IdlerPlace(PlainBlock):
    """Where an idler of the side that lands on the drum at +x stands; that of the other side is its mirror image.

    The cables pass between the two.
    """

    x_mm: Number = quantity("axis of the idler, from the line of centres", "(0, 2000]", example=14.0)
    z_mm: Number = quantity("axis of the idler, from the drum's axis towards the input", "(0, 2000]", example=90.0)


@dataclass(frozen=True, kw_only=True)
class IdlerBlock(PlainBlock):
    """Idlers between the input and the drum, in pairs, one for each side of the cable."""

    pairs: Integer | None = quantity(
        "number of pairs that the rule places; left out, that of places, or else one", example=1, ge=1, le=1
    )
    radius_mm: Number = quantity("pitch radius of all idlers", "(0, 500]", example=14.0)
    width_mm: Number = quantity("land of an idler along its axis, on which the cable walks", "(0, 300]", example=15.0)
    bearing: EntryName = choice("bearing in both ends of each idler", example="624")
    places: tuple[IdlerPlace, ...] = choice(
        "the idlers of the side that lands on the drum at +x, in the order from the input to the drum: "
        "{x_mm: X, z_mm: Z}; the other side has their mirror images",
        example=[{"x_mm": 14.0, "z_mm": 90.0}],
        min_length=1,
        max_length=8,
    )


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
