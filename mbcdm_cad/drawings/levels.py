"""Positions of dimensions beside a view: their level, and the position of their text along it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from mbcdm_cad.drawings.style import ARROW_MM, GAP_MM

# Space for an arrow from outside with its tail.
_OUTSIDE_MM = 2 * ARROW_MM
_APART_MM = 1.5
_LEVELS = 40


@dataclass(frozen=True)
class DimensionSpan:
    """A dimension along one side of a view, paper mm: its two ends and the length of its text."""

    low: float
    high: float
    text_mm: float

    @property
    def arrows_outside(self) -> bool:
        """Whether the arrows point inwards from outside, because the ends are too close for both."""
        return self.high - self.low < 2 * ARROW_MM + GAP_MM + 0.2

    @property
    def text_inside(self) -> bool:
        """Whether the text fits between the ends."""
        return self.high - self.low > self.text_mm + 1.0


@dataclass(frozen=True)
class Place:
    """Level from the view outwards (0 nearest) and the middle of the text along the side."""

    level: int
    text_at: float
    inside: bool


def _candidates(span: DimensionSpan, ends: list[float]) -> list[tuple[float, float, float]]:
    """(middle of the text, low end, high end) of the possible positions of a dimension, the best first."""
    out = _OUTSIDE_MM if span.arrows_outside else 0.0
    middle = (span.low + span.high) / 2
    if span.text_inside:
        return [(middle, span.low - out, span.high + out)]
    tail = out + GAP_MM + span.text_mm
    beyond = out + GAP_MM + span.text_mm / 2
    near = [
        (span.high + beyond, span.low - out, span.high + tail),
        (span.low - beyond, span.low - tail, span.high + out),
    ]
    # Outside the extension lines of all other dimensions.
    top, bottom = max([span.high + out, *ends]) + _APART_MM, min([span.low - out, *ends]) - _APART_MM
    far = [
        (top + span.text_mm / 2, span.low - out, top + span.text_mm),
        (bottom - span.text_mm / 2, bottom - span.text_mm, span.high + out),
    ]
    return near + far


def placed(spans: Sequence[DimensionSpan], within: tuple[float, float]) -> list[Place]:
    """A place for each span: shorter ones nearer to the view, without overlap, no text on an extension line.

    ``within``: the ends of the view on this side; texts stay between them if possible, clear of the adjacent sides.
    """
    order = sorted(range(len(spans)), key=lambda i: (spans[i].high - spans[i].low, spans[i].low, i))
    places: dict[int, Place] = {}
    taken: list[list[tuple[float, float]]] = [[] for _ in range(_LEVELS)]
    for i in order:
        span = spans[i]
        ends = [e for j, other in enumerate(spans) if j != i for e in (other.low, other.high)]
        lowest = 0
        for j, place in places.items():
            if min(span.high, spans[j].high) - max(span.low, spans[j].low) > 0.1:
                lowest = max(lowest, place.level + 1)
        places[i] = _first_free(span, ends, lowest, taken, within)
    return [places[i] for i in range(len(spans))]


def _first_free(
    span: DimensionSpan,
    ends: list[float],
    lowest: int,
    taken: list[list[tuple[float, float]]],
    within: tuple[float, float],
) -> Place:
    candidates = _candidates(span, ends)
    candidates.sort(key=lambda c: c[1] < within[0] - _OUTSIDE_MM or c[2] > within[1] + _OUTSIDE_MM)
    for strict in (True, False):
        for level in range(lowest, _LEVELS):
            for middle, low, high in candidates:
                if any(low < b - 0.05 and high > a + 0.05 for a, b in taken[level]):
                    continue
                half = span.text_mm / 2 + 0.4
                crossed = any(middle - half < e < middle + half for e in ends)
                if strict and crossed and not span.text_inside:
                    continue
                text = (min(low, middle - half), max(high, middle + half))
                taken[level].append((text[0], text[1] + (0.0 if span.text_inside else _APART_MM)))
                return Place(level, middle, span.text_inside)
    raise ValueError(f"{len(ends) // 2 + 1} dimensions on one side of a view: no place for all of them")
