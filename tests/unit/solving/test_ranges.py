"""Ranges in a design file: valid forms, refusals with line and remedy, and the commands that accept them.

The independent search of the reach study, with a few starts instead of some hundred.

The bound that proves that requirements exclude each other: it never excludes an existing design.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import pytest
import yaml
from hypothesis import given, settings
from hypothesis import strategies as st

from mbcdm_cad.design.sized import scaled
from mbcdm_cad.design.yamltree import leaves, put, take_out
from mbcdm_cad.errors import InputError, MbcdmError
from mbcdm_cad.layouts.loader import load_text
from mbcdm_cad.solving.question import difference, patched, question_of
from tests.acceptance.test_docs_commands import GALLERY
from tests.support.random_generator import WHOLE, failing, requirements
from tests.support.random_search import Draw, missed, search
from tests.support.reach_bound import Asked, asked, excluding

SHORT = """\
name: short
configuration: miso_bevel
travel: {half_angle_deg: 35.0}
transmission: {ratio: 9.0, drum_radius_mm: 60.0}
loads: {peak_torque_Nm: 1.5}
"""


def test_ranges_are_read_and_a_field_without_a_rule_needs_a_value() -> None:
    asked = question_of(SHORT.replace("60.0", "{min: 50, max: 70}, centre_distance_mm: min"))
    assert {name: (r.low, r.high, r.aim) for name, r in asked.ranges.items()} == {
        "transmission.drum_radius_mm": (50.0, 70.0, ""),
        "transmission.centre_distance_mm": (2.0, 500.0, "min"),
    }
    assert asked.unruled == {"transmission.drum_radius_mm"}
    assert asked.middle("transmission.drum_radius_mm") == 60.0


@pytest.mark.parametrize(
    ("written", "line", "words"),
    [
        ("{min: 70, max: 50}", 4, "a range upside down (value min 70, max 50"),
        ("{min: wide, max: 50}", 4, "not a number (value 'wide'"),
        ("{min: 1, max: 50}", 4, "out of bounds (value 1, limit 5 to 500 mm"),
        ("{min: 30, max: 50, aim: 3}", 4, "unknown field of a range"),
        ("60.0, drum_radius_mm: 50.0", 4, "given twice"),
    ],
)
def test_a_wrong_range_is_named_with_line_and_remedy(written: str, line: int, words: str) -> None:
    with pytest.raises(InputError) as refused:
        question_of(SHORT.replace("60.0", written), "short.yaml")
    (problem,) = refused.value.problems
    assert problem.line == line and words in str(problem) and problem.remedy, str(problem)


def test_a_choice_that_no_catalogue_holds_is_bad_input() -> None:
    with pytest.raises(InputError, match="not in the catalogue of ropes"):
        question_of(SHORT + "rope: {type: 7x7-9.9}\n")


def test_pins_that_contradict_are_bad_input() -> None:
    pins = "drum_radii_mm: [54, 58, 62, 66], guide_radii_mm: [9, 9.6, 10, 11], input_radii_mm: [6, 6.4, 6.8, 7.2]"
    both = SHORT.replace("60.0", f"60.0, ratios: {{input_to_guide: 1.5, guide_to_drum: 6.0}}, {pins}")
    with pytest.raises(InputError, match="ratios or explicit radii"):
        question_of(both)


@pytest.mark.parametrize(
    ("written", "words"),
    [
        (
            "60.0, ratios: {input_to_guide: 1.5, guide_to_drum: 5.0}",
            "ratio: contradicts ratios (value 9, limit 7.5, 1.5 x 5 of ratios); leave ratio out",
        ),
        (
            "60.0, drum_radii_mm: [54, 58, 62, 66]",
            "drum_radius_mm: contradicts drum_radii_mm (value 60 mm, limit 54 mm, the radius of step 1); leave one",
        ),
        (
            "60.0, centre_distance_mm: 12.0",
            "centre_distance_mm: too short for guide and input pulley beside each other",
        ),
        (
            "60.0}\ninput_pulleys: {surface: polished",
            "surface: not a known word (value 'polished', limit one of smooth",
        ),
        ("60.0}\ndrive: {motor: motor-1kNm", "motor: not in the catalogue of motors (value 'motor-1kNm')"),
        ("60.0}\ntravel: {half_angle_deg: 40.0", "travel: given twice (value first on line 3); keep one of the two"),
    ],
    ids=["ratio", "radius", "distance", "word", "motor", "twice"],
)
def test_contradictions_and_choices_that_do_not_exist_are_one_sentence(written: str, words: str) -> None:
    with pytest.raises(InputError) as refused:
        load_text(SHORT.replace("60.0", written), "short.yaml")
    (problem,) = refused.value.problems
    assert words in str(problem) and problem.line in (4, 5) and problem.remedy, str(problem)


def test_only_solve_reads_ranges_all_else_says_so() -> None:
    with pytest.raises(InputError) as refused:
        load_text(SHORT.replace("60.0", "{min: 50, max: 70}"), "short.yaml")
    assert "short.yaml:4: transmission.drum_radius_mm: a range" in str(refused.value)
    assert "mbcdm solve short.yaml --apply FILE" in str(refused.value)


def test_a_range_that_is_wrong_is_not_sent_to_solve() -> None:
    with pytest.raises(InputError) as caught:
        load_text(SHORT.replace("60.0", "{min: 70, max: 50}"))
    assert "a range upside down" in str(caught.value) and "mbcdm solve" not in str(caught.value), caught.value


def test_a_requirement_left_out_is_marked_as_missing() -> None:
    with pytest.raises(InputError) as refused:
        load_text("name: x\nconfiguration: miso_bevel\ntravel: {half_angle_deg: 30.0}\n")
    assert {problem.field for problem in refused.value.problems if problem.missing} >= {"loads.peak_torque_Nm"}
    with pytest.raises(InputError) as wrong:
        load_text("name: x\nconfiguration: miso_bevel\ntravel: {half_angle_deg: -30.0}\n")
    assert not any(problem.missing for problem in wrong.value.problems)


def test_moved_steps_keep_their_first_radius() -> None:
    assert scaled([60.0, 63.0], 1.5) == [60.0, 64.5]
    assert scaled(12.0, 1.5) == 18.0


def test_a_file_that_passes_needs_no_move() -> None:
    assert search(requirements(1), starts=1) == {}


def test_a_requirement_that_is_left_out_is_drawn_and_the_same_search_ends_alike() -> None:
    data = requirements(1)
    del data["loads"]["peak_torque_Nm"]
    found = search(data, starts=12)
    assert found is not None and found["loads.peak_torque_Nm"] > 0.0
    assert search(data, starts=12) == found


def test_a_miss_counts_failing_checks_and_stops_at_what_is_bad_enough() -> None:
    thin = requirements(1) | {"transmission": {"ratio": 20.0, "drum_radius_mm": 34.0}}
    whole = missed(thin, Draw())
    assert whole > 3.0
    assert missed(thin, Draw(), most=0.5) < whole


# 68 mm across at a ratio of 20: the input pulleys are 3.4 mm across, no journal goes round a 3 mm shaft in them.
THIN = Asked(ratio=20.0, radius=34.0, travel=35.0, torque=0.5, rope=None, distance=None)


@pytest.mark.parametrize("path", GALLERY, ids=lambda path: path.stem)
def test_no_drive_of_the_gallery_is_excluded(path) -> None:  # type: ignore[no-untyped-def]
    assert excluding(asked(yaml.safe_load(path.read_text("utf-8")))) == ()


def test_a_set_is_the_smallest() -> None:
    assert excluding(THIN) == ("ratio", "radius")
    for name in ("ratio", "radius"):
        assert excluding(replace(THIN, **{name: None})) == ()


@pytest.mark.parametrize(
    ("found", "names"),
    [
        (replace(THIN, ratio=5.0, torque=60.0), ("ratio", "radius", "torque")),
        (replace(THIN, ratio=5.0, torque=6.0, rope="7x7-0.3"), ("radius", "torque", "rope")),
        (replace(THIN, ratio=5.0, rope="7x7-3.0"), ("ratio", "radius", "rope")),
        (replace(THIN, ratio=5.0, distance=8.0), ("radius", "distance")),
    ],
    ids=["torque", "thin rope", "thick rope", "distance"],
)
def test_each_condition_names_its_requirements(found: Asked, names: tuple[str, ...]) -> None:
    assert excluding(found) == names


def test_what_is_excluded_fails_when_it_is_sized() -> None:
    data = requirements(2, WHOLE)
    assert excluding(asked(data)) == ("ratio", "radius")
    assert "bearing_shoulders" in dict(failing(load_text(yaml.safe_dump(data))))


# Changes of fields in the text of a file: the content is as wanted, comments of other fields stay.


TEXT = """\
# head
name: a  # the name
travel: {half_angle_deg: 35.0}   # one line
transmission:
  ratio: 9.0               # drum over input,
                           # in all
  radii: [1.0, 2.0]        # two
  # a comment of its own
  inner:
    deep: 1.0  # deep
