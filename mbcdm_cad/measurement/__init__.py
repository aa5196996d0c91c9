"""Measurement file and data of a logger: one run in SI units, and what speaks against taking it at its word."""
