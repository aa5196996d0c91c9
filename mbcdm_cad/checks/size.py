"""Mass and box of all parts against their targets, from a layout before anything is drawn."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from typing import Any

from mbcdm_cad.checks.comparison import Check, Comparison, at_most, noted
from mbcdm_cad.checks.design_variables import Adjustment
from mbcdm_cad.layouts.base import NoFigureError
from mbcdm_cad.parts.bill import Bill

BillOf = Callable[[Any], Bill]


def estimated_mass_g(bill: Bill) -> float:
    """Mass of all items, g: bought parts as in the catalogue, made ones by closed forms of their volume."""
    volumes = bill.volumes_mm3
    return sum(
        volumes[item.part] * item.material.density_g_cm3 * 1e-3 if item.mass_g is None else item.mass_g
        for item in bill.items
    )


def kept_mass_g(layout: Any, bill_of: BillOf) -> float:
    """The same of a layout, worked out once."""
    return float(layout.once("estimated mass", lambda s: estimated_mass_g(s.once("bill", bill_of))))


def _mass(bill_of: BillOf, s: Any) -> Comparison:
    """Mass of all parts from their dimensions, within 1 % of the mass of the solids, which the build computes."""
    try:
        mass, targets = kept_mass_g(s, bill_of), s.drive.targets
    except (ValueError, ZeroDivisionError) as error:
        raise NoFigureError(f"a part of this design has no volume: {error}") from None
    if targets.mass_g is None:
        return noted("estimated mass", mass, "g", "the design file has no target")
    what = f"estimated mass {mass:.1f} g: from the target of {targets.mass_g:g} g"
    return at_most(what, abs(mass - targets.mass_g), targets.mass_tolerance_g, "g")


def mass_check(bill_of: BillOf) -> Check:
    """The check of the estimated mass. It only warns, because the build judges the mass of the solids."""
    return Check(
        "mass_estimate",
        "Estimated mass",
        "targets.mass_g; volumes in closed form",
        partial(_mass, bill_of),
        "warn",
        advice="set targets.mass_g to the required mass, or change walls of the frame where their limits allow",
    )


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
    """The box of all parts against its target, from a layout before anything is drawn."""
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
