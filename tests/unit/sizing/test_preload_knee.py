"""Preload at the knee of backlash over preload: the closed form."""

from pathlib import Path

import pytest

from mbcdm_cad.layouts.loader import layout_of, load_design
from mbcdm_cad.layouts.preload import preload_rule

PARAMS = Path(__file__).parents[3] / "params"


@pytest.mark.parametrize("name", ["mbcdm", "siso_spur", "miso_spur", "siso_bevel"])
def test_the_knee_of_the_computed_curve_is_the_mean_of_its_ends(name: str) -> None:
    """A swing a + b/T is furthest from its chord at sqrt(T_0 T_1); the curve of the whole model is nearly one."""
    rule = preload_rule(layout_of(load_design(PARAMS / f"{name}.yaml").drive))
    assert rule.knee_N == pytest.approx((rule.slack_N * rule.most_N) ** 0.5, rel=0.04)
