"""Preload at the knee of backlash over preload: the closed form, and drives whose rules choose it."""

from __future__ import annotations

from pathlib import Path

import pytest

from mbcdm_cad.layouts.loader import design_file, load_design, load_text
from mbcdm_cad.layouts.preload import preload_rule
from tests.support.checked import failing

PARAMS = Path(__file__).parents[3] / "params"
LAYOUTS = ("siso_spur", "miso_spur", "siso_bevel", "miso_bevel")


@pytest.mark.parametrize("name", ["mbcdm", "siso_spur", "miso_spur", "siso_bevel"])
def test_the_knee_of_the_computed_curve_is_the_mean_of_its_ends(name: str) -> None:
    """A swing a + b/T is furthest from its chord at sqrt(T_0 T_1); the curve of the whole model is nearly one."""
    rule = preload_rule(load_design(PARAMS / f"{name}.yaml").drive.layout)
    assert rule.knee_N == pytest.approx((rule.slack_N * rule.most_N) ** 0.5, rel=0.04)


@pytest.mark.parametrize("layout", LAYOUTS)
def test_rules_reach_the_knee_that_a_file_asks_for(layout: str) -> None:
    text = str(design_file(layout).starting).format(name="started")
    usual, asked = (load_text(text + more).drive for more in ("", "rope: {preload_by: knee}\n"))
    rule = preload_rule(asked.layout)
    assert rule.preload_N == pytest.approx(rule.knee_N, rel=0.1), rule
    swing = [next(row.swing_mrad for row in r.table if row.factor == 1.0) for r in (preload_rule(usual.layout), rule)]
    assert swing[1] < 0.5 * swing[0], swing
    assert not failing(asked)


def test_a_stated_rope_ends_the_way_to_the_knee() -> None:
    """A rope that is too thin for the knee gets what it holds, and no less than the usual preload."""
    text = str(design_file("siso_bevel").starting).format(name="started")
    at = {by: load_text(text + f"rope: {{type: 7x7-0.45, preload_by: {by}}}\n").drive for by in ("slack", "knee")}
    preload = {by: drive.cables[0].preload_N for by, drive in at.items()}
    assert preload["slack"] < preload["knee"] < preload_rule(at["knee"].layout).knee_N, preload
    assert not failing(at["knee"])
