"""The values that sizing adds to a design file for fields that it leaves out, each with its reason."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

from mbcdm_cad.design.rules import Broken

# What a search makes of the value that a rule finds, by field.
Moved = Mapping[str, Callable[[Any], Any]]

# The driver of a ratio that is that of the lightest drive.
LIGHTEST = "the lightest drive"


# Begins the driver of a field that the design has no use for.
NOT_USED = "not used: "


@dataclass(frozen=True)
class SizedValue:
    """A field that the file leaves out and a rule filled. Values are plain data, in the units of the field's name.

    ``rests_on`` holds the fields that the rule read, with their values; ``driver`` says what set the value: the id of
    the check whose limit it keeps, or the requirement that asks for it.
    """

    field: str
    value: Any
    text: str
    driver: str
    rests_on: Mapping[str, Any]
    rounding: str

    @property
    def reason(self) -> str:
        """What set the value, and by which rule; of a field that is not used only why."""
        return self.driver if self.driver.startswith(NOT_USED) else f"{self.driver}: {self.text}"


@dataclass(frozen=True)
class Sizing:
    """A file's data with every field filled, and a record for each field that a rule filled, in the rules' order.

    ``ends``: how the searches of the rules ended, where they search; the sizing of a similar design begins there.
    ``raised``: factors on the values of rules with which the design is as stiff, or turns as easily, as its file asks;
    None where it asks for neither. ``ratio``: what the lightest of several drives had, where file and rules of single
    fields leave the ratio open.
    """

    data: dict[str, Any]
    values: tuple[SizedValue, ...]
    ends: Mapping[Any, Any] = field(default_factory=dict)
    raised: Mapping[str, float] | None = None
    ratio: float | None = None

    def of(self, name: str) -> SizedValue | None:
        """The record of a field by its dotted name; None where the file gives it."""
        return next((value for value in self.values if value.field == name), None)


class SizingError(Exception):
    """What sizing cannot fill from what the file gives, as broken rules; becomes messages with file and line."""

    def __init__(self, *broken: Broken) -> None:
        super().__init__("; ".join(rule.what for rule in broken))
        self.broken = broken

    def __reduce__(self) -> tuple[type[SizingError], tuple[Broken, ...]]:
        """Whole across processes, as :class:`~mbcdm_cad.errors.InputError`."""
        return type(self), self.broken
