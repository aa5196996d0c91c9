"""The catalogue of the package: every entry is valid and agrees with its stated rules and fixed values."""

from __future__ import annotations

import math
from itertools import pairwise
from typing import Any

import pytest

from mbcdm_cad.design.bought import Entry
from mbcdm_cad.design.catalogue import KINDS, entry_orders, package_entries
from mbcdm_cad.design.fields import validated
from mbcdm_cad.design.resolve import Catalogue
from mbcdm_cad.errors import InputError
from mbcdm_cad.layouts.loader import load_text, new_design_text

ALL = [(kind, name) for kind in KINDS for name in package_entries(kind)]
WIRES = {"7x7": (49, 9), "7x19": (133, 15), "1x19": (19, 5)}  # count, and rope diameter over wire diameter


@pytest.mark.parametrize(("kind", "name"), ALL)
def test_entry_is_valid_ordered_and_has_a_source(kind: str, name: str) -> None:
    entry: Entry = validated(KINDS[kind], package_entries(kind)[name])
    for names in entry_orders(entry):
        values = [value for field in names if (value := getattr(entry, field)) is not None]
        assert values == sorted(values), f"{kind} {name}: {names} are {values}"
    assert len(entry.source) > 10, f"{kind} {name}: source is {entry.source!r}"
    for field, target in (("material", "materials"), ("screw", "screws")):
        if getattr(entry, field, None) is not None:
            assert getattr(entry, field) in package_entries(target)


@pytest.mark.parametrize("name", package_entries("ropes"))
def test_rope_area_follows_from_its_wires_and_mass_from_its_area(name: str) -> None:
    rope = package_entries("ropes")[name]
    if rope["construction"] == "braid":
        nominal = math.pi / 4 * rope["diameter_mm"] ** 2
        assert 0.55 < rope["metallic_area_mm2"] / nominal < 0.7, f"{name}: share of fibre"
        assert 900 < rope["breaking_load_N"] / nominal < 1300, f"{name}: N/mm2 on the nominal area"
        assert 0.5 < rope["mass_g_m"] / nominal < 1.0, f"{name}: g/m per mm2"
        return
    count, ratio = WIRES[rope["construction"]]
    area = count * math.pi / 4 * (rope["diameter_mm"] / ratio) ** 2
    assert rope["metallic_area_mm2"] == pytest.approx(area, rel=1e-3), f"{name}: {area:.5f} mm2 from the wires"
    assert rope["mass_g_m"] == pytest.approx(8.02 * area, rel=6e-3), f"{name}: {8.02 * area:.4f} g/m from the area"
    strength = rope["breaking_load_N"] / area
    assert 1400 < strength < 2000, f"{name}: {strength:.0f} N/mm2 on the wires' area"


def test_there_are_several_ropes_of_both_constructions() -> None:
    sizes = {
        con: [r["diameter_mm"] for r in package_entries("ropes").values() if r["construction"] == con] for con in WIRES
    }
    assert min(sizes["7x7"]) <= 0.45 and max(sizes["7x7"]) >= 2.3 and len(sizes["7x7"]) >= 5, sizes
    assert len(sizes["7x19"]) >= 3, sizes


FIXED: list[tuple[str, str, dict[str, Any]]] = [
    (
        "ropes",
        "FF-081",
        {
            "diameter_mm": 0.81,
            "metallic_area_mm2": 0.3117,
            "breaking_load_N": 530.0,
            "mass_g_m": 2.5,
            "bend_ratio_minimum": 28.0,
            "bend_ratio_desired": 42.0,
        },
    ),
    ("motors", "motor-2.9mNm-15", {"rated_torque_mNm": 2.9, "mass_g": 18.0, "diameter_mm": 15.0, "length_mm": 24.0}),
    (
        "gearheads",
        "gearhead-76-16",
        {
            "ratio": 76.0,
            "mass_g": 18.0,
            "diameter_mm": 16.0,
            "length_mm": 20.0,
            "shaft_diameter_mm": 3.0,
            "shaft_length_mm": 10.0,
            "screw_count": 2,
        },
    ),
    ("encoders", "encoder-17", {"diameter_mm": 17.0, "length_mm": 14.0, "mass_g": 7.0}),
    ("encoders", "encoder-24-ring", {"mass_g": 9.0}),
    ("screws", "M2x6", {"mass_g": 0.28}),
    ("screws", "M2.5x8", {"mass_g": 0.52}),
    ("screws", "M3x8", {"mass_g": 0.86}),
    *[
        ("bearings", name, {"bore_mm": d, "outer_diameter_mm": outer, "width_mm": b, "mass_g": m})
        for name, d, outer, b, m in (
            ("623", 3.0, 10.0, 4.0, 1.5),
            ("618/4", 4.0, 9.0, 2.5, 0.7),
            ("618/5", 5.0, 11.0, 3.0, 1.2),
            ("618/6", 6.0, 13.0, 3.5, 2.0),
            ("618/8", 8.0, 16.0, 4.0, 3.0),
            ("61800", 10.0, 19.0, 5.0, 5.3),
        )
    ],
]


@pytest.mark.parametrize(("kind", "name", "figures"), FIXED)
def test_fixed_figures_are_not_tuned(kind: str, name: str, figures: dict[str, Any]) -> None:
    entry = package_entries(kind)[name]
    assert {key: entry[key] for key in figures} == figures


def test_encoder_resolution_is_a_power_of_two_per_turn() -> None:
    lines = 2 * math.pi / (package_entries("encoders")["encoder-17"]["resolution_urad"] * 1e-6)
    assert lines == pytest.approx(32768, rel=1e-6), f"{lines:.3f} steps per turn"


def test_screw_masses_grow_with_length_by_the_mass_of_the_thread() -> None:
    screws = package_entries("screws")
    for thread, pitch in ((2.0, 0.40), (2.5, 0.45), (3.0, 0.50)):
        per_mm = 7.85e-3 * math.pi / 4 * (thread - 0.6495 * pitch) ** 2
        family = sorted(
            (s["length_mm"], s["mass_g"])
            for s in screws.values()
            if s["thread_mm"] == thread and s["head_diameter_mm"] > 0
        )
        for (l_1, m_1), (l_2, m_2) in pairwise(family):
            slope = (m_2 - m_1) / (l_2 - l_1)
            assert slope == pytest.approx(per_mm, abs=0.002), f"M{thread:g}: {slope:.4f} g/mm, thread has {per_mm:.4f}"


def test_own_entry_overrides_the_package_and_is_used() -> None:
    mine = {**package_entries("bearings")["618/8"], "mass_g": 3.5}
    text = new_design_text("trial").replace("catalogue: {}", "catalogue:\n  bearings:\n    618/8: " + str(mine))
    loaded = load_text(text)
    assert (loaded.drive.bearings.drum.name, loaded.drive.bearings.drum.mass_g) == ("618/8", 3.5)
    assert Catalogue(loaded.design).names("bearings").count("618/8") == 1


def test_an_entry_has_its_name_from_its_key_alone() -> None:
    named = {**package_entries("bearings")["618/8"], "name": "mine"}
    text = new_design_text("trial").replace("catalogue: {}", "catalogue:\n  bearings:\n    own: " + str(named))
    with pytest.raises(InputError, match=r"catalogue\.bearings\.own\.name: unknown field"):
        load_text(text)
