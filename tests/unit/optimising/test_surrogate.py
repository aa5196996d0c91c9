"""The surrogate of a search: what it preselects of many points, against functions whose best is known."""

from __future__ import annotations

import numpy as np
import pytest

from mbcdm_cad.optimising.engine import Surrogate
from mbcdm_cad.optimising.variables import Variable
from mbcdm_cad.routes import Floats

VARIABLES = [Variable("a", ruled=False), Variable("b", (), 0.5, 2.0), Variable("steel", ("soft", "hard", "rust"))]
COST = {"soft": 0.0, "hard": 0.3, "rust": 0.1}


def drawn(rng: np.random.Generator, count: int) -> list[dict[str, object]]:
    """Random points."""
    return [{v.field: v.drawn(rng) for v in VARIABLES} for _ in range(count)]


def judged(points: list[dict[str, object]]) -> tuple[Floats, np.ndarray]:
    """Two aims that want ``a`` and ``steel`` differently, with a curve and a product; what rusts fails."""
    a, b = (np.array([one[name] for one in points], dtype=float) for name in ("a", "b"))
    cost = np.array([COST[str(one["steel"])] for one in points])
    passes = np.array([one["steel"] != "rust" for one in points])
    return np.stack([a + cost + 0.2 * np.abs(b), (1.0 - a) ** 2 - cost], axis=1), passes


@pytest.fixture
def known() -> Surrogate:
    """A surrogate that was told of 120 points."""
    points = drawn(np.random.default_rng(5), 120)
    surrogate = Surrogate(VARIABLES, 2)
    aims, passes = judged(points)
    surrogate.add(points, aims, np.where(passes, 0.0, 1.0))
    return surrogate


def test_the_preselected_points_are_near_the_front_and_pass(known: Surrogate) -> None:
    points = drawn(np.random.default_rng(6), 300)
    aims, passes = judged(points)
    chosen = known.preselected(points, 12)
    assert chosen == sorted(set(chosen)) and len(chosen) == 12
    assert passes[chosen].mean() > 0.9 > passes.mean() + 0.1, passes[chosen]
    # The number of points that are better in both aims, of those that pass.
    beaten = np.array([((aims[passes] < one).all(axis=1)).sum() for one in aims])
    assert beaten[chosen].mean() < 0.15 * beaten[passes].mean(), (beaten[chosen], beaten[passes].mean())
    assert np.ptp(aims[chosen], axis=0).min() > 0.5, "they lie in one place of the front"


def test_without_a_design_that_passes_the_first_ones_are_taken() -> None:
    surrogate, points = Surrogate(VARIABLES, 2), drawn(np.random.default_rng(7), 20)
    assert surrogate.preselected(points, 6) == list(range(6))
    surrogate.add(points, np.zeros((20, 2)), np.ones(20))
    assert surrogate.preselected(points, 6) == list(range(6))
    assert surrogate.preselected(points, 40) == list(range(20))


def test_one_aim_that_is_the_same_everywhere_still_has_a_choice(known: Surrogate) -> None:
    surrogate, points = Surrogate(VARIABLES, 1), drawn(np.random.default_rng(8), 60)
    passes = np.array([one["steel"] == "hard" for one in points])
    surrogate.add(points, np.full((60, 1), 2.5), np.where(passes, 0.0, 1.0))
    more = drawn(np.random.default_rng(9), 60)
    chosen = surrogate.preselected(more, 10)
    assert len(set(chosen)) == 10 and all(more[k]["steel"] == "hard" for k in chosen), [more[k] for k in chosen]
