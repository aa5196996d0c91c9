"""All checks of a design: those of its configuration, run on the configuration's design under test."""

from __future__ import annotations

import re
from dataclasses import replace
from typing import TYPE_CHECKING

from mbcdm_cad.checks.comparison import Check, CheckResult, failed
from mbcdm_cad.checks.run import Budget, run_all
from mbcdm_cad.checks.size import BUILD_IDS
from mbcdm_cad.design.drive import Drive
from mbcdm_cad.design.loader import LoadedDesign
from mbcdm_cad.design.yamltree import dotted
from mbcdm_cad.errors import InputError, Problem, did_you_mean
from mbcdm_cad.layouts.base import Layout
from mbcdm_cad.layouts.registry import layout_of

if TYPE_CHECKING:
    from mbcdm_cad.layouts.together import Together


def checks_of(drive: Drive) -> tuple[Check, ...]:
    """The checks of this drive, in the order in which they are run and shown."""
    own = (check for check in layout_of(drive).checks_by_id().values() if check.asked_of(drive))
    return (*own, *layout_of(drive).further_checks)


def known_ids(drive: Drive) -> tuple[str, ...]:
    """Every id that a waiver may name."""
    return (*(check.id for check in checks_of(drive)), *BUILD_IDS)


def run_checks(design: Drive | LoadedDesign | Layout) -> tuple[CheckResult, ...]:
    """Every check on ``design``, in order; given dimensions are tested as they are.

    Raises ``InputError`` for a waiver that names no check (with file and line if a ``LoadedDesign`` is given), and
    for nothing else: where a figure does not exist, the checks that need it fail with the reason.
    """
    if isinstance(design, LoadedDesign):
        return advised_checks(design)[0]
    layout = layout_of(design) if isinstance(design, Drive) else design
    refuse_unknown_waivers(layout.drive)
    return run_all(checks_of(layout.drive), layout)


def advised_checks(loaded: LoadedDesign) -> tuple[tuple[CheckResult, ...], Together | None]:
    """Every check on a design file, with advice on its pins, and the result of applying all remedies together."""
    refuse_unknown_waivers(loaded.drive, loaded)
    checks, budget = checks_of(loaded.drive), Budget(requires=lambda: _asked(loaded))
    results = run_all(checks, layout_of(loaded.drive), budget)
    wrong = [result.id for result in failed(results)]
    if not wrong:
        return results, None
    # These trials are made only if a check fails.
    from mbcdm_cad.layouts.together import pin_advice, together

    advice, pins = pin_advice(loaded, [check for check in checks if check.id in wrong])
    results = tuple(_advised(result, loaded, advice.get(result.id, "")) for result in results)
    return results, together(loaded, checks, budget.asked, {name: budget.offers.get(name, ()) for name in wrong}, pins)


def _asked(loaded: LoadedDesign) -> frozenset[str]:
    """Fields that the file gives and that are not derived dimensions; empty if there are no rules."""
    derived = layout_of(loaded.drive).design_file().derived()
    given = {dotted(path) for path in loaded.lines}
    return frozenset(given.difference(derived)) if derived else frozenset()


def _advised(result: CheckResult, loaded: LoadedDesign, advice: str) -> CheckResult:
    """The result with the advice on pins first, and with each cable's own preload in place of the common one."""
    remedy = result.remedy
    if loaded.design.cables[0].preload_N is not None:
        remedy = _COMMON.sub(r"cables.0.preload_N \1, the other cables' in proportion", remedy)
    remedy = "; or ".join(filter(None, [advice, remedy]))
    return replace(result, remedy=remedy) if remedy != result.remedy else result


_COMMON = re.compile(r"rope\.preload_N (from \S+ to at (?:least|most) [0-9.e+-]*[0-9])")


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
