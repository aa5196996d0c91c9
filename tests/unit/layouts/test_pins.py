"""A pin that a requirement contradicts: the first advice is to remove it, and this works."""

from typing import Any

import yaml

from mbcdm_cad.checks.comparison import failed
from mbcdm_cad.layouts.check_design import run_checks
from mbcdm_cad.layouts.loader import load_text, reference_data


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
    assert found["outer_face"].remedy.startswith("take drum.outer_face_y_mm out: its rule gives "), found
    del data["drum"]
    assert failed(run_checks(load_text(yaml.safe_dump(data)))) == ()


def test_the_advice_on_a_pin_tells_its_line() -> None:
    text = yaml.safe_dump(short(), sort_keys=False) + "# the pin\ndrum:\n  outer_face_y_mm: 10.5\n"
    line = text.splitlines().index("  outer_face_y_mm: 10.5") + 1
    found = {check.id: check for check in failed(run_checks(load_text(text)))}
    assert f"(given on line {line})" in found["outer_face"].remedy, found["outer_face"].remedy


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


def test_advice_for_a_short_file_names_the_fields_that_it_has() -> None:
    """Of a file with ratio and drum radius nobody can lower the ratio of input to guide alone."""
    data = short() | {"rope": {"type": "7x7-1.6"}, "limits": {"bend_ratio_min": 10.0}}
    data["transmission"] = {"ratio": 12.0, "drum_radius_mm": 54.0}
    found = {check.id: check for check in failed(run_checks(load_text(yaml.safe_dump(data))))}
    remedy = found["bend_ratio"].remedy
    assert "lower transmission.ratio from 12 to at most" in remedy, remedy
    assert "raise transmission.drum_radius_mm from 54 to at least" in remedy, remedy
    bend = 2 * 54.0 / (12.0 * 1.59)
    assert f"{bend:.3g} D/d" in found["bend_ratio"].message, found["bend_ratio"].message
    ratio = float(remedy.split("transmission.ratio from 12 to at most ")[1].split()[0])
    assert 10.0 <= 2 * 54.0 / (ratio * 1.59) <= 10.05, f"the advice of {ratio} does not just reach D/d 10"
