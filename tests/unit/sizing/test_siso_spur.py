"""Short files of siso_spur: rules fill every dimension, and stated values do not change."""

from math import hypot
from pathlib import Path
from typing import Any

import pytest
import yaml

from mbcdm_cad.errors import InputError
from mbcdm_cad.layouts.loader import layout_of, load_design, load_text
from mbcdm_cad.layouts.siso_spur.sizing import DERIVED, size
from tests.support.checked import failing

PARAMS = Path(__file__).parents[3] / "params"


def short(half_deg: float, ratio: float, radius_mm: float, peak_Nm: float, **more: Any) -> str:
    data = {
        "name": "short",
        "configuration": "siso_spur",
        "travel": {"half_angle_deg": half_deg},
        "transmission": {"input_to_drum": ratio, "drum_radius_mm": radius_mm},
        "loads": {"peak_torque_Nm": peak_Nm},
    }
    return yaml.safe_dump(data | more)


@pytest.mark.parametrize(
    ("half_deg", "ratio", "radius_mm", "peak_Nm", "more"),
    [
        (35.0, 9.9, 60.0, 2.0, {}),
        (60.0, 6.9, 30.0, 0.28, {}),
        (90.0, 7.9, 80.0, 2.0, {}),
        # A collar of 31 mm beside the wide corner of its pocket.
        (14.5, 3.76, 110.6, 5.0, {}),
        (20.0, 4.0, 100.0, 3.0, {"rope": {"type": "uhmwpe-1.5"}, "input_pulleys": {"surface": "smooth"}}),
        (60.0, 8.0, 70.0, 2.0, {"drum": {"material": "pla"}, "support": {"material": "pla"}}),
        # An antenna: much torque on a stated rope, from a motor with a short shaft.
        pytest.param(120.0, 8.0, 300.0, 150.0, {"rope": {"type": "7x19-2.0"}}, marks=pytest.mark.slow),
    ],
)
def test_a_short_file_passes_every_check(
    half_deg: float, ratio: float, radius_mm: float, peak_Nm: float, more: dict[str, Any]
) -> None:
    found = failing(load_text(short(half_deg, ratio, radius_mm, peak_Nm, **more)).drive)
    assert not found, found


@pytest.mark.parametrize(
    ("half_deg", "transmission", "peak_Nm", "more"),
    [
        (60.0, {"input_to_drum": 6.9, "drum_radius_mm": 30.0}, 0.28, {}),
        (20.0, {"input_to_drum": 4.0}, 3.0, {"rope": {"type": "uhmwpe-1.5"}, "input_pulleys": {"surface": "smooth"}}),
        (60.0, {"input_to_drum": 8.0}, 2.0, {"drum": {"material": "pla"}, "support": {"material": "pla"}}),
    ],
)
def test_one_line_more_gives_two_anchored_cables_that_pass(
    half_deg: float, transmission: dict[str, Any], peak_Nm: float, more: dict[str, Any]
) -> None:
    """Turns for travel and reserve, an input that takes the stops, bearings inside their necks."""
    data = yaml.safe_load(short(half_deg, 1.0, 1.0, peak_Nm, **more))
    data["transmission"] = transmission | {"cables": "two_anchored"}
    drive: Any = load_text(yaml.safe_dump(data)).drive
    assert not failing(drive), failing(drive)
    assert 0.5 <= drive.dead_turns < 1.6, drive.dead_turns


def test_motor_alone_gives_ratio_and_radius() -> None:
    """6 N m with losses from 0.74 N m: 8.75 to 1, on the smallest input that a 2 mm rope and the shaft allow."""
    data = yaml.safe_load(short(60.0, 1.0, 1.0, 6.0)) | {
        "transmission": {},
        "rope": {"type": "uhmwpe-2"},
        "drive": {"motor": "eaglepower-8308-90kv"},
    }
    drive: Any = load_text(yaml.safe_dump(data)).drive
    assert drive.gearhead.absent and drive.total_ratio == pytest.approx(1.08 * 6.0 / 0.74, rel=0.03)
    assert 2 * drive.input_radius_mm / drive.cable.diameter_mm >= drive.limits.bend_ratio_min
    assert drive.drum_radius_mm < 75.0
    assert not failing(drive), failing(drive)


@pytest.mark.parametrize("given", [{"transmission": {"input_to_drum": 8.0}}, {"drive": {"motor": "motor-2.9mNm-15"}}])
def test_rope_and_radius_both_left_out_follow_from_each_other(given: dict[str, Any]) -> None:
    """The thinnest rope that holds the tension on the drum that it leads to; gearhead and ratio follow from a motor."""
    values = {
        v.field: v.value
        for v in size({**yaml.safe_load(short(45.0, 1.0, 1.0, 1.5)), "transmission": {}} | given).values
    }
    assert {"rope.type", "transmission.drum_radius_mm", "drive.gearhead"} <= values.keys(), values


def test_what_is_given_stays_and_a_whole_file_has_no_gaps() -> None:
    data = yaml.safe_load((PARAMS / "siso_spur.yaml").read_text())
    values = {value.field: value.value for value in size(data).values}
    assert values == {"input_pulleys.collar_screw": "M1.6x6", "drum.stop_pin_mm": 3.0}, "other than the schema's own"
    pinned: Any = load_text(short(35.0, 9.9, 60.0, 2.0, support={"plate_mm": 7.3})).drive
    assert pinned.support.plate_mm == 7.3


def test_every_dimension_has_a_rule() -> None:
    """Each block's numbers of the reference that the short file leaves out come from a rule, and are named derived."""
    named = {value.field for value in size(yaml.safe_load(short(35.0, 9.9, 60.0, 2.0))).values}
    # A file without idlers has none of their fields.
    derived = {field for field in DERIVED if not field.startswith("idlers.")}
    assert derived <= named, derived - named


def test_a_missing_requirement_is_told_with_what_to_add() -> None:
    with pytest.raises(InputError) as caught:
        load_text("name: x\nconfiguration: siso_spur\ntravel: {half_angle_deg: 30.0}\n")
    told = str(caught.value)
    assert "loads.peak_torque_Nm" in told and "add peak_torque_Nm: 2.15" in told, told


def test_lugs_of_long_terminals_are_rooted_in_the_rim() -> None:
    """An M4 terminal puts its lug beyond where the tangent has left the rim: its root reaches the rim all the same.

    Without, the drum of params/gallery/capstan.yaml fell into three pieces.
    """
    drive: Any = load_design(PARAMS / "gallery" / "capstan.yaml").drive
    drum = layout_of(drive).drum  # type: ignore[attr-defined]
    for t in drum.tensioners:
        foot = hypot(t.radius_mm - drum.lug_root(t), t.lug_end)
        surface = drum.lands[-1].surface_radius_mm
        assert foot < surface, f"{t.cable_name}: the far corner at {foot:.2f} mm, the rim to {surface}"
