"""The box of all parts against its target, from a layout before anything is drawn."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from typing import Any

from mbcdm_cad.checks.comparison import Check, Comparison, at_most, noted
from mbcdm_cad.checks.design_variables import Adjustment

# A design's box (X, Z, Y), mm.
Box = Callable[[Any], tuple[float, float, float]]


def _side(box_mm: Box, axis: int, s: Any) -> Comparison:
    """Box along one axis."""
    size, wanted, name = s.once("box_mm", box_mm)[axis], s.drive.targets.envelope_mm, "XZY"[axis]
    if wanted is None:
        return noted(f"box along {name}, drum centred", size, "mm", "the design file has no target")
    target = wanted[axis]
    return at_most(
        f"box along {name}, drum centred, {size:.2f} mm: from the target of {target:g} mm",
        abs(size - target),
        s.drive.targets.envelope_tolerance_mm,
        "mm",
    )


def box_checks(box_mm: Box, source: str, adjust: Sequence[tuple[Adjustment, ...]]) -> tuple[Check, ...]:
    """One check for each side, in the order X, Z, Y; ``adjust``: variables that may correct each."""
    return tuple(
        Check(
            f"envelope_{name.lower()}",
            f"Box along {name}",
            source,
            partial(_side, box_mm, axis),
            adjust=adjust[axis],
            advice="set targets.envelope_mm to the required box",
        )
        for axis, name in enumerate("XZY")
    )
