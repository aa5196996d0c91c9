"""Short files of the layouts: rules fill every dimension, and stated values do not change."""

from math import hypot
from typing import Any

import pytest
import yaml

from mbcdm_cad.design.drive import Drive
from mbcdm_cad.errors import InputError
from mbcdm_cad.layouts.loader import layout_of, load_design, load_text
from mbcdm_cad.layouts.miso_spur.design_file import DESIGN_FILE
from mbcdm_cad.layouts.miso_spur.sizing import size as size_of_several
from mbcdm_cad.layouts.siso_bevel.checks import highest_ratio
from mbcdm_cad.layouts.siso_spur.sizing import DERIVED, size
from tests.support.checked import PARAMS, failing, short_file

PLASTIC = {"drum": {"material": "pla"}, "support": {"material": "pla"}}
FIBRE = {"rope": {"type": "uhmwpe-1.5"}}
SMOOTH = FIBRE | {"input_pulleys": {"surface": "smooth"}}


def passing(data: dict[str, Any]) -> Any:
    """The drive of a file, which passes every check."""
    drive: Drive = load_text(yaml.safe_dump(data)).drive
    assert not failing(drive), failing(drive)
    return drive


def with_inputs(count: int | None, data: dict[str, Any]) -> dict[str, Any]:
    """The same with a number of inputs, or none stated."""
    return data if count is None else data | {"inputs": [{"name": f"input_{k}"} for k in range(count)]}


@pytest.mark.parametrize(
    ("half_deg", "ratio", "radius_mm", "peak_Nm", "more"),
    [
        (35.0, 9.9, 60.0, 2.0, {}),
        (60.0, 6.9, 30.0, 0.28, {}),
        (90.0, 7.9, 80.0, 2.0, {}),
        # A collar of 31 mm beside the wide corner of its pocket.
        (14.5, 3.76, 110.6, 5.0, {}),
        (20.0, 4.0, 100.0, 3.0, SMOOTH),
        (60.0, 8.0, 70.0, 2.0, PLASTIC),
        # An antenna: much torque on a stated rope, from a motor with a short shaft.
        pytest.param(120.0, 8.0, 300.0, 150.0, {"rope": {"type": "7x19-2.0"}}, marks=pytest.mark.slow),
    ],
)
def test_a_short_file_of_siso_spur_passes_every_check(
    half_deg: float, ratio: float, radius_mm: float, peak_Nm: float, more: dict[str, Any]
) -> None:
    passing(short_file("siso_spur", half_deg, ratio, radius_mm, peak_Nm, **more))


@pytest.mark.parametrize(("peak_Nm", "inputs", "more"), [(4.0, None, {}), (6.0, 3, {}), (6.0, 4, FIBRE)])
def test_a_short_file_of_miso_spur_passes_every_check(peak_Nm: float, inputs: int | None, more: dict[str, Any]) -> None:
    drive = passing(with_inputs(inputs, short_file("miso_spur", 35.0, 9.9, 60.0, peak_Nm, **more)))
    assert len(drive.input_names) == (inputs or 2)


@pytest.mark.parametrize(
    ("half_deg", "radius_mm", "peak_Nm"), [(35.0, 60.0, 0.9), (20.0, 120.0, 4.0), (15.0, 80.0, 0.7)]
)
def test_a_short_file_of_siso_bevel_passes_every_check(half_deg: float, radius_mm: float, peak_Nm: float) -> None:
    drive = passing(short_file("siso_bevel", half_deg, None, radius_mm, peak_Nm))
    # Travel, reserve and the stop's slot on one turn of the input.
    assert drive.total_ratio * 2 * half_deg + drive.reserve_deg < 360.0


