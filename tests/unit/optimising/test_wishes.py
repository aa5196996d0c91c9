"""Wishes are read from their texts, and what is none is refused with value and limit."""

from __future__ import annotations

import pytest

import mbcdm_cad as mc
from mbcdm_cad.errors import MbcdmError
from mbcdm_cad.optimising.prices import STEP, Price, Prices, requirements
from mbcdm_cad.optimising.wishes import Aim, Freed, Keep, wishes_of
from mbcdm_cad.solving.question import question_of


def test_wishes_are_read_from_their_texts() -> None:
    found = wishes_of(
        ["mass_g:min", "torque_Nm:max"], ["bend_ratio:>=14.8"], ["drum.material=pa12,pla", "rope.preload_N=30..90"]
    )
    assert found.aims == (Aim("mass_g", "min"), Aim("torque_Nm", "max"))
    assert found.keeps == (Keep("bend_ratio", 1, 14.8),)
    assert found.free == (Freed("drum.material", ("pa12", "pla")), Freed("rope.preload_N", (), 30.0, 90.0))
    assert found.keeps[0].margin(15.0) == pytest.approx(0.2) and found.aims[1].less(3.0) == -3.0


@pytest.mark.parametrize(
    ("aims", "keeps", "free", "words"),
    [
        ([], [], [], "0 given (limit 1 to 4)"),
        (["a:min"] * 5, [], [], "5 given (limit 1 to 4)"),
        (["mass_g:min", "mass_g:max"], [], [], "mass_g is given twice"),
        (["mass_g"], [], [], "value mass_g, limit FIGURE:min or FIGURE:max"),
        (["mass_g:least"], [], [], "value mass_g:least"),
        (["mass_g:min"], ["torque_Nm:3"], [], "value torque_Nm:3, limit FIGURE:>=NUMBER"),
        (["mass_g:min"], ["torque_Nm:>=three"], [], "value torque_Nm:>=three"),
        (["mass_g:min"], [], ["rope.preload_N"], "value rope.preload_N, limit FIELD=A,B"),
        (["mass_g:min"], [], ["rope.preload_N=90..30"], "value rope.preload_N=90..30"),
    ],
)
def test_what_is_no_wish_is_refused(aims: list[str], keeps: list[str], free: list[str], words: str) -> None:
    with pytest.raises(MbcdmError) as refused:
        wishes_of(aims, keeps, free)
    assert words in str(refused.value)


# Prices of requirements against differences of two designs, each by its own ``check``.


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
