"""Arithmetic of sizing rules, on one number or on a :class:`PerDesign` of numbers, one a design.

A rule is written once, with these functions instead of those of :mod:`math`. For one design they are those of ``math``;
for many designs the same rule then works on whole columns. Where a rule decides between two ways (``if``, ``max``, the
choice of a part) and the designs of a column do not agree, :class:`Split` says which of them go which way, and
:func:`mbcdm_cad.sizing.bulk.fill_many` runs the rule again on each part.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from functools import reduce
from typing import Any

import numpy as np


class Split(Exception):  # noqa: N818 - no error: it tells the engine how to divide the designs
    """The designs of a column do not agree on a condition: ``holds`` says for which of them it is true."""

    def __init__(self, holds: Any) -> None:
        super().__init__("designs go different ways here")
        self.holds = holds


class PerDesign(np.ndarray):
    """One value for each of several designs. As a condition it must agree for all, else it raises :class:`Split`."""

    def __bool__(self) -> bool:
        """The truth value that all designs share. Raises :class:`Split` if they differ."""
        holds = np.asarray(self, dtype=bool)
        if holds.all():
            return True
        if holds.any():
            raise Split(holds)
        return False

    # Each number is rounded alone, so that the result is exactly that of a single design.
    def __round__(self, digits: int = 0) -> PerDesign:
        """Rounded to decimals."""
        return per_design([round(value, digits) for value in self.tolist()])

    def __ceil__(self) -> PerDesign:
        """Next whole number upwards."""
        return np.ceil(self).view(PerDesign)

    def __floor__(self) -> PerDesign:
        """Next whole number downwards."""
        return np.floor(self).view(PerDesign)


def per_design(values: Any) -> PerDesign:
    """The values as a column."""
    return np.asarray(values, dtype=float).view(PerDesign)


def number(value: Any) -> float:
    """``float(value)`` for a number; a column stays a column, also where a rule's annotation says ``float``."""
    found: Any = value if isinstance(value, PerDesign) else float(value)
    return found  # type: ignore[no-any-return]


def significant(value: float, digits: int) -> float:
    """Rounded to significant digits."""
    if isinstance(value, PerDesign):
        return per_design([significant(one, digits) for one in value.tolist()])
    return float(f"{value:.{digits}g}")


def _either(of_one: Callable[..., float], of_many: Callable[..., Any], text: str) -> Callable[..., float]:
    def either(*values: float) -> float:
        return of_many(*values) if any(isinstance(value, PerDesign) for value in values) else of_one(*values)

    either.__doc__ = text
    return either


greatest = _either(
    lambda *values: max(values),
    lambda *values: reduce(np.maximum, values),
    "Largest of the values, one or more, design by design.",
)
least = _either(
    lambda *values: min(values),
    lambda *values: reduce(np.minimum, values),
    "Smallest of the values, one or more, design by design.",
)
sqrt = _either(math.sqrt, np.sqrt, "Square root.")
hypot = _either(math.hypot, np.hypot, "Length of a vector of two components.")
sin = _either(math.sin, np.sin, "Sine of an angle in rad.")
cos = _either(math.cos, np.cos, "Cosine of an angle in rad.")
tan = _either(math.tan, np.tan, "Tangent of an angle in rad.")
atan = _either(math.atan, np.arctan, "Angle in rad of a tangent.")
radians = _either(math.radians, np.radians, "Degrees to rad.")


def index_of_greatest(values: Sequence[float]) -> int:
    """Index of the largest value, the first of equals. Raises :class:`Split` where designs do not agree."""
    if not any(isinstance(value, PerDesign) for value in values):
        return max(range(len(values)), key=lambda k: values[k])
    which = np.argmax(np.stack(np.broadcast_arrays(*(np.asarray(value) for value in values))), axis=0)
    if not (which == which.flat[0]).all():
        raise Split(which == which.flat[0])
    return int(which.flat[0])
