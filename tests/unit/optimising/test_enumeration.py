"""The front of a search over three variables against every combination of a grid."""

from __future__ import annotations

from itertools import product
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import mbcdm_cad as mc
from mbcdm_cad.optimising.engine import front_of, hypervolume, reference_of
from mbcdm_cad.optimising.evaluate import evaluate
from mbcdm_cad.optimising.variables import Variable, point_of, variables_of
from mbcdm_cad.optimising.wishes import wishes_of
from mbcdm_cad.parallel import forks
from mbcdm_cad.parallel.forks import fork_map
from mbcdm_cad.solving.question import question_of

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
