"""Compare planned runs: from which size each run names an effect and separates it from all others."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import exp, inf, log

from mbcdm_cad.planning.plan import Foreseen, RunPlan

# A run that needs an effect this many times larger than the best run does is as bad as one that cannot show it.
BLIND = 10.0


@dataclass(frozen=True)
class Rated:
    """Rating of a run: geometric mean over the effects of its smallest size over that of the best run; 1 is best.

    ``blind`` effects are shown by another run but not by this one, or this one never separates them from a rival.
    """

    mean_multiple: float
    blind: int


def alone_from(effect: Foreseen) -> float:
    """Size from which the effect is named and not confused with another; infinite if no size is enough."""
    if effect.smallest is None:
        return inf
    return max([effect.smallest, *(inf if rival.from_size is None else rival.from_size for rival in effect.rivals)])


def rated(plans: Sequence[RunPlan]) -> list[Rated]:
    """The rating of each plan against all others; effects that no plan shows do not count."""
    sizes = [{one.label: alone_from(one) for one in plan.effects} for plan in plans]
    best = {label: min(size.get(label, inf) for size in sizes) for size in sizes for label in size}
    shown = {label: size for label, size in best.items() if size < inf}
    found = []
    for size in sizes:
        multiples = [min(size.get(label, inf) / least, BLIND) for label, least in shown.items()]
        mean = exp(sum(map(log, multiples)) / len(multiples)) if multiples else inf
        found.append(Rated(mean, sum(size.get(label, inf) == inf for label in shown)))
    return found
