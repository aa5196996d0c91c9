"""Messages to the user: file, line, field, value, limit and remedy, all problems at once."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

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
    lines = refusal("\n".join(f"key_{k}: 1" for k in range(200)))
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