@pytest.mark.parametrize(
    ("inputs", "data"),
    [
        # Two inputs and +-62 degrees: the terminals of one sector come round to the other input's encoder and shelf.
        (2, short_file("miso_spur", 61.9, 11.96, 42.7, 0.52, limits={"losses": "counted"})),
        # Four printed hubs of 98 mm for their dowels: the stop's slot lies outside them. With losses counted the motors
        # are stronger, and their stop pin leaves the slot no web. Four M3 would not hold the plastic frame.
        (
            4,
            short_file("miso_spur", 35.0, 4.95, 89.5, 8.0, rope={"type": "7x7-0.61"}, limits={"losses": "paper"})
            | PLASTIC,
        ),
        # A pulley of 56 mm: its deep box needs wide corners, which the encoder's pocket must hold.
        (None, short_file("siso_bevel", 14.4, 1.97, 110.6, 2.2)),
        # A printed drum of 43 mm, which leaves the column's pockets as much as their screws need.
        (
            None,
            short_file("siso_bevel", 51.2, 3.09, 43.0, 0.15, drum={"material": "pa12"}, support={"material": "pa12"}),
        ),
        # A pulley of 9.1 mm beside an encoder of 8 mm radius.
        (None, short_file("siso_bevel", 22.9, 6.02, 55.0, 0.13, rope={"type": "uhmwpe-0.8"})),
    ],
    ids=("wide travel", "wide hub", "wide pulley", "small printed drum", "thin pulley"),
)
def test_far_corners_of_the_space_pass_every_check(inputs: int | None, data: dict[str, Any]) -> None:
    passing(with_inputs(inputs, data))


@pytest.mark.parametrize(
    ("half_deg", "ratio", "radius_mm", "peak_Nm", "more"),
    [(60.0, 6.9, 30.0, 0.28, {}), (20.0, 4.0, None, 3.0, SMOOTH), (60.0, 8.0, None, 2.0, PLASTIC)],
)
def test_one_line_more_gives_two_anchored_cables_that_pass(
    half_deg: float, ratio: float, radius_mm: float | None, peak_Nm: float, more: dict[str, Any]
) -> None:
    """Turns for travel and reserve, an input that takes the stops, bearings inside their necks."""
    anchored = {"transmission": {"cables": "two_anchored"}}
    drive = passing(short_file("siso_spur", half_deg, ratio, radius_mm, peak_Nm, **more, **anchored))
    assert 0.5 <= drive.dead_turns < 1.6, drive.dead_turns


def test_motor_alone_gives_ratio_and_radius() -> None:
    """6 N m with losses from 0.74 N m: 8.75 to 1, on the smallest input that a 2 mm rope and the shaft allow."""
    more = {"rope": {"type": "uhmwpe-2"}, "drive": {"motor": "eaglepower-8308-90kv"}}
    drive = passing(short_file("siso_spur", 60.0, None, None, 6.0, **more))
    assert drive.gearhead.absent and drive.total_ratio == pytest.approx(1.08 * 6.0 / 0.74, rel=0.03)
    assert 2 * drive.input_radius_mm / drive.cable.diameter_mm >= drive.limits.bend_ratio_min
    assert drive.drum_radius_mm < 75.0


def test_motors_alone_give_the_smallest_drum_that_rope_and_shaft_allow() -> None:
    """6 N m from two of 0.7 N m at 4.65 to 1: the stop pin stands where hub and rim leave its slot a web."""
    # A stiffness that any drive has: nothing is raised over what strength and place ask for.
    more = {"rope": {"type": "uhmwpe-2"}, "drive": {"motor": "tmotor-u8-100kv"}, "loads": {"stiffness_Nm_rad": 1.0}}
    radius = passing(short_file("miso_spur", 60.0, None, None, 6.0, **more, **PLASTIC)).cables[0].drum_radius_mm
    assert radius == 37.5, f"{radius} mm"


@pytest.mark.parametrize("more", [{"transmission": {"input_to_drum": 8.0}}, {"drive": {"motor": "motor-2.9mNm-15"}}])
def test_rope_and_radius_both_left_out_follow_from_each_other(more: dict[str, Any]) -> None:
    """The thinnest rope that holds the tension on the drum that it leads to; gearhead and ratio follow from a motor."""
    values = {v.field for v in size(short_file("siso_spur", 45.0, None, None, 1.5, **more)).values}
    assert {"rope.type", "transmission.drum_radius_mm", "drive.gearhead"} <= values, values


