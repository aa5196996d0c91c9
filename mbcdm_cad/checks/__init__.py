"""Checks of a design before anything is drawn: pure numbers, no CAD, no scipy.

:func:`mbcdm_cad.checks.run.run_checks` gives every result; the functions of :mod:`mbcdm_cad.checks.built` judge what a
build measured.
"""
