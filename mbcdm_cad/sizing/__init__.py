"""Sizing: compute a value for every field from the requirements, choices and pins of a design file.

A rule computes one field. In a pass rules run once, in a fixed order, and each reads only fields of the file or fields
that an earlier rule computed. The layouts supply the rules, and trial drives on which passes are repeated; this room
contains neither.
"""
