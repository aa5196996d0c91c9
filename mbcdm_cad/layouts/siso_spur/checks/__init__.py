"""The checks of this layout; the families in the order in which they run and are shown."""

from mbcdm_cad.checks import bearings, drum_sector, fixings, motor_head, motors, springs, strength, structure, terminals
from mbcdm_cad.checks.comparison import Family, families
from mbcdm_cad.layouts.siso_spur.checks import frame, idlers, overhung, stage, winding
from mbcdm_cad.layouts.siso_spur.checks.winding import stacks

__all__ = ["FAMILIES", "stacks"]

# First the checks of the mechanism, then those of the parts.
FAMILIES = families(
    *winding.FAMILIES,
    idlers,
    *winding.ON_DRUM,
    strength,
    motors,
    bearings,
    fixings,
    Family(
        "Input pulley, the stops of two cables anchored on it, and its coupling: walls, bores and space round it",
        winding.PULLEY_FITS,
    ),
    stage,
    overhung,
    drum_sector,
    structure,
    terminals,
    springs,
    frame.SUPPORT,
    motor_head,
    frame.ROOM,
)
