"""Checks of a design before anything is drawn: pure numbers, no CAD, no scipy.

``run_checks`` gives every result; the three functions of :mod:`mbcdm_cad.checks.built` judge what a build measured.
"""

from __future__ import annotations

from mbcdm_cad.checks.built import envelope_check, frame_windup_check, interference_check, mass_check
from mbcdm_cad.checks.result import CheckResult
from mbcdm_cad.checks.run import failed, run_checks

__all__ = [
    "CheckResult",
    "envelope_check",
    "failed",
    "frame_windup_check",
    "interference_check",
    "mass_check",
    "run_checks",
]
