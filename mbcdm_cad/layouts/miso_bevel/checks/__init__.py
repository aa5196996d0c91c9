"""The checks of this configuration; the families in the order in which they run and are shown."""

from __future__ import annotations

from types import ModuleType

from mbcdm_cad.checks import creep, drum_sector, duty, fixings, life, motors, strength, structure, take_up, terminals
from mbcdm_cad.checks.comparison import Check
from mbcdm_cad.layouts.miso_bevel.checks import (
    bearings,
    bending,
    envelope,
    guide_fits,
    pulley_fits,
    ratios,
    spans,
    support_fits,
    support_walls,
    surfaces,
    sweeps,
    tolerances,
    transfer,
    wraps,
)

# First the checks of the mechanism, then those of the parts.
FAMILIES: tuple[ModuleType, ...] = (
    ratios,
    surfaces,
    bending,
    transfer,
    spans,
    tolerances,
    wraps,
    strength,
    creep,
    life,
    motors,
    duty,
    bearings,
    fixings,
    pulley_fits,
    guide_fits,
    drum_sector,
    structure,
    terminals,
    take_up,
    support_walls,
    support_fits,
    sweeps,
    envelope,
)
CHECKS: tuple[Check, ...] = tuple(check for family in FAMILIES for check in family.CHECKS)
