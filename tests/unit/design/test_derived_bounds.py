"""Messages about what the user did not write: values of rules, fields that an own catalogue entry lacks, a comma."""

from __future__ import annotations

import re
from dataclasses import MISSING, fields
from typing import Any

import pytest
import yaml

from mbcdm_cad.design.catalogue import KINDS, package_entries
from mbcdm_cad.errors import InputError
from mbcdm_cad.layouts.loader import load_text
from mbcdm_cad.solving.question import question_of

SHORT: dict[str, Any] = {
    "name": "short",
    "configuration": "siso_spur",
    "travel": {"half_angle_deg": 40.0},
    "transmission": {"input_to_drum": 8.0, "drum_radius_mm": 60.0},
    "loads": {"peak_torque_Nm": 2.0},
}


def refusal(text: str) -> list[str]:
    with pytest.raises(InputError) as caught:
        load_text(text, "f.yaml")
    return str(caught.value).split("\n")


@pytest.mark.parametrize(
    ("field", "value", "derived"),
    [
        ("loads.peak_torque_Nm", 0.002, "rope.preload_N"),
        ("transmission.drum_radius_mm", 6.0, "drum.rim_inner_radius_mm"),
        ("transmission.drum_radius_mm", 470.0, "transmission.centre_distance_mm"),
    ],
)
def test_a_derived_value_out_of_bounds_names_a_requirement_with_a_value_that_works(
    field: str, value: float, derived: str
) -> None:
    block, name = field.split(".")
    data = {**SHORT, block: {**SHORT[block], name: value}}
    text = yaml.safe_dump(data, sort_keys=False)
    (said,) = refusal(text)
    found = re.match(
        rf"f.yaml:(\d+): ([a-z_.A-Z]+): leads to {re.escape(derived)} of .*(raise|lower) \2 to ([0-9.e+-]+),", said
    )
    assert found, said
    asked, better = found[2].split("."), float(found[4])
    assert asked[1] in text.split("\n")[int(found[1]) - 1], f"line {found[1]} of\n{text}"
    assert (better > data[asked[0]][asked[1]]) == (found[3] == "raise"), said
    data[asked[0]] = {**data[asked[0]], asked[1]: better}
    assert load_text(yaml.safe_dump(data, sort_keys=False)).drive.name == "short"


def test_solve_says_the_same_of_a_derived_value_out_of_bounds() -> None:
    text = yaml.safe_dump({**SHORT, "loads": {"peak_torque_Nm": 0.002}}, sort_keys=False)
    with pytest.raises(InputError) as caught:
        question_of(text, "f.yaml")
    assert str(caught.value).split("\n") == refusal(text)


def _required(kind: str) -> list[str]:
    return [item.name for item in fields(KINDS[kind]) if item.default is MISSING]


@pytest.mark.parametrize(("kind", "field"), [(kind, field) for kind in KINDS for field in _required(kind)])
def test_an_own_entry_that_lacks_a_field_is_told_with_line_and_field(kind: str, field: str) -> None:
    """For every kind and field, whether the entry is used or not; rules that read it must not come first."""
    entry = dict(next(iter(package_entries(kind).values())))
    entry.pop(field)
    text = yaml.safe_dump({**SHORT, "catalogue": {kind: {"mine": entry}}}, sort_keys=False)
    line = next(k for k, row in enumerate(text.split("\n"), 1) if "mine:" in row)
    (said,) = refusal(text)
    assert said.startswith(f"f.yaml:{line}: catalogue.{kind}.mine.{field}: missing"), said


@pytest.mark.parametrize(
    ("kind", "block", "named", "like"),
    [("ropes", "rope", "type", "7x7-1.0"), ("gearheads", "drive", "gearhead", "gearhead-76-16")],
)
def test_an_entry_with_its_required_fields_alone_is_enough(kind: str, block: str, named: str, like: str) -> None:
    entry = {name: value for name, value in package_entries(kind)[like].items() if name in _required(kind)}
    text = yaml.safe_dump({**SHORT, block: {named: "mine"}, "catalogue": {kind: {"mine": entry}}}, sort_keys=False)
    assert load_text(text).drive.name == "short"


def test_a_decimal_comma_is_told_with_the_number_that_was_meant() -> None:
    text = yaml.safe_dump(SHORT, sort_keys=False).replace("half_angle_deg: 40.0", "{half_angle_deg: 40,5}")
    (said,) = refusal(text)
    assert said.startswith("f.yaml:4: travel: a decimal comma") and said.endswith("write half_angle_deg: 40.5"), said


def test_a_file_without_a_configuration_is_told_of_all_layouts_and_gets_no_guess_from_one() -> None:
    said = refusal(yaml.safe_dump({name: value for name, value in SHORT.items() if name != "configuration"}))
    assert len(said) == 1 and "miso_bevel, miso_spur, siso_bevel, siso_spur" in said[0], said
