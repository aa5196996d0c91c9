"""Simple formulas for a measured curve, as a person would write them into a new effect."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mbcdm_cad.loop.result import readable
from mbcdm_cad.routes import Floats

# Shapes within this of the best one's share are listed too.
CLOSE = 0.03
MOST = 3
# A shape is listed only if it explains at least this share of the curve's variance.
LEAST = 0.6


@dataclass(frozen=True)
class Shape:
    """One shape: its formula in the variable, the share of the curve's variance it explains, and words with sizes."""

    form: str
    explains: float
    words: str


Basis = Callable[[Floats], Floats]
# Formula, words, power of the unit that the coefficient is divided by, basis. A constant is always fitted besides.
FIXED: tuple[tuple[str, str, int, Basis], ...] = (
    ("x", "proportional to {name}", 1, lambda x: x),
    ("x^2", "goes with the square of {name}", 2, np.square),
    ("x |x|", "goes with the square of {name} and its sign", 2, lambda x: x * np.abs(x)),
    ("x^3", "goes with the cube of {name}", 3, lambda x: x**3),
    ("max(x, 0)", "one-sided, proportional to positive {name}", 1, lambda x: np.maximum(x, 0.0)),
    ("max(-x, 0)", "one-sided, proportional to negative {name}", 1, lambda x: np.maximum(-x, 0.0)),
    ("max(x, 0)^2", "one-sided, with the square of positive {name}", 2, lambda x: np.maximum(x, 0.0) ** 2),
    ("max(-x, 0)^2", "one-sided, with the square of negative {name}", 2, lambda x: np.maximum(-x, 0.0) ** 2),
    ("|x|", "goes with the size of {name}", 1, np.abs),
    ("sign(x)", "goes with the sign of {name}", 0, np.sign),
)


def best_shapes(name: str, unit: str, at: Floats, mean: Floats, count: NDArray[np.int64]) -> tuple[Shape, ...]:
    """Shapes that fit a curve ``mean`` (rad) over ``at`` (``unit``), weighted by ``count``, best first."""
    if at.size < 6:
        return ()
    weight = np.sqrt(count / count.sum())
    found = []
    for form, words, power, basis in FIXED:
        explains, size = _explained(basis(at)[:, None], mean, weight)
        per = f" rad/({unit})" + (f"^{power}" if power > 1 else "") if power else " rad"
        found.append(Shape(form, explains, f"{words.format(name=name)}: {size[0]:.3g}{per}"))
    found += [_bump(name, unit, at, mean, weight), _step(name, unit, at, mean, weight)]
    found.sort(key=lambda shape: -shape.explains)
    best = found[0].explains
    return tuple(shape for shape in found[:MOST] if shape.explains >= max(LEAST, best - CLOSE))


def _explained(columns: Floats, mean: Floats, weight: Floats) -> tuple[float, Floats]:
    """Share of the weighted variance that the columns and a constant explain, and the coefficients."""
    x = np.column_stack([np.ones(mean.size), columns]) * weight[:, None]
    y = mean * weight
    solved = np.linalg.lstsq(x, y, rcond=1e-10)[0]
    left = float(np.sum((y - x @ solved) ** 2))
    level = float(np.sum(weight * y) / np.sum(weight**2))
    whole = float(np.sum((y - weight * level) ** 2))
    return (1.0 - left / whole if whole > 0.0 else 0.0), np.asarray(solved[1:], dtype=float)


def _bump(name: str, unit: str, at: Floats, mean: Floats, weight: Floats) -> Shape:
    """A bump at one place, Gaussian."""
    span = float(np.ptp(at))
    best = (-np.inf, 0.0, 0.0, 0.0)
    for width in span * np.geomspace(0.01, 0.15, 8):
        for centre in at:
            explains, size = _explained(np.exp(-0.5 * ((at - centre) / width) ** 2)[:, None], mean, weight)
            if explains > best[0]:
                best = explains, float(centre), float(width), float(size[0])
    explains, centre, width, height = best
    tall = readable("_rad", [height])[1][0]
    words = f"a bump of {tall} at {name} {centre:.4g} {unit}, {2.355 * width:.3g} {unit} wide at half height"
    return Shape("exp(-((x - x0)/w)^2 / 2)", explains, words)


def _step(name: str, unit: str, at: Floats, mean: Floats, weight: Floats) -> Shape:
    """A step at one place."""
    best = (-np.inf, 0.0, 0.0)
    for k in range(2, at.size - 2):
        explains, size = _explained((np.arange(at.size) >= k).astype(float)[:, None], mean, weight)
        if explains > best[0]:
            best = explains, float(0.5 * (at[k - 1] + at[k])), float(size[0])
    explains, place, height = best
    tall = readable("_rad", [height])[1][0]
    return Shape("x > x0", explains, f"a step of {tall} at {name} {place:.4g} {unit}")
