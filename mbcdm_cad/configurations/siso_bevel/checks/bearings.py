"""Bearing loads against static ratings, and what reaches the gearhead in spite of the pulley's own bearings."""

from __future__ import annotations

from mbcdm_cad.checks.bearings import (
    BEARING_SPACING,
    COUPLING_RUNOUT,
    DRUM_BEARINGS,
    INPUT_BEARINGS,
    QUIET_SAFETY,
    drum_safety,
    input_safety,
    quiet,
)
from mbcdm_cad.checks.comparison import Comparison, worst
from mbcdm_cad.configurations.siso_bevel.design_under_test import DirectUnderTest


def quiet_running(s: DirectUnderTest) -> Comparison:
    """All bearings against the safety asked for quiet running."""
    return worst([*input_safety(s, QUIET_SAFETY), *drum_safety(s, QUIET_SAFETY)])


CHECKS = (INPUT_BEARINGS, DRUM_BEARINGS, quiet(quiet_running), BEARING_SPACING, COUPLING_RUNOUT)
