"""Scouts: points that try the options which no good design has.

Another rope seldom passes in the place of the present one: it also needs another ratio and radius. So an option that
is taken into a good design misses something, is given up, and with it an end of the front. Here each option keeps the
point that was nearest to a pass, and is tried on from there, with whatever else it needs.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from mbcdm_cad.optimising.surrogate import Surrogate
from mbcdm_cad.optimising.variables import Values, Variable
from mbcdm_cad.routes import Floats

# Share of the scouts that try options which pass somewhere, but in no good design.
PASSING = 0.2
# Points drawn for each scout, of which the surrogate takes one.
DRAWS = 40
# Fields that differ from the point before, on average, besides one; and how often one of them is a range.
MORE, RANGED = 1.5, 0.5
# How far a number moves, as a share of its extent; how often it is drawn anew, and then from its rule.
WIDTH, ANEW, RULED = 0.15, 0.3, 0.5
# How often a scout takes fields from a good design, and what share of them.
MIXED, SHARE = 0.3, 0.3


@dataclass
class _Option:
    """What is known of an option: the least violation, the point that has it, and the scouts since; -1: none yet."""

    violation: float = np.inf
    values: Values | None = None
    stalled: int = -1


class Scouts:
    """The options of all choices. Which points they propose follows from ``seed`` and what was added."""

    def __init__(self, variables: Sequence[Variable], seed: int) -> None:
        self._variables = tuple(v for v in variables if len(v.options) != 1)
        self._ranges = [v for v in self._variables if not v.options and not v.ruled]
        self._options = {(v.field, option): _Option() for v in self._variables for option in v.options}
        self._rng = np.random.default_rng([seed, len(self._options)])
        self._seen: set[tuple[Any, ...]] = set()

    def add(self, points: Sequence[Values], violation: Floats) -> None:
        """What was found of points."""
        for values, miss in zip(points, violation.tolist(), strict=True):
            self._seen.add(tuple(values.values()))
            for v in self._variables:
                if v.options and miss < self._options[v.field, values[v.field]].violation:
                    self._options[v.field, values[v.field]] = _Option(miss, values, 0)

    def proposed(self, count: int, good: Sequence[Values], surrogate: Surrogate) -> list[Values]:
        """At most ``count`` points, each with another option that none of the designs ``good`` has."""
        present = {(v.field, values[v.field]) for values in good for v in self._variables}
        rare = [key for key in self._options if key not in present]
        drawn = self._rng.permutation(len(rare)).tolist()
        found: list[Values] = []
        for key in self._order([rare[k] for k in drawn], count):
            option = self._options[key]
            points = [self._drawn(key, option.values, good) for _ in range(DRAWS)]
            points = [values for values in points if tuple(values.values()) not in self._seen]
            if points:
                option.stalled += 1
                passes = option.violation <= 0.0
                one = surrogate.preselected(points, 1)[0] if passes else surrogate.nearest(points, *key)
                found.append(points[one])
        return found

    def _order(self, keys: Sequence[tuple[str, Any]], count: int) -> list[tuple[str, Any]]:
        """The next ``count`` to be tried: what was never tried, then the oftener the nearer to a pass.

        A share goes to those that pass and are not good.
        """
        options = self._options
        missing = sorted((key for key in keys if options[key].violation > 0.0), key=lambda key: options[key].violation)
        tried = {key: (options[key].stalled + 1) * (1 + rank) for rank, key in enumerate(missing)}
        passing = sorted((key for key in keys if key not in tried), key=lambda key: options[key].stalled)
        least = max(round(PASSING * count), count - len(missing))
        return [*passing[:least], *sorted(tried, key=lambda key: tried[key])[: count - min(least, len(passing))]]

    def _drawn(self, key: tuple[str, Any], before: Values | None, good: Sequence[Values]) -> Values:
        """A point with the option ``key``, near the one ``before`` or, if there is none, near a good design."""
        rng, (field, option) = self._rng, key
        other = good[int(rng.integers(len(good)))]
        values = dict(before or other)
        if before is not None and rng.random() < MIXED:
            values = {name: other[name] if rng.random() < SHARE else value for name, value in values.items()}
        values[field] = option
        free = [v for v in self._variables if v.field != field]
        for _ in range(1 + rng.poisson(MORE) if free else 0):
            among = self._ranges if self._ranges and rng.random() < RANGED else free
            v = among[int(rng.integers(len(among)))]
            if v.options or rng.random() < ANEW:
                values[v.field] = v.start if rng.random() < RULED else v.drawn(rng)
            else:
                low = -1.0 if v.ruled else 0.0
                moved = values[v.field] + rng.normal(0.0, WIDTH * (1.0 - low))
                values[v.field] = float(np.clip(moved, low, 1.0))
        return values
