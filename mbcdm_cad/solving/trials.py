"""Evaluate a trial of a search: the checks that fail on it, and by how much."""

import os
import warnings
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from math import inf, isfinite, log
from typing import Any

import numpy as np

from mbcdm_cad.checks.comparison import Check
from mbcdm_cad.checks.run import Budget, run_check
from mbcdm_cad.design.drive import Drive
from mbcdm_cad.design.loader import Resolved
from mbcdm_cad.design.sized import Freedom, Sizing
from mbcdm_cad.errors import InputError
from mbcdm_cad.layouts.base import NoFigureError
from mbcdm_cad.layouts.check_design import checks_of
from mbcdm_cad.layouts.registry import layout_named, layout_of
from mbcdm_cad.parallel.forks import fork_map
from mbcdm_cad.solving.question import Fixed, Out, Point, Question, Setting, Times

# Checks that take as long as all others together: run only if all others pass.
SLOW = frozenset({"cables_apart", "spans_clear", "terminals_apart", "no_slack"})
# A warning as long as nothing is drawn. The build measures the mass and fails, so that a solution must keep this check,
# too. It runs last: only complete dimensions have a mass.
MASS = "mass_estimate"
LAST = SLOW | {MASS}
# A failed check adds 1 and a part that grows with its miss towards this value, steepest near the limit.
MOST = 3.0
# What a check without a figure adds, and the violation of a trial that gives no drive.
NO_FIGURE, NO_DRIVE = 4.0, 100.0
# The miss is taken relative to the limit, or to this if the limit is zero.
UNIT = 1.0
# Cost of a change: another choice, a field removed from the file; a factor costs log(factor) / log(FACTOR).
CHOICE_COST, OUT_COST, FACTOR = 0.5, 1.0, 1.5
# Fewer trials than this run in this process: starting others would take longer.
FEW_TRIALS = 4


@dataclass(frozen=True)
class TrialResult:
    """Result of a trial: ids of failed checks with what each adds to ``violation``; ``refused``: why it is no drive."""

    failing: tuple[tuple[str, float], ...]
    refused: str = ""

    @property
    def violation(self) -> float:
        """Zero for a design that passes; grows with the number of failed checks and with their misses."""
        return NO_DRIVE if self.refused else sum(miss for _, miss in self.failing)

    @property
    def passes(self) -> bool:
        """Whether no check fails."""
        return not self.failing and not self.refused


class SpentError(Exception):
    """As many trials were evaluated as a search may take."""


class Trials:
    """Evaluates trials of one question, each once; ``told`` is called after each batch with their number.

    After ``most`` trials each new one raises :class:`SpentError`.

    The rules that search begin at the design of :meth:`begin_at`, so that the sizing of a trial takes a third of the
    time. :meth:`confirmed` sizes the trial from its file alone, as every other command does.
    """

    def __init__(
        self, question: Question, jobs: int | None = None, told: Callable[[int], None] | None = None, most: float = inf
    ) -> None:
        self.question = question
        self.jobs = jobs or len(os.sched_getaffinity(0))
        self.told = told or (lambda count: None)
        self.most = most
        self._similar: Sizing | None = None
        self.from_files = False
        self._known: dict[tuple[frozenset[tuple[str, Setting]], bool], TrialResult] = {}

    @property
    def count(self) -> int:
        """Number of trials evaluated so far."""
        return len(self._known)

    @cached_property
    def checks(self) -> Mapping[str, Check]:
        """The checks of this configuration by their ids."""
        return checks_by_id(self.question)

    def begin_at(self, point: Point) -> Resolved | None:
        """Begin the sizing of later trials at the design of ``point``. Returns this design, None if there is none."""
        try:
            found = self.question.resolve(*self.question.trial(point))
        except InputError:
            return None
        if not self.from_files and found.sizing is not None and (found.sizing.ends or found.sizing.raised is not None):
            self._similar = found.sizing
        return found

    def begin_at_files(self) -> None:
        """Size all later trials from their files alone."""
        self._similar, self.from_files = None, True

    def confirmed(self, point: Point) -> bool:
        """Whether a trial passes, and also the design that a reader of its file gets."""
        if not self(point).passes:
            return False
        similar, self._similar = self._similar, None
        found = self(point)
        self._similar = similar
        return found.passes

    def __call__(self, point: Point) -> TrialResult:
        """One trial."""
        return self.many([point])[0]

    def many(self, points: Sequence[Point]) -> list[TrialResult]:
        """Several trials, in parallel on all cores."""
        keys = [self._key(point) for point in points]
        new = {key: point for key, point in zip(keys, points, strict=True) if key not in self._known}
        if len(self._known) + len(new) > self.most:
            raise SpentError
        if new:
            jobs = self.jobs if len(new) >= FEW_TRIALS else 1
            outcomes = fork_map(lambda point: outcome(self.question, point, self._similar), list(new.values()), jobs)
            self._known |= dict(zip(new, outcomes, strict=True))
            self.told(self.count)
        return [self._known[key] for key in keys]

    def _key(self, point: Point) -> tuple[frozenset[tuple[str, Setting]], bool]:
        """The point, and whether it is sized from its file alone; a known result of this kind is always used."""
        from_file = frozenset(point.items()), True
        return from_file if self._similar is None or from_file in self._known else (from_file[0], False)

    @property
    def nearest(self) -> Point:
        """The point with the smallest violation of all that were tried, the first of equal ones."""
        key, _ = min(self._known.items(), key=lambda item: round(item[1].violation, 9))
        return dict(key[0])

    def best(self, points: Iterable[Point]) -> Point:
        """The point with the smallest violation; of equal ones the one with the smallest cost, then the first."""
        listed = list(points)
        outcomes = self.many(listed)
        order = [
            (round(o.violation, 9), cost(self.question, p), k)
            for k, (p, o) in enumerate(zip(listed, outcomes, strict=True))
        ]
        return listed[min(order)[2]]