def test_each_input_is_sized_for_its_share_of_the_torque() -> None:
    """Train, rope, preload and turns of n inputs under n M are those of siso_spur under M."""
    alike = ("drive.motor", "drive.gearhead", "rope.type", "rope.preload_N", "rope.helix_lead_mm", "transmission.turns")
    one = {v.field: v.value for v in size(short_file("siso_spur", 35.0, 9.9, 60.0, 2.0)).values}
    asked = with_inputs(3, short_file("miso_spur", 35.0, 9.9, 60.0, 6.0))
    three = {v.field: v.value for v in size_of_several(asked).values}
    assert {name: three[name] for name in alike} == {name: one[name] for name in alike}


@pytest.mark.parametrize(("layout", "sized"), [("siso_spur", size), ("miso_spur", size_of_several)])
def test_a_whole_file_has_no_gaps(layout: str, sized: Any) -> None:
    values = {v.field: v.value for v in sized(yaml.safe_load((PARAMS / f"{layout}.yaml").read_text())).values}
    assert values == {"input_pulleys.collar_screw": "M1.6x6", "drum.stop_pin_mm": 3.0}, "other than the schema's own"


def test_what_is_given_stays_and_the_starting_file_passes() -> None:
    pinned: Any = load_text(yaml.safe_dump(short_file("siso_spur", 35.0, 9.9, 60.0, 2.0, support={"plate_mm": 7.3})))
    assert pinned.drive.support.plate_mm == 7.3
    passing(yaml.safe_load(DESIGN_FILE.starting.format(name="started")))


def test_every_dimension_has_a_rule() -> None:
    """Each block's numbers of the reference that the short file leaves out come from a rule, and are named derived."""
    named = {value.field for value in size(short_file("siso_spur", 35.0, 9.9, 60.0, 2.0)).values}
    # A file without idlers has none of their fields.
    derived = {field for field in DERIVED if not field.startswith("idlers.")}
    assert derived <= named, derived - named


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (
            "name: x\nconfiguration: siso_spur\ntravel: {half_angle_deg: 30.0}\n",
            "loads.peak_torque_Nm.*add peak_torque_Nm: 2.15",
        ),
        (yaml.safe_dump(short_file("siso_bevel", 30.0, None, None, 0.5)), r"drum_radius_mm: 58\.0"),
        (
            yaml.safe_dump(short_file("siso_bevel", 35.0, None, 60.0, 0.9, transmission={"drum_radii_mm": [50, 55]})),
            "drum_radius_mm: contradicts drum_radii_mm",
        ),
    ],
    ids=("no torque", "no radius", "two radii of step 1"),
)
def test_what_is_missing_or_contradicts_itself_is_told_with_what_to_add(text: str, words: str) -> None:
    with pytest.raises(InputError, match=words):
        load_text(text)


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


def test_a_free_ratio_fills_the_turn_that_a_long_travel_leaves() -> None:
    """At +-60 degrees 120 i + 18 + slot <= 360: the check's own figure is met, and a step of 0.05 more is too much."""
    drive: Any = load_text(yaml.safe_dump(short_file("siso_bevel", 60.0, None, 90.0, 0.9))).drive
    most = highest_ratio(drive)
    assert most - 0.05 < drive.total_ratio <= most, f"{drive.total_ratio} of {most}"


def test_a_stated_ratio_that_needs_it_takes_from_the_reserve() -> None:
    """Two hundredths over the highest ratio that 18 degrees of reserve leave, some of them go; below it they stay."""
    free: Any = load_text(yaml.safe_dump(short_file("siso_bevel", 60.0, None, 90.0, 0.9))).drive
    most = highest_ratio(free)
    for ratio, least, above in ((most - 0.01, 18.0, 18.1), (most + 0.02, 15.0, 17.5)):
        drive: Any = load_text(yaml.safe_dump(short_file("siso_bevel", 60.0, round(ratio, 3), 90.0, 0.9))).drive
        assert least <= drive.reserve_deg < above, f"{ratio}: {drive.reserve_deg} deg"
