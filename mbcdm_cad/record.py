"""Frozen dataclasses that are quick to define.

``@dataclass(frozen=True)`` writes and compiles the text of six methods for each class. A command uses some sixty such
classes, and defining them was a tenth of the whole time of ``mbcdm check``. The methods of a record are functions
compiled once with this module.
"""

from __future__ import annotations

from dataclasses import FrozenInstanceError, dataclass, fields
from operator import attrgetter
from typing import Any, NoReturn, TypeVar, dataclass_transform

_T = TypeVar("_T")


@dataclass_transform(frozen_default=True)
def record(cls: type[_T]) -> type[_T]:
    """As ``@dataclass(frozen=True)``, for fields without ``field(...)``: ``replace``, ``asdict`` and the like work.

    Raises ``TypeError`` for a class with ``__post_init__``, which no record calls.
    """
    if hasattr(cls, "__post_init__"):
        raise TypeError(f"{cls.__name__} has __post_init__; make it a dataclass, not a record")
    names = [field.name for field in fields(dataclass(init=False, repr=False, eq=False)(cls))]  # type: ignore[arg-type]
    known = set(names)
    values_of = attrgetter(*names)

    def init(self: Any, /, *given: Any, **named: Any) -> None:
        values = self.__dict__
        values.update(zip(names, given, strict=False), **named)
        if values.keys() != known or len(given) + len(named) != len(names):
            _refuse_wrong_call(cls, names, given, named)

    def text(self: Any) -> str:
        return f"{cls.__qualname__}({', '.join(f'{name}={getattr(self, name)!r}' for name in names)})"

    def equal(self: Any, other: object) -> Any:
        if other.__class__ is not self.__class__:
            return NotImplemented
        return values_of(self) == values_of(other)

    def hashed(self: Any) -> int:
        return hash(values_of(self))

    methods = {
        "__init__": init,
        "__repr__": text,
        "__eq__": equal,
        "__hash__": hashed,
        "__setattr__": _refuse_assignment,
        "__delattr__": _refuse_deletion,
    }
    for name, method in methods.items():
        setattr(cls, name, method)
    return cls


def _refuse_wrong_call(cls: type, names: list[str], given: tuple[Any, ...], named: dict[str, Any]) -> None:
    """``TypeError`` where arguments are missing, unknown or doubled. A default stays an attribute of the class."""
    by_place = names[: len(given)]
    missing = [name for name in names if name not in by_place and name not in named and not hasattr(cls, name)]
    wrong = [name for name in named if name in by_place or name not in names]
    if missing or wrong or len(given) > len(names):
        raise TypeError(
            f"{cls.__name__}() takes {', '.join(names)}; "
            f"missing: {', '.join(missing) or 'none'}, unknown or given twice: {', '.join(wrong) or 'none'}, "
            f"{len(given)} given by place"
        )


def _refuse_assignment(self: Any, name: str, value: Any) -> NoReturn:
    raise FrozenInstanceError(f"cannot assign to {name!r} of {type(self).__name__}")


def _refuse_deletion(self: Any, name: str) -> NoReturn:
    raise FrozenInstanceError(f"cannot delete {name!r} of {type(self).__name__}")