loads: {peak: 3.0, test: 1.0}
"""


def changed(text: str, change: dict[str, Any]) -> str:
    data = yaml.safe_load(text)
    for field, value in change.items():
        if value is None:
            take_out(data, field)
        else:
            put(data, field, value)
    after = patched(text, "a.yaml", data)
    assert dict(leaves(yaml.safe_load(after))) == dict(leaves(data)), after
    return after


def test_a_value_is_replaced_and_its_comment_stays() -> None:
    assert "  ratio: 8.5               # drum over input,\n" in changed(TEXT, {"transmission.ratio": 8.5})


def test_a_field_goes_with_its_comment_and_no_other() -> None:
    after = changed(TEXT, {"transmission.ratio": None})
    assert "drum over input" not in after and "in all" not in after
    assert "# a comment of its own" in after and "# two" in after


def test_a_block_that_loses_its_last_field_goes() -> None:
    after = changed(TEXT, {"transmission.inner.deep": None, "travel.half_angle_deg": None})
    assert "inner" not in after and "travel" not in after


def test_new_fields_join_the_innermost_block_that_there_is() -> None:
    after = changed(TEXT, {"loads.most": 4.0, "transmission.inner.more": "a b", "drum.face_mm": 1.5})
    assert "loads: {peak: 3.0, test: 1.0, most: 4.0}" in after
    assert "    deep: 1.0  # deep\n    more: " in after
    assert after.endswith("drum:\n  face_mm: 1.5\n")


def test_a_range_becomes_a_number() -> None:
    text = "transmission:\n  l: {min: 30, max: 60}  # how long\n  m: min\n"
    after = patched(text, "a.yaml", {"transmission": {"l": 41.0, "m": 2.0}})
    assert after == "transmission:\n  l: 41.0  # how long\n  m: 2.0\n"
    assert difference(text, after, "a.yaml").splitlines()[4:] == [
        "-  l: {min: 30, max: 60}  # how long",
        "-  m: min",
        "+  l: 41.0  # how long",
        "+  m: 2.0",
    ]


def test_a_range_written_as_a_block_becomes_a_number() -> None:
    text = "a:\n  l:\n    min: 30\n    max: 60\n  k: 1\n"
    assert patched(text, "a.yaml", {"a": {"l": 41.0, "k": 1}}) == "a:\n  l: 41.0\n  k: 1\n"


def test_aliases_are_refused_rather_than_changed_in_two_places() -> None:
    text = "a: {x: &v 1.0}\nb: {x: *v}\n"
    with pytest.raises(MbcdmError, match="aliases"):
        patched(text, "a.yaml", {"a": {"x": 1.0}, "b": {"x": 2.0}})


FIELDS = ("name", "travel.half_angle_deg", "transmission.ratio", "transmission.inner.deep", "loads.test", "new.one")


@settings(max_examples=60, deadline=None)
@given(st.dictionaries(st.sampled_from(FIELDS), st.one_of(st.none(), st.floats(0.1, 9.0).map(lambda x: round(x, 3)))))
def test_any_change_gives_the_content_asked_and_keeps_other_lines(change: dict[str, Any]) -> None:
    if "name" in change and change["name"] is None:
        change["name"] = 1.0  # a file is never empty
    after = changed(TEXT, change)
    assert "# a comment of its own" in after and "# head" in after
