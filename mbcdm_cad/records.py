"""Dataclasses that start fast: same fields and meaning as those of the standard library, methods compiled when used.

The standard library compiles six methods of a frozen dataclass when its module is imported: for the 300 classes of a
check this took as long as all of its finite elements. Type checkers see the standard decorator. Not supported, because
unused: ``order``, ``slots``, ``InitVar``, ``init=False``.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from dataclasses import MISSING, FrozenInstanceError, asdict, field, fields, replace
from reprlib import recursive_repr
from types import MethodType
from typing import TYPE_CHECKING, Any

__all__ = ["asdict", "dataclass", "field", "fields", "replace"]

if TYPE_CHECKING:
    from dataclasses import dataclass
else:

    def dataclass(cls=None, /, *, frozen=False, eq=True, kw_only=False):
        """As ``dataclasses.dataclass``."""
        made = _maker(frozen, eq, kw_only)
        return made if cls is None else made(cls)


def _maker(frozen: bool, eq: bool, kw_only: bool) -> Callable[[Any], Any]:
    def made(cls: Any) -> Any:
        own = vars(cls)
        cls.__doc__ = own.get("__doc__") or cls.__name__  # the standard library writes a signature, which takes long
        methods: dict[str, Any] = {"__init__": _Late(cls, _init, frozen), "__repr__": _repr}
        if frozen:
            methods |= {"__setattr__": _refuse_setting, "__delattr__": _refuse_deleting}
        if eq:
            methods["__eq__"] = _Late(cls, _eq)
            if own.get("__hash__") is None:
                cls.__hash__ = _Late(cls, _hash) if frozen else None
        for name, method in methods.items():
            if name not in own:
                setattr(cls, name, method)
        return dataclasses.dataclass(init=False, repr=False, eq=False, kw_only=kw_only)(cls)

    return made


class _Late:
    """In place of a method of ``cls`` until that is asked for: then compiled from ``source`` (its text, its names)."""

    def __init__(self, cls: Any, source: Callable[..., tuple[str, dict[str, Any]]], *options: bool) -> None:
        self.cls, self.source, self.options = cls, source, options

    def __get__(self, one: Any, kind: Any = None) -> Any:
        text, names = self.source(self.cls, *self.options)
        name = f"_{self.source.__name__}__"  # of _init __init__
        exec(text, names)
        made = names[name]
        made.__qualname__ = f"{self.cls.__qualname__}.{name}"
        if self.source is _init:
            made.__annotations__ = {f.name: f.type for f in fields(self.cls)} | {"return": None}
        setattr(self.cls, name, made)
        return made if one is None else MethodType(made, one)


def _init(cls: Any, frozen: bool) -> tuple[str, dict[str, Any]]:
    """Sets the fields in their order and calls ``__post_init__``."""
    names: dict[str, Any] = {"MISSING": MISSING, "assign": object.__setattr__}
    positional, by_name, body = ["self"], ["*"], []
    for one in fields(cls):
        name = text = one.name
        if one.default is not MISSING:
            names[f"default_{name}"] = one.default
            text += f"=default_{name}"
        elif one.default_factory is not MISSING:
            names[f"made_{name}"] = one.default_factory
            text += "=MISSING"
            body.append(f"if {name} is MISSING: {name} = made_{name}()")
        (by_name if one.kw_only else positional).append(text)
        body.append(f"assign(self, {name!r}, {name})" if frozen else f"self.{name} = {name}")
    if hasattr(cls, "__post_init__"):
        body.append("self.__post_init__()")
    parameters = ", ".join(positional + (by_name if len(by_name) > 1 else []))
    return f"def __init__({parameters}):\n  " + "\n  ".join(body or ["pass"]), names


def _eq(cls: Any) -> tuple[str, dict[str, Any]]:
    mine, others = ("".join(f"{of}.{f.name}," for f in fields(cls) if f.compare) for of in ("self", "other"))
    same = f"({mine}) == ({others}) if other.__class__ is self.__class__ else NotImplemented"
    return f"def __eq__(self, other):\n  return {same}", {}


def _hash(cls: Any) -> tuple[str, dict[str, Any]]:
    values = "".join(f"self.{f.name}," for f in fields(cls) if (f.compare if f.hash is None else f.hash))
    return f"def __hash__(self):\n  return hash(({values}))", {}


@recursive_repr()
def _repr(self: Any) -> str:
    shown = (f"{f.name}={getattr(self, f.name)!r}" for f in fields(self) if f.repr)
    return f"{type(self).__qualname__}({', '.join(shown)})"


def _refuse_setting(self: Any, name: str, value: Any) -> None:
    raise FrozenInstanceError(f"cannot assign to field {name!r}")


def _refuse_deleting(self: Any, name: str) -> None:
    raise FrozenInstanceError(f"cannot delete field {name!r}")
