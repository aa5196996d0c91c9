"""The resolved drive: radii, sense, order, and that every field of the file has an effect."""

import dataclasses
import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
import yaml

from mbcdm_cad.checks.run import Budget, offers, run_check
from mbcdm_cad.design.catalogue import package_entries
from mbcdm_cad.design.describe import editor_schema
from mbcdm_cad.errors import InputError
from mbcdm_cad.layouts.check_design import checks_of
from mbcdm_cad.layouts.loader import design_file, layout_of, load_design, load_text, new_design_text, reference_data
from mbcdm_cad.model.analysis import analyse
from tests.support.single_values import KIND_OF, leaves

from .conftest import Edit

TABLE_2 = [  # cable, input, r_m, r_g, r_o, sigma: the mechanism's table
    ("cable_1", "left", 6.0, 9.0, 54.0, -1),
    ("cable_2", "left", 6.4, 9.6, 57.6, +1),
    ("cable_3", "right", 6.8, 10.2, 61.2, +1),
    ("cable_4", "right", 7.2, 10.8, 64.8, -1),
]


def test_reference_radii_are_those_of_table_2(load_edited: Edit) -> None:
    drive = load_edited({}).drive
    rows = [
        (c.name, c.input_name, c.input_radius_mm, c.guide_radius_mm, c.drum_radius_mm, c.sense) for c in drive.cables
    ]
    assert rows == TABLE_2
    assert [c.input_side for c in drive.cables] == [-1, -1, 1, 1]
    assert not drive.radii_explicit


def test_explicit_radii_are_taken_as_they_are(load_edited: Edit) -> None:
    drive = load_edited(
        {
            ("transmission", "ratios"): None,
            ("transmission", "guide_radii_mm"): [9.0, 9.6, 10.2, 10.9],
            ("transmission", "input_radii_mm"): [6.0, 6.4, 6.8, 7.3],
        }
    ).drive
    assert drive.radii_explicit
    assert [(c.input_radius_mm, c.guide_radius_mm) for c in drive.cables] == [
        (6, 9),
        (6.4, 9.6),
        (6.8, 10.2),
        (7.3, 10.9),
    ]


def test_cables_come_in_the_order_of_their_steps(load_edited: Edit) -> None:
    drive = load_edited({("cables",): list(reversed(reference_data()["cables"]))}).drive
    assert [c.step for c in drive.cables] == [1, 2, 3, 4]


def test_a_cable_may_have_its_own_preload(load_edited: Edit) -> None:
    drive = load_edited({("cables", 1, "preload_N"): 65.625}).drive
    assert [c.preload_N for c in drive.cables] == [70.0, 65.625, 70.0, 70.0]


def test_modulus_override_keeps_its_area_with_it(load_edited: Edit) -> None:
    own = load_edited({}).drive.cable
    assert (own.modulus_GPa, own.modulus_area) == (54.0, "metallic")
    assert own.axial_stiffness_N == pytest.approx(54.0e3 * 0.3117, rel=1e-12)
    catalogue = load_edited({("rope", "modulus_GPa"): None, ("rope", "modulus_area"): None}).drive.cable
    assert (catalogue.modulus_GPa, catalogue.modulus_area) == (57.0, "nominal")
    assert catalogue.axial_stiffness_N == pytest.approx(29.4e3, rel=3e-3), f"{catalogue.axial_stiffness_N:.0f} N"


def test_screws_materials_and_waivers_are_found_by_name(load_edited: Edit) -> None:
    drive = load_edited({("waivers",): [{"check": "bend_ratio", "reason": "as in the paper"}]}).drive
    assert drive.screw("M2x6").mass_g == 0.28
    assert drive.material(drive.tensioner.material).density_g_cm3 == 7.9
    waiver = drive.waiver("bend_ratio")
    assert waiver is not None and waiver.reason == "as in the paper"
    assert drive.waiver("mass") is None
    with pytest.raises(KeyError, match="no screw 'M9' in the catalogue"):
        drive.screw("M9")


