"""Questions about drives with a motor head: ranges of their files are kept, and all free fields exist."""

from __future__ import annotations

from typing import Any, get_args, get_type_hints

import pytest

from mbcdm_cad.design.fields import is_block
from mbcdm_cad.design.yamltree import value_at
from mbcdm_cad.layouts.loader import design_file
from mbcdm_cad.layouts.registry import names
from mbcdm_cad.solving.question import Fixed, Point, Times, question_of
from mbcdm_cad.solving.solve import solve
from mbcdm_cad.solving.trials import Trials

# Of each layout a field is given as a range.
QUESTIONS = {
    "siso_spur": "{input_to_drum: 6.0, drum_radius_mm: {min: 55, max: 70}}",
    "miso_spur": "{input_to_drum: {min: 4, max: 6}, drum_radius_mm: 70.0}",
    "siso_bevel": "{input_to_drum: {min: 2, max: 5}, drum_radius_mm: {min: 50, max: 75}}",
}


@pytest.mark.parametrize("layout", QUESTIONS)
def test_ranges_are_met(layout: str) -> None:
    asked = question_of(
        f"name: asked\nconfiguration: {layout}\ntravel: {{half_angle_deg: 30.0}}\n"
        f"transmission: {QUESTIONS[layout]}\nloads: {{peak_torque_Nm: 1.0}}\n"
    )
    found = solve(asked, jobs=1)
    assert found.data is not None, found.conflict
    for field, limits in asked.ranges.items():
        assert limits.low <= value_at(found.data, field) <= limits.high, field
    assert found.trials < 20, "the rules alone come to a passing design from there"


def test_what_may_move_are_fields_of_the_schema() -> None:
    for layout in names():
        file = design_file(layout)
        for freedom in file.freedoms():
            assert file.node_at(tuple(freedom.field.split("."))) is not None, f"{layout}: {freedom.field}"
            block: Any = file.schema
            for part in freedom.field.split("."):
                kind = get_type_hints(block).get(part)
                assert kind is not None, f"{layout}: {freedom.field}"
                block = next((one for one in get_args(kind) if is_block(one)), kind)
        assert file.freedoms() or file.sizing is None, layout


@pytest.mark.parametrize("layout", QUESTIONS)
def test_a_trial_that_begins_at_a_similar_design_is_that_of_its_own_file(layout: str) -> None:
    asked = question_of(
        f"name: asked\nconfiguration: {layout}\ntravel: {{half_angle_deg: 30.0}}\n"
        "transmission: {input_to_drum: 4.0, drum_radius_mm: 60.0}\nloads: {peak_torque_Nm: 1.0}\n"
    )
    near, alone = Trials(asked, jobs=1), Trials(asked, jobs=1)
    near.begin_at({})
    points: list[Point] = [
        {"drum.outer_face_y_mm": Times(0.8)},
        {"transmission.drum_radius_mm": Fixed(63.0), "drum.hub_diameter_mm": Times(1.1)},
    ]
    assert near.many(points) == alone.many(points)
    assert [near.confirmed(point) for point in points] == [alone(point).passes for point in points]


def test_sizes_that_are_bought_stay_bought_and_blocks_that_a_drive_lacks_are_not_free() -> None:
    rest = (
        "travel: {half_angle_deg: 30.0}\ntransmission: {input_to_drum: 6.0, drum_radius_mm: 60.0}\n"
        "loads: {peak_torque_Nm: 1.0}\n"
    )
    plain, led = (
        question_of(f"name: asked\nconfiguration: siso_spur\n{rest}{more}").freedoms
        for more in ("", "idlers: {pairs: 1}\n")
    )
    pin = plain["drum.stop_pin_mm"]
    assert [pin.stretch(3.0, factor) for factor in (0.5, 0.9, 1.2, 1.45, 2.0)] == [3.0, 3.0, 4.0, 4.0, 6.0]
    assert led["idlers.bearing"].is_choice and "idlers.width_mm" in led, "a bearing's name cannot be multiplied"
    assert not [field for field in plain if field.split(".")[0] in ("idlers", "stage", "first_stage")]
