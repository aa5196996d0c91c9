"""Short files of siso_bevel: ratio and dimensions follow from travel, radius and torque."""

from typing import Any

import pytest
import yaml

from mbcdm_cad.errors import InputError
from mbcdm_cad.layouts.loader import load_text
from mbcdm_cad.layouts.siso_bevel.checks import highest_ratio
from tests.support.checked import failing


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
    failed = failing(drive)
    assert not failed, failed
    # Travel, reserve and the stop's slot on one turn of the input.
    assert drive.total_ratio * 2 * half_deg + drive.reserve_deg < 360.0


@pytest.mark.parametrize(
    "asked",
    [
        # A pulley of 56 mm: its deep box needs wide corners, which the encoder's pocket must hold.
        {"half": 14.4, "radius": 110.6, "peak": 2.2, "ratio": 1.97},
        # A printed drum of 43 mm, which leaves the column's pockets as much as their screws need.
        {"half": 51.2, "radius": 43.0, "peak": 0.15, "ratio": 3.09, "material": "pa12"},
        # A pulley of 9.1 mm beside an encoder of 8 mm radius.
        {"half": 22.9, "radius": 55.0, "peak": 0.13, "ratio": 6.02, "rope": "uhmwpe-0.8"},
    ],
    ids=("wide pulley", "small printed drum", "thin pulley"),
)
def test_far_corners_of_the_space_pass_every_check(asked: dict[str, Any]) -> None:
    data = short(asked["half"], asked["radius"], asked["peak"])
    data["transmission"]["input_to_drum"] = asked["ratio"]
    if "rope" in asked:
        data["rope"] = {"type": asked["rope"]}
    if "material" in asked:
        data |= {part: {"material": asked["material"]} for part in ("drum", "support")}
    failed = failing(load_text(yaml.safe_dump(data)).drive)
    assert not failed, failed


def test_a_free_ratio_fills_the_turn_that_a_long_travel_leaves() -> None:
    """At +-60 degrees 120 i + 18 + slot <= 360: the check's own figure is met, and a step of 0.05 more is too much."""
    drive = load_text(yaml.safe_dump(short(60.0, 90.0, 0.9))).drive
    most = highest_ratio(drive)
    assert most - 0.05 < drive.total_ratio <= most, f"{drive.total_ratio} of {most}"


def test_a_stated_ratio_that_needs_it_takes_from_the_reserve() -> None:
    """Two hundredths over the highest ratio that 18 degrees of reserve leave, some of them go; below it they stay."""
    data = short(60.0, 90.0, 0.9)
    most = highest_ratio(load_text(yaml.safe_dump(data)).drive)
    for ratio, least, above in ((most - 0.01, 18.0, 18.1), (most + 0.02, 15.0, 17.5)):
        data["transmission"]["input_to_drum"] = round(ratio, 3)
        drive = load_text(yaml.safe_dump(data)).drive
        assert least <= drive.reserve_deg < above, f"{ratio}: {drive.reserve_deg} deg"


def test_two_radii_of_step_1_contradict_each_other() -> None:
    data = short(35.0, 60.0, 0.9)
    data["transmission"]["drum_radii_mm"] = [50.0, 55.0]
    with pytest.raises(InputError, match="drum_radius_mm: contradicts drum_radii_mm"):
        load_text(yaml.safe_dump(data))


def test_a_missing_radius_is_told() -> None:
    with pytest.raises(InputError) as caught:
        load_text(yaml.safe_dump(short(30.0, 1.0, 0.5) | {"transmission": {}}))
    assert "drum_radius_mm: 58.0" in str(caught.value)
