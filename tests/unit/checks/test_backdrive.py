"""The torque that turns the drum from its side: asked, not asked, and gearheads that lock."""

from __future__ import annotations

import pytest
from designs import put, reference

from mbcdm_cad.checks.motors import CHECKS, backdrive
from mbcdm_cad.checks.run import run_check
from mbcdm_cad.layouts.loader import load_text

CHECK = next(check for check in CHECKS if check.id == "backdrive")
HANDLE = """name: handle
configuration: siso_spur
travel: {half_angle_deg: 45}
transmission: {input_to_drum: 10, drum_radius_mm: 60}
loads: {peak_torque_Nm: 0.5, backdrive_Nm: 0.05}
"""


def test_a_design_that_asks_for_none_is_told_the_torque() -> None:
    found = backdrive(reference().layout)
    back = reference().layout.losses.backdrive
    assert back is not None
    assert found.sense == 0 and found.actual == pytest.approx(back.start_Nm)


def test_gearheads_that_lock_fail_only_where_back_driving_is_asked() -> None:
    locked = put(reference(), "gearhead.efficiency", 0.5)
    assert run_check(CHECK, locked.layout).status == "pass"
    asked = run_check(CHECK, put(locked, "loads.backdrive_Nm", 1.0).layout)
    assert asked.status == "fail" and "0.5 or below" in asked.message, asked


def test_a_handle_learns_what_resists_most() -> None:
    found = run_check(CHECK, load_text(HANDLE).drive.layout)
    assert found.status == "fail" and found.actual is not None and found.actual > 0.05, found
    assert "gearhead" in found.remedy, found.remedy
    direct = HANDLE.replace("input_to_drum: 10,", "input_to_drum: 6,").replace("0.05}", "3.0}")
    assert run_check(CHECK, load_text(direct).drive.layout).status == "pass"
