"""Messages to the user: file, line, field, value, limit and remedy, all problems at once."""

import math
import os
from itertools import pairwise
from pathlib import Path
from typing import Any

import pytest

from mbcdm_cad.design.bought import Entry
from mbcdm_cad.design.catalogue import KINDS, entry_orders, package_entries
from mbcdm_cad.design.fields import validated
from mbcdm_cad.design.resolve import Catalogue
from mbcdm_cad.errors import InputError, did_you_mean, shortened
from mbcdm_cad.layouts.loader import load_design, load_text, new_design_text

TEXT = new_design_text("trial")


def refusal(text: str) -> list[str]:
    with pytest.raises(InputError) as caught:
        load_text(text, "f.yaml")
    return str(caught.value).split("\n")


def edited(old: str, new: str) -> tuple[str, int]:
    """The reference file with the first ``old`` replaced, and the line it stands on."""
    assert old in TEXT, f"the reference file no longer holds {old!r}"
    return TEXT.replace(old, new, 1), TEXT[: TEXT.index(old)].count("\n") + 1


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        (
            "centre_distance_mm: 34.6",
            "centre_distance_mm: 1.5",
            "transmission.centre_distance_mm: out of bounds (value 1.5, limit 2 to 500 mm); choose a value within the "
            "limit (input pulley axis to guide axis, L)",
        ),
        (
            "centre_distance_mm: 34.6",
            'centre_distance_mm: "34.6 mm"',
            "transmission.centre_distance_mm: not a number (value '34.6 mm', limit 2 to 500 mm); write the bare "
            "number, in mm, without quotes or unit",
        ),
        ("centre_distance_mm: 34.6", "centre_distance_mm: true", "not a number (value True"),
        ("centre_distance_mm: 34.6", "centre_distance_mm:", "not a number (value nothing"),
        ("centre_distance_mm: 34.6", "centre_distance_mm: [34.6]", "not a number (value [34.6]"),
        ("test_torque_Nm: 0.91", "test_torque_Nm: 0", "limit over 0 to 1000 N m"),
        ("bearing: 618/8", "bearing: 623", "drum.bearing: not text (value 623, limit 1 to 64 of A-Z"),
        ("bearing: 618/8", "bearing: 623", 'put it in quotes: "623"'),
        (
            "bearing: 618/8",
            "bearing: 618/88",
            "drum.bearing: not in the catalogue of bearings (value '618/88'); did you mean 618/8?",
        ),
        (
            "type: FF-081",
            "diameter_mm: 1.0",
            "rope.diameter_mm: unknown field; name a catalogue entry with type:, or write diameter_mm under inline:",
        ),
        (
            "name: trial",
            "centre_distance_mm: 40\nname: trial",
            "centre_distance_mm: unknown field; write it under transmission: (",
        ),
        (
            "peak_torque_Nm: 3.15",
            "life_cycles: 1000\n  peak_torque_Nm: 3.15",
            "loads.life_cycles: unknown field; write it under targets:",
        ),
        ("gearhead: gearhead-76-16", "gearhead: gearhed-76-16", "did you mean gearhead-76-16?"),
        ("material: aluminium-7075", "material: wood", "drum.material: not in the catalogue of materials"),
        ("name: trial", "name: ../../etc", "name: not a plain name (value '../../etc', limit 1 to 64 of a-z"),
        ("name: trial", "name: a/b", "not a plain name"),
        ("name: trial", "name: ..", "not a plain name"),
        ("name: trial", "name: -rf", "not a plain name"),
        ("name: trial", 'name: "a\\n"', "not a plain name"),
        ("name: trial", "name: " + "a" * 65, "not a plain name"),
        ("name: trial", "name: café", "not a plain name"),
        ("side: +x", "side: +y", "inputs[1].side: not a known word (value '+y', limit one of -x, +x)"),
        ("modulus_area: metallic", "modulus_area: metalic", "did you mean metallic?"),
        ("step: 2", "step: 2.0", "cables[1].step: not a whole number (value 2.0, limit 1 to 4)"),
        ("step: 2", "step: 5", "cables[1].step: out of bounds (value 5, limit 1 to 4)"),
        (
            "drum_radii_mm: [54.0, 57.6, 61.2, 64.8]",
            "drum_radii_mm: [54.0, 57.6]",
            "transmission.drum_radii_mm: too short (value [54.0, 57.6], limit 4 values, each 0.5 to 500 mm)",
        ),
        (
            "drum_radii_mm: [54.0, 57.6, 61.2, 64.8]",
            "drum_radii_mm: [54.0, 57.6, x, 64.8]",
            "transmission.drum_radii_mm[2]: not a number (value 'x', limit 0.5 to 500 mm)",
        ),
        ("schema_version: 1", "schema_version: 2", "schema_version: out of bounds (value 2, limit 1)"),
        ("configuration: miso_bevel", "configuration: siso_worm", "limit one of miso_bevel"),
        ("waivers: []", "waivers: [{check: bend_ratio, reason: ' '}]", "waivers[0].reason: too short"),
        ("catalogue: {}", "catalogue: {bearing: {}}", "catalogue.bearing: unknown field; did you mean bearings?"),
        ("catalogue: {}", "catalogue: {bearings: {a b: {}}}", "catalogue.bearings.a b: not a plain name"),
        (
            "catalogue: {}",
            "catalogue: {bearings: {'1/2': {bore_mm: 0.1}}}",
            "bearings.1/2.bore_mm: out of bounds (value 0.1",
        ),
    ],
)
def test_a_wrong_value_is_told_with_line_value_limit_and_remedy(old: str, new: str, message: str) -> None:
    text, line = edited(old, new)
    lines = refusal(text)
    assert any(said.startswith(f"f.yaml:{line}: ") and message in said for said in lines), "\n".join(lines)


