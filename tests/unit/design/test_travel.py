"""A travel from one angle of the output to another: the drive of half of it, counted from its middle."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import pytest

from mbcdm_cad.checks.run import Budget, offers, run_check
from mbcdm_cad.errors import InputError
from mbcdm_cad.layouts.check_design import checks_of
from mbcdm_cad.layouts.loader import layout_of, load_text

from .conftest import Edit

SHORT = """\
name: arm
configuration: {layout}
travel: {{{travel}}}
transmission: {{{ratio}: 8.0, drum_radius_mm: 60.0}}
loads: {{peak_torque_Nm: 1.0}}
"""


def short(travel: str, layout: str = "siso_spur") -> str:
    return SHORT.format(travel=travel, layout=layout, ratio="ratio" if layout == "miso_bevel" else "input_to_drum")


@pytest.mark.parametrize("layout", ["siso_spur", "miso_bevel"])
def test_it_gives_the_drive_of_half_of_it(layout: str) -> None:
    one = load_text(short("from_deg: -30, to_deg: 10", layout)).drive
    other = load_text(short("half_angle_deg: 20", layout)).drive
    assert replace(one, travel_from_deg=None) == other
    assert (one.middle_deg, one.travel_words) == (-10.0, "-30 to +10")
    assert (other.middle_deg, other.travel_words) == (0.0, "+-20")


@pytest.mark.parametrize("layout", ["siso_spur", "miso_spur", "siso_bevel", "miso_bevel"])
@pytest.mark.parametrize(
    ("travel", "field", "what"),
    [
        ("from_deg: 10", "travel.to_deg", "missing beside from_deg"),
        ("to_deg: 10", "travel.from_deg", "missing beside to_deg"),
        ("from_deg: 10, to_deg: -30", "travel.to_deg", "not above from_deg"),
        ("", "travel.half_angle_deg", "missing; it is a requirement"),
    ],
)
def test_half_a_statement_is_refused(layout: str, travel: str, field: str, what: str) -> None:
    with pytest.raises(InputError) as raised:
        load_text(short(travel, layout))
    found = {problem.field: problem.what for problem in raised.value.problems}
    assert what in found.get(field, ""), found


def test_two_statements_must_agree(load_edited: Edit) -> None:
    ends: dict[tuple[str | int, ...], Any] = {("travel", "from_deg"): -30.0, ("travel", "to_deg"): 40.0}
    assert load_edited(ends).drive.middle_deg == 5.0
    with pytest.raises(InputError, match=r"travel.half_angle_deg: not half of the way .*value 35 deg, limit 34 deg"):
        load_edited({**ends, ("travel", "to_deg"): 38.0})


def test_a_remedy_names_the_end_that_the_file_states(load_edited: Edit) -> None:
    """Too much travel for the sector: the remedy lowers the upper end by twice what it lowers half the travel."""
    wide = {("travel", "half_angle_deg"): 70.0}
    said = []
    for more, field in (
        ({}, "half_angle_deg"),
        ({("travel", "from_deg"): -100.0, ("travel", "to_deg"): 40.0}, "to_deg"),
    ):
        loaded = load_edited({**wide, **more})
        check = next(c for c in checks_of(loaded.drive) if c.id == "wrap_left")
        assert run_check(check, layout_of(loaded.drive), Budget(0)).status == "fail"
        asked = {f"travel.{field}"}
        _, required = offers(check, layout_of(loaded.drive), Budget(asked=lambda asked=asked: asked))
        said.append(next(text for text in required if text.startswith(f"lower travel.{field} ")))
    half, end = (float(text.rpartition(" ")[2]) for text in said)
    assert abs((40.0 - end) / 2 - (70.0 - half)) < 0.05, said
