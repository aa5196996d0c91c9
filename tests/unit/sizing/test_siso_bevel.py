"""Short files of siso_bevel: ratio and dimensions follow from travel, radius and torque."""

from __future__ import annotations

from typing import Any

import pytest
import yaml

from mbcdm_cad.configurations.check_design import run_checks
from mbcdm_cad.configurations.loader import load_text
from mbcdm_cad.errors import InputError


def short(half_deg: float, radius_mm: float, peak_Nm: float) -> dict[str, Any]:
    return {
        "name": "short",
        "configuration": "siso_bevel",
        "travel": {"half_angle_deg": half_deg},
        "transmission": {"drum_radius_mm": radius_mm},
        "loads": {"peak_torque_Nm": peak_Nm},
    }


@pytest.mark.parametrize(
    ("half_deg", "radius_mm", "peak_Nm"), [(35.0, 60.0, 0.9), (20.0, 120.0, 4.0), (15.0, 80.0, 0.7)]
)
def test_a_short_file_passes_every_check(half_deg: float, radius_mm: float, peak_Nm: float) -> None:
    drive: Any = load_text(yaml.safe_dump(short(half_deg, radius_mm, peak_Nm))).drive
    failed = {check.id: check.message for check in run_checks(drive) if check.status == "fail"}
    assert not failed, failed
    # Travel, reserve and the stop's slot on one turn of the input.
    assert drive.total_ratio * 2 * half_deg + drive.reserve_deg < 360.0


def test_a_missing_radius_is_told() -> None:
    with pytest.raises(InputError) as caught:
        load_text(yaml.safe_dump(short(30.0, 1.0, 0.5) | {"transmission": {}}))
    assert "drum_radius_mm: 58.0" in str(caught.value)
