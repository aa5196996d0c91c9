"""Geometric tolerances (ISO 1101) and the datums that they refer to (ISO 5459), as plain data of a sheet."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

Vector = tuple[float, float, float]
Characteristic = Literal["run-out", "perpendicularity", "parallelism"]


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
    features; ``at`` is on one of them, ``others`` one point on each of the rest.
    """

    view: str
    at: Vector
    characteristic: Characteristic
    value_mm: float
    datums: tuple[str, ...]
    others: tuple[Vector, ...] = ()

    @property
    def places(self) -> tuple[Vector, ...]:
        """A point on each feature that it holds for."""
        return (self.at, *self.others)
