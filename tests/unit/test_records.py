"""Fast dataclasses behave as those of the standard library."""

from __future__ import annotations

import copy
import dataclasses
import inspect
import pickle
from typing import Any

import pytest

from mbcdm_cad import records


def _kinds(dataclass: Any) -> tuple[type[Any], type[Any]]:
    @dataclass(frozen=True)
    class Base:
        a: int
        b: float = 2.0
        c: list[int] = dataclasses.field(default_factory=list, hash=False)
        d: str = dataclasses.field(default="", compare=False, repr=False)

        def __post_init__(self) -> None:
            if self.b < 0.0:
                raise ValueError("b")

    @dataclass(kw_only=True, frozen=True)
    class Further(Base):
        e: str

    return Base, Further


def test_fast_dataclasses_are_those_of_the_standard_library() -> None:
    seen = []
    for dataclass in (records.dataclass, dataclasses.dataclass):
        base, further = _kinds(dataclass)
        parameters = [str(p.replace(default=p.empty)) for p in inspect.signature(further).parameters.values()]
        one, other = further(1, e="x", d="y"), further(a=1, b=2.0, e="x")
        same = (
            one == other,
            hash(one) == hash(other),
            one == base(1),
            one != further(2, e="x"),
            base(1) == base(1, 3.0),
        )
        told = repr(one).partition("<locals>")[2], dataclasses.asdict(one), dataclasses.replace(one, b=7.0).b
        refused = []
        for wrong in (lambda b=base: b(), lambda b=base: b(1, -1.0), lambda o=one: setattr(o, "a", 2), one.__delattr__):
            with pytest.raises((TypeError, ValueError, AttributeError)) as error:
                wrong("a") if wrong == one.__delattr__ else wrong()
            refused.append(str(error.value).partition("<locals>")[2] or str(error.value))
        seen.append((parameters, same, told, refused, copy.deepcopy(one) == one, base.__match_args__))
    assert seen[0] == seen[1]


@records.dataclass
class _Open:
    """One that may change, at the head of a module, where pickle finds it."""

    value: int = 1


def test_an_object_that_may_change_is_not_hashable_and_survives_pickle() -> None:
    one = _Open()
    one.value = 5
    assert pickle.loads(pickle.dumps(one)) == one != _Open()
    with pytest.raises(TypeError, match="unhashable"):
        hash(one)
