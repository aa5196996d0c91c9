"""Stack-up of tolerances on one figure: how far it may fall below its nominal value, by three methods.

A contribution shifts the figure by ``per_unit * tolerance`` at either end of its tolerance, to first order.

- RSS: sqrt(sum of squares), the three-sigma spread where each tolerance is three sigma of its part and all are
  independent (Evans, "Statistical tolerancing", 1974).
- Worst case: sum of magnitudes, every part at the bad end of its tolerance at once.
- Monte Carlo: every part uniform within its tolerance; the fall that 99.865 % of all drives do not exceed. It lies
between the other two, because parts spread over the whole tolerance are worse than RSS assumes.

Any unit, the same throughout. Plain numbers: ``check`` calls it.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from math import isfinite, sqrt
from typing import Any

import numpy as np

# Share of drives beyond three sigma on one side of a normal law.
BEYOND_THREE_SIGMA = 0.00135
DRAWS = 200_000


@dataclass(frozen=True)
class Contribution:
    """One tolerance (half its band) and how much the figure changes for a change of it by one."""

    name: str
    tolerance: float
    per_unit: float = 1.0

    @property
    def shift(self) -> float:
        """Change of the figure at the end of the tolerance, without sign."""
        return abs(self.per_unit) * self.tolerance


@dataclass(frozen=True)
class StackUp:
    """Tolerance stack of ``figure``, whose nominal margin is ``margin``; infinite if nothing limits it."""

    figure: str
    margin: float
    contributions: tuple[Contribution, ...]

    @property
    def rss(self) -> float:
        """Root of the sum of squares."""
        return sqrt(sum(c.shift**2 for c in self.contributions))

    @property
    def worst_case(self) -> float:
        """All parts at the bad end of their tolerances."""
        return sum(c.shift for c in self.contributions)

    @property
    def costliest(self) -> Contribution:
        """The tolerance with the largest effect. Raises ``ValueError`` where there is none."""
        return max(self.contributions, key=lambda c: c.shift)

    @property
    def spare(self) -> float:
        """Margin after the RSS stack; below zero some drives exceed the limit."""
        return self.margin - self.rss

    def monte_carlo(self, draws: int = DRAWS, seed: int = 0) -> float:
        """How far 99.865 % of drives fall at most, each part uniform within its tolerance; seeded."""
        rng = np.random.default_rng(seed)
        total = np.zeros(draws)
        for c in self.contributions:
            total += c.shift * rng.uniform(-1.0, 1.0, draws)
        return float(np.quantile(total, 1.0 - BEYOND_THREE_SIGMA))


def stack_data(stack: StackUp, draws: int = 0) -> dict[str, Any]:
    """The stack as plain data, the costliest tolerance first; with ``draws`` by Monte Carlo too."""
    ordered = sorted(stack.contributions, key=lambda c: -c.shift)
    data: dict[str, Any] = {
        "figure": stack.figure,
        "margin": stack.margin if isfinite(stack.margin) else None,
        "rss": stack.rss,
        "worst_case": stack.worst_case,
        "contributions": [{"name": c.name, "tolerance": c.tolerance, "shift": c.shift} for c in ordered],
    }
    return data | ({"monte_carlo": stack.monte_carlo(draws)} if draws else {})


def tightest(stacks: Iterable[StackUp]) -> StackUp:
    """The stack with the least margin left."""
    return min(stacks, key=lambda stack: stack.spare)
