"""Runs checks, and searches for the value of a design variable at which a check passes: its remedy.

A run never raises for a design that loads, and never returns NaN or infinity. A remedy is never a guess: its value was
tried on the design. Only the one check is evaluated; the next run shows the effect of the change on the others.
"""

import warnings
from collections.abc import Callable, Collection, Iterable
from dataclasses import dataclass, field
from functools import cached_property
from math import ceil, floor, inf, isfinite, log10
from typing import NamedTuple

import numpy as np

from mbcdm_cad.checks.comparison import Check, CheckResult, Comparison, Status, shown
from mbcdm_cad.checks.design_variables import ROPE_DIAMETER, DesignVariable
from mbcdm_cad.design.catalogue import package_entries
from mbcdm_cad.design.drive import Drive
from mbcdm_cad.layouts.base import Layout, NoFigureError

SIGNIFICANT_DIGITS = 4
BISECTIONS = 14
# Largest change of a variable: to this multiple of its value, or to the inverse.
REACH = 6.0
MOST_OFFERS = 3
TRIALS = 400
# A value may be rounded by this share, to have fewer digits, if the check still passes.
ROUNDING = 3e-3


class Offer(NamedTuple):
    """A value at which a check passes; ``asked``: it changes a requirement on the drive."""

    path: str
    sense: int
    value: float
    asked: bool


@dataclass(eq=False)
class Budget:
    """Number of trials that all remedies of one run may take; not a time, so that results do not depend on speed.

    ``requires`` tells the fields that the file asks for, named last; it is called when a value is first searched for,
    since it loads all sizing rules. ``offers`` holds the values found, by check: at most ``most`` each, and none
    for a check that only warns unless ``warnings``.
    """

    left: int = TRIALS
    requires: Callable[[], Collection[str]] = tuple
    most: int = MOST_OFFERS
    warnings: bool = True
    offers: dict[str, list[Offer]] = field(default_factory=dict)

    @cached_property
    def asked(self) -> Collection[str]:
        """Fields that the file requires."""
        return self.requires()


def remedy(check: Check, design: Layout, budget: Budget) -> str:
    """The sentence that says how the check would pass; each number was tried on the design."""
    if check.severity_on(design.drive) == "warn" and not budget.warnings:
        return ""
    free, required = offers(check, design, budget)
    advice = check.advice(design) if callable(check.advice) else check.advice
    if free or required or advice:
        return " or ".join([*free, *([advice] if advice else []), *required])
    senses: dict[str, str] = {}
    for path, sign in check.adjust:
        if path in design.variables:
            sense = "raise" if sign > 0 else "lower"
            senses[path] = sense if senses.get(path, sense) == sense else "change"
    if budget.left <= 0:
        ways = " or ".join(f"{sense} {path}" for path, sense in senses.items())
        return f"{ways}; no value was searched, because too many other checks fail: correct them first"
    return f"no single one of {', '.join(senses)} is enough: change several"


def offers(check: Check, design: Layout, budget: Budget) -> tuple[list[str], list[str]]:
    """The first variables that can make the check pass alone, as in ``raise X from 34.6 to at least 36.2``.

    First those that leave the requirements alone, then the requirements.
    """
    free: list[str] = []
    required: list[str] = []
    drive, variables = design.drive, design.variables
    kept = budget.offers.setdefault(check.id, [])
    # Requirements on the drive are named last.
    asked = {path: path in budget.asked or (path in variables and variables[path].asked) for path, _ in check.adjust}
    for path, sense in sorted(check.adjust, key=lambda adjustment: asked[adjustment.path]):
        if len(free) + len(required) == budget.most or budget.left <= 0:
            break
        variable = variables.get(path)
        # Shared families list variables that not every configuration has.
        if variable is not None and variable.applies(drive):
            value = passing_value(variable, sense, design, check.measure, budget, bounds(design, path))
            if value is not None:
                kept.append(Offer(path, sense, value, asked[path]))
                (required if asked[path] else free).append(_offer(variable, sense, drive, value, budget.asked))
    return free, required


def _offer(variable: DesignVariable, sense: int, drive: Drive, value: float, asked: Collection[str]) -> str:
    bound, figure = "at least" if sense > 0 else "at most", f"{value:.{SIGNIFICANT_DIGITS}g}"
    verb = "raise" if sense > 0 else "lower"
    if variable.short is not None and variable.short[0] in asked:
        path, get = variable.short
        changed = rounded(get(variable.put(drive, value)), ceil if sense > 0 else floor)
        return f"{verb} {path} from {get(drive):.4g} to {bound} {changed}"
    if variable.path == ROPE_DIAMETER:
        return f"choose a rope of {bound} {figure} mm{_rope_of(drive, sense, value)}"
    if variable.scale:
        name, note = variable.shown(drive) if variable.shown else (variable.path, "")
        return f"scale {name} by {bound} {figure}{note}"
    return f"{verb} {variable.path} from {variable.get(drive):.4g} to {bound} {figure}"


