"""``analyse_many`` of a short file gives the figures of each design sized alone."""

from __future__ import annotations

import pytest

import mbcdm_cad as mc
from mbcdm_cad.layouts.loader import load_text

SHORT = """
name: short
configuration: miso_bevel
travel: {half_angle_deg: 30.0}
transmission: {ratio: 9.0, drum_radius_mm: 60.0}
loads: {peak_torque_Nm: 2.0}
"""


def test_rules_may_route_the_cables_of_some_designs_otherwise() -> None:
    design = mc.DriveDesign(load_text(SHORT)).with_(transmission__centre_distance_mm=60.0)
    ranges = {"loads.peak_torque_Nm": [2.0, 20.0]}
    each = [design.with_(loads__peak_torque_Nm=torque) for torque in ranges["loads.peak_torque_Nm"]]
    assert len({one.drive.input_setback_mm for one in each}) == 2
    swings = [one.analyse().figures.reversal_swing_mrad for one in each]
    assert mc.analyse_many(design, ranges)["reversal_swing_mrad"] == pytest.approx(swings, rel=1e-9)


@pytest.mark.parametrize("layout", ["siso_spur", "miso_spur", "siso_bevel"])
def test_designs_of_other_layouts_are_those_of_each_alone(layout: str) -> None:
    ratio = "input_to_drum: 4.0" if layout == "siso_bevel" else "input_to_drum: 8.0"
    text = SHORT.replace("miso_bevel", layout).replace("ratio: 9.0", ratio)
    design = mc.DriveDesign(load_text(text.replace("peak_torque_Nm: 2.0", "peak_torque_Nm: 0.4")))
    ranges = {"transmission.drum_radius_mm": [60.0, 75.0], "rope.type": ["7x7-1.0", "7x7-0.61"]}
    together = mc.analyse_many(design, ranges)["reversal_swing_mrad"]
    for k in range(2):
        one = design.with_({field: values[k] for field, values in ranges.items()})
        assert together[k] == pytest.approx(one.analyse().figures.reversal_swing_mrad, rel=1e-9)
