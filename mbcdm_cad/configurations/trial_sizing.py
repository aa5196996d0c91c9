"""Sizing of drives with a motor head: fields, catalogue, and checks on a trial drive.

Rules find the value at which checks pass by running them on a trial drive. It is made of the fields known so far and,
for open fields, of their values from the previous pass. Passes are repeated until no field changes.
"""

from __future__ import annotations

import copy
from abc import abstractmethod
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from math import ceil, floor, inf, pi
from typing import Any

from pydantic import ValidationError

from mbcdm_cad.checks.comparison import Check
from mbcdm_cad.checks.design_under_test import DesignUnderTest, NoFigureError
from mbcdm_cad.design.blocks import Design
from mbcdm_cad.design.bought import Gearhead, Screw, least_wall_mm
from mbcdm_cad.design.lookup import Catalogue
from mbcdm_cad.design.rules import Broken, NamedEntry, every_broken_rule
from mbcdm_cad.design.sized import Moved, Sizing, SizingError
from mbcdm_cad.sizing.engine import fill
from mbcdm_cad.sizing.known import KnownFields, RopeKnown
from mbcdm_cad.sizing.rule import Found, Rule, rounded_up

# The schema's own.
NOZZLE_MM = 0.4
# Largest number of trials of one field: each moves it by the missing margin, so that a few are enough.
_MOST_TRIALS = 40
_MOST_PASSES = 4
# Fields that a length says nothing of.
_RATIOS = ("transmission.input_to_drum",)
_ON_STEP = 1e-9
# A value tried, and margin with its unit by check.
Trial = tuple[Any, dict[str, tuple[float, str]]]
# Parts and sizes of a medium drive, for fields that the first pass does not know yet.
MIDDLE_SIZE: Mapping[str, Any] = {
    "drive.encoder": "encoder-20-5",
    "drive.drum_encoder": "encoder-24-ring",
    "drum.bearing": "618/8",
    "drum.web_thickness_mm": 2.0,
    "drum.shaft_bore_mm": 2.0,
    "drum.hub_diameter_mm": 20.0,
    "input_pulleys.lower_bearing": "618/8",
    "input_pulleys.upper_bearing": "625",
    "support.motor_shelf_mm": 4.0,
    "support.bearing_shelf_mm": 6.0,
    "support.encoder_shelf_mm": 6.0,
    "support.coupling_space_mm": 15.0,
    "support.back_y_mm": -60.0,
    "limits.frame_windup_max_mrad": 1.0,
}


