"""Runs checks on a design: never raises for a design that loads, and never returns NaN or infinity."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Iterable
from math import isfinite

import numpy as np

from mbcdm_cad.checks.comparison import Check, CheckResult, Comparison, Status, shown
from mbcdm_cad.checks.remedies import Budget, remedy
from mbcdm_cad.design.drive import Drive
from mbcdm_cad.layouts.base import Layout, NoFigureError


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
    status: Status = "pass" if found.holds else ("warn" if check.severity == "warn" else "fail")
    found = found.shown
    limit, margin = (found.limit, found.margin) if found.sense else (None, None)
    waiver = drive.waiver(check.id) if status == "fail" else None
    return CheckResult(
        check.id,
        check.title,
        "pass" if waiver else status,
        found.actual,
        limit,
        found.unit,
        margin,
        _message(found),
        "" if status == "pass" else remedy_of(),
        check.source,
        waiver.reason if waiver else None,
    )


def _unevaluated(check: Check, reason: str, unit: str = "") -> CheckResult:
    """The failure of a check whose figure does not exist. It cannot be waived, because the design cannot be built."""
    message, advice = f"not evaluated because {reason}", "correct what is named there first"
    return CheckResult(check.id, check.title, "fail", None, None, unit, None, message, advice, check.source)


def _message(found: Comparison) -> str:
    limit = {1: "at least", -1: "at most", 0: ""}[found.sense]
    against = f" (limit {limit} {shown(found.limit)})" if limit else ""
    note = f"; {found.note}" if found.note else ""
    return f"{found.subject} {shown(found.actual)} {found.unit}{against}{note}"
