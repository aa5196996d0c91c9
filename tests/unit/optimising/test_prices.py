"""Prices of requirements against differences of two designs, each by its own ``check``."""

from __future__ import annotations

import pytest

import mbcdm_cad as mc
from mbcdm_cad.optimising.prices import STEP, Price, Prices, requirements
from mbcdm_cad.solving.question import question_of


def test_the_table_gives_the_change_for_one_unit_of_a_requirement() -> None:
    found = Prices({"mass_g": 300.0}, (Price("a.b_mm", 10.0, 9.5, {"mass_g": 298.0}), Price("a.b_mm", 10.0, 10.5, {})))
    assert found.table().rows == (("a.b_mm", 10.0, "+4", "none passes"),)


def test_requirements_are_the_numbers_of_the_file() -> None:
    question = question_of(mc.new_design_text("drive", "siso_bevel"))
    found = dict(requirements(question))
    assert found == {"travel.half_angle_deg": 35.0, "transmission.drum_radius_mm": 60.0, "loads.peak_torque_Nm": 0.9}


def test_a_design_that_fails_has_no_prices() -> None:
    broken = mc.new_design("drive", "siso_bevel").with_(rope__preload_N=400.0)
    with pytest.raises(mc.MbcdmError, match="does not pass"):
        mc.prices(broken, ["mass_g"])


@pytest.mark.slow
def test_a_price_is_the_difference_of_two_designs() -> None:
    design = mc.new_design("drive", "siso_bevel")
    found = mc.prices(design, ["mass_g"])
    up = next(p for p in found.prices if p.field == "travel.half_angle_deg" and p.after > p.before)
    assert up.after == pytest.approx(35.0 * (1.0 + STEP))
    wider = design.with_(travel__half_angle_deg=up.after).check()
    assert wider.passed and wider["mass_estimate"].actual == pytest.approx(up.figures["mass_g"], rel=1e-9)
    assert design.check()["mass_estimate"].actual == pytest.approx(found.figures["mass_g"], rel=1e-9)
