"""Changes of fields in the text of a file: the content is as wanted, comments of other fields stay."""

from __future__ import annotations

from typing import Any

import pytest
import yaml
from hypothesis import given, settings
from hypothesis import strategies as st

from mbcdm_cad.design.yamltree import leaves, put, take_out
from mbcdm_cad.errors import MbcdmError
from mbcdm_cad.solving.question import difference, patched

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
