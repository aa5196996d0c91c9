"""What the sizing of all layouts reads: fields, catalogue, and checks on a trial drive.

Rules find the value at which checks pass by running them on a trial drive. It is made of the fields known so far and,
for open fields, of their values from the previous pass. Passes are repeated until no field changes.
"""

import copy
from abc import abstractmethod
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from math import ceil, floor, inf, pi
from typing import Any

from mbcdm_cad.checks.comparison import TOLERANCE
from mbcdm_cad.design import bought
from mbcdm_cad.design.paths import at
from mbcdm_cad.design.resolve import Catalogue
from mbcdm_cad.design.rules import every_broken_rule
from mbcdm_cad.design.sized import Moved, Sizing, SizingError
from mbcdm_cad.layouts.base import Layout, NoFigureError
from mbcdm_cad.layouts.trial_drives import At, End, Margin, TrialDrives, Way
from mbcdm_cad.sizing import Found, KnownFields, RopeKnown, Rule, fill, rounded_up

# Largest number of trials of one field: each moves it by the missing margin, so that a few are enough.
_MOST_TRIALS = 40
# If so many trials in a row miss the same check by the same amount, the field does not affect it.
_MOST_IDLE = 8
# Passes before the usual end of a sizing; what a drive misses is looked at after the second (``missed_before``).
# From the fourth pass, values that go up and down are no search for others any more.
_LEAST_PASSES, _LATE, _MOST_PASSES = 3, 4, 6
# Fields that are no lengths: a missing margin in mm does not give their next step.
_RATIOS = (at.transmission.input_to_drum,)
_ON_STEP = 1e-9
# Bore of the drum's shaft over the bore of its bearings.
SHAFT_BORE, SHAFT_BORE_SHARE = at.drum.shaft_bore_mm, 0.5
# A value tried, and margin with its unit by check.
Trial = tuple[Any, dict[str, Margin]]
# Parts and sizes of a medium drive, for fields that the first pass does not know yet.
MIDDLE_SIZE: Mapping[str, Any] = {
    at.drive.encoder: "encoder-20-5",
    at.drive.drum_encoder: "encoder-24-ring",
    at.drum.bearing: "618/8",
    at.drum.web_thickness_mm: 2.0,
    at.drum.shaft_bore_mm: 2.0,
    at.drum.hub_diameter_mm: 20.0,
    at.input_pulleys.lower_bearing: "618/8",
    at.input_pulleys.upper_bearing: "625",
    at.support.motor_shelf_mm: 4.0,
    at.support.bearing_shelf_mm: 6.0,
    at.support.encoder_shelf_mm: 6.0,
    at.support.coupling_space_mm: 15.0,
    at.support.back_y_mm: -60.0,
}
# The same of a pulley on the motor's shaft.
ON_SHAFT: Mapping[str, Any] = {
    at.drive.encoder: bought.NO_ENCODER,
    at.input_pulleys.lower_bearing: bought.NO_BEARING,
    at.input_pulleys.upper_bearing: bought.NO_BEARING,
}


