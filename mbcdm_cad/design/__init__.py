"""The design file: blocks that all configurations share, catalogue, reading, and the ``Drive`` that other rooms read.

Which configurations there are is not known here: a design is loaded by :mod:`mbcdm_cad.configurations.loader`.
"""
