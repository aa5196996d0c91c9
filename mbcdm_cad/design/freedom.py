"""Which of the fields that a file leaves out ``mbcdm solve`` may change, and within which limits."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from math import log
from typing import Any


def scaled(value: Any, factor: float) -> Any:
    """A number times a factor, to four significant digits: what a file can be written with.

    Of a list, such as the radii of steps, the first value stays and the distances from it are multiplied.
    """
    if isinstance(value, list):
        return [round(value[0] + factor * (item - value[0]), 3) for item in value]
    return float(f"{value * factor:.4g}")


def to_a_size(sizes: Sequence[float], value: float, factor: float) -> float:
    """A number times a factor, to the nearest (by ratio) of the ``sizes`` in which its part is bought."""
    return min(sizes, key=lambda size: abs(log(size / (value * factor))))


def nothing_instead(data: Mapping[str, Any]) -> dict[str, Any]:
    """No fields to add in place of a field that is taken out."""
    return {}


@dataclass(frozen=True)
class Freedom:
    """One field that follows from a rule, and the range in which a search may change it.

    A number is moved by a factor between ``low`` and ``high``: ``stretch(value, factor)`` is the moved value. A choice
    is one of ``words``, the schema's own first, or of the catalogue's entries of ``kind``, which ``order`` sorts by
    size. ``mends`` names design variables of the checks' remedies that this field stands for, +1 where both rise
    together. ``only_named``: tried only where a failing check names it. ``instead``: the requirements that take the
    field's place where it is taken out of a file, from the file's data.
    """

    field: str
    low: float = 1.0
    high: float = 1.0
    stretch: Callable[[Any, float], Any] = scaled
    kind: str = ""
    order: str = ""
    words: tuple[str, ...] = ()
    mends: tuple[tuple[str, int], ...] = ()
    only_named: bool = False
    instead: Callable[[Mapping[str, Any]], dict[str, Any]] = nothing_instead

    @property
    def is_choice(self) -> bool:
        """Whether the field names something, rather than being a number."""
        return bool(self.kind or self.words)