def checks_by_id(question: Question) -> Mapping[str, Check]:
    """The checks of the question's configuration by their ids."""
    return layout_named(question.data["configuration"]).checks_by_id()


def outcome(question: Question, point: Point, similar: Sizing | None = None) -> TrialResult:
    """Size and check one trial; of the checks that only warn it runs that of the mass; waived ones pass."""
    with np.errstate(all="ignore"), warnings.catch_warnings():
        warnings.simplefilter("ignore", RuntimeWarning)
        try:
            drive = question.resolve(*question.trial(point), similar).drive
        except InputError as error:
            return TrialResult((), str(error.problems[0].what))
        subject = layout_of(drive)
        asked = [check for check in checks_of(drive) if must_hold(check, drive) and drive.waiver(check.id) is None]
        found = [(check.id, missed(check, subject)) for check in asked if check.id not in LAST]
        if not any(miss for _, miss in found):
            found = [(check.id, missed(check, subject)) for check in asked if check.id in LAST]
        return TrialResult(tuple((name, miss) for name, miss in found if miss))


def missed(check: Check, subject: object) -> float:
    """Contribution of a check to the violation: zero if it passes."""
    try:
        found = check.measure(subject)
    except NoFigureError:
        return NO_FIGURE
    if not isfinite(found.actual) or not isfinite(found.limit):
        return NO_FIGURE
    if found.holds:
        return 0.0
    share = -found.margin / (abs(found.limit) or UNIT)
    return 1.0 + MOST * share / (MOST + share)


def over_limit(miss: float) -> float:
    """What a check misses over its limit, from its contribution to the violation; infinite without a figure."""
    part = miss - 1.0
    return MOST * part / (MOST - part) if part < MOST else inf


def messages(question: Question, point: Point) -> list[tuple[str, str]]:
    """(id, message) of every check that fails at a point."""
    try:
        drive = question.resolve(*question.trial(point)).drive
    except InputError as error:
        return [("sizing", str(error.problems[0].what))]
    subject = layout_of(drive)
    with np.errstate(all="ignore"), warnings.catch_warnings():
        warnings.simplefilter("ignore", RuntimeWarning)
        results = [run_check(check, subject, Budget(0)) for check in checks_of(drive)]
    must = {check.id for check in checks_of(drive) if must_hold(check, drive)}
    return [
        (result.id, result.message) for result in results if result.id in must and result.status in ("fail", "warn")
    ]


def must_hold(check: Check, drive: Drive) -> bool:
    """Whether a solution must keep the check on this drive: those that fail, and that of the mass."""
    return check.severity_on(drive) == "fail" or check.id == MASS


def cost(question: Question, point: Point) -> float:
    """Distance of a point from the values of file and rules: the sum of the costs of its changes."""
    total = 0.0
    for field, setting in sorted(point.items()):
        if isinstance(setting, Times):
            total += abs(log(setting.factor)) / log(FACTOR) + 0.05
        elif isinstance(setting, Out):
            total += OUT_COST * question.releases.get(field, 1)
        elif field in question.ranges:
            # Distance within a range from the end that is its aim, or from its middle, as a share of its width.
            found = question.ranges[field]
            aim = {"min": found.low, "max": found.high}.get(found.aim, question.middle(field))
            total += abs(float(setting.value) - aim) / ((found.high - found.low) or 1.0)
        else:
            total += CHOICE_COST
    return total


def choices(question: Question, freedom: Freedom) -> list[str]:
    """The names of which a choice takes one, small before large."""
    if freedom.words:
        return list(freedom.words)
    entries = entries_of(question, freedom.kind)
    return sorted(entries, key=lambda name: (entries[name].get(freedom.order, 0.0), name))


def entries_of(question: Question, kind: str) -> dict[str, Any]:
    """The catalogue's entries of a kind, with the file's own."""
    from mbcdm_cad.design.catalogue import package_entries

    return {**package_entries(kind), **((question.data.get("catalogue") or {}).get(kind) or {})}


def setting_of(value: object) -> Fixed:
    """A value as a setting; a list becomes a tuple, which is hashable."""
    return Fixed(tuple(value)) if isinstance(value, list) else Fixed(value)