class TrialKnown(RopeKnown):
    """Adds figures that follow from a few fields each, and the checks on a trial drive.

    ``guesses``: estimates for the fields that are still open.

    ``layout``: that of its drives. ``asked``: fields on which every check on a trial drive depends,
    besides the dimensions known so far. ``own_checks``: checks of this configuration that a field must also pass,
    besides those that its rule names; ``encoder_checks``: those of an input's encoder.
    """

    layout: type[Layout]
    asked: tuple[str, ...] = ()
    own_checks: Mapping[str, tuple[str, ...]] = {}
    encoder_checks: tuple[str, ...] = ("encoder_shelf",)
    # Half of the travel above which rules take a whole drum, of a configuration that has them.
    most_sector_travel_deg: float = inf

    def __init__(self, data: dict[str, Any], guesses: Mapping[str, Any], drives: TrialDrives | None = None) -> None:
        """``drives``: those of the pass before, which are not computed again."""
        super().__init__(data)
        self._file = KnownFields(copy.deepcopy(data))
        self.guesses = guesses
        self.drives = drives or TrialDrives(self.layout.design_file().schema, self.of_design)
        whole = KnownFields({})
        for field, guess in guesses.items():
            whole.put(field, guess)
        # The data of a trial: the known fields, and guesses of those that are still open.
        self._filled = self._at_start = _laid_over(whole.data, data)

    def put(self, field: str, value: Any) -> None:
        """See the base class."""
        super().put(field, value)
        self._filled = self._whole(field, value)

    def leave_out(self, field: str) -> None:
        """See the base class; later trials of the pass have no guess of the field either."""
        block, _, name = field.partition(".")
        if field in self.guesses:
            self._filled = {**self._filled, block: {k: v for k, v in self._filled[block].items() if k != name}}

    @property
    def axial_stiffness_N(self) -> float:
        """EA of the rope, with the modulus of the design, else of the catalogue."""
        modulus = float(self.get(at.rope.modulus_GPa, self.rope["modulus_GPa"]))
        nominal = self.get(at.rope.modulus_area, self.rope["modulus_area"]) == "nominal"
        return modulus * 1e3 * (pi / 4 * self.d_mm**2 if nominal else float(self.rope["metallic_area_mm2"]))

    @property
    def gearhead(self) -> bought.Gearhead:
        """The gearhead, or the motor's own face."""
        values = self.entry("gearheads", at.drive.gearhead)
        if self[at.drive.gearhead] == bought.NO_GEARHEAD:
            return bought.without_gearhead(
                bought.Motor(name=self[at.drive.motor], **self.entry("motors", at.drive.motor))
            )
        return bought.Gearhead(name=self[at.drive.gearhead], **values)

    @property
    def servo(self) -> bought.Servo | None:
        """What the motor has as a bought servo; None for a plain motor."""
        gear = self.gearhead
        return gear.servo if isinstance(gear, bought.ServoOutput) else None

    @property
    def overhung(self) -> bool:
        """Whether the shaft of motor or gearhead alone carries each input pulley."""
        return bool(self.get(at.input_pulleys.carried_by) == "motor")

    @property
    @abstractmethod
    def drum_mm(self) -> float:
        """Pitch radius of the drum, of its smallest step."""

    @property
    @abstractmethod
    def ratio(self) -> float:
        """Drum radius over input radius."""

    @property
    def has_ratio(self) -> bool:
        """Whether the ratio is known yet."""
        return True

    @property
    def input_peak_Nm(self) -> float:
        """Share of one input in the peak torque at the drum, N m."""
        return float(self[at.loads.peak_torque_Nm] / max(1, len(self.get("inputs", ()))))

    @property
    def half_torque_N(self) -> float:
        """Tension that the peak torque adds to one cable of an input and takes from the other, N."""
        return self.input_peak_Nm * 1e3 / (2 * self.drum_mm)

    def of_design(self, design: Any) -> Layout:
        """A design of the layout's schema, under test.

        Raises ``SizingError`` for the first rule that it breaks by a field of the file, ``NoFigureError`` for one that
        it breaks by a field of a trial.
        """
        file, catalogue = self.layout.design_file(), Catalogue(design)
        first = next(every_broken_rule(design, catalogue, file.rules(design), file.named(design)), None)
        if first is not None and self._file.has(".".join(part for part in first.path if isinstance(part, str))):
            raise SizingError(first)
        if first is not None:
            raise NoFigureError(first.what)
        return self.layout(file.drive(design, catalogue, {}))

    def filled(self, block: str) -> dict[str, Any]:
        """A block of a trial: its known fields, and guesses of those that are still open."""
        return dict(self._filled.get(block) or {})

    def trial(self, field: str, value: Any) -> Layout:
        """The drive under test with ``field`` at ``value``, all known fields, and guesses for the open ones.

        Raises ``NoFigureError`` if the data give no drive, ``SizingError`` if the file breaks a rule.
        """
        return self.drives.under_test(self._whole(field, value))

    def before(self) -> Layout:
        """The drive under test of the file and, for its open fields, of their values in the pass before.

        Raises ``NoFigureError`` if they describe no drive.
        """
        for name in self.asked:
            self.get(name)
        return self.drives.under_test(self._at_start)

    def missed_before(self, check: str) -> bool:
        """Whether the drive of the pass before, the third or a later one, misses a check."""
        return self.drives.passes > 1 and -inf < self._margins_of(self._at_start, (check,))[check][0] < 0.0

    def has_missed(self, check: str) -> bool:
        """Whether the drive of any pass so far, the second or a later one, missed a check."""
        if self.missed_before(check):
            self.drives.refused.add(check)
        return check in self.drives.refused

    def margins(self, field: str, value: Any, checks: Iterable[str], to_first_miss: bool = False) -> dict[str, Margin]:
        """Margin and its unit by check, with ``field`` at ``value``; -inf where a check has no figure there.

        ``to_first_miss``: see :meth:`~mbcdm_cad.layouts.trial_drives.TrialDrives.margins`.
        """
        return self._margins_of(self._whole(field, value), checks, to_first_miss)

    def _margins_of(
        self, data: dict[str, Any], checks: Iterable[str], to_first_miss: bool = False
    ) -> dict[str, Margin]:
        for name in self.asked:
            self.get(name)
        return self.drives.margins(data, checks, self.layout.checks_by_id(), to_first_miss)

    def _whole(self, field: str, value: Any) -> dict[str, Any]:
        """The data of a trial. Trials share the blocks in which the field is not, so that no block may be changed."""
        found = _with(self._filled, field.split("."), value)
        if field == at.drum.bearing and not self.has(SHAFT_BORE):
            # The bore of a shaft follows its bearing: that of a wider one would leave a thinner shaft no wall.
            most = _down(SHAFT_BORE_SHARE * self.entries("bearings")[value]["bore_mm"], 0.5)
            return _with(found, SHAFT_BORE.split("."), min(found["drum"].get("shaft_bore_mm", most), most))
        return found

    def moved(self, field: str, start: float, step: float, checks: tuple[str, ...]) -> Found:
        """The value nearest to ``start``, at multiples of ``step`` in its direction, at which all the checks hold.

        Each trial moves by the missing margin of the worst check, if it is a length, else by growing steps. Checks that
        hold at no trial must be met by another field: they are left out of a second search. If that finds no value
        either, the result is the one that misses least. If the pass before searched from the same start, the search
        goes on from its last trial that failed, unless that one holds now.
        """
        checks = (*checks, *self.own_checks.get(field, ()))
        start = rounded_up(max(start, self.drives.held.get(field, start)), step) if step > 0.0 else _down(start, -step)
        way = Way(field, start, step, checks)
        before = self.drives.ends.get(way)
        if before is not None:
            found, tried, failing = self._searched(way, before.checks, before.failing)
            if found is not None and (before.failing is None) == (len(tried) == 1):
                self.drives.ends[way] = End(before.checks, failing)
                return self._without(field, found, checks, before.checks)
        found, tried, failing = self._searched(way, checks)
        within = checks if found is not None else _within_reach(checks, tried)
        if found is None and within and len(within) < len(checks):
            found, _, failing = self._searched(way, within)
        if found is None:
            nearest, margins = max(tried, key=_worst_margin)
            return Found(nearest, min(margins, key=lambda name: margins[name][0]), "no value passes: the nearest")
        self.drives.ends[way] = End(within, failing)
        return self._without(field, found, checks, within)

    def _without(self, field: str, found: Found, checks: Sequence[str], within: Sequence[str]) -> Found:
        """The result with a note of the checks that were left out and still fail with it.

        Those left out in an earlier pass may hold now that other fields are known.
        """
        left = [name for name in checks if name not in within]
        missed = [name for name in left if self.margins(field, found.value, (name,))[name][0] < -TOLERANCE]
        return replace(found, rounding=f"{found.rounding}; no value meets {', '.join(missed)}") if missed else found

    def _searched(
        self, way: Way, checks: tuple[str, ...], begin: At | None = None
    ) -> tuple[Found | None, list[Trial], At | None]:
        """The value at which the checks hold, if any does; all values tried; and the last at which one did not.

        The search begins at the start of ``way``, or at ``begin``, the trial of an earlier search.
        """
        step = way.step
        value, pace = begin or At(way.start, abs(step))
        driver, tried, failing, idle = "", list[Trial](), None, 0
        for _ in range(_MOST_TRIALS):
            margins = self.margins(way.field, value, checks)
            idle = idle + 1 if tried and _missed(margins) == _missed(tried[-1][1]) else 0
            tried.append((value, margins))
            name = min(margins, key=lambda check: margins[check][0])
            missed, unit = margins[name]
            if missed >= 0.0:
                return Found(value, driver, f"{'up' if step > 0.0 else 'down'} to {abs(step):g}"), tried, failing
            if idle == _MOST_IDLE:
                break
            driver, failing = name, At(value, pace)
            by = max(abs(step), -missed) if unit == "mm" and missed > -50.0 and way.field not in _RATIOS else pace
            pace *= 1.3
            value = rounded_up(value + by, step) if step > 0.0 else _down(value - by, -step)
        return None, tried, failing

    def first(self, field: str, candidates: Iterable[Any], checks: tuple[str, ...]) -> Found:
        """The first candidate with which all the checks hold.

        If there is none, checks that hold with no candidate are left out; if still none fits, the one that misses
        least. Raises ``ValueError`` if there is no candidate.
        """
        checks, missed = (*checks, *self.own_checks.get(field, ())), list[Any]()
        for value in candidates:
            margins = self.margins(field, value, checks, to_first_miss=True)
            if _worst_margin((value, margins)) >= 0.0:
                return Found(value, self._driver(field, missed[-1], checks) if missed else "", "first that does")
            missed.append(value)
            if len(missed) == _MOST_IDLE and not any(
                self.margins(field, each, (name,))[name][0] > -inf for each in missed for name in checks
            ):
                break  # no candidate gives a figure for any check: another field is missing
        if not missed:
            raise ValueError("the catalogue has no entry that fits")
        tried = [(value, self.margins(field, value, checks)) for value in missed]
        driver = self._driver(field, missed[-1], checks)
        within = _within_reach(checks, tried)
        for value, margins in tried if within else ():
            if all(margins[name][0] >= 0.0 for name in within):
                return Found(value, driver, "first that does; no candidate meets " + _others(checks, within))
        nearest, margins = max(tried, key=_worst_margin)
        return Found(nearest, min(margins, key=lambda name: margins[name][0]), "no candidate does: the nearest")

    def _driver(self, field: str, value: Any, checks: Iterable[str]) -> str:
        """The check that ``value`` misses most."""
        margins = self.margins(field, value, checks)
        return min(margins, key=lambda name: margins[name][0])


