"""Gaps at the transfer compared with the tolerances of the parts, and the transmission error."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from mbcdm_cad.checks.stacks import TRANSMISSION_ERROR, TransferStacks, ratio_contributions, stack_check
from mbcdm_cad.layouts.siso_bevel.layout import DirectLayout
from mbcdm_cad.model.stack_up import StackUp, tightest

_INPUT = TransferStacks("input", "bearings in frame and motor head")


def stacks(s: DirectLayout) -> Iterator[StackUp]:
    """The stack of each gap and of each ratio; of several, the one with the least reserve."""
    for of in (_INPUT.gap, _INPUT.bodies_clear, _INPUT.land_edge):
        yield tightest(of(s))
    for c in s.steps:
        yield StackUp(f"total ratio of {c.name}, relative", np.inf, ratio_contributions(s.drive, c))


_CLOSER = "lower clearances.transfer_gap_mm, or raise clearances.land_edge_mm"
_WIDER = "raise clearances.transfer_gap_mm, or lower clearances.land_edge_mm"
CHECKS = (
    stack_check("transfer_gap", "Transfer gap stays under half a cable with tolerances", _INPUT.gap, _CLOSER),
    stack_check("bodies_clear", "Input and drum do not touch with tolerances", _INPUT.bodies_clear, _WIDER),
    stack_check(
        "land_edge",
        "Contact lines stay on their lands with tolerances",
        _INPUT.land_edge,
        "raise clearances.land_edge_mm, or lower clearances.transfer_gap_mm",
    ),
    TRANSMISSION_ERROR,
)
