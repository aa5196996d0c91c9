"""The design file: blocks that all configurations share, catalogue, reading, and the ``Drive`` that other rooms read.

This room does not know the configurations: a design is loaded by :mod:`mbcdm_cad.layouts.loader`.
"""