NOT_IN_THE_DRIVE = {("schema_version",), ("configuration",), ("waivers",), ("as_built",), ("catalogue",)}
COUPLED = {  # fields that cannot change alone without breaking a rule
    "inputs": {("inputs", 0, "side"): "+x", ("inputs", 1, "side"): "-x"},
    "name of an input": {("inputs", 0, "name"): "port", ("cables", 0, "input"): "port", ("cables", 1, "input"): "port"},
    "inputs of the cables": {("cables", k, "input"): side for k, side in enumerate(("right", "right", "left", "left"))},
    "steps": {("cables", 0, "step"): 2, ("cables", 1, "step"): 1},
    "drum sides": {("cables", 0, "drum_side"): "-x", ("cables", 1, "drum_side"): "+x"},
}
SINGLE = [
    path
    for path in leaves(reference_data())
    if path not in NOT_IN_THE_DRIVE and path[0] != "inputs" and not (path[0] == "cables" and path[2] != "name")
]


def changed(path: tuple[str | int, ...]) -> Any:
    """Another legal value for a field of the reference design."""
    value: Any = reference_data()
    for part in path:
        value = value[part]
    if path[-1] == "modulus_area":
        return "nominal"
    if path[-1] == "losses":
        return "counted"
    if path[-1] == "mount_screw":
        return "M4"
    if path[-1] == "threads":
        return "tap_drill" if path[0] == "export" else "inserts"
    if isinstance(value, str):
        kind = KIND_OF.get(str(path[-1]))
        return next(name for name in package_entries(kind) if name != value) if kind else value + "-2"
    if isinstance(value, list):
        return [item + 0.1 for item in value]
    node = design_file().nodes.at(path) or {}
    return value * 1.01 if value * 1.01 <= node["maximum"] else value * 0.99


@pytest.mark.parametrize("path", SINGLE, ids=lambda path: ".".join(map(str, path)))
def test_each_field_changes_the_drive_and_the_hash(load_edited: Edit, path: tuple[str | int, ...]) -> None:
    before, after = load_edited({}), load_edited({path: changed(path)})
    assert after.drive != before.drive, f"{path} = {changed(path)!r} leaves the drive as it was"
    assert after.sha256 != before.sha256


@pytest.mark.parametrize("changes", COUPLED.values(), ids=COUPLED.keys())
def test_each_coupled_change_changes_the_drive(load_edited: Edit, changes: dict[Any, Any]) -> None:
    assert load_edited(changes).drive != load_edited({}).drive


def test_hash_is_over_content_not_layout(load_edited: Edit, tmp_path: Path) -> None:
    params = Path(__file__).parents[3] / "params" / "mbcdm.yaml"
    text = params.read_text("utf-8")
    other = tmp_path / "other.yaml"
    other.write_text("# a comment\n\n" + text.replace("34.6 ", "34.60 ").replace("35.0 ", "35 "))
    assert load_design(other).sha256 == load_design(params).sha256


def test_hash_sees_a_change_of_a_catalogue_entry_in_use(load_edited: Edit) -> None:
    entry = {**package_entries("motors")["motor-2.9mNm-15"], "mass_g": 18.5}
    assert load_edited({("catalogue",): {"motors": {"motor-2.9mNm-15": entry}}}).sha256 != load_edited({}).sha256


def test_the_drive_is_frozen_and_hashable(load_edited: Edit) -> None:
    drive = load_edited({}).drive
    assert isinstance(hash(drive), int)
    with pytest.raises(dataclasses.FrozenInstanceError):
        drive.name = "x"  # type: ignore[misc]


def found(name: str, form: str, share: float, **more: Any) -> dict[str, Any]:
    value = {"name": "share", "value": share, "low": share - 0.0196, "high": share + 0.0196}
    return {"name": name, "form": form, "values": [value], **more}


MODULUS = found("stiffness_error", "modulus of the rope", 0.1)
ONE_CABLE = found("preload_error", "one cable", -0.2, cables=["cable_3"])
FRICTION = found("cable_friction", "rope on pulley", 0.5)
GUIDE = {
    "name": "once_per_rev",
    "form": "eccentric pulley",
    "stage": "guide",
    "values": [{"name": "cosine_m", "value": 1e-05}, {"name": "sine_m", "value": 0.0}],
}


def test_values_change_by_their_shares_and_get_sigmas(load_edited: Any) -> None:
    bare = load_edited({}).drive
    drive = load_edited({("as_built",): [MODULUS, ONE_CABLE, FRICTION, MODULUS]}).drive
    assert drive.cable.modulus_GPa == pytest.approx(1.1**2 * bare.cable.modulus_GPa)
    assert drive.sigmas.modulus_GPa == pytest.approx(0.01 * 1.1 * 2**0.5 * bare.cable.modulus_GPa)
    assert [c.preload_N for c in drive.cables] == pytest.approx([70.0, 70.0, 56.0, 70.0])
    assert drive.sigmas.preload_N == pytest.approx((0.0, 0.0, 0.7, 0.0))
    assert drive.friction_coefficient == pytest.approx(0.225)
    assert drive.as_built == ()


