"""Input pulley, its stops and its coupling: bores, walls, and room for the parts on and around it."""

from __future__ import annotations

from mbcdm_cad.checks.design_variables import down, up
from mbcdm_cad.checks.input_pulley import pulley_checks

CHECKS = pulley_checks(
    (
        up("transmission.input_radii_mm"),
        down("transmission.ratios.input_to_guide"),
        up("all radii of transmission"),
    )
)
