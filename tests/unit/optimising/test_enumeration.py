"""The front of a search over three variables against every combination of a grid."""

from __future__ import annotations

from itertools import product
from pathlib import Path

import numpy as np
import pytest

import mbcdm_cad as mc
from mbcdm_cad.optimising.evaluate import evaluate
from mbcdm_cad.optimising.front import front_of, hypervolume, reference_of
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
