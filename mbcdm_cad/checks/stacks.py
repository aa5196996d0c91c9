"""Gaps against the sum of the tolerances of the parts, and the transmission error that the tolerances cause."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np

from mbcdm_cad.checks.comparison import Check, Comparison, at_least, noted
from mbcdm_cad.layouts.base import Layout
from mbcdm_cad.model.stack_up import StackUp, tightest
from mbcdm_cad.parts.making import model_tolerances

# Its argument is a configuration's design under test.
Stacks = Callable[[Any], list[StackUp]]
# Standard deviations on either side that hold 95 % of all drives.
MOST_DRIVES = 1.96


def _against_stack(of: Stacks, s: Any) -> Comparison:
    """The smallest gap is compared with the root sum of squares of the tolerances that change it."""
    stack = tightest(of(s))
    note = f"sum of the tolerances (RSS); worst case {stack.worst_case:.3g} mm; largest share: {stack.costliest.name}"
    return at_least(stack.figure.removesuffix(", mm"), stack.margin, stack.rss, "mm", note)


def transmission_error(s: Layout) -> Comparison:
    """Largest error of the drum's angle over the travel that the tolerances cause: linear theory, two sigma."""
    from mbcdm_cad.model.tolerance import linear_error

    names, error = linear_error(s.loads.si, s.half_travel_rad, model_tolerances(s.drive))
    whole = np.sqrt((error**2).sum(axis=0))
    pose = int(np.argmax(whole))
    most = names[int(np.argmax(np.abs(error[:, pose])))]
    return noted(
        "drum off by at most, over the travel, in 95 % of drives",
        MOST_DRIVES * float(whole[pose]) * 1e3,
        "mrad",
        f"zero at the centred drum; most by the {most}",
    )


def stack_check(name: str, title: str, of: Stacks, advice: str) -> Check:
    """The check that warns if the margin of ``of`` is smaller than its tolerance stack."""
    return Check(
        f"{name}_stack",
        title,
        "root sum of squares of the tolerances in parts/fits.py and making",
        partial(_against_stack, of),
        "warn",
        advice=advice,
    )


TRANSMISSION_ERROR = Check(
    "transmission_error", "Transmission error by the tolerances", "linear theory, two sigma", transmission_error
)