def test_analysis_is_that_of_the_drive_as_built(load_edited: Any) -> None:
    bare = analyse(layout_of(load_edited({}).drive))
    stiff = analyse(layout_of(load_edited({("as_built",): [MODULUS]}).drive))
    ratio = stiff.reversal_swing_mrad / bare.reversal_swing_mrad
    assert ratio == pytest.approx(1.0 / 1.1, rel=1e-9)


def test_what_has_no_value_in_the_design_is_kept(load_edited: Any) -> None:
    (entry,) = load_edited({("as_built",): [GUIDE]}).drive.as_built
    assert (entry.name, entry.stage, entry.cables) == ("once_per_rev", "guide", ())
    assert [value.value for value in entry.values] == [1e-05, 0.0]


@pytest.mark.parametrize(
    ("entry", "field", "remedy"),
    [
        (ONE_CABLE | {"cables": ["cable_7"]}, "as_built[0].cables[0]", "cable_1"),
        (found("stiffness_error", "modulus of the rope", -1.5), "as_built[0].values[0].value", "0.1 for 10 % more"),
        (MODULUS | {"values": [{"name": "part", "value": 0.1}]}, "as_built[0].values", "add {name: share"),
        (MODULUS | {"values": []}, "as_built[0].values", "1"),
    ],
)
def test_refusals_say_where_and_what_to_do(load_edited: Any, entry: dict[str, Any], field: str, remedy: str) -> None:
    with pytest.raises(InputError) as caught:
        load_edited({("as_built",): [entry]})
    text = str(caught.value)
    assert field in text, text
    assert remedy in text, text


def with_values(**changes: Any) -> str:
    """The reference design with ``block__field=value`` replaced."""
    data = reference_data()
    for name, value in changes.items():
        block, field = name.split("__")
        data[block][field] = value
    return yaml.safe_dump(data, sort_keys=False)


def test_a_file_without_sigmas_has_none() -> None:
    sigmas = load_text(new_design_text("plain")).drive.sigmas
    values = vars(sigmas) | sigmas.lengths_mm
    del values["lengths_mm"]
    numbers = [x for value in values.values() for x in (value if isinstance(value, tuple) else (value,))]
    assert numbers == [0.0] * len(numbers) and len(numbers) > 20, sigmas


def test_values_stay_what_they_were() -> None:
    plain = load_text(with_values()).drive
    measured = load_text(with_values(rope__preload_N={"value": 70.0, "sigma": 3.0})).drive
    assert measured.cables == plain.cables
    assert measured.sigmas.preload_N == (3.0,) * 4
    assert load_text(with_values()).sha256 != load_text(with_values(rope__preload_N={"value": 70, "sigma": 3})).sha256


def test_a_cables_own_preload_has_its_own_sigma() -> None:
    data = reference_data()
    data["rope"]["preload_N"] = {"value": 70.0, "sigma": 3.0}
    data["cables"][1]["preload_N"] = {"value": 65.0, "sigma": 1.0}
    data["cables"][2]["preload_N"] = 66.0
    drive = load_text(yaml.safe_dump(data)).drive
    assert drive.sigmas.preload_N == (3.0, 1.0, 0.0, 3.0)
    assert [run.preload_N for run in drive.cables] == [70.0, 65.0, 66.0, 70.0]


def test_items_of_a_list_each_for_itself() -> None:
    radii = [54.0, {"value": 57.6, "sigma": 0.02}, 61.2, 64.8]
    drive = load_text(with_values(transmission__drum_radii_mm=radii)).drive
    assert drive.sigmas.lengths_mm["drum_radius_mm"] == (0.0, 0.02, 0.0, 0.0)
    assert drive.sigmas.lengths_mm["guide_radius_mm"] == (0.0,) * 4, "the ratio carries none"


