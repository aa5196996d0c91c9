"""All checks of a design: those of its configuration, run on the design as this configuration tests it."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from mbcdm_cad.checks.built import BUILD_IDS
from mbcdm_cad.checks.comparison import Check
from mbcdm_cad.checks.result import CheckResult, failed
from mbcdm_cad.checks.run import run_all
from mbcdm_cad.configurations.interface import Layout
from mbcdm_cad.configurations.registry import configuration
from mbcdm_cad.design.drive import Drive
from mbcdm_cad.design.loaded import LoadedDesign
from mbcdm_cad.errors import InputError, Problem, did_you_mean


def checks_of(drive: Drive) -> tuple[Check, ...]:
    """The checks of this drive's configuration, in the order in which they are run and shown."""
    return tuple(check for family in configuration(drive.configuration).check_families() for check in family.CHECKS)


def known_ids(drive: Drive) -> tuple[str, ...]:
    """Every id that a waiver may name."""
    return (*(check.id for check in checks_of(drive)), *BUILD_IDS)


def run_checks(design: Drive | LoadedDesign | Layout) -> tuple[CheckResult, ...]:
    """Every check on ``design``, in order; dimensions that are given are tested as they are.

    Raises ``InputError`` for a waiver that names no check (with file and line if a ``LoadedDesign`` is given), and
    for nothing else: where a figure does not exist, the checks that need it fail with the reason.
    """
    drive: Drive = design if isinstance(design, Drive) else design.drive
    given: Any = None if isinstance(design, Drive | LoadedDesign) else design
    refuse_unknown_waivers(drive, design if isinstance(design, LoadedDesign) else None)
    checks = checks_of(drive)
    results = run_all(checks, configuration(drive.configuration).design_under_test(drive, given))
    if not isinstance(design, LoadedDesign) or not failed(results):
        return results
    from mbcdm_cad.configurations.pins import pin_advice  # only where something fails

    ids = {result.id for result in failed(results)}
    advice = pin_advice(design, [check for check in checks if check.id in ids])
    return tuple(
        replace(r, remedy=f"{advice[r.id]}; or {r.remedy}" if r.remedy else advice[r.id]) if r.id in advice else r
        for r in results
    )


def refuse_unknown_waivers(drive: Drive, loaded: LoadedDesign | None = None) -> None:
    """Raise ``InputError`` if a waiver names no check."""
    if not drive.waivers:
        return
    known = known_ids(drive)
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