def _rope_of(drive: Drive, sense: int, diameter_mm: float) -> str:
    """The nearest suitable rope of the same construction in the catalogue, in brackets; empty if there is none."""
    ropes = package_entries("ropes")
    fitting = [
        (sense * entry["diameter_mm"], name)
        for name, entry in ropes.items()
        if entry["construction"] == drive.cable.construction and sense * (entry["diameter_mm"] - diameter_mm) >= 0.0
    ]
    return f" (such as {min(fitting)[1]})" if fitting else ""


def bounds(design: Layout, path: str) -> tuple[float, float]:
    """Least and largest value that a design file may have for a field; endless for what is no number of a file."""
    node = design.design_file().node_at(tuple(path.split("."))) or {}
    return node.get("minimum", -inf), node.get("maximum", inf)


def passing_value(
    variable: DesignVariable,
    sense: int,
    design: Layout,
    measure: Callable[[Layout], Comparison],
    budget: Budget,
    within: tuple[float, float] = (-inf, inf),
) -> float | None:
    """The rounded value nearest to the present one, in the given direction, at which ``measure`` holds, or None.

    ``within``: least and largest value that may be.
    """

    def holds(value: float) -> bool:
        if not within[0] <= value <= within[1]:
            return False
        budget.left -= 1
        try:
            return measure(design.with_drive(variable.put(design.drive, value))).holds
        except NoFigureError:
            return False

    now = variable.get(design.drive)
    size = abs(now) or 1.0
    step, before = size * 1e-3, now
    reach = size * (REACH - 1.0) if sense * (now or 1.0) > 0 else size * (1.0 - 1.0 / REACH)
    limit = min(reach, sense * (within[sense > 0] - now))
    while not holds(now + sense * min(step, limit)):
        if step >= limit:
            return None
        before = now + sense * step
        step *= 2.0
    after = now + sense * min(step, limit)
    for _ in range(BISECTIONS):
        middle = 0.5 * (before + after)
        before, after = (before, middle) if holds(middle) else (middle, after)
    for digits in range(2, SIGNIFICANT_DIGITS + 1):
        unit = 10.0 ** (floor(log10(abs(after))) + 1 - digits) if after else 1.0
        for value in (round(after / unit) * unit, (ceil if sense > 0 else floor)(after / unit) * unit):
            if abs(value - after) <= ROUNDING * abs(after) and holds(value):
                return round(value, 12)
    return after


def rounded(value: float, whole: Callable[[float], int] = floor) -> str:
    """A positive value rounded down, or by ``whole``, to the digits that remedies show."""
    unit = 10.0 ** (floor(log10(value)) + 1 - SIGNIFICANT_DIGITS)
    return f"{whole(value / unit) * unit:.{SIGNIFICANT_DIGITS}g}"


def run_all(checks: Iterable[Check], design: Layout, budget: Budget | None = None) -> tuple[CheckResult, ...]:
    """All checks on ``design``, in order; if a figure does not exist, the checks that need it fail with the reason.

    ``budget``: number of trials for the remedies; it receives the values that they find.
    """
    budget = budget or Budget()
    with np.errstate(all="ignore"), warnings.catch_warnings():
        warnings.simplefilter("ignore", RuntimeWarning)
        return tuple(run_check(check, design, budget) for check in checks)


def run_check(check: Check, design: Layout, budget: Budget | None = None) -> CheckResult:
    """One check on one design, waiver applied."""
    try:
        found = check.measure(design)
    except NoFigureError as missing:
        return _unevaluated(check, str(missing))
    return judged(check, found, design.drive, lambda: remedy(check, design, budget or Budget()))


def judged(check: Check, found: Comparison, drive: Drive, remedy_of: Callable[[], str]) -> CheckResult:
    """The result of a comparison: status, message, remedy. ``remedy_of`` is called if the check does not pass."""
    if not isfinite(found.actual) or not isfinite(found.limit):
        return _unevaluated(check, f"{found.subject} is not a finite number", found.unit)
    status: Status = "pass" if found.holds else ("warn" if check.severity_on(drive) == "warn" else "fail")
    found = found.shown
    limit, margin = (found.limit, found.margin) if found.sense else (None, None)
    waiver = drive.waiver(check.id) if status == "fail" else None
    asked = {1: "at least", -1: "at most", 0: ""}[found.sense]
    against = f" (limit {asked} {shown(found.limit)})" if asked else ""
    note = f"; {found.note}" if found.note else ""
    return CheckResult(
        check.id,
        check.title,
        "pass" if waiver else status,
        found.actual,
        limit,
        found.unit,
        margin,
        f"{found.subject} {shown(found.actual)} {found.unit}{against}{note}",
        "" if status == "pass" else remedy_of(),
        check.source,
        waiver.reason if waiver else None,
    )


def _unevaluated(check: Check, reason: str, unit: str = "") -> CheckResult:
    """The failure of a check whose figure does not exist. It cannot be waived, because the design cannot be built."""
    message, advice = f"not evaluated because {reason}", "correct what is named there first"
    return CheckResult(check.id, check.title, "fail", None, None, unit, None, message, advice, check.source)