def _within_reach(checks: Iterable[str], tried: Sequence[Trial]) -> tuple[str, ...]:
    """The checks that hold in any of the trials: this field can meet them."""
    return tuple(name for name in checks if any(margins[name][0] >= 0.0 for _, margins in tried))


def _others(checks: Iterable[str], within: Sequence[str]) -> str:
    return ", ".join(name for name in checks if name not in within)


def _worst_margin(trial: Trial) -> float:
    return min(margin for margin, _ in trial[1].values())


def _missed(margins: Mapping[str, Margin]) -> dict[str, Margin]:
    return {name: margin for name, margin in margins.items() if margin[0] < 0.0}


def _down(value: float, step: float) -> float:
    return round(floor(value / step + _ON_STEP) * step, 9)


def _with(block: Mapping[str, Any], path: Sequence[str], value: Any) -> dict[str, Any]:
    """A copy of a block with a value at a path below it."""
    first, *rest = path
    return {**block, first: _with(block.get(first) or {}, rest, value) if rest else value}


def _laid_over(below: Mapping[str, Any], above: Mapping[str, Any]) -> dict[str, Any]:
    """Values of ``above``, and those of ``below`` where these are missing, in an order that ``below`` begins."""
    found = {key: dict(value) if isinstance(value, dict) else value for key, value in below.items()}
    for key, value in above.items():
        if isinstance(value, dict):
            under = found.get(key)
            found[key] = _laid_over(under if isinstance(under, dict) else {}, value)
        elif value is not None or key not in found:
            found[key] = value
    return found


