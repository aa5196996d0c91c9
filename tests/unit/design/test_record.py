"""Records behave as the frozen dataclasses they stand for."""

from __future__ import annotations

import copy
import pickle
from dataclasses import FrozenInstanceError, asdict, dataclass, fields, replace
from functools import cached_property
from typing import Any

import pytest

from mbcdm_cad.record import record


@record
class Pin:
    """Two fields with a default among them, and what is worked out from them once."""

    name: str
    length_mm: float
    count: int = 1

    @cached_property
    def total_mm(self) -> float:
        """Length of all."""
        return self.length_mm * self.count


@record
class Hole:
    """One field, which ``attrgetter`` does not wrap in a tuple."""

    pin: Pin


@dataclass(frozen=True)
class _Frozen:
    """The standard class that ``Pin`` has to agree with."""

    name: str
    length_mm: float
    count: int = 1


@pytest.mark.parametrize(
    ("given", "named"),
    [
        (("a", 2.0), {}),
        (("a", 2.0, 3), {}),
        (("a",), {"length_mm": 2.0}),
        ((), {"count": 3, "length_mm": 2.0, "name": "a"}),
        (("a",), {}),
        (("a", 2.0, 3, 4), {}),
        (("a", 2.0), {"name": "b"}),
        (("a", 2.0, 3), {"name": "b"}),
        (("a", 2.0), {"colour": "red"}),
        (("a",), {"colour": "red"}),
        (("a",), {"length_mm": 2.0, "colour": "red"}),
    ],
)
def test_takes_the_arguments_that_a_frozen_dataclass_takes(given: tuple[Any, ...], named: dict[str, Any]) -> None:
    try:
        expected = _Frozen(*given, **named)
    except TypeError:
        with pytest.raises(TypeError, match=r"Pin\(\) takes name, length_mm, count"):
            Pin(*given, **named)
        return
    pin = Pin(*given, **named)
    assert asdict(pin) == asdict(expected)
    assert repr(pin).partition("(")[2] == repr(expected).partition("(")[2]


def test_equal_values_are_equal_and_hash_alike() -> None:
    assert Pin("a", 2.0) == Pin("a", 2.0, 1)
    assert hash(Pin("a", 2.0)) == hash(Pin("a", 2.0, 1))
    assert Pin("a", 2.0) != Pin("a", 2.5)
    assert Hole(Pin("a", 2.0)) == Hole(Pin("a", 2.0))
    assert Hole(Pin("a", 2.0)) != Hole(Pin("b", 2.0))
    assert Pin("a", 2.0) != _Frozen("a", 2.0)


def test_what_is_worked_out_from_the_fields_is_no_field() -> None:
    pin = Pin("a", 2.0, 3)
    assert pin.total_mm == 6.0
    assert pin == Pin("a", 2.0, 3)
    assert replace(pin, count=4).total_mm == 8.0
    assert [field.name for field in fields(pin)] == ["name", "length_mm", "count"]


def test_neither_set_nor_deleted() -> None:
    pin = Pin("a", 2.0)
    with pytest.raises(FrozenInstanceError, match="length_mm"):
        pin.length_mm = 3.0  # type: ignore[misc]
    with pytest.raises(FrozenInstanceError, match="length_mm"):
        del pin.length_mm
    assert pin == Pin("a", 2.0)


def test_copies_and_goes_to_other_processes() -> None:
    hole = Hole(Pin("a", 2.0))
    assert copy.deepcopy(hole) == hole
    assert pickle.loads(pickle.dumps(hole)) == hole


def test_a_class_that_expects_to_be_called_when_made_is_refused() -> None:
    class Checked:
        length_mm: float

        def __post_init__(self) -> None:
            """Would never run."""

    with pytest.raises(TypeError, match="__post_init__"):
        record(Checked)
