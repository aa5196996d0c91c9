"""Rules between fields: for each an edit that breaks it, and the message."""

import re
from dataclasses import MISSING, fields
from typing import Any

import pytest
import yaml

from mbcdm_cad.design.catalogue import KINDS, package_entries
from mbcdm_cad.errors import InputError
from mbcdm_cad.layouts.loader import load_text, reference_data
from mbcdm_cad.solving.question import question_of

from .conftest import Edit

RADII = {"guide_radii_mm": [9.0, 9.6, 10.2, 10.8], "input_radii_mm": [6.0, 6.4, 6.8, 7.2]}
CABLES = reference_data()["cables"]
BEARING = {
    "bore_mm": 8.0,
    "outer_diameter_mm": 16.0,
    "width_mm": 4.0,
    "inner_shoulder_mm": 9.5,
    "outer_shoulder_mm": 14.2,
    "static_rating_N": 570.0,
    "mass_g": 3.0,
    "source": "estimate",
}
MOTOR = {
    "diameter_mm": 15.0,
    "length_mm": 24.0,
    "rated_torque_mNm": 2.9,
    "rotor_inertia_g_cm2": 0.65,
    "mass_g": 18.0,
    "source": "a bench",
}
ROPE = {
    "construction": "7x7",
    "diameter_mm": 0.81,
    "metallic_area_mm2": 0.3117,
    "modulus_GPa": 54.0,
    "modulus_area": "metallic",
    "breaking_load_N": 530.0,
    "mass_g_m": 2.5,
    "bend_ratio_minimum": 28.0,
    "bend_ratio_desired": 42.0,
    "material": "stainless",
    "source": "estimate",
}


def cables(**changes: dict[str, Any]) -> list[dict[str, Any]]:
    """The reference cables, ``cable_2={"step": 3}`` changing one of them."""
    return [{**cable, **changes.get(cable["name"], {})} for cable in CABLES]