def repeated(
    data: dict[str, Any],
    known: type[TrialKnown],
    rules: Sequence[Rule],
    guesses: Mapping[str, Any],
    moved: Moved | None,
    similar: Sizing | None = None,
) -> Sizing:
    """The data with its open fields filled by ``rules``, in passes until no field changes.

    After as many passes as usual it goes on only while the drum's bearing of a pass does not carry that pass's drive.

    ``similar``: a sizing of nearly the same data. The first pass then starts with its values, which saves most of the
    trials; if the rules have more than one fixed point, the result may be another one than with ``guesses``.
    """
    before: Mapping[str, Any] = {}
    drives = known(data, guesses).drives
    if similar is not None:
        guesses = {**guesses, **{value.field: value.value for value in similar.values}}
        # A search in which a check was met by no value is made again, because a value may meet it here.
        drives.ends |= {way: end for way, end in similar.ends.items() if end.checks == way.checks}
        drives.refused |= similar.refused
        # Windows that were not closed are weighed again.
        drives.held |= {field: value for field, value in similar.held.items() if value}
        drives.passes = 1
    for passed in range(1, 2 * _MOST_PASSES + 1):
        given = known(copy.deepcopy(data), guesses, drives)
        sizing = fill(given, rules, moved)
        drives.passes += 1
        if passed == 1 and similar is None:
            drives.ends.clear()  # what no value met beside guesses, some value may meet now
        found = {value.field: value.value for value in sizing.values}
        settled = all(guesses.get(field) == value for field, value in found.items())
        if settled and (passed >= _LEAST_PASSES or similar is not None):
            break
        # Two values that ask for each other in turn, as a web and its rim, are settled by the larger.
        for value in sizing.values if passed >= _LATE else ():
            field, now = value.field, value.value
            back = isinstance(now, float) and now == before.get(field) != guesses[field]
            if back and "no value" not in value.rounding:
                drives.held[field] = max(now, guesses[field])
        before = guesses
        guesses = {**guesses, **found}
        if passed < _MOST_PASSES:
            continue
        # A drum's bearing that a rule chose and that does not carry the drive of its pass is refused by the next one.
        chosen, load = found.get(at.drum.bearing), "drum_bearings"
        if chosen is None or not -inf < given.margins(at.drum.bearing, chosen, (load,))[load][0] < 0.0:
            break
    return replace(sizing, ends=drives.ends, refused=frozenset(drives.refused), held=drives.held)


def whole_turns(angle_deg: float) -> int:
    """Least number of whole turns that contain an angle."""
    return max(1, ceil(angle_deg / 360.0))
