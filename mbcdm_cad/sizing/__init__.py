"""Sizing: from the requirements, choices and pins of a design file to a value for every field.

A rule fills one field. Rules run once, in the order of the drive, and each reads only what stands in the file or what
an earlier rule filled. Configurations supply the rules; this room knows none of them.
"""