@pytest.mark.parametrize(
    ("changes", "field", "what"),
    [
        (
            {("transmission", "guide_radii_mm"): RADII["guide_radii_mm"]},
            "transmission.guide_radii_mm",
            "given beside ratios",
        ),
        ({("transmission", "ratios"): None}, "transmission", "not given"),
        (
            {("transmission", "ratios"): None, ("transmission", "input_radii_mm"): RADII["input_radii_mm"]},
            "transmission",
            "add guide_radii_mm",
        ),
        (
            {("transmission", "drum_radii_mm"): [54.0, 57.6, 57.6, 64.8]},
            "transmission.drum_radii_mm[2]",
            "steps do not grow",
        ),
        (
            {("transmission", "drum_radii_mm"): [64.8, 61.2, 57.6, 54.0]},
            "transmission.drum_radii_mm[1]",
            "steps do not grow",
        ),
        ({("inputs",): [{"name": "left", "side": "-x"}]}, "inputs", "wrong number of inputs"),
        ({("inputs", 1, "side"): "-x"}, "inputs[1].side", "both inputs on one side"),
        ({("inputs", 1, "name"): "left"}, "inputs[1].name", "used twice"),
        ({("cables",): CABLES[:3]}, "cables", "wrong number of cables"),
        ({("cables",): cables(cable_2={"name": "cable_1"})}, "cables[1].name", "used twice"),
        ({("cables",): cables(cable_2={"step": 1})}, "cables[1].step", "used twice"),
        ({("cables",): cables(cable_2={"name": "left"})}, "cables[1].name", "also the name of an input"),
        ({("cables",): cables(cable_2={"input": "lft"})}, "cables[1].input", "did you mean left?"),
        ({("cables",): cables(cable_2={"input": "right"})}, "inputs[0]", "needs two cables (value 1 cables"),
        (
            {("cables",): cables(cable_2={"drum_side": "+x"})},
            "cables[1].drum_side",
            "both cables of left run to one side",
        ),
        (
            {("cables",): cables(cable_2={"step": 3}, cable_3={"step": 2})},
            "cables[1].step",
            "not on neighbouring steps",
        ),
        ({("rope", "type"): None}, "rope", "neither type nor inline"),
        ({("rope", "inline"): ROPE}, "rope", "both type and inline"),
        ({("rope", "modulus_area"): None}, "rope", "modulus_area is missing"),
        ({("rope", "modulus_GPa"): None}, "rope", "modulus_GPa is missing"),
        ({("rope", "type"): None, ("rope", "inline"): ROPE}, "rope.modulus_GPa", "given beside inline"),
        (
            {("waivers",): [{"check": "a", "reason": "x"}, {"check": "a", "reason": "y"}]},
            "waivers[1].check",
            "used twice",
        ),
        ({("rope", "type"): "FF-082"}, "rope.type", "did you mean FF-081?"),
        ({("drive", "motor"): "motor"}, "drive.motor", "not in the catalogue of motors"),
        ({("drive", "gearhead"): "none"}, "drive.gearhead", "motor-2.9mNm-15 has no face and shaft of its own"),
        (
            {("drive", "bus_voltage_V"): 24.0, ("drive", "motor"): "mine", ("catalogue",): {"motors": {"mine": MOTOR}}},
            "drive.bus_voltage_V",
            "no torque constant of mine",
        ),
        ({("drive", "drum_encoder"): "x"}, "drive.drum_encoder", "not in the catalogue of encoders"),
        ({("drum", "tensioner"): "M1.7"}, "drum.tensioner", "not in the catalogue of tensioners"),
        ({("input_pulleys", "upper_bearing"): "x"}, "input_pulleys.upper_bearing", "not in the catalogue of bearings"),
        ({("support", "material"): "x"}, "support.material", "not in the catalogue of materials"),
        (
            {("catalogue",): {"ropes": {"mine": {**ROPE, "material": "x"}}}},
            "catalogue.ropes.mine.material",
            "not in the catalogue of materials",
        ),
        (
            {("catalogue",): {"bearings": {"618/8": {**BEARING, "inner_shoulder_mm": 15.0}}}},
            "catalogue.bearings.618/8.inner_shoulder_mm",
            "larger than outer_shoulder_mm (value 15, limit up to 14.2)",
        ),
        (
            {("catalogue",): {"ropes": {"mine": {**ROPE, "metallic_area_mm2": 0.6}}}},
            "catalogue.ropes.mine.metallic_area_mm2",
            "larger than the rope's own circle (value 0.6 mm2, limit up to 0.5153 mm2)",
        ),
        (
            {("catalogue",): {"ropes": {"mine": {**ROPE, "bend_ratio_minimum": 50.0}}}},
            "catalogue.ropes.mine.bend_ratio_minimum",
            "larger than bend_ratio_desired",
        ),
    ],
)
def test_a_broken_rule_is_told_at_its_field(load_edited: Edit, changes: dict[Any, Any], field: str, what: str) -> None:
    with pytest.raises(InputError) as caught:
        load_edited(changes)
    problems = caught.value.problems
    assert any(problem.field == field and what in str(problem) for problem in problems), str(caught.value)
    assert all(problem.remedy for problem in problems), str(caught.value)


def test_all_broken_rules_are_listed_at_once(load_edited: Edit) -> None:
    with pytest.raises(InputError) as caught:
        load_edited({("inputs", 1, "side"): "-x", ("rope", "type"): "x", ("drum", "bearing"): "x"})
    assert [problem.field for problem in caught.value.problems] == ["inputs[1].side", "rope.type", "drum.bearing"]


@pytest.mark.parametrize(
    "changes",
    [
        {("transmission", "ratios"): None, **{("transmission", key): radii for key, radii in RADII.items()}},
        {
            ("rope", "type"): None,
            ("rope", "inline"): ROPE,
            ("rope", "modulus_GPa"): None,
            ("rope", "modulus_area"): None,
        },
        {
            ("cables",): cables(
                cable_1={"input": "right"},
                cable_2={"input": "right"},
                cable_3={"input": "left"},
                cable_4={"input": "left"},
            )
        },
        {("cables",): list(reversed(CABLES))},
        {("drum", "bearing"): "mine", ("catalogue",): {"bearings": {"mine": BEARING}}},
    ],
)
def test_the_other_ways_of_saying_it_are_accepted(load_edited: Edit, changes: dict[Any, Any]) -> None:
    assert len(load_edited(changes).drive.cables) == 4


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
