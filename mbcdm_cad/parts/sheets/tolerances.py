"""Geometric tolerances (ISO 1101) and the datums that they refer to (ISO 5459), as plain data of a sheet."""

from __future__ import annotations

from dataclasses import dataclass
from math import cos, radians, sin
from typing import Literal

Vector = tuple[float, float, float]
Characteristic = Literal["run-out", "perpendicularity", "parallelism", "coaxiality"]


@dataclass(frozen=True)
class Datum:
    """A plane face that tolerances refer to: a point of it in a view, and its letter.

    The axis of a cylinder is a datum by the field ``datum`` of its diameter instead.
    """

    view: str
    at: Vector
    letter: str


@dataclass(frozen=True)
class GeometricTolerance:
    """A tolerance of ``value_mm`` on the face at a point of a view.

    ``datums``: the letters that it refers to, ``("D-E",)`` for a common datum of two. ``count``: of how many equal
    features; ``at`` is on one of them, ``others`` one point on each of the rest. ``axis``: it holds for the axis of the
    cylinder there, within a cylinder of ``value_mm``; ``of``: the letter of those holes in the table of holes.
    """

    view: str
    at: Vector
    characteristic: Characteristic
    value_mm: float
    datums: tuple[str, ...]
    others: tuple[Vector, ...] = ()
    axis: bool = False
    of: str = ""

    @property
    def places(self) -> tuple[Vector, ...]:
        """A point on each feature that it holds for."""
        return (self.at, *self.others)


# Letters of the drum's axis and of the face on which heads and plates rest; holes have the letters from A on.
_BESIDE_RAD = radians(20.0)
DRUM_AXIS, REST = "S", "T"
# Two seats of one shaft that are bored in one setting, a bore that is square or parallel to them, and faces, mm.
ONE_AXIS_MM, TO_AXIS_MM, SHOULDER_MM, FACE_MM = 0.005, 0.02, 0.01, 0.02


def one_axis(view: str, seats: tuple[Vector, ...], datum: str) -> GeometricTolerance:
    """The seats at a point of their walls are on their common axis, the ``datum``."""
    return GeometricTolerance(view, seats[0], "coaxiality", ONE_AXIS_MM, (datum,), seats[1:], axis=True)


def square(view: str, at: Vector, datum: str, of: str, others: tuple[Vector, ...] = ()) -> GeometricTolerance:
    """The axis of the bore at a point of its wall is square to the axis ``datum``; ``of`` is the bore's letter."""
    return GeometricTolerance(view, at, "perpendicularity", TO_AXIS_MM, (datum,), others, axis=True, of=of)


def shoulder_place(seat_mm: float, shoulder_mm: float) -> tuple[float, float]:
    """A point of the shoulder of a seat round the origin, beside the holes that are often on its X axis."""
    middle = (seat_mm + shoulder_mm) / 2.0
    return middle * cos(_BESIDE_RAD), middle * sin(_BESIDE_RAD)


def level(view: str, at: Vector, value_mm: float, others: tuple[Vector, ...] = ()) -> GeometricTolerance:
    """The face at a point is parallel to the face on which the part rests."""
    return GeometricTolerance(view, at, "parallelism", value_mm, (REST,), others)
