"""Sizing rules of miso_spur: those of siso_spur with what each input holds, and names for inputs and cables."""

from __future__ import annotations

from typing import Any

from mbcdm_cad.configurations.miso_spur.design_file.reference import INPUTS, sides
from mbcdm_cad.configurations.miso_spur.sizing.known import RoundDrumKnown
from mbcdm_cad.configurations.siso_spur.sizing import DERIVED, sized
from mbcdm_cad.design.sized import Moved, Sizing
from mbcdm_cad.sizing.rule import Rule, constant

__all__ = ["DERIVED", "size"]


def _cables(given: RoundDrumKnown) -> list[dict[str, str]]:
    """Both sides of a cable for each input."""
    return sides(str(item["name"]) for item in given["inputs"])


NAMES = (
    constant("inputs", INPUTS, "two inputs, one above and one below the drum", "the fewest of the configuration"),
    Rule("cables", "both sides of a cable for each input", "the configuration", _cables),
)


def size(data: dict[str, Any], moved: Moved | None = None) -> Sizing:
    """The data with its gaps filled, values that rules find as ``moved`` makes them.

    Raises ``SizingError`` where a requirement is missing.
    """
    return sized(data, RoundDrumKnown, NAMES, moved)