def test_a_misspelt_key_is_told_as_unknown_with_the_right_name() -> None:
    text, line = edited("half_angle_deg", "half_angel_deg")
    assert refusal(text) == [f"f.yaml:{line}: travel.half_angel_deg: unknown field; did you mean half_angle_deg?"]


def test_a_missing_requirement_is_told_with_what_to_add() -> None:
    text, line = edited("  half_angle_deg", "  # half_angle_deg")
    assert refusal(text) == [
        f"f.yaml:{line - 1}: travel.half_angle_deg: missing; it is a requirement, so no sizing rule gives it; "
        "add half_angle_deg: 35.0 (travel from the centre to each side, deg), or from_deg and to_deg"
    ]


def test_all_problems_of_a_file_are_listed_in_the_order_of_its_lines() -> None:
    text = TEXT
    for old, new in (
        ("mass_g: 350.0", "mass_g: -1"),
        ("half_angle_deg: 35.0", "half_angle_deg: x"),
        ("rib_mm: 7.0", "rib_mm: 1e9"),
        ("side: -x", "side: up"),
    ):
        text = text.replace(old, new, 1)
    lines = refusal(text)
    numbers = [int(line.split(":")[1]) for line in lines]
    assert len(lines) == 4 and numbers == sorted(numbers), "\n".join(lines)


def test_a_flood_of_problems_is_cut_with_a_word_on_the_rest() -> None:
    lines = refusal("configuration: miso_bevel\ndrum:\n" + "\n".join(f"  key_{k}: 1" for k in range(200)))
    assert len(lines) == 51
    assert lines[-1].split("; ")[0].endswith("more problems are not listed"), lines[-1]


@pytest.mark.parametrize("text", ["just words", "[1, 2]", "12", "true", "- a: 1"])
def test_a_file_that_is_no_block_of_fields(text: str) -> None:
    assert refusal(text)[0].startswith("f.yaml:1: not a block"), refusal(text)


class TestFiles:
    def refused(self, path: Path | str) -> str:
        with pytest.raises(InputError) as caught:
            load_design(path)
        return str(caught.value)

    def test_missing(self, tmp_path: Path) -> None:
        message = self.refused(tmp_path / "no.yaml")
        assert message.startswith(f"{tmp_path}/no.yaml:1: cannot be read: No such file"), message

    def test_directory(self, tmp_path: Path) -> None:
        assert "not a regular file" in self.refused(tmp_path)

    def test_device_and_pipe_do_not_hang(self, tmp_path: Path) -> None:
        os.mkfifo(tmp_path / "pipe")
        assert "not a regular file" in self.refused("/dev/zero")
        assert "not a regular file" in self.refused(tmp_path / "pipe")

    @pytest.mark.skipif(os.geteuid() == 0, reason="root may read everything")
    def test_unreadable(self, tmp_path: Path) -> None:
        path = tmp_path / "f.yaml"
        path.write_text(TEXT)
        path.chmod(0)
        assert "Permission denied" in self.refused(path)

    def test_path_with_a_null_byte_or_too_long(self) -> None:
        assert "cannot be read" in self.refused("a\0b")
        assert "cannot be read" in self.refused("x" * 5000)

    def test_not_utf8(self, tmp_path: Path) -> None:
        path = tmp_path / "f.yaml"
        path.write_bytes(b"a: 1\nb: caf\xe9\n")
        assert self.refused(path) == f"{path}:2: not UTF-8 text (value byte 0xe9); save the file as UTF-8"
        path.write_bytes(TEXT.encode("utf-16"))
        assert "not UTF-8 text" in self.refused(path)

    def test_too_big(self, tmp_path: Path) -> None:
        path = tmp_path / "f.yaml"
        path.write_text(TEXT + "#" * (1 << 20))
        assert "too big (value over 1048576 bytes, limit 1048576 bytes)" in self.refused(path)

    def test_empty(self, tmp_path: Path) -> None:
        path = tmp_path / "f.yaml"
        path.write_bytes(b"")
        assert self.refused(path).startswith(f"{path}:1: the design file is empty"), self.refused(path)

    def test_byte_order_mark_and_windows_line_ends_are_read(self, tmp_path: Path) -> None:
        path = tmp_path / "f.yaml"
        path.write_bytes(b"\xef\xbb\xbf" + TEXT.replace("\n", "\r\n").encode())
        assert load_design(path).sha256 == load_text(TEXT).sha256

    def test_a_name_with_a_line_break_keeps_the_message_on_one_line(self, tmp_path: Path) -> None:
        assert "\n" not in self.refused(tmp_path / "a\nb.yaml")


@pytest.mark.parametrize("value", [10**30, "x" * 500, {"a": 1}, [[1]], list(range(100)), None, "a\nb\x00"])
def test_values_in_messages_are_short_and_on_one_line(value: object) -> None:
    text = shortened(value)
    assert len(text) <= 60 and text.isprintable(), text


@pytest.mark.parametrize(
    ("name", "meant"), [("7x7-1.4", "7x7-1.5"), ("7x7-1.7", "7x7-1.6"), ("7x19-1.1", "7x19-1.0"), ("FF-08", "FF-081")]
)
def test_the_part_of_the_nearest_size_is_meant(name: str, meant: str) -> None:
    ropes = ["7x7-2.4", "7x7-1.2", "7x7-1.5", "7x7-1.6", "7x19-1.0", "7x19-1.6", "FF-081"]
    assert did_you_mean(name, ropes) == f"did you mean {meant}?"


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
