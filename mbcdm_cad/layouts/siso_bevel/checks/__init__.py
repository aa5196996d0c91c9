"""The checks of this layout; the families in the order in which they run and are shown."""

from __future__ import annotations

from mbcdm_cad.checks import (
    bearings,
    creep,
    drum_sector,
    duty,
    fixings,
    life,
    motor_head,
    motors,
    springs,
    strength,
    structure,
    take_up,
    terminals,
)
from mbcdm_cad.checks.comparison import Family, families
from mbcdm_cad.checks.design_variables import down, up
from mbcdm_cad.checks.input_pulley import pulley_checks
from mbcdm_cad.checks.transfer import transfer_checks
from mbcdm_cad.layouts.bevel_transfer import wrap_checks
from mbcdm_cad.layouts.siso_bevel.checks import input_turn, ratios, room, support, tolerances

_WIDER = (up("transmission.input_radii_mm"), down("transmission.input_to_drum"), up("all radii of transmission"))
# Tolerance stacks of each gap and ratio.
stacks = tolerances.stacks
# First the checks of the mechanism, then those of the parts.
FAMILIES = families(
    ratios,
    input_turn,
    Family(
        "The transfer point: both step planes on one pitch line, lands wide enough, "
        "input and drum close but not touching",
        transfer_checks("input pulley", "keep r_o/r_m equal for both steps, as transmission.input_to_drum does"),
    ),
    tolerances,
    Family(
        "Wrap on the drum over the travel: more than zero, less than a turn, clear of the input, compared with the "
        "slip zones.",
        wrap_checks("input"),
    ),
    strength,
    creep,
    life,
    motors,
    duty,
    bearings,
    fixings,
    Family(
        "Input pulley, its stops and its coupling: bores, walls, and room for the parts on and around it",
        pulley_checks(_WIDER),
    ),
    drum_sector,
    structure,
    terminals,
    take_up,
    springs,
    support,
    motor_head,
    room,
)