class TrialKnown(RopeKnown):
    """Adds figures that follow from a few fields each, and the checks on a trial drive.

    ``schema``: that of the configuration's files. ``asked``: fields on which every check on a trial drive depends,
    besides the dimensions known so far. ``own_checks``: checks of this configuration that a field must also pass,
    besides those that its rule names.
    """

    schema: type[Design]
    asked: tuple[str, ...] = ()
    own_checks: Mapping[str, tuple[str, ...]] = {}

    def __init__(self, data: dict[str, Any], guesses: Mapping[str, Any]) -> None:
        super().__init__(data)
        self.guesses = guesses

    @property
    def axial_stiffness_N(self) -> float:
        """EA of the rope: by the design's own modulus, else the catalogue's."""
        modulus = float(self.get("rope.modulus_GPa", self.rope["modulus_GPa"]))
        nominal = self.get("rope.modulus_area", self.rope["modulus_area"]) == "nominal"
        return modulus * 1e3 * (pi / 4 * self.d_mm**2 if nominal else float(self.rope["metallic_area_mm2"]))

    @property
    def gearhead(self) -> Gearhead:
        """The gearhead, or the motor's own face."""
        return Gearhead(name=self["drive.gearhead"], **self.entry("gearheads", "drive.gearhead"))

    def screw(self, name: str) -> Screw:
        """A screw of the catalogue."""
        return Screw(name=name, **self.entries("screws")[name])

    def printed(self, part: str) -> bool:
        """Whether a part is 3D printed."""
        return bool(self.entry("materials", f"{part}.material")["process"] in ("printed", "sintered"))

    def wall_mm(self, part: str) -> float:
        """Thinnest wall of the material of a part, ``"drum"``."""
        metal = self.entry("materials", f"{part}.material")
        nozzle = self.get("printing.nozzle_mm", NOZZLE_MM)
        return least_wall_mm(metal["process"], float(metal["min_wall_mm"]), nozzle)

    @property
    @abstractmethod
    def drum_mm(self) -> float:
        """Pitch radius of the drum, of its smallest step."""

    @property
    @abstractmethod
    def ratio(self) -> float:
        """Drum radius over input radius."""

    @property
    def input_peak_Nm(self) -> float:
        """Share of one input in the peak torque at the drum, N m."""
        return float(self["loads.peak_torque_Nm"] / max(1, len(self.get("inputs", ()))))

    @property
    def half_torque_N(self) -> float:
        """Tension that the peak torque adds to one cable of an input and takes from the other, N."""
        return self.input_peak_Nm * 1e3 / (2 * self.drum_mm)

    @abstractmethod
    def checks(self) -> Mapping[str, Check]:
        """The checks of the configuration, by id."""

    @abstractmethod
    def of_design(self, design: Any) -> DesignUnderTest:
        """A design of the configuration's schema, under test. Raises ``SizingError`` where it breaks a rule."""

    def under_test(self, data: dict[str, Any]) -> DesignUnderTest:
        """The design under test of complete data.

        Raises ``NoFigureError`` if the data give no drive, ``SizingError`` if the file breaks a rule.
        """
        try:
            design = self.schema.model_validate(data)
        except ValidationError as error:
            raise NoFigureError(f"what is known so far makes no drive: {error.errors()[0]['msg']}") from None
        return self.of_design(design)

    def trial(self, field: str, value: Any) -> DesignUnderTest:
        """The design under test with ``field`` at ``value``, known fields, and estimates for the open ones."""
        whole = KnownFields(copy.deepcopy(self.data))
        for name, guess in self.guesses.items():
            if not whole.has(name):
                whole.put(name, guess)
        whole.put(field, value)
        return self.under_test(whole.data)

    def margins(self, field: str, value: Any, checks: Iterable[str]) -> dict[str, tuple[float, str]]:
        """Margin and its unit by check, with ``field`` at ``value``; -inf where a check has no figure there."""
        found, known = {}, self.checks()
        for name in self.asked:
            self.get(name)
        try:
            under_test = self.trial(field, value)
        except NoFigureError:
            return dict.fromkeys(checks, (-inf, ""))
        for name in checks:
            try:
                comparison = known[name].measure(under_test)
            except (NoFigureError, ValueError, ZeroDivisionError):
                found[name] = (-inf, "")
            else:
                held = comparison.holds
                found[name] = (max(comparison.margin, 0.0) if held else min(comparison.margin, -1e-9), comparison.unit)
        return found

    def moved(self, field: str, start: float, step: float, checks: tuple[str, ...]) -> Found:
        """The value nearest to ``start``, at multiples of ``step`` in its direction, at which all the checks hold.

        Each trial moves by the missing margin of the worst check, if it is a length, else by growing steps. Checks that
        hold at no trial must be met by another field: they are left out of a second search. If that finds no value
        either, the result is the one that misses least.
        """
        checks = (*checks, *self.own_checks.get(field, ()))
        found, tried = self._searched(field, start, step, checks)
        if found is not None:
            return found
        within = _within_reach(checks, tried)
        if within and len(within) < len(checks):
            found, _ = self._searched(field, start, step, within)
            if found is not None:
                return replace(found, rounding=f"{found.rounding}; no value meets {_others(checks, within)}")
        nearest, margins = max(tried, key=_worst_margin)
        return Found(nearest, min(margins, key=lambda name: margins[name][0]), "no value passes: the nearest")

    def _searched(
        self, field: str, start: float, step: float, checks: tuple[str, ...]
    ) -> tuple[Found | None, list[Trial]]:
        """The value at which the checks hold, if any does; and all values tried, with their margins."""
        value = rounded_up(start, step) if step > 0.0 else _down(start, -step)
        driver, pace, tried = "", abs(step), []
        for _ in range(_MOST_TRIALS):
            margins = self.margins(field, value, checks)
            tried.append((value, margins))
            name = min(margins, key=lambda check: margins[check][0])
            missed, unit = margins[name]
            if missed >= 0.0:
                return Found(value, driver, f"{'up' if step > 0.0 else 'down'} to {abs(step):g}"), tried
            driver = name
            by = max(abs(step), -missed) if unit == "mm" and missed > -50.0 and field not in _RATIOS else pace
            pace *= 1.3
            value = rounded_up(value + by, step) if step > 0.0 else _down(value - by, -step)
        return None, tried

    def first(self, field: str, candidates: Iterable[Any], checks: tuple[str, ...]) -> Found:
        """The first candidate with which all the checks hold.

        Where there is none, the first with which those hold that hold with any candidate at all, else the one that
        misses least. Raises ``ValueError`` where there is no candidate.
        """
        driver, tried, checks = "", [], (*checks, *self.own_checks.get(field, ()))
        for value in candidates:
            margins = self.margins(field, value, checks)
            tried.append((value, margins))
            worst = min(margins, key=lambda check: margins[check][0])
            if margins[worst][0] >= 0.0:
                return Found(value, driver, "first that does")
            driver = worst
        if not tried:
            raise ValueError("the catalogue has nothing that could fit")
        within = _within_reach(checks, tried)
        for value, margins in tried if within else ():
            if all(margins[name][0] >= 0.0 for name in within):
                return Found(value, driver, "first that does; nothing meets " + _others(checks, within))
        nearest, margins = max(tried, key=_worst_margin)
        return Found(nearest, min(margins, key=lambda name: margins[name][0]), "nothing does: the nearest")


