"""Sizing rules: how a field follows from others, and why; and a pass of rules over the data of a design file."""

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from math import ceil, floor
from typing import Any

from mbcdm_cad.design.rules import Broken
from mbcdm_cad.design.sized import Moved, SizedValue, Sizing, SizingError
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


def fill(given: KnownFields, rules: Iterable[Rule], moved: Moved | None = None) -> Sizing:
    """Fill every open field for which a rule applies; fields of the file do not change.

    ``moved``: by field, a function with which a search changes the value of a rule; later rules use the changed value.
    """
    moved = moved or {}
    records: list[SizedValue] = []
    for one in rules:
        if given.has(one.field):
            continue
        if not one.applies(given):
            given.leave_out(one.field)
            continue
        given.start()
        try:
            found = one.value(given)
        except (ValueError, ArithmeticError, IndexError) as error:
            path, why = tuple(one.field.split(".")), f"no rule can fill it here ({error})"
            raise SizingError(
                Broken(path, why, "", "", f"state it in the file; its rule gives: {one.text}", may_move=True)
            ) from None
        if not isinstance(found, Found):
            found = Found(found)
        if one.field in moved:
            found = Found(moved[one.field](found.value), found.driver, "moved")
        rests_on = given.read
        given.put(one.field, found.value)
        records.append(
            SizedValue(one.field, found.value, one.text, found.driver or one.driver, rests_on, found.rounding)
        )
    return Sizing(given.data, tuple(records))
