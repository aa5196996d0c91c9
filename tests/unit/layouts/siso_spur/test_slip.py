"""The torque at which a continuous cable slips on its input is one figure wherever it is told."""

from pathlib import Path

import pytest

from mbcdm_cad.layouts.loader import load_design, load_text
from mbcdm_cad.report.analysis_report import analyse_design
from tests.support.checked import result

PARAMS = Path(__file__).parents[4] / "params"
RING = """name: ring
configuration: siso_spur
travel: {half_angle_deg: 86}
transmission: {input_to_drum: 18.6, drum_radius_mm: 111}
loads: {peak_torque_Nm: 3.55}
"""


@pytest.mark.parametrize("name", ["siso_spur.yaml", "gallery/capstan.yaml", "ring"])
def test_slip_is_one_figure_in_check_and_analyse(name: str) -> None:
    loaded = load_text(RING) if name == "ring" else load_design(PARAMS / name)
    check = result(loaded, "input_slip")
    told = [t.torque_Nm for t in analyse_design(loaded.drive).figures.limits if t.cause == "slip"]
    checked = check.actual * loaded.drive.loads.peak_torque_Nm
    assert min(told) == pytest.approx(checked, rel=1e-6), f"analyse {told} N m, check {checked} N m"
