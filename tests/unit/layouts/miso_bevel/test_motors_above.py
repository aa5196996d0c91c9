"""Motors above the top plate, and gearheads turned about their axes: levels, pulleys, loads, checks and rules."""

from dataclasses import replace
from math import hypot
from typing import Any

import numpy as np
import pytest
import yaml

from mbcdm_cad.checks.bearings import input_reactions
from mbcdm_cad.checks.comparison import Comparison
from mbcdm_cad.design.loader import LoadedDesign
from mbcdm_cad.layouts.loader import load_text
from mbcdm_cad.layouts.miso_bevel.bill import bill
from mbcdm_cad.layouts.miso_bevel.checks import box_mm, collar_space, drum_sweep
from mbcdm_cad.layouts.miso_bevel.checks.support_fits import drives_apart, head_seats, key_access, screwdriver
from mbcdm_cad.layouts.miso_bevel.checks.support_walls import bearing_shelf, front_wall, hole_webs, top_plate
from mbcdm_cad.layouts.miso_bevel.drive import BevelDrive, bevel
from mbcdm_cad.layouts.miso_bevel.layout import BevelLayout
from mbcdm_cad.layouts.miso_bevel.support.stiffness import seat_loads
from mbcdm_cad.parts.bodies import screw_places
from mbcdm_cad.parts.input_pulley.dims import ENCODER_INSERTION_MM
from mbcdm_cad.solving.question import question_of
from mbcdm_cad.solving.solve import solve
from tests.support.checked import failing, short_file

SIDES = ("below", "above")


def design(changes: dict[str, Any] | None = None) -> LoadedDesign:
    data = short_file("miso_bevel", 35.0, 9.0, 54.0, 3.15, drive={"motor_side": "above"})
    for block, fields in (changes or {}).items():
        data.setdefault(block, {}).update(fields)
    data["drive"] = {name: value for name, value in data["drive"].items() if value is not None}
    return load_text(yaml.safe_dump(data))


def drive_of(**fields: Any) -> BevelDrive:
    return bevel(design({"drive": fields}).drive)


@pytest.fixture(scope="module")
def drive() -> BevelDrive:
    return drive_of(motor="motor-2.9mNm-15", gearhead="gearhead-141-16")


@pytest.fixture(scope="module")
def dims(drive: BevelDrive) -> BevelLayout:
    return BevelLayout(drive)


def test_from_the_lowest_shelf_to_the_motors(dims: BevelLayout) -> None:
    v, d = dims.levels, dims.drive
    order = (
        v.shelf_bottom_z,
        v.shelf_top_z,
        v.encoder_bottom_z,
        v.encoder_top_z,
        v.bearing_shelf_top_z,
        v.guide_bottom_z,
        v.guide_top_z,
        v.top_plate_bottom_z,
        v.top_plate_top_z,
        v.motor_shelf_bottom_z,
        v.motor_shelf_top_z,
        v.gearhead_top_z,
        v.motor_top_z,
    )
    assert list(order) == sorted(order)
    assert v.encoder_top_z == v.bearing_shelf_bottom_z and v.gearhead_bottom_z == v.motor_shelf_top_z
    assert v.motor_top_z - v.gearhead_bottom_z == pytest.approx(d.gearhead.length_mm + d.motor.length_mm)


def test_levels_from_the_gearhead_are_those_of_the_assembly_reversed(dims: BevelLayout) -> None:
    v, line = dims.levels, dims.levels.from_gearhead
    assert (line.bearing_shelf_top_z, line.top_plate_bottom_z) == (-v.top_plate_bottom_z, -v.bearing_shelf_top_z)
    assert line.motor_top_z < line.motor_shelf_top_z < line.top_plate_bottom_z < line.encoder_top_z
    below = BevelLayout(drive_of(motor_side="below")).levels
    assert below.from_gearhead is below


def test_the_shaft_ends_in_the_pulley_and_the_pulley_in_the_encoder(dims: BevelLayout) -> None:
    line, gear = dims.levels.from_gearhead, dims.drive.gearhead
    for p in dims.inputs:
        assert p.journal_bottom_z < line.motor_shelf_bottom_z + gear.shaft_length_mm < p.bore_top_z
        assert p.journal_top_z == pytest.approx(line.top_plate_top_z + ENCODER_INSERTION_MM)
        # In the assembly the encoder is below.
        assert -p.journal_top_z > dims.levels.encoder_bottom_z


