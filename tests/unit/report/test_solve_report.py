"""The text of a solved design."""

from __future__ import annotations

from pathlib import Path

import pytest

import mbcdm_cad as mc
from mbcdm_cad.report.solve_report import SolveReport
from mbcdm_cad.solving.question import question_of
from mbcdm_cad.solving.solve import Change, Solution


@pytest.mark.parametrize("ranges", [True, False])
def test_only_a_file_with_ranges_is_told_of_the_search_for_the_best(ranges: bool) -> None:
    text = mc.new_design_text("drive", "siso_spur")
    if ranges:
        text = text.replace("drum_radius_mm: 60.0", "drum_radius_mm: {min: 50, max: 70}")
        assert "{min: 50" in text
    question = question_of(text, Path("my drive.yaml"))
    solution = Solution(question, {}, (Change("transmission.drum_radius_mm", "range", 60.0, "chosen"),), 3)
    said = SolveReport(question.path, solution, text.replace("{min: 50, max: 70}", "60.0")).text()
    named = "the best one finds: mbcdm optimise 'my drive.yaml' --aim mass_g:min"
    assert (named in said) == ranges, said
