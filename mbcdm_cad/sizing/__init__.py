"""Sizing: compute a value for every field from the requirements, choices and pins of a design file.

A rule computes one field. Rules run once, in a fixed order, and each reads only fields of the file or fields that an
earlier rule computed. The configurations supply the rules; this room contains none.
"""