@pytest.mark.parametrize("side", SIDES)
def test_stops_are_where_their_cables_end(side: str) -> None:
    """Two ways to one place: the bill turns the pulley with its stops, the path is computed in the assembly."""
    raised = BevelLayout(drive_of(motor_side=side))
    items = {item.name: item for item in bill(raised, 12.0).items}
    for path in raised.cable_paths(np.radians(12.0)):
        end, bend = path.only(("chord",)).sample(0.05)[[0, -1]]
        at = items[f"stop_{path.cable.name}"].location
        slot = next(s for p in raised.inputs for s in p.slots if s.cable_name == path.cable.name)
        stop = at.apply(np.array([[0.0, 0.0, 0.0], [0.0, 0.0, slot.stop_start - slot.stop_end]]))
        along = (end - bend) / np.linalg.norm(end - bend)
        for point in stop:
            off = point - bend - along * ((point - bend) @ along)
            assert np.linalg.norm(off) < 1e-6, f"{path.cable.name}: stop beside its cable by {off}"


@pytest.mark.parametrize("side", SIDES)
def test_bearing_loads_by_two_ways(side: str) -> None:
    """The checks take moments along the input from its gearhead, the frame's load in the assembly's coordinates."""
    s = BevelLayout(drive_of(motor_side=side))
    tension = s.loads.idle
    seats = seat_loads(s, np.asarray(tension))
    ends = ("upper", "lower") if side == "above" else ("lower", "upper")
    s.loads.__dict__["on_bodies"] = [s.loads.on_bodies[0]]
    for name, low, high in input_reactions(s):
        for end, load in zip(ends, (low, high), strict=True):
            assert np.linalg.norm(seats.at(f"{name}_{end}")) == pytest.approx(load, rel=1e-6)


def test_every_check_passes_as_with_motors_below() -> None:
    for side in SIDES:
        assert failing(design({"drive": {"motor_side": side}})) == {}


def test_box_reaches_from_the_hub_to_the_motors(drive: BevelDrive, dims: BevelLayout) -> None:
    x, z, _ = box_mm(BevelLayout(drive))
    low = max(dims.frame.boss.radius, dims.drum.hub_radius)
    assert z >= dims.levels.motor_top_z + low - 1e-9
    below = box_mm(BevelLayout(drive_of(motor_side="below")))
    assert below[1] < z and x >= 2 * dims.levels.side_outer_x


def test_boxes_mirror_each_other(dims: BevelLayout) -> None:
    turned = BevelLayout(drive_of(gearhead_angle_deg=20.0))
    (left, at_left), (right, at_right) = turned.top_plate.boxes
    assert left == -right
    assert sorted((-x, y) for x, y in at_left.gear_screws) == sorted(at_right.gear_screws)
    assert dims.top_plate.boxes[0][1].gear_screws == dims.top_plate.boxes[1][1].gear_screws


@pytest.mark.parametrize("side", SIDES)
@pytest.mark.parametrize("turn", [0.0, 25.0, -60.0])
def test_threads_of_the_gearheads_are_behind_the_holes_for_their_screws(side: str, turn: float) -> None:
    raised = BevelLayout(drive_of(motor_side=side, gearhead_angle_deg=turn))
    gear = raised.drive.gearhead
    items = {item.name: item for item in bill(raised).items}
    holes = list(raised.frame.gear_screws) or [
        (x + dx, raised.top_plate.input_y + dy) for x, box in raised.top_plate.boxes for dx, dy in box.gear_screws
    ]
    assert len(holes) == 2 * gear.screw_count
    for name in raised.drive.input_names:
        threads = [(x, y, 0.0) for x, y in screw_places(gear.screw_count, gear.bolt_circle_mm / 2)]
        for x, y, _ in items[f"gearhead_{name}"].location.apply(np.array(threads)):
            assert min(hypot(x - u, y - v) for u, v in holes) < 1e-6
        screws = [items[f"gearhead_screw_{name}_{n}"].location.shift_mm for n in range(1, gear.screw_count + 1)]
        assert all(min(hypot(x - u, y - v) for u, v in holes) < 1e-6 for x, y, _ in screws)


def test_the_motor_turns_with_its_gearhead() -> None:
    first, other = (
        {item.name: item.location for item in bill(BevelLayout(drive_of(gearhead_angle_deg=turn))).items}
        for turn in (0.0, 30.0)
    )
    for name in ("motor_left", "motor_right"):
        turn = first[name].rotation.T @ other[name].rotation
        assert np.degrees(np.arctan2(abs(turn[1, 0]), turn[0, 0])) == pytest.approx(30.0)
        assert np.allclose(first[name].shift_mm, other[name].shift_mm)


def margins(drive: BevelDrive) -> dict[str, Comparison]:
    s = BevelLayout(drive)
    checks = (
        *(drives_apart, head_seats, key_access, screwdriver, bearing_shelf, front_wall),
        *(hole_webs, top_plate, collar_space, drum_sweep),
    )
    return {check.id: check(s) for check in checks}


