"""Global search by differential evolution over all free fields, used when the guided search does not succeed."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from math import ceil, exp, log
from typing import Any

import numpy as np

from mbcdm_cad.design.freedom import Freedom
from mbcdm_cad.routes import Floats
from mbcdm_cad.solving.question import Fixed, Point, Setting, Times
from mbcdm_cad.solving.trials import Trials, choices, cost, setting_of

SEED = 20
# Trials in one generation.
POPULATION = 24
# Share of a variable's interval that means "keep the value of the rule", because few fields of a solution change.
STILL = 0.5


def evolve(trials: Trials, start: Point, most: int) -> Point:
    """The best point that at most about ``most`` trials find; stops after the first generation with a passing trial."""
    from scipy.optimize import differential_evolution  # its import takes longer than all checks of a design

    held = dict(start)
    trials.begin_at(start)
    variables = [_variable(trials, f) for f in trials.question.open_fields(start) if f.is_choice or f.low < f.high]
    variables += [_along_range(trials, field) for field in sorted(trials.question.unruled)]
    if not variables:
        return start
    rng = np.random.default_rng(SEED)
    first = rng.uniform(0.0, 1.0, (POPULATION, len(variables)))
    first[0] = _STAYS
    found: list[Point] = [start]

    def point_of(x: Floats) -> Point:
        settings = {name: setting for (name, of), u in zip(variables, x, strict=True) if (setting := of(float(u)))}
        return {**held, **settings}

    def generation(_: Callable[..., Any], members: Any) -> Sequence[float]:
        points = [point_of(np.asarray(member)) for member in members]
        outcomes = trials.many(points)
        found.append(trials.best([found[-1], *points]))
        return [o.violation or 1e-3 * cost(trials.question, p) for p, o in zip(points, outcomes, strict=True)]

    differential_evolution(
        lambda x: 0.0,
        [(0.0, 1.0)] * len(variables),
        init=first,
        maxiter=max(ceil(most / POPULATION) - 1, 1),
        popsize=1,
        tol=0.0,
        atol=0.0,
        mutation=(0.4, 0.9),
        recombination=0.6,
        seed=SEED,
        polish=False,
        updating="deferred",
        workers=generation,
        callback=lambda *_, **__: trials(found[-1]).passes,
    )
    return found[-1]


_STAYS = 0.5 * STILL
Variable = tuple[str, Callable[[float], Setting | None]]


def _variable(trials: Trials, freedom: Freedom) -> Variable:
    """A field as a variable from 0 to 1: the value of its rule below ``STILL``, its other values above."""
    names = choices(trials.question, freedom) if freedom.is_choice else []

    def setting(u: float) -> Setting | None:
        if u < STILL:
            return None
        share = (u - STILL) / (1.0 - STILL)
        if names:
            return Fixed(names[min(int(share * len(names)), len(names) - 1)])
        low, high = log(freedom.low), log(freedom.high)
        return Times(float(f"{exp(low + share * (high - low)):.4g}"))

    return freedom.field, setting


def _along_range(trials: Trials, field: str) -> Variable:
    found = trials.question.ranges[field]
    return field, lambda u: setting_of(found.within(float(f"{found.low + u * (found.high - found.low):.4g}")))
