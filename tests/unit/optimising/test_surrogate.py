"""The surrogate of a search: what it preselects of many points, against functions whose best is known.

The front of a search over three variables against every combination of a grid.
"""

from __future__ import annotations

from itertools import product
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import mbcdm_cad as mc
from mbcdm_cad.optimising.engine import Surrogate, front_of, hypervolume, reference_of
from mbcdm_cad.optimising.evaluate import evaluate
from mbcdm_cad.optimising.variables import Variable, point_of, variables_of
from mbcdm_cad.optimising.wishes import wishes_of
from mbcdm_cad.parallel import forks
from mbcdm_cad.parallel.forks import fork_map
from mbcdm_cad.routes import Floats
from mbcdm_cad.solving.question import question_of

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


AIMS = ["mass_g:min", "swing_mrad:min"]
FREE = ["drum.web_thickness_mm=2.5..7", "drum.material=aluminium-7075,pa12"]
GRID = 4
SEARCHED = 120


@pytest.mark.slow
def test_a_search_reaches_what_a_grid_reaches(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(forks, "_allowed", True)
    text = mc.new_design_text("grid", "miso_bevel")
    radius = next(line.split(":")[1].split()[0] for line in text.splitlines() if "  drum_radius_mm:" in line)
    low, high = 0.85 * float(radius), 1.2 * float(radius)
    text = text.replace(f"drum_radius_mm: {radius} ", f"drum_radius_mm: {{min: {low:.4g}, max: {high:.4g}}} ")
    (tmp_path / "grid.yaml").write_text(text)
    question = question_of(text, tmp_path / "grid.yaml")
    wishes = wishes_of(AIMS, (), FREE, only_free=True)
    variables = variables_of(question, wishes)
    assert len(variables) == 3, variables

    def levels(v: Variable) -> list[object]:
        return list(v.options) or np.linspace(0.0, 1.0, GRID).tolist()

    names = [aim.figure for aim in wishes.aims]
    values = [
        dict(zip([v.field for v in variables], row, strict=True)) for row in product(*(levels(v) for v in variables))
    ]
    every = fork_map(lambda x: evaluate(question, point_of(variables, x), (), names), values, 2)
    grid = np.array([[one.figures[name] for name in names] for one in every if one.passes])
    assert len(grid) > 8, f"only {len(grid)} of {len(values)} pass"

    found = mc.optimise(
        tmp_path / "grid.yaml", AIMS, tmp_path, free=FREE, only_free=True, effort=mc.Effort(SEARCHED, workers=2)
    )
    front = np.array([[point.figures[name] for name in names] for point in found.points])
    reference, scale = reference_of(grid[front_of(grid)])
    share = hypervolume(front[(front <= reference).all(axis=1)], reference, scale) / hypervolume(grid, reference, scale)
    assert share >= 0.98, f"{share:.4f} of the grid's volume with {SEARCHED} designs; {len(grid)} on the grid pass"
    for point in found.points[::8]:
        (tmp_path / f"{point.name}.yaml").write_text(point.text)
        assert mc.load(tmp_path / f"{point.name}.yaml").check().passed, point.name


# The front and its volume, against brute force and closed forms.


POINTS = st.lists(st.tuples(*[st.integers(0, 6).map(float)] * 3), min_size=1, max_size=40)


@given(POINTS)
@settings(max_examples=60, deadline=None)
def test_no_point_of_the_front_is_dominated_and_every_other_is(points: list[tuple[float, ...]]) -> None:
    found = np.array(points)
    front = front_of(found)
    for k, point in enumerate(found):
        better = [n for n, other in enumerate(found) if (other <= point).all() and (other < point).any()]
        equal_before = [n for n in range(k) if (found[n] == point).all()]
        assert (k in front) == (not better and not equal_before), (k, point, better)


def test_volume_of_two_points_is_that_of_their_rectangles() -> None:
    points = np.array([[0.0, 2.0], [1.0, 0.0]])
    reference, scale = np.array([2.0, 3.0]), np.ones(2)
    assert hypervolume(points, reference, scale) == pytest.approx(2.0 * 1.0 + 1.0 * 3.0 - 1.0 * 1.0)
    assert hypervolume(points, reference, np.array([2.0, 3.0])) == pytest.approx(4.0 / 6.0)
    assert hypervolume(np.zeros((0, 2)), reference, scale) == 0.0


def test_the_reference_lies_beyond_the_worst_point_also_without_a_spread() -> None:
    reference, scale = reference_of(np.array([[1.0, 5.0], [3.0, 5.0]]))
    assert reference == pytest.approx([3.2, 5.5]) and scale == pytest.approx([2.0, 5.0])
