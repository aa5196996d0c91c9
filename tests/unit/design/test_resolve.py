"""The resolved drive: radii, sense, order, and that every field of the file has an effect."""

from __future__ import annotations

import dataclasses
from pathlib import Path
from typing import Any

import pytest

from mbcdm_cad.design.catalogue import package_entries
from mbcdm_cad.layouts.loader import design_file, load_design, reference_data
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
