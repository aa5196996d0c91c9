"""Designs of params/, sized once, and results of all checks without the search for remedies, which takes longest."""

from functools import cache
from pathlib import Path

import numpy as np

from mbcdm_cad.checks.comparison import CheckResult
from mbcdm_cad.checks.run import Budget, run_check
from mbcdm_cad.design.drive import Drive
from mbcdm_cad.design.loader import LoadedDesign
from mbcdm_cad.layouts.base import Layout
from mbcdm_cad.layouts.check_design import checks_of
from mbcdm_cad.layouts.loader import layout_of, load_design

PARAMS = Path(__file__).parents[2] / "params"


@cache
def of_params(name: str) -> LoadedDesign:
    """The design of a file of params/: short files take seconds to size, and many tests look at the same."""
    return load_design(PARAMS / f"{name}.yaml")


def _layout(design: Layout | Drive | LoadedDesign) -> Layout:
    if isinstance(design, LoadedDesign):
        return layout_of(design.drive)
    return layout_of(design) if isinstance(design, Drive) else design


def results(design: Layout | Drive | LoadedDesign) -> list[CheckResult]:
    """Every check that is asked of the design."""
    layout = _layout(design)
    with np.errstate(all="ignore"):
        return [run_check(check, layout, Budget(0)) for check in checks_of(layout.drive)]


def result(design: Layout | Drive | LoadedDesign, name: str) -> CheckResult:
    """One check, with its remedy."""
    layout = _layout(design)
    return run_check(layout.checks_by_id()[name], layout)


def statuses(design: Layout | Drive | LoadedDesign) -> dict[str, str]:
    """Status by check."""
    return {found.id: found.status for found in results(design)}


def failing(design: Layout | Drive | LoadedDesign) -> dict[str, str]:
    """Message of each check that fails."""
    return {found.id: found.message for found in results(design) if found.status == "fail"}
