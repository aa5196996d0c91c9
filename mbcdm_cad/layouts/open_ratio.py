"""A ratio that the file leaves open together with the motor: that of the lightest drive which passes every check.

Torque, speed, heat and back-driving fix only motor, gearhead and ratio together: a larger ratio has a smaller motor and
a larger drum. So whole drives are sized at round ratios, each with the train that its rules choose, and compared.
"""

from __future__ import annotations

import copy
import marshal
from dataclasses import replace
from math import inf
from typing import Any, Protocol

from mbcdm_cad.checks.size import kept_mass_g
from mbcdm_cad.design.rules import Broken
from mbcdm_cad.design.sized import LIGHTEST, Moved, Sizing, SizingError
from mbcdm_cad.layouts.base import Layout, NoFigureError
from mbcdm_cad.layouts.stiff_sizing import layout_of, misses
from mbcdm_cad.sizing.known import KnownFields
from mbcdm_cad.sizing.rule import Found, Rule

# Below the first no drive is built with a capstan; above the last the input of a thin rope outgrows any usual drum.
RATIOS = (2.0, 3.0, 4.0, 5.0, 6.0, 8.0, 10.0, 12.0, 15.0, 20.0)
# Wishes that choose a train.
_WISHES = ("peak_torque_Nm", "continuous_torque_Nm", "speed_deg_s", "backdrive_Nm", "duty", "payload")


class SizeWith(Protocol):
    """The rules of a layout, with one more before them."""

    def __call__(
        self, data: dict[str, Any], moved: Moved | None, similar: Sizing | None, ratio: tuple[Rule, ...]
    ) -> Sizing:
        """The data with its open fields filled."""


def lightest(
    size: SizeWith,
    field: str,
    data: dict[str, Any],
    moved: Moved | None,
    similar: Sizing | None,
    *,
    layout: type[Layout],
) -> Sizing:
    """The sizing with the ratio ``field`` of the lightest drive of all that fail fewest checks, and miss them least.

    A search (``moved``, with the sizing ``similar``) keeps the ratio that was found there. Raises ``SizingError`` where
    no ratio gives a drive.
    """
    ratio = similar.ratio if similar is not None else None
    if ratio is None:
        # One command sizes the same file several times.
        key = layout.__name__, marshal.dumps(data, 2)
        ratio = _FOUND.pop(key, None) or _lightest(size, field, data, layout)
        _FOUND[key] = ratio
        if len(_FOUND) > _REMEMBERED:
            del _FOUND[next(iter(_FOUND))]
    return _with(size, field, data, moved, similar, ratio)


# Ratios of the last files, the latest used last.
_FOUND: dict[tuple[str, bytes], float] = {}
_REMEMBERED = 64


def _lightest(size: SizeWith, field: str, data: dict[str, Any], layout: type[Layout]) -> float:
    ranked: list[tuple[tuple[int, float, float], float]] = []
    refused: list[NoFigureError | SizingError] = []
    for ratio in RATIOS:
        try:
            ranked.append((_rank(layout, _with(size, field, data, None, None, ratio)), ratio))
        except (NoFigureError, SizingError) as error:
            refused.append(error)
    if ranked:
        return min(ranked)[1]
    if isinstance(refused[0], SizingError) and len({str(error) for error in refused}) == 1:
        raise refused[0]  # a fault of the file, whatever the ratio
    what = f"missing, and no ratio from {RATIOS[0]:g} to {RATIOS[-1]:g} gives a drive: {refused[0]}"
    raise SizingError(Broken(tuple(field.split(".")), what, "", "", "add it, or name the motor under drive:"))


def _with(
    size: SizeWith, field: str, data: dict[str, Any], moved: Moved | None, similar: Sizing | None, ratio: float
) -> Sizing:
    found = size(copy.deepcopy(data), moved, similar, (_rule(field, ratio),))
    return replace(found, ratio=ratio)


def _rule(field: str, ratio: float) -> Rule:
    def chosen(given: KnownFields) -> Found:
        for wish in _WISHES:
            given.get(f"loads.{wish}")
        return Found(ratio, LIGHTEST, f"of {RATIOS[0]:g} to {RATIOS[-1]:g}")

    return Rule(
        field,
        "that of the lightest drive which passes, of round ratios with the motor and gearhead that loads ask for",
        "motor_torque_forward",
        chosen,
    )


def _rank(layout: type[Layout], sizing: Sizing) -> tuple[int, float, float]:
    """Number of failing checks, what they miss over their limits, mass in g."""
    found = layout_of(layout, sizing)
    missed = misses(found)
    try:
        mass_g = kept_mass_g(found, layout.bill)
    except (ValueError, ZeroDivisionError):
        mass_g = inf
    return len(missed), sum(missed.values()), mass_g
