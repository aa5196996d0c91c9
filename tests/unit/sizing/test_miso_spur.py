"""Short files of miso_spur: as siso_spur with a shared load, and gaps between sectors and inputs."""

from pathlib import Path
from typing import Any

import pytest
import yaml

from mbcdm_cad.layouts.loader import load_text
from mbcdm_cad.layouts.miso_spur.design_file import DESIGN_FILE
from mbcdm_cad.layouts.miso_spur.sizing import size
from mbcdm_cad.layouts.siso_spur.sizing import size as size_of_one
from tests.support.checked import failing

PRINTED = ("drum", "support")
PARAMS = Path(__file__).parents[3] / "params"


def short(peak_Nm: float, inputs: int | None = None, **more: Any) -> dict[str, Any]:
    """Requirements, with a number of inputs or none stated."""
    data: dict[str, Any] = {
        "name": "short",
        "configuration": "miso_spur",
        "travel": {"half_angle_deg": 35.0},
        "transmission": {"input_to_drum": 9.9, "drum_radius_mm": 60.0},
        "loads": {"peak_torque_Nm": peak_Nm},
    }
    if inputs is not None:
        data["inputs"] = [{"name": f"input_{k}"} for k in range(inputs)]
    return data | more


@pytest.mark.parametrize(
    ("peak_Nm", "inputs", "more"), [(4.0, None, {}), (6.0, 3, {}), (6.0, 4, {"rope": {"type": "uhmwpe-1.5"}})]
)
def test_a_short_file_passes_every_check(peak_Nm: float, inputs: int | None, more: dict[str, Any]) -> None:
    drive = load_text(yaml.safe_dump(short(peak_Nm, inputs, **more))).drive
    assert len(drive.input_names) == (inputs or 2)
    assert not failing(drive), failing(drive)


def test_each_input_is_sized_for_its_share_of_the_torque() -> None:
    """Train, rope, preload and turns of n inputs under n M are those of siso_spur under M."""
    alike = ("drive.motor", "drive.gearhead", "rope.type", "rope.preload_N", "rope.helix_lead_mm", "transmission.turns")
    one = {v.field: v.value for v in size_of_one(short(2.0, configuration="siso_spur")).values}
    three = {v.field: v.value for v in size(short(6.0, 3)).values}
    assert {name: three[name] for name in alike} == {name: one[name] for name in alike}


@pytest.mark.parametrize(
    "asked",
    [
        # Two inputs and +-62 degrees: the terminals of one sector come round to the other input's encoder and shelf.
        {"half": 61.9, "radius": 42.7, "ratio": 11.96, "peak": 0.52, "inputs": 2},
        # Four printed hubs of 98 mm for their dowels: the stop's slot lies outside them. With losses counted the motors
        # are stronger, and their stop pin leaves the slot no web. Four M3 would not hold the plastic frame.
        {"half": 35.0, "radius": 89.5, "ratio": 4.95, "peak": 8.0, "inputs": 4, "rope": "7x7-0.61", "material": "pla"}
        | {"losses": "paper"},
    ],
    ids=("wide travel", "wide hub"),
)
def test_far_corners_of_the_space_pass_every_check(asked: dict[str, Any]) -> None:
    data = short(asked["peak"], asked["inputs"])
    data["travel"]["half_angle_deg"] = asked["half"]
    data["limits"] = {"losses": asked.get("losses", "counted")}
    data["transmission"] = {"input_to_drum": asked["ratio"], "drum_radius_mm": asked["radius"]}
    if "rope" in asked:
        data |= {"rope": {"type": asked["rope"]}, **{part: {"material": asked["material"]} for part in PRINTED}}
    drive = load_text(yaml.safe_dump(data)).drive
    assert not failing(drive), failing(drive)


def test_motors_alone_give_the_smallest_drum_that_rope_and_shaft_allow() -> None:
    """6 N m from two of 0.7 N m at 4.65 to 1: the stop pin stands where hub and rim leave its slot a web."""
    plastic = {"drum": {"material": "pla"}, "support": {"material": "pla"}}
    data = short(6.0, rope={"type": "uhmwpe-2"}, drive={"motor": "tmotor-u8-100kv"}, transmission={}, **plastic)
    # A stiffness that any drive has: nothing is raised over what strength and place ask for.
    data |= {"travel": {"half_angle_deg": 60.0}, "loads": {"peak_torque_Nm": 6.0, "stiffness_Nm_rad": 1.0}}
    drive = load_text(yaml.safe_dump(data)).drive
    assert not failing(drive), failing(drive)
    radius = drive.cables[0].drum_radius_mm
    assert radius == 37.5, f"{radius} mm"


def test_what_is_given_stays_and_the_starting_file_passes() -> None:
    data = yaml.safe_load((PARAMS / "miso_spur.yaml").read_text())
    values = {value.field: value.value for value in size(data).values}
    assert values == {"input_pulleys.collar_screw": "M1.6x6", "drum.stop_pin_mm": 3.0}, "other than the schema's own"
    drive = load_text(DESIGN_FILE.starting.format(name="started")).drive
    assert not failing(drive), failing(drive)
