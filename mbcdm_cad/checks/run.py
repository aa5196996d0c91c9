"""Running all checks on a design: never raises for a design that loads, never gives a number that is none."""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from math import isfinite

import numpy as np

from mbcdm_cad.checks.finding import Check, Finding, shown
from mbcdm_cad.checks.knobs import Budget, offers
from mbcdm_cad.checks.registry import CHECKS, known_ids
from mbcdm_cad.checks.result import CheckResult, Status
from mbcdm_cad.checks.subject import NoFigureError, Subject
from mbcdm_cad.configurations.miso_bevel.layout import Layout
from mbcdm_cad.design.drive import Drive
from mbcdm_cad.design.loaded import LoadedDesign
from mbcdm_cad.errors import InputError, Problem, did_you_mean


def run_checks(design: Drive | Layout | LoadedDesign) -> tuple[CheckResult, ...]:
    """Every check of the registry on ``design``, in order.

    Raises ``InputError`` for a waiver that names no check (with file and line if a ``LoadedDesign`` is given), and
    for nothing else: where a figure does not exist, the checks that need it fail with the reason.
    """
    drive = design.drive if isinstance(design, LoadedDesign | Layout) else design
    refuse_unknown_waivers(drive, design if isinstance(design, LoadedDesign) else None)
    subject, budget = Subject(drive, design if isinstance(design, Layout) else None), Budget()
    with np.errstate(all="ignore"), warnings.catch_warnings():
        warnings.simplefilter("ignore", RuntimeWarning)
        return tuple(run_check(check, subject, budget) for check in CHECKS)


def run_check(check: Check, subject: Subject, budget: Budget | None = None) -> CheckResult:
    """One check on one design, waiver applied."""
    try:
        finding = check.measure(subject)
    except NoFigureError as missing:
        return _unevaluated(check, str(missing))
    return judged(check, finding, subject, budget)


def judged(check: Check, finding: Finding, subject: Subject, budget: Budget | None = None) -> CheckResult:
    """The finding as a result: status, message, remedy."""
    if not isfinite(finding.actual) or not isfinite(finding.limit):
        return _unevaluated(check, f"{finding.subject} comes to no finite number", finding.unit)
    status: Status = "pass" if finding.holds else ("warn" if check.severity == "warn" else "fail")
    message, remedy = _message(finding), "" if status == "pass" else remedy_of(check, subject, budget or Budget())
    limit, margin = (finding.limit, finding.margin) if finding.sense else (None, None)
    waiver = subject.drive.waiver(check.id) if status == "fail" else None
    return CheckResult(
        check.id,
        check.title,
        "pass" if waiver else status,
        finding.actual,
        limit,
        finding.unit,
        margin,
        message,
        remedy,
        check.source,
        waiver.reason if waiver else None,
    )


def _unevaluated(check: Check, reason: str, unit: str = "") -> CheckResult:
    """A figure that does not exist is a failure, and no waiver helps it: there is nothing to build."""
    message = f"not evaluated because {reason}"
    remedy = "mend what is named there first"
    return CheckResult(check.id, check.title, "fail", None, None, unit, None, message, remedy, check.source)


def _message(finding: Finding) -> str:
    limit = {1: "at least", -1: "at most", 0: ""}[finding.sense]
    against = f" (limit {limit} {shown(finding.limit)})" if limit else ""
    note = f"; {finding.note}" if finding.note else ""
    return f"{finding.subject} {shown(finding.actual)} {finding.unit}{against}{note}"


def remedy_of(check: Check, subject: Subject, budget: Budget) -> str:
    """What would make the check pass, each number tried on the design."""
    choices = offers(check.turns, subject.drive, check.measure, budget)
    advice = check.advice(subject) if callable(check.advice) else check.advice
    if choices or advice:
        return " or ".join([*choices, *([advice] if advice else [])])
    names = ", ".join(dict.fromkeys(turn.path for turn in check.turns))
    if budget.left <= 0:
        senses = " or ".join(f"{'raise' if turn.sense > 0 else 'lower'} {turn.path}" for turn in check.turns)
        return f"{senses}; no figure was looked for, since so much else fails: mend that first"
    return f"no single one of {names} mends it: change several"


def refuse_unknown_waivers(drive: Drive, loaded: LoadedDesign | None = None) -> None:
    """Raise ``InputError`` if a waiver names no check."""
    known = known_ids()
    problems = [
        Problem(
            str(loaded.path) if loaded else drive.name,
            loaded.line_of("waivers", k, "check") if loaded else 1,
            f"waivers[{k}].check",
            "no such check",
            waiver.check,
            "the id of a check",
            did_you_mean(waiver.check, known),
        )
        for k, waiver in enumerate(drive.waivers)
        if waiver.check not in known
    ]
    if problems:
        raise InputError(problems)


def failed(results: Sequence[CheckResult]) -> tuple[CheckResult, ...]:
    """Results that fail and are not waived."""
    return tuple(result for result in results if result.status == "fail")