def with_support(drive: BevelDrive, **fields: float) -> BevelDrive:
    return replace(drive, support=replace(drive.support, **fields))


# For each check that looks at other parts with motors above: a change that it refuses, and words of its message.
REFUSED: dict[str, tuple[str, Any, str]] = {
    "encoder reaches the mounting screws": (
        "drives_apart",
        lambda d: with_support(d, back_y_mm=d.support.back_y_mm + 4.0),
        "encoder from back plate",
    ),
    "boxes stand behind the base": ("drives_apart", lambda d: with_support(d, side_wall_mm=20.0), "coupling boxes"),
    "boxes touch the axle": (
        "drives_apart",
        lambda d: with_support(d, side_wall_mm=38.0, back_y_mm=-60.0),
        "coupling boxes from the guide's axle",
    ),
    "encoder stands out of the front": (
        "drum_sweep",
        lambda d: replace(d, input_setback_mm=d.input_setback_mm - 0.5),
        "encoders",
    ),
    "shelf too thin for its bearing": (
        "bearing_shelf",
        lambda d: replace(d, bearings=replace(d.bearings, input_upper=replace(d.bearings.input_upper, width_mm=3.5))),
        "upper bearings",
    ),
    "shelf too thin for the encoder's heads": (
        "bearing_shelf",
        lambda d: replace(d, screws=tuple(replace(x, head_height_mm=3.2) for x in d.screws)),
        "encoders' screw heads",
    ),
    "plate too thin for its bearing": ("top_plate", lambda d: with_support(d, top_plate_mm=3.2), "lower bearings"),
}


@pytest.mark.parametrize("case", REFUSED)
def test_what_a_check_refuses(drive: BevelDrive, case: str) -> None:
    name, change, words = REFUSED[case]
    assert margins(drive)[name].holds
    found = margins(change(drive))[name]
    assert not found.holds, found
    assert words in found.subject, found.subject


def test_the_rule_puts_motors_above_where_the_stated_distance_has_no_room_below() -> None:
    near = {"transmission": {"ratio": 6.0, "centre_distance_mm": 18.0}, "travel": {"half_angle_deg": 20.0}}
    near["loads"] = {"peak_torque_Nm": 1.0}
    loaded = design({**near, "drive": {"motor_side": None}})
    (sized,) = (value for value in loaded.sized if value.field == "drive.motor_side")
    assert sized.value == "above" and sized.driver == "drives_apart"
    assert failing(loaded) == {}
    below = design({**near, "drive": {"motor_side": "below"}})
    assert "drives_apart" in failing(below)


def test_solve_may_put_the_motors_above() -> None:
    """No bearing fits below, where the smaller step of the pulley is next to the gearhead, and one does above."""
    text = yaml.safe_dump(short_file("miso_bevel", 28.5, 16.8, 62.3, 0.861))
    assert "bearing_shoulders" in failing(load_text(text))
    found = solve(question_of(text), jobs=1)
    assert found.data is not None and found.data["drive"] == {"motor_side": "above"}


def test_without_need_motors_stay_below() -> None:
    loaded = design({"drive": {"motor_side": None}})
    assert not bevel(loaded.drive).motors_above
    assert not [value for value in loaded.sized if value.field in ("drive.motor_side", "drive.gearhead_angle_deg")]


def test_the_rule_turns_gearheads_whose_screws_have_no_room() -> None:
    """One of three screws is at the back, where a thick back plate stands in its head's way."""
    pinned = {
        "transmission": {"ratio": 8.0, "drum_radius_mm": 60.0},
        "travel": {"half_angle_deg": 20.0},
        "loads": {"peak_torque_Nm": 3.0},
        "support": {"back_plate_mm": 7.4, "back_y_mm": -16.0},
    }
    train = {"gearhead": "gearhead-76-22", "motor_side": "below"}
    loaded = design({**pinned, "drive": train})
    (sized,) = (value for value in loaded.sized if value.field == "drive.gearhead_angle_deg")
    assert sized.driver == "head_seats" and sized.value != 0.0
    assert failing(loaded) == {}
    usual = design({**pinned, "drive": {**train, "gearhead_angle_deg": 0.0}})
    assert list(failing(usual)) == ["head_seats"]


def test_order_of_assembly_reaches_the_gearheads_screws_on_the_bench(dims: BevelLayout) -> None:
    steps = dims.assembly_order
    at = {name: k for k, step in enumerate(steps) for name in step.items}
    assert at["encoder_left"] == at["input_bearing_upper_left"] < at["input_pulley_left"] < at["guide"]
    assert at["guide"] < at["gearhead_left"] == at["top_plate"] < at["plate_screw_1"] < at["drum"]
    assert "from below" in steps[at["gearhead_left"]].text