def test_sigma_of_a_nominal_area_comes_from_the_diameter() -> None:
    rope = {
        "construction": "7x7",
        "diameter_mm": {"value": 0.8, "sigma": 0.008},
        "metallic_area_mm2": {"value": 0.3, "sigma": 0.01},
        "modulus_GPa": {"value": 50.0, "sigma": 2.0},
        "modulus_area": "nominal",
        "breaking_load_N": 530.0,
        "mass_g_m": 2.5,
        "bend_ratio_minimum": 28.0,
        "bend_ratio_desired": 42.0,
        "material": "stainless",
        "source": "a test",
    }
    data = reference_data()
    data["rope"] = {k: v for k, v in data["rope"].items() if k not in ("type", "modulus_GPa", "modulus_area")}
    data["rope"]["inline"] = rope
    drive = load_text(yaml.safe_dump(data)).drive
    assert drive.sigmas.area_mm2 == pytest.approx(2 * 0.01 * drive.cable.area_mm2), "twice the diameter's, relatively"
    assert drive.sigmas.modulus_GPa == 2.0
    rope["modulus_area"] = "metallic"
    assert load_text(yaml.safe_dump(data)).drive.sigmas.area_mm2 == 0.01


@pytest.mark.parametrize(
    ("value", "said"),
    [
        ({"value": 70.0, "sigma": -3.0}, "rope.preload_N.sigma: out of bounds (value -3, limit 0 to 23.33"),
        ({"value": 70.0, "sigma": 24}, "rope.preload_N.sigma: out of bounds (value 24, limit 0 to 23.33"),
        ({"value": 70.0, "sigma": "wide"}, "rope.preload_N.sigma: not a number (value 'wide')"),
        ({"value": 70.0, "sigma": True}, "rope.preload_N.sigma: not a number (value True)"),
        ({"value": 70.0, "sigma": None}, "rope.preload_N.sigma: not a number (value nothing)"),
        ({"value": 70.0}, "rope.preload_N: has no sigma"),
        ({"sigma": 3.0}, "rope.preload_N: has no value"),
        ({"value": 70.0, "sigma": 3.0, "unit": "N"}, "rope.preload_N.unit: unknown field"),
        ({"value": "70 N", "sigma": 3.0}, "rope.preload_N: not a number (value '70 N'"),
        ({"value": 1e6, "sigma": 3.0}, "rope.preload_N: out of bounds (value 1000000.0, limit 0.1 to 20000 N)"),
        ({"value": {"value": 1.0, "sigma": 0.1}, "sigma": 3.0}, "rope.preload_N: not a number (value a block"),
    ],
)
def test_what_cannot_be_meant_is_refused(value: Any, said: str) -> None:
    text = with_values(rope__preload_N=value)
    line = next(k for k, row in enumerate(text.split("\n"), 1) if row.startswith("  preload_N"))
    with pytest.raises(InputError) as caught:
        load_text(text, "design.yaml")
    assert said in str(caught.value), caught.value
    told = caught.value.problems[0].line
    assert line <= told <= line + 3, f"line {told}, the field is on {line}"


def test_fields_that_the_model_does_not_use_take_no_sigma() -> None:
    with pytest.raises(InputError, match="helix_lead_mm: carries a sigma, which nothing here would use"):
        load_text(with_values(rope__helix_lead_mm={"value": 0.87, "sigma": 0.01}))


def test_a_catalogue_entry_may_be_called_sigma() -> None:
    from mbcdm_cad.design.catalogue import package_entries

    data = reference_data() | {"catalogue": {"ropes": {"sigma": package_entries("ropes")["FF-081"]}}}
    data["rope"]["type"] = "sigma"
    assert load_text(yaml.safe_dump(data)).drive.cable.name == "sigma"


def test_editor_schema_offers_both_forms_and_nothing_of_ours() -> None:
    text = json.dumps(editor_schema(design_file().nodes))
    assert '"uncertain"' not in text
    rope = editor_schema(design_file().nodes)["$defs"]["WoundRope"]["properties"]
    kinds = [branch["type"] for branch in rope["preload_N"]["anyOf"]]
    assert kinds == ["number", "object"], kinds
    kinds = [branch["type"] for branch in rope["modulus_GPa"]["anyOf"]]
    assert kinds == ["number", "object", "null"], kinds
    assert "anyOf" not in rope["helix_lead_mm"]
    items = editor_schema(design_file().nodes)["$defs"]["Transmission"]["properties"]["drum_radii_mm"]["items"]
    assert [branch["type"] for branch in items["anyOf"]] == ["number", "object"]


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
        _, required = offers(check, layout_of(loaded.drive), Budget(requires=lambda asked=asked: asked))
        said.append(next(text for text in required if text.startswith(f"lower travel.{field} ")))
    half, end = (float(text.rpartition(" ")[2]) for text in said)
    assert abs((40.0 - end) / 2 - (70.0 - half)) < 0.05, said
