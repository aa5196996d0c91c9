"""A pin that a requirement contradicts: the first advice is to remove it, and this works."""

from __future__ import annotations

from typing import Any

import yaml

from mbcdm_cad.checks.result import failed
from mbcdm_cad.configurations.check_design import run_checks
from mbcdm_cad.configurations.loader import load_text, reference_data


def short() -> dict[str, Any]:
    return {
        "name": "pinned",
        "configuration": "miso_bevel",
        "travel": {"half_angle_deg": 35.0},
        "transmission": {"ratio": 9.0, "drum_radius_mm": 54.0},
        "loads": {"peak_torque_Nm": 3.0},
    }


def test_a_contradicting_pin_is_the_first_advice_and_taking_it_out_passes() -> None:
    data = short() | {"drum": {"outer_face_y_mm": 10.5}}
    found = {check.id: check for check in failed(run_checks(load_text(yaml.safe_dump(data))))}
    assert found["outer_face"].remedy.startswith("take drum.outer_face_y_mm out: its rule gives 12.5"), found
    del data["drum"]
    assert failed(run_checks(load_text(yaml.safe_dump(data)))) == ()


def test_a_pin_that_is_not_to_blame_is_not_named() -> None:
    data = short() | {"support": {"side_wall_mm": 6.0}}
    data["limits"] = {"bend_ratio_min": 60.0}
    found = {check.id: check for check in failed(run_checks(load_text(yaml.safe_dump(data))))}
    assert "take " not in found["bend_ratio"].remedy, found["bend_ratio"].remedy


def test_a_complete_file_is_told_that_its_derived_fields_may_follow() -> None:
    data = reference_data()
    data["transmission"]["centre_distance_mm"] = 38.0
    found = {check.id: check for check in failed(run_checks(load_text(yaml.safe_dump(data))))}
    assert found["drum_sweep"].remedy.startswith("take the "), found["drum_sweep"].remedy
    assert "derived fields out" in found["drum_sweep"].remedy
