"""Parametric twin of a cable drive: design file in; checked, weighed and openable parts out."""

__version__ = "0.1.0"
