"""A sizing rule: how one field follows from others, and why."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from math import ceil, floor
from typing import Any

from mbcdm_cad.sizing.known import KnownFields

# Tolerance, so that a figure that is already a multiple of its step is not rounded up.
_ON_STEP = 1e-9


@dataclass(frozen=True)
class Found:
    """Result of a rule: the value, the need that determined it, and how it was rounded."""

    value: Any
    driver: str = ""
    rounding: str = ""


@dataclass(frozen=True)
class Rule:
    """How one field is filled.

    ``text`` is one sentence for people; ``driver`` the check or requirement that the value serves, where ``value`` does
    not say which of several it was. ``value`` gets the configuration's :class:`~mbcdm_cad.sizing.known.KnownFields` and
    returns the value, or a :class:`Found`. ``applies``: whether the field belongs to this design at all.
    """

    field: str
    text: str
    driver: str
    value: Callable[[Any], Any]
    applies: Callable[[Any], bool] = lambda given: True


def rule(
    field: str, text: str, driver: str, applies: Callable[[Any], bool] = lambda given: True
) -> Callable[[Callable[[Any], Any]], Rule]:
    """Make the :class:`Rule` of a field, whose name is the function's, of the function below that gives its value."""
    return lambda value: Rule(field, text, driver, value, applies)


def rounded_up(value: float, step: float) -> float:
    """The value rounded up to a multiple of ``step``, without the noise of binary fractions."""
    return round(ceil(value / step - _ON_STEP) * step, 9)


def rounded_down(value: float, step: float) -> float:
    """The value rounded down to a multiple of ``step``."""
    return round(floor(value / step + _ON_STEP) * step, 9)


def significant(value: float, digits: int) -> float:
    """The value rounded to significant digits."""
    return float(f"{value:.{digits}g}")


def largest(needs: dict[str, float], step: float) -> Found:
    """The smallest value that meets all needs, rounded up; the need that determines it is the driver."""
    return Found(rounded_up(max(needs.values()), step), driver_of(needs, max), f"up to {step:g}")


def driver_of(needs: Mapping[str, float], which: Callable[..., str]) -> str:
    """Name of the largest need (``which`` is ``max``) or of the smallest (``min``)."""
    return which(needs, key=lambda name: needs[name])


def constant(field: str, value: Any, text: str, driver: str) -> Rule:
    """A field that has one value for every design."""

    def same(given: KnownFields) -> Any:
        return value

    return Rule(field, text, driver, same)
