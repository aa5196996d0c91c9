"""Short files: init writes them, explain explains each field."""

from __future__ import annotations

import json
import re
from pathlib import Path

import pytest
import yaml

from mbcdm_cad import cli
from mbcdm_cad.checks.size import kept_mass_g
from mbcdm_cad.design.loader import LoadedDesign
from mbcdm_cad.layouts.loader import layout_of, load_design, load_text, short_design_text
from mbcdm_cad.layouts.structure import structure_of


@pytest.fixture
def short(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> Path:
    path = tmp_path / "drive.yaml"
    assert cli.run(["init", str(path)]) == 0
    capsys.readouterr()
    return path


def test_a_short_file_is_a_whole_design(short: Path) -> None:
    lines = [line for line in short.read_text().splitlines() if line.strip() and not line.strip().startswith("#")]
    # Five requirements, and that losses count.
    assert len(lines) <= 11, lines
    assert len(load_design(short).sized) > 45


def test_derived_values_stand_as_comments_and_give_the_same_design(short: Path, tmp_path: Path) -> None:
    path = tmp_path / "more" / "drive.yaml"
    path.parent.mkdir()
    assert cli.run(["init", str(path), "--full"]) == 0
    assert load_design(path).sha256 == load_design(short).sha256
    for value in load_design(short).sized:
        assert f"{value.field.split('.')[-1]}: " in path.read_text(), value.field


@pytest.mark.parametrize("layout", ["miso_bevel", "siso_bevel", "siso_spur", "miso_spur"])
def test_a_derived_line_without_its_comment_mark_pins_its_field(layout: str) -> None:
    lines = short_design_text("drive", layout, derived=True).splitlines()
    whole = load_text("\n".join(lines), "drive.yaml")
    derived = [n for n, line in enumerate(lines) if re.match(r" *# \w+: .*  # .*: ", line) and "left out" not in line]
    assert len(derived) > 40, len(derived)
    for n in derived:
        pinned = [*lines[:n], lines[n].replace("# ", "", 1), *lines[n + 1 :]]
        found = load_text("\n".join(pinned), "drive.yaml")
        if "# stiffness: " in lines[n]:
            # It was weighed with others, which are weighed anew.
            assert _mass_times_turn(found) == pytest.approx(_mass_times_turn(whole), rel=0.01), lines[n]
        else:
            assert found.design == whole.design, lines[n]


def _mass_times_turn(loaded: LoadedDesign) -> float:
    layout = layout_of(loaded.drive)
    assert structure_of(layout) is not None
    return kept_mass_g(layout) / structure_of(layout).stiffness_Nm_rad


def test_every_sized_field_is_listed_with_its_driver(short: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.run(["explain", str(short)]) == 0
    out = capsys.readouterr().out
    for value in load_design(short).sized:
        assert any(line.startswith(value.field) and value.driver in line for line in out.splitlines()), value.field


def test_one_field_is_told_down_to_what_the_file_gives(short: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.run(["explain", str(short), "support.back_y_mm"]) == 0
    out = capsys.readouterr().out
    assert "set by: " in out and "loads.peak_torque_Nm = 3.15  (given)" in out, out
    assert cli.run(["explain", str(short), "support.back_y_mm", "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["value"] == load_design(short).design.model_dump()["support"]["back_y_mm"], found
    assert found["given"] is False and "drive.gearhead" in found["rests_on"], found


def test_a_pin_is_told_beside_what_its_rule_gives(short: Path, capsys: pytest.CaptureFixture[str]) -> None:
    data = yaml.safe_load(short.read_text())
    data["drum"] = {"outer_face_y_mm": 30.0}
    short.write_text(yaml.safe_dump(data))
    assert cli.run(["explain", str(short), "drum.outer_face_y_mm"]) == 0
    out = capsys.readouterr().out
    assert "drum.outer_face_y_mm = 30.0" in out and "given in the file" in out and "its rule gives 1" in out, out


def test_a_pulley_on_the_motors_shaft_beside_a_stiffness_is_told(capsys: pytest.CaptureFixture[str]) -> None:
    """Its rules are tried without ``carried_by`` too, where bearings called none are no drive."""
    path = Path(__file__).parents[3] / "params" / "built-by-others" / "wooden-haptics.yaml"
    assert cli.run(["explain", str(path)]) == 0
    out = capsys.readouterr().out
    assert re.search(r"^transmission.input_to_drum +16.0 +given; its rule gives ", out, re.M)
    # A rule that had nothing to choose is not told.
    assert re.search(r"^drive.encoder +none +not used: the motor's shaft carries the pulley$", out, re.M)


@pytest.mark.parametrize(("more", "said"), [("", "lightest of"), (", speed_deg_s: 172.0", "the torque at the speed")])
def test_no_gearhead_is_told_with_the_speed_that_refused_it(more: str, said: str) -> None:
    text = (
        "configuration: siso_spur\ntravel: {half_angle_deg: 45.0}\ntransmission: {input_to_drum: 11.12}\n"
        f"loads: {{peak_torque_Nm: 15.0{more}}}\n"
    )
    found = next(value for value in load_text(text, "drive.yaml").sized if value.field == "drive.gearhead")
    assert (found.value == "none") is bool(more) and said in f"{found.driver} {found.rounding}", found


def test_an_unknown_field_is_one_sentence(short: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.run(["explain", str(short), "drum.outer_face"]) == 2
    assert "no such field; did you mean drum.outer_face_y_mm?" in capsys.readouterr().err


def test_a_complete_file_is_told_beside_what_the_rules_give(capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.run(["explain", str(Path(__file__).parents[3] / "params" / "mbcdm.yaml")]) == 0
    lines = {line.split()[0]: line for line in capsys.readouterr().out.splitlines()}
    assert len(lines) > 45
    assert "34.6" in lines["transmission.centre_distance_mm"]
    assert "given; its rule gives 34.5 (fleet_angle" in lines["transmission.centre_distance_mm"]
