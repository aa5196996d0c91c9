"""Remedies applied together: the text is true, requirements do not change, and checks without a figure are named."""

import copy
from typing import Any

import pytest
import yaml

from mbcdm_cad.checks.comparison import failed
from mbcdm_cad.layouts.check_design import advised_checks, run_checks
from mbcdm_cad.layouts.loader import load_text, reference_data

ASKED = {
    "name": "asked",
    "configuration": "miso_bevel",
    "travel": {"half_angle_deg": 35.0},
    "transmission": {"ratio": 9.0, "drum_radius_mm": 60.0},
    "loads": {"peak_torque_Nm": 1.5},
}
# What each start changes of a short file: pins too small and too large, requirements that exclude each other.
STARTS: dict[str, dict[str, Any]] = {
    "rim": {"drum": {"outer_face_y_mm": 9.0}},
    "back": {"support": {"back_y_mm": -9.0}},
    "web": {"drum": {"web_thickness_mm": 0.4}, "support": {"side_wall_mm": 2.0}},
    "sector": {"drum": {"sector_half_angle_deg": 40.0}},
    "space": {"support": {"coupling_space_mm": 3.0}},
    "rope": {"rope": {"type": "7x7-2.4"}},
    "plate": {"support": {"top_plate_mm": 1.2}},
    "preload": {"rope": {"preload_N": 900.0}},
    "torque": {"loads": {"peak_torque_Nm": 40.0}},
}


def started(name: str) -> dict[str, Any]:
    data = copy.deepcopy(ASKED)
    for block, fields in STARTS[name].items():
        data[block] = {**data.get(block, {}), **fields}  # type: ignore[dict-item]
    return data


# Starts from which three rounds are tried, some seconds each.
LONG = ("torque", "preload", "sector", "web")


@pytest.mark.parametrize("name", [pytest.param(n, marks=pytest.mark.slow) if n in LONG else n for n in STARTS])
def test_following_the_advice_passes_or_says_what_stays(name: str) -> None:
    data = started(name)
    results, found = advised_checks(load_text(yaml.safe_dump(data), "asked.yaml"))
    assert failed(results) and found is not None
    for path in found.taken_out:
        block, field = path.split(".")
        del data[block][field]
    for path, value in found.changes.items():
        block, field = path.split(".")
        data.setdefault(block, {})[field] = value
    left = tuple(result.id for result in failed(run_checks(load_text(yaml.safe_dump(data), "asked.yaml"))))
    words = found.words("asked.yaml")
    if found.changes or found.taken_out:
        assert left == found.failing, words
    assert ("passes every check" in words) is (not left) and ("mbcdm solve asked.yaml" in words) is bool(left), words
    for field in ("peak_torque_Nm",):
        assert data["loads"][field] == started(name)["loads"][field]
    assert data["travel"] == started(name)["travel"] and data["transmission"] == started(name)["transmission"] | {
        field: value for field, value in data["transmission"].items() if field not in started(name)["transmission"]
    }


def test_what_the_file_asks_is_named_last() -> None:
    data = started("torque")
    for result in failed(run_checks(load_text(yaml.safe_dump(data)))):
        offers = [part for part in result.remedy.split(" or ") if part.startswith(("raise ", "lower "))]
        asked = ["loads.peak_torque_Nm" in part or "half_angle_deg" in part for part in offers]
        assert asked == sorted(asked), result.remedy


def test_a_lug_without_metal_has_no_stress() -> None:
    found = {result.id: result for result in run_checks(load_text(yaml.safe_dump(started("rim"))))}
    assert found["lug_stress"].actual is None
    assert "not evaluated because the rim ends before the lug of cable_" in found["lug_stress"].message


def test_preloads_of_single_cables_are_named_by_their_own_key() -> None:
    data = reference_data()
    for cable in data["cables"]:
        cable["preload_N"] = 300.0
    remedies = [result.remedy for result in run_checks(load_text(yaml.safe_dump(data))) if "preload_N" in result.remedy]
    assert remedies
    assert any("cables.0.preload_N from 300 to at most" in remedy for remedy in remedies), remedies
