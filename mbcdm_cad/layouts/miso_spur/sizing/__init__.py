"""Sizing rules of miso_spur: those of siso_spur, for the share of one input, and names of inputs and cables."""

from __future__ import annotations

from typing import Any

from mbcdm_cad.design.sized import Moved, Sizing
from mbcdm_cad.layouts.miso_spur.design_file.schema import REFERENCE
from mbcdm_cad.layouts.miso_spur.sizing.known import RoundDrumKnown
from mbcdm_cad.layouts.siso_spur.sizing import DERIVED, FREEDOMS, sized
from mbcdm_cad.sizing.rule import Rule, constant

__all__ = ["DERIVED", "FREEDOMS", "size"]


def _cables(given: RoundDrumKnown) -> list[dict[str, str]]:
    """The two sides of one cable for each input."""
    names = (item["name"] for item in given["inputs"])
    return [
        {"name": f"{name}_{n}", "input": name, "drum_side": side}
        for name in names
        for n, side in enumerate(("+x", "-x"), 1)
    ]


NAMES = (
    constant("inputs", REFERENCE.inputs, "two, one above and one below the drum", "least number of the configuration"),
    Rule("cables", "the two sides of one cable for each input", "the configuration", _cables),
)


def size(data: dict[str, Any], moved: Moved | None = None, similar: Sizing | None = None) -> Sizing:
    """The data with all open fields filled; ``moved`` changes the values that rules give.

    ``similar``: see :func:`~mbcdm_cad.layouts.trial_sizing.repeated`. Raises ``SizingError`` if a requirement
    is missing.
    """
    return sized(data, RoundDrumKnown, NAMES, moved, similar)
