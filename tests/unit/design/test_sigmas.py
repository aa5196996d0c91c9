"""Values given as {value, sigma}: read, refused, and copied to the ``Drive``."""

from __future__ import annotations

import json
from typing import Any

import pytest
import yaml

from mbcdm_cad.design.describe import editor_schema
from mbcdm_cad.errors import InputError
from mbcdm_cad.layouts.loader import design_file, load_text, new_design_text, reference_data


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
