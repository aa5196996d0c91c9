"""Checks of a design before anything is drawn: pure numbers, no CAD, no scipy.

What all configurations share: comparing figures with limits, running checks, remedies, and the families that hold for
any cable drive. :func:`mbcdm_cad.configurations.check_design.run_checks` runs all checks of a design; the functions of
:mod:`mbcdm_cad.checks.built` judge what a build measured.
"""
