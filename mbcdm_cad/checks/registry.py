"""All checks in the order in which they are run and shown: first what the mechanism asks, then what the parts ask."""

from __future__ import annotations

from types import ModuleType

from mbcdm_cad.checks import (
    bearings,
    bending,
    drum_fits,
    envelope,
    fixings,
    guide_fits,
    motors,
    pulley_fits,
    ratios,
    spans,
    strength,
    support_fits,
    support_walls,
    surfaces,
    sweeps,
    terminals,
    transfer,
    wraps,
)
from mbcdm_cad.checks.finding import Check

FAMILIES: tuple[ModuleType, ...] = (
    ratios, surfaces, bending, transfer, spans, wraps, strength, motors, bearings, fixings,
    pulley_fits, guide_fits, drum_fits, terminals, support_walls, support_fits, sweeps, envelope,
)  # fmt: skip
CHECKS: tuple[Check, ...] = tuple(check for family in FAMILIES for check in family.CHECKS)

# Checks that need the drawn solids, or seconds; the build adds them.
BUILD_IDS = ("mass", "envelope", "interference", "frame_windup")


def known_ids() -> tuple[str, ...]:
    """Every id that a waiver may name."""
    return (*(check.id for check in CHECKS), *BUILD_IDS)
