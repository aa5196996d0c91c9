"""Placement of a part in the assembly: a rigid motion as plain numbers, which needs no kernel."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Row = tuple[float, float, float, float]
Vector = tuple[float, float, float]

_ORTHONORMAL_LIMIT = 1e-9


@dataclass(frozen=True)
class Placement:
    """Rigid motion from a part's own frame to the assembly's: the upper three rows of the 4 x 4 matrix, in mm.

    Raises ``ValueError`` for a matrix that scales, shears, mirrors or holds a number that is not finite.
    """

    rows: tuple[Row, Row, Row]

    def __post_init__(self) -> None:
        # Plain arithmetic: thousands of placements are made for one design, and small arrays are slow.
        if not all(math.isfinite(value) for row in self.rows for value in row):
            raise ValueError(f"placement holds a number that is not finite: {self.rows}")
        (a, b, c, _), (d, e, f, _), (g, h, i, _) = self.rows
        lengths = (a * a + b * b + c * c - 1.0, d * d + e * e + f * f - 1.0, g * g + h * h + i * i - 1.0)
        slants = (a * d + b * e + c * f, a * g + b * h + c * i, d * g + e * h + f * i)
        error = max(abs(value) for value in lengths + slants)
        determinant = a * (e * i - f * h) - b * (d * i - f * g) + c * (d * h - e * g)
        if error > _ORTHONORMAL_LIMIT or determinant < 0.0:
            raise ValueError(
                f"placement is not a rigid motion: R R^T differs from 1 by {error:.3g} (limit {_ORTHONORMAL_LIMIT:g}), "
                f"det R = {determinant:.6g} (must be +1): {self.rows}"
            )

    @classmethod
    def identity(cls) -> Placement:
        """The part's frame is the assembly's frame."""
        return cls.translation(0.0, 0.0, 0.0)

    @classmethod
    def translation(cls, x_mm: float, y_mm: float, z_mm: float) -> Placement:
        """A shift without rotation."""
        return cls(((1.0, 0.0, 0.0, x_mm), (0.0, 1.0, 0.0, y_mm), (0.0, 0.0, 1.0, z_mm)))

    @classmethod
    def about(cls, axis: Vector, angle_deg: float, point_mm: Vector = (0.0, 0.0, 0.0)) -> Placement:
        """Right-handed rotation by ``angle_deg`` about the line through ``point_mm`` along ``axis`` (any length).

        Multiples of 90 degrees about a coordinate axis come out exact (no 6e-17 in the files).
        """
        length = math.hypot(*axis)
        if length == 0.0:
            raise ValueError(f"rotation by {angle_deg} deg has no axis: {axis}")
        x, y, z = (component / length for component in axis)
        cosine, sine = _exact_cos_sin(angle_deg)
        rest = 1.0 - cosine
        rotation = np.array(
            [
                [cosine + x * x * rest, x * y * rest - z * sine, x * z * rest + y * sine],
                [y * x * rest + z * sine, cosine + y * y * rest, y * z * rest - x * sine],
                [z * x * rest - y * sine, z * y * rest + x * sine, cosine + z * z * rest],
            ]
        )
        point = np.array(point_mm)
        return cls._of(rotation, point - rotation @ point)

    @classmethod
    def _of(cls, rotation: NDArray[np.float64], shift: NDArray[np.float64]) -> Placement:
        rows = np.column_stack((rotation, shift)) + 0.0
        first, second, third = ((float(a), float(b), float(c), float(d)) for a, b, c, d in rows)
        return cls((first, second, third))

    @property
    def rotation(self) -> NDArray[np.float64]:
        """The 3 x 3 rotation matrix."""
        return np.array(self.rows)[:, :3]

    @property
    def shift_mm(self) -> NDArray[np.float64]:
        """Place of the part's origin in the assembly, mm, shape (3,)."""
        return np.array(self.rows)[:, 3]

    def __matmul__(self, inner: Placement) -> Placement:
        """``(a @ b)`` moves by b first, then by a."""
        (r0, r1, r2), columns = self.rows, tuple(zip(*inner.rows, strict=True))
        return Placement((_times(r0, columns), _times(r1, columns), _times(r2, columns)))

    @property
    def inverse(self) -> Placement:
        """The inverse motion."""
        back = self.rotation.T
        return self._of(back, -back @ self.shift_mm)

    def apply(self, points_mm: NDArray[np.float64]) -> NDArray[np.float64]:
        """Points (..., 3) of the part's frame in the assembly's frame, mm."""
        return np.asarray(points_mm) @ self.rotation.T + self.shift_mm


def _times(row: Row, columns: tuple[tuple[float, ...], ...]) -> Row:
    """One row of the product of two placements."""
    a, b, c, shift = row
    x, y, z, along = (a * u + b * v + c * w for u, v, w in columns)
    # Adding 0.0 turns -0.0 into 0.0, so that equal placements are written alike.
    return x + 0.0, y + 0.0, z + 0.0, along + shift + 0.0


def _exact_cos_sin(angle_deg: float) -> tuple[float, float]:
    quarter_turns, remainder = divmod(angle_deg, 90.0)
    if remainder == 0.0:
        return ((1.0, 0.0), (0.0, 1.0), (-1.0, 0.0), (0.0, -1.0))[int(quarter_turns) % 4]
    return math.cos(math.radians(angle_deg)), math.sin(math.radians(angle_deg))
