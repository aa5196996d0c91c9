"""How values are written in tables and notes."""

from __future__ import annotations


def mm(value: float, decimals: int = 2) -> str:
    """Millimetres, trailing zeros left out."""
    text = f"{value:.{decimals}f}".rstrip("0").rstrip(".")
    return "0" if text in ("-0", "") else text


def mm3(value: float) -> str:
    """Millimetres to the micrometre."""
    return mm(value, 3)


def degrees(value: float) -> str:
    """Degrees to a hundredth."""
    return f"{mm(value)}%%d"
