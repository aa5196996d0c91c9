"""All checks in the order in which they are run and shown: first what the mechanism asks, then what the parts ask."""

from __future__ import annotations

from mbcdm_cad.checks.finding import Check
from mbcdm_cad.configurations.miso_bevel.checks import FAMILIES

CHECKS: tuple[Check, ...] = tuple(check for family in FAMILIES for check in family.CHECKS)

# Checks that need the drawn solids, or seconds; the build adds them.
BUILD_IDS = ("mass", "envelope", "interference", "frame_windup")


def known_ids() -> tuple[str, ...]:
    """Every id that a waiver may name."""
    return (*(check.id for check in CHECKS), *BUILD_IDS)
