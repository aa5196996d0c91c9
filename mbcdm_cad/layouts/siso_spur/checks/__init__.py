"""The checks of this configuration; the families in the order in which they run and are shown."""

from __future__ import annotations

from types import ModuleType

from mbcdm_cad.checks import (
    bearings,
    creep,
    drum_sector,
    duty,
    fixings,
    life,
    motor_head,
    motors,
    strength,
    structure,
    take_up,
    terminals,
)
from mbcdm_cad.layouts.siso_spur.checks import (
    pulley_fits,
    ratios,
    room,
    support,
    tolerances,
    winding,
    wraps,
)

# First the checks of the mechanism, then those of the parts.
FAMILIES: tuple[ModuleType, ...] = (
    ratios,
    winding,
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
    drum_sector,
    structure,
    terminals,
    take_up,
    support,
    motor_head,
    room,
)
