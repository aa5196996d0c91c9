"""``size_many`` gives the same values as the sizing of each design alone; ``analyse_many`` those of a short file."""

from __future__ import annotations

import numpy as np
import pytest

import mbcdm_cad as mc
from mbcdm_cad.errors import MbcdmError
from mbcdm_cad.layouts.loader import load_text

SHORT = """
name: short
configuration: miso_bevel
travel: {half_angle_deg: 30.0}
transmission: {ratio: 9.0, drum_radius_mm: 60.0}
loads: {peak_torque_Nm: 2.0}
"""
RANGES = {
    "transmission.drum_radius_mm": [45.0, 60.0, 100.0, 75.0],
    "loads.peak_torque_Nm": [0.5, 2.0, 6.0, 3.0],
    "transmission.centre_distance_mm": [45.0, 50.0, 90.0, 60.0],
}
# Wraps on the guide rest on the setback, which needs the frame.
NEEDS_FRAME = "passed_wrap"


@pytest.fixture(scope="module")
def short() -> mc.DriveDesign:
    return mc.DriveDesign(load_text(SHORT))


def test_sized_fields_and_figures_are_those_of_each_design(short: mc.DriveDesign) -> None:
    many, alone = mc.size_many(short, RANGES), mc.analyse_many(short, RANGES)
    assert len(many) == 4 and list(many["refused"]) == [""] * 4
    for name in alone:
        if not name.startswith(NEEDS_FRAME):
            assert many[name] == pytest.approx(alone[name], rel=1e-8, abs=1e-9), name
    for k in range(4):
        design = short.with_({field: values[k] for field, values in RANGES.items()}).drive
        assert many["rope.type"][k] == design.cable.name
        assert many["drive.gearhead"][k] == design.gearhead.name
        assert many["transmission.drum_radii_mm[4]"][k] == pytest.approx(design.cables[3].drum_radius_mm)
        assert many["rope.helix_lead_mm"][k] == design.helix_lead_mm
    assert len(set(many["rope.type"])) > 1 and "4 designs, 4 sized" in str(many)


def test_rules_may_route_the_cables_of_some_designs_otherwise(short: mc.DriveDesign) -> None:
    design = short.with_(transmission__centre_distance_mm=60.0)
    ranges = {"loads.peak_torque_Nm": [2.0, 20.0]}
    each = [design.with_(loads__peak_torque_Nm=torque) for torque in ranges["loads.peak_torque_Nm"]]
    assert len({one.drive.input_setback_mm for one in each}) == 2
    swings = [one.analyse().figures.reversal_swing_mrad for one in each]
    assert mc.analyse_many(design, ranges)["reversal_swing_mrad"] == pytest.approx(swings, rel=1e-9)


def test_a_design_that_no_rule_can_fill_is_refused_with_its_reason(short: mc.DriveDesign) -> None:
    many = mc.size_many(short, {"transmission.centre_distance_mm": [60.0, 8.0]})
    assert many["refused"][0] == "" and "too short for guide and input pulley" in many["refused"][1]
    assert np.isfinite(many["reversal_swing_mrad"]).tolist() == [True, False]
    assert many["rope.type"][1] is None and "2 designs, 1 sized" in many.summary()


def test_names_may_differ_and_bad_values_are_refused(short: mc.DriveDesign) -> None:
    many = mc.size_many(short, {"rope.type": ["7x7-1.0", "no-such"]})
    assert many["refused"][0] == "" and "no-such" in many["refused"][1]
    with pytest.raises(mc.InputError, match=r"loads\.peak_torque_Nm: out of bounds"):
        mc.size_many(short, {"loads.peak_torque_Nm": [1.0, -1.0]})
    with pytest.raises(MbcdmError, match="only numbers and names"):
        mc.size_many(short, {"input_pulleys.surface": [True, False]})


@pytest.mark.parametrize("layout", ["siso_spur", "miso_spur", "siso_bevel"])
def test_other_layouts_are_sized_one_by_one_with_the_values_of_each_alone(layout: str) -> None:
    ratio = "input_to_drum: 4.0" if layout == "siso_bevel" else "input_to_drum: 8.0"
    text = SHORT.replace("miso_bevel", layout).replace("ratio: 9.0", ratio)
    design = mc.DriveDesign(load_text(text.replace("peak_torque_Nm: 2.0", "peak_torque_Nm: 0.4")))
    ranges = {"transmission.drum_radius_mm": [60.0, 75.0, 70.0], "rope.type": ["7x7-1.0", "7x7-0.61", "no-such"]}
    many = mc.size_many(design, ranges)
    assert list(many["refused"][:2]) == ["", ""] and "no-such" in many["refused"][2]
    assert "3 designs, 2 sized" in str(many)
    alone = mc.analyse_many(design, {field: values[:2] for field, values in ranges.items()})
    for name in alone:
        if name.startswith(NEEDS_FRAME):
            continue
        assert list(many[name][:2]) == pytest.approx(list(alone[name]), rel=1e-12), name
    for k in range(2):
        one = design.with_({field: values[k] for field, values in ranges.items()})
        assert alone["reversal_swing_mrad"][k] == pytest.approx(one.analyse().figures.reversal_swing_mrad, rel=1e-9)
        sized = {value.field: value.value for value in one.loaded.sized if not isinstance(value.value, list)}
        assert len(sized) > 30
        for field, value in sized.items():
            assert many[field][k] == value, field
    assert many["drum.sector_half_angle_deg"][0] != many["drum.sector_half_angle_deg"][1]
