"""The reference drive, and functions that change one value of it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import cache, partial
from typing import Any

from mbcdm_cad.design.drive import Drive
from mbcdm_cad.layouts.loader import load_text, new_design_text

Change = Callable[[Drive, float], Drive]


@cache
def reference() -> Drive:
    """The drive of the reference design."""
    return load_text(new_design_text("reference")).drive


def put(drive: Drive, path: str, value: Any) -> Drive:
    """The drive with the attribute at a dotted ``path`` replaced."""

    def inside(block: Any, names: list[str]) -> Any:
        first, *rest = names
        return replace(block, **{first: inside(getattr(block, first), rest) if rest else value})

    changed: Drive = inside(drive, path.split("."))
    return changed


def to(path: str) -> Change:
    """Setting the attribute at a dotted path."""
    return lambda drive, value: put(drive, path, value)


def with_cable(drive: Drive, index: int, **changes: float) -> Drive:
    """The drive with fields of one cable replaced."""
    cables = list(drive.cables)
    cables[index] = replace(cables[index], **changes)  # type: ignore[arg-type]
    return replace(drive, cables=tuple(cables))


def radius_of(index: int, field: str) -> Change:
    """Setting one radius of one cable."""
    return lambda drive, value: with_cable(drive, index, **{field: value})


def _scaled(field: str, which: tuple[int, ...], drive: Drive, factor: float) -> Drive:
    for k in which:
        drive = with_cable(drive, k, **{field: getattr(drive.cables[k], field) * factor})
    return drive


def scaled(field: str, which: tuple[int, ...] = (0, 1, 2, 3)) -> Change:
    """Scaling a field of some cables."""
    return partial(_scaled, field, which)


def preloaded(drive: Drive, value: float) -> Drive:
    """All preloads at one value."""
    return replace(drive, cables=tuple(replace(c, preload_N=value) for c in drive.cables))


def with_screw(name: str, **factors: float) -> Change:
    """Scaling the fields of one screw of the catalogue by ``value``."""

    def change(drive: Drive, value: float) -> Drive:
        screws = tuple(
            replace(s, **{field: getattr(s, field) * value**power for field, power in factors.items()})  # type: ignore[arg-type]
            if s.name == name
            else s
            for s in drive.screws
        )
        return replace(drive, screws=screws)

    return change