def _within_reach(checks: Iterable[str], tried: Sequence[Trial]) -> tuple[str, ...]:
    """The checks that hold in any of the trials: this field can meet them."""
    return tuple(name for name in checks if any(margins[name][0] >= 0.0 for _, margins in tried))


def _others(checks: Iterable[str], within: Sequence[str]) -> str:
    return ", ".join(name for name in checks if name not in within)


def _worst_margin(trial: Trial) -> float:
    return min(margin for margin, _ in trial[1].values())


def _down(value: float, step: float) -> float:
    return round(floor(value / step + _ON_STEP) * step, 9)


def sound(design: Design, broken: Iterator[Broken], named: Iterator[NamedEntry]) -> Catalogue:
    """The catalogue of a design that breaks no rule. Raises ``SizingError`` for the first that it breaks."""
    catalogue = Catalogue(design)
    first = next(every_broken_rule(design, catalogue, broken, named), None)
    if first is not None:
        raise SizingError(first)
    return catalogue


def repeated(
    data: dict[str, Any],
    known: Callable[[dict[str, Any], Mapping[str, Any]], TrialKnown],
    rules: Sequence[Rule],
    guesses: Mapping[str, Any],
    moved: Moved | None,
) -> Sizing:
    """The data with its open fields filled by ``rules``, in passes until no field changes."""
    for _ in range(_MOST_PASSES):
        sizing = fill(known(copy.deepcopy(data), guesses), rules, moved)
        found = {value.field: value.value for value in sizing.values}
        if all(guesses.get(field) == value for field, value in found.items()):
            break
        guesses = {**guesses, **found}
    return sizing


def whole_turns(angle_deg: float) -> int:
    """Least number of whole turns that contain an angle."""
    return max(1, ceil(angle_deg / 360.0))
