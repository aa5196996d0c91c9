"""Input pulley, the stops of two cables anchored on it, and its coupling: walls, bores and space round it."""

from __future__ import annotations

from mbcdm_cad.checks.design_variables import down, up
from mbcdm_cad.checks.input_pulley import coupling_checks, dead_turns_check, stop_checks
from mbcdm_cad.layouts.siso_spur.checks.ratios import WIDER
from mbcdm_cad.layouts.siso_spur.drive import is_anchored

_STOPS = (
    dead_turns_check((up("transmission.turns"), down("transmission.input_to_drum"), down("travel.half_angle_deg"))),
    *stop_checks(WIDER),
)
CHECKS = (*(check._replace(applies=is_anchored) for check in _STOPS), *coupling_checks(WIDER))
