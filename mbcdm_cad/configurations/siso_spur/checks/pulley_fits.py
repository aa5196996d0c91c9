"""Input pulley and its coupling: bores, walls, and room for the parts on and around it."""

from __future__ import annotations

from mbcdm_cad.checks.input_pulley import coupling_checks
from mbcdm_cad.configurations.siso_spur.checks.ratios import WIDER

CHECKS = coupling_checks(WIDER)
