"""Checks of a design before anything is drawn: pure numbers, no CAD, no scipy.

This room has what all configurations share: comparison of figures with limits, the runner, remedies, and the families
of checks for any cable drive. :func:`mbcdm_cad.layouts.check_design.run_checks` runs all checks of a design; the
functions of :mod:`mbcdm_cad.checks.size` judge the figures that a build measured.
"""
