"""The checks of this configuration; the families in the order in which they run and are shown.

Each input with its cable and sector is checked as in siso_spur.
"""

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
from mbcdm_cad.layouts.miso_spur.checks import room, sectors, sharing
from mbcdm_cad.layouts.siso_spur.checks import pulley_fits, ratios, support, tolerances, winding, wraps

# First the checks of the mechanism, then those of the parts.
FAMILIES: tuple[ModuleType, ...] = (
    ratios,
    winding,
    sharing,
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
    sectors,
    support,
    motor_head,
    room,
)
