"""Results of all checks on a layout, without the search for remedies, which takes longest."""

from __future__ import annotations

import numpy as np

from mbcdm_cad.checks.remedies import Budget
from mbcdm_cad.checks.result import CheckResult
from mbcdm_cad.checks.run import run_check
from mbcdm_cad.layouts.base import Layout
from mbcdm_cad.layouts.check_design import checks_of


def results(layout: Layout) -> list[CheckResult]:
    """Every check that is asked of the design."""
    with np.errstate(all="ignore"):
        return [run_check(check, layout, Budget(0)) for check in checks_of(layout.drive)]


def statuses(layout: Layout) -> dict[str, str]:
    """Status by check."""
    return {found.id: found.status for found in results(layout)}


def failing(layout: Layout) -> dict[str, str]:
    """Message of each check that fails."""
    return {found.id: found.message for found in results(layout) if found.status == "fail"}
