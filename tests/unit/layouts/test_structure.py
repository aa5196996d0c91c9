"""All layouts: compliance by cause, pins, angles of the terminals, steps of assembly."""

from dataclasses import replace
from functools import cache
from math import degrees, inf, radians
from pathlib import Path
from typing import Any

import pytest
import yaml

from mbcdm_cad.api.design import DriveDesign
from mbcdm_cad.checks.comparison import failed
from mbcdm_cad.checks.run import run_check
from mbcdm_cad.design.drive import Drive
from mbcdm_cad.design.loader import LoadedDesign
from mbcdm_cad.layouts.check_design import checks_of, run_checks
from mbcdm_cad.layouts.loader import layout_of, load_design, load_text, reference_data
from mbcdm_cad.layouts.sector import SectorLayout
from mbcdm_cad.layouts.siso_spur.layout import SpurLayout
from mbcdm_cad.layouts.structure import structure_of
from mbcdm_cad.layouts.turns import implied_moduli_GPa
from mbcdm_cad.model.stiffness import drum_backlash
from tests.support.checked import failing, of_params, short_file
from tests.support.reference import PARAMS

REFERENCES = ("mbcdm", "siso_spur", "miso_spur", "siso_bevel")


@cache
def layout_in(name: str) -> SectorLayout:
    layout = layout_of(load_design(PARAMS / f"{name}.yaml").drive)
    assert isinstance(layout, SectorLayout)
    return layout


def test_a_rope_that_leaves_no_metal_to_a_neck_is_analysed_and_its_checks_fail(tmp_path: Path) -> None:
    text = (PARAMS / "mbcdm.yaml").read_text()
    assert "type: FF-081" in text
    thick = tmp_path / "thick.yaml"
    thick.write_text(text.replace("type: FF-081", "type: 7x19-3.0"))
    design = DriveDesign(load_design(thick))
    assert structure_of(layout_in(str(thick.with_suffix("")))).motor_urad_Nm > 1e6
    assert "input pulleys, torsion" in str(design.analyse())
    assert design.check()["bearing_shoulders"].status == "fail"


@pytest.mark.parametrize("name", REFERENCES)
def test_every_cause_gives_and_the_sums_are_those_of_their_causes(name: str) -> None:
    s = structure_of(layout_in(name))
    assert all(c.urad_Nm > 0.0 for c in s.causes), [(c.name, c.urad_Nm) for c in s.causes]
    face = next(c.urad_Nm for c in s.causes if not c.at_encoder)
    assert s.payload_urad_Nm - s.encoder_urad_Nm == pytest.approx(face)
    before = sum(c.urad_Nm for c in s.causes if c.before_input)
    assert s.motor_urad_Nm - s.payload_urad_Nm == pytest.approx(before)
    assert s.stiffness_Nm_rad == pytest.approx(1e6 / (s.cables_urad_Nm + s.payload_urad_Nm))


def test_the_frame_is_the_frame_study_and_the_cables_are_those_of_the_analysis() -> None:
    layout = layout_in("mbcdm")
    assert layout.frame_study is not None
    frame = next(c.urad_Nm for c in structure_of(layout).causes if c.name == "frame")
    assert frame == pytest.approx(layout.frame_study.compliance().windup_urad_Nm)
    report = of_params("mbcdm").drive
    case = analysis(report).figures.test[0]
    assert structure_of(layout).cables_urad_Nm == pytest.approx(abs(case.turn_mrad) / case.load_Nm * 1e3, rel=1e-6)


def analysis(drive: Drive):  # type: ignore[no-untyped-def]
    from mbcdm_cad.report.analysis_report import analyse_design

    return analyse_design(drive)


def test_with_the_implied_modulus_the_drums_encoder_sees_the_papers_backlash() -> None:
    layout = layout_in("mbcdm")
    found, d = implied_moduli_GPa(layout), layout.si
    give = structure_of(layout).encoder_urad_Nm * 1e-6 * 0.91
    for reading, turns in (("reversal", 2.0), ("single", 1.0)):
        drum = drum_backlash(d.with_(modulus_Pa=found[reading] * 1e9), 0.91)
        own = drum.reversal_swing_rad if reading == "reversal" else drum.first_loading_rad
        assert float(own) + turns * give == pytest.approx(0.33e-3, rel=1e-9), reading
    assert 20.0 < found["single"] < found["reversal"], found
    rubber = {
        **vars(structure_of(layout)),
        "causes": tuple(replace(c, urad_Nm=10.0 * c.urad_Nm) for c in structure_of(layout).causes),
    }
    soft = type(layout)(layout.drive)
    soft.once("structure", lambda _: type(structure_of(layout))(**rubber))
    assert implied_moduli_GPa(soft) == {"reversal": inf, "single": inf}, "the structure alone turns further"


def test_two_equal_sectors_share_the_torque() -> None:
    # With one hub miso_spur has two sectors like that of siso_spur: each carries half, and turns half as far.
    both = [layout_in(name) for name in ("siso_spur", "miso_spur")]
    drum = replace(both[1].drive.drum, hub_diameter_mm=both[0].drive.drum.hub_diameter_mm)
    both[1] = layout_of(replace(both[1].drive, drum=drum))
    one, two = (next(c.urad_Nm for c in structure_of(s).causes if c.name == "drum: web and rim") for s in both)
    assert two == pytest.approx(one / 2.0, rel=0.02)
    # The first hub passes half on, the last one all: 1/4 and 1 of the twist of a hub under the whole torque.
    alone, line = (
        sum(c.urad_Nm for c in structure_of(s).causes if c.name.startswith("drum: hub"))
        for s in (SpurLayout(both[1].drive.unit(0)), both[1])
    )
    assert line == pytest.approx(1.25 * alone, rel=1e-6)


def test_a_drive_without_a_gearhead_has_no_give_of_one() -> None:
    names = [c.name for c in structure_of(layout_in("gallery/capstan")).causes]
    assert not [name for name in names if "gearhead" in name], names


def test_a_stated_stiffness_of_the_gearhead_replaces_the_estimate() -> None:
    # Closed form: a shaft of stiffness k behind the ratio i turns the drum by 1/(k i^2) per N m.
    drive = load_design(PARAMS / "siso_spur.yaml").drive
    stiff = replace(drive, gearhead=replace(drive.gearhead, stiffness_Nm_rad=100.0))
    causes = {c.name: c.urad_Nm for c in structure_of(SpurLayout(stiff)).causes}  # type: ignore[arg-type]
    ratio = drive.cables[0].drum_radius_mm / drive.cables[0].input_radius_mm
    assert causes["gearheads"] == pytest.approx(1e6 / (100.0 * ratio**2), rel=1e-6), causes
    assert "gearheads (estimate)" not in causes


def test_json_and_text_carry_the_same_figures() -> None:
    import mbcdm_cad

    design: DriveDesign = mbcdm_cad.load(PARAMS / "siso_spur.yaml")
    report = design.analyse()
    block = report.to_dict()["structure"]
    text = report.text()
    for cause in block["causes"]:
        line = next(line for line in text.splitlines() if line.strip().startswith(cause["name"] + "  "))
        assert f"{cause['urad_Nm']:.1f}" in line
    places = (("payload  ", "payload"), ("drum's encoder", "drum_encoder"), ("cables alone", "cables"))
    for name, key in places:
        line = next(line for line in text.splitlines() if line.strip().startswith(name))
        assert f"{block['places'][key]['turn_mrad']:.3f}" in line, line
        assert f"{block['places'][key]['swing_mrad']:.3f}" in line, line
    own = report.figures.reversal_swing_mrad
    added = 2.0 * block["structure_at_payload_urad_Nm"] * report.figures.test[0].load_Nm * 1e-3
    assert block["payload_swing_mrad"] == pytest.approx(own + added)


def short() -> dict[str, Any]:
    return short_file("miso_bevel", 35.0, 9.0, 54.0, 3.0)


def test_a_contradicting_pin_is_the_first_advice_and_taking_it_out_passes() -> None:
    data = short() | {"drum": {"outer_face_y_mm": 10.5}}
    found = {check.id: check for check in failed(run_checks(load_text(yaml.safe_dump(data))))}
    assert found["outer_face"].remedy.startswith("take drum.outer_face_y_mm out: its rule gives "), found
    del data["drum"]
    assert failed(run_checks(load_text(yaml.safe_dump(data)))) == ()


def test_the_advice_on_a_pin_tells_its_line() -> None:
    text = yaml.safe_dump(short(), sort_keys=False) + "# the pin\ndrum:\n  outer_face_y_mm: 10.5\n"
    line = text.splitlines().index("  outer_face_y_mm: 10.5") + 1
    found = {check.id: check for check in failed(run_checks(load_text(text)))}
    assert f"(given on line {line})" in found["outer_face"].remedy, found["outer_face"].remedy


def test_a_pin_that_is_not_to_blame_is_not_named() -> None:
    data = short() | {"support": {"side_wall_mm": 6.0}}
    data["limits"] = {"bend_ratio_min": 60.0}
    found = {check.id: check for check in failed(run_checks(load_text(yaml.safe_dump(data))))}
    assert "take " not in found["bend_ratio"].remedy, found["bend_ratio"].remedy


def test_a_complete_file_is_told_that_its_derived_fields_may_follow() -> None:
    data = reference_data()
    data["transmission"]["centre_distance_mm"] = 38.0
    found = {check.id: check for check in failed(run_checks(load_text(yaml.safe_dump(data))))}
    assert found["drum_sweep"].remedy.startswith("take the "), found["drum_sweep"].remedy
    assert "derived fields out" in found["drum_sweep"].remedy


def test_advice_for_a_short_file_names_the_fields_that_it_has() -> None:
    """Of a file with ratio and drum radius nobody can lower the ratio of input to guide alone."""
    data = short() | {"rope": {"type": "7x7-1.6"}, "limits": {"bend_ratio_min": 10.0}}
    data["transmission"] = {"ratio": 12.0, "drum_radius_mm": 54.0}
    found = {check.id: check for check in failed(run_checks(load_text(yaml.safe_dump(data))))}
    remedy = found["bend_ratio"].remedy
    assert "lower transmission.ratio from 12 to at most" in remedy, remedy
    assert "raise transmission.drum_radius_mm from 54 to at least" in remedy, remedy
    bend = 2 * 54.0 / (12.0 * 1.59)
    assert f"{bend:.3g} D/d" in found["bend_ratio"].message, found["bend_ratio"].message
    ratio = float(remedy.split("transmission.ratio from 12 to at most ")[1].split()[0])
    assert 10.0 <= 2 * 54.0 / (ratio * 1.59) <= 10.05, f"the advice of {ratio} does not just reach D/d 10"


LAYOUTS = ("mbcdm", "siso_spur", "miso_spur", "siso_bevel")
# More than the travel, and less than the reference designs have.
ASKED_DEG = {"mbcdm": 55.0, "siso_spur": 70.0, "miso_spur": 70.0, "siso_bevel": 55.0}


def with_angle(name: str, angle_deg: float | None) -> LoadedDesign:
    data = yaml.safe_load((PARAMS / f"{name}.yaml").read_text())
    if angle_deg is not None:
        data["cables"][0]["terminal_angle_deg"] = angle_deg
    return load_text(yaml.safe_dump(data, sort_keys=False))


@pytest.mark.parametrize("name", LAYOUTS)
def test_only_the_terminal_with_an_angle_moves(name: str) -> None:
    free, asked = with_angle(name, None), with_angle(name, ASKED_DEG[name])
    before, after = (layout_of(loaded.drive).terminals for loaded in (free, asked))
    first = asked.design.cables[0].name
    for old, new in zip(before, after, strict=True):
        if new.cable_name == first:
            assert degrees(new.anchor_rad) == pytest.approx(ASKED_DEG[name])
            assert new.furthest_rad == old.anchor_rad > new.anchor_rad
        else:
            assert new.anchor_rad == old.anchor_rad


@pytest.mark.parametrize("name", LAYOUTS)
def test_length_on_the_drum_follows_the_angle(name: str) -> None:
    """Of the drawn paths: the cable loses r times the angle, the others keep their length."""
    free, asked = with_angle(name, None), with_angle(name, ASKED_DEG[name])
    terminals = layout_of(free.drive).terminals
    lost = terminals[0].radius_mm * (terminals[0].anchor_rad - radians(ASKED_DEG[name]))
    before, after = (sum(p.length_mm for p in layout_of(x.drive).cable_paths(0.0)) for x in (free, asked))
    assert lost > 3.0
    # A winding's slope on the input may change a little with its length.
    assert before - after == pytest.approx(lost, abs=0.02)


@pytest.mark.parametrize("name", LAYOUTS)
def test_an_angle_outside_the_sector_fails_with_the_limit(name: str) -> None:
    asked = with_angle(name, 200.0)
    test = layout_of(asked.drive)
    check = next(c for c in checks_of(asked.drive) if c.id == "terminal_angles")
    result = run_check(check, test)
    assert result.status == "fail"
    assert result.actual == pytest.approx(200.0)
    assert result.limit == pytest.approx(degrees(test.terminals[0].furthest_rad))
    assert "terminal_angle_deg" in result.remedy


@pytest.mark.parametrize("name", ["miso_bevel", "siso_spur", "miso_spur", "siso_bevel"])
def test_the_sector_grows_for_a_stated_angle(name: str) -> None:
    """A short file with a terminal further out than its sector would reach gets a larger sector, and passes."""
    data = short_file(name, 30.0, 4.0, 80.0, 1.0)
    free = load_text(yaml.safe_dump(data))
    furthest = degrees(layout_of(free.drive).terminals[0].furthest_rad)
    cables = [c.model_dump(exclude_none=True) for c in free.design.cables]
    cables[0]["terminal_angle_deg"] = round(furthest + 12.0, 1)
    asked = load_text(yaml.safe_dump({**data, "cables": cables}))
    terminal = layout_of(asked.drive).terminals[0]
    assert degrees(terminal.anchor_rad) == pytest.approx(cables[0]["terminal_angle_deg"])
    assert asked.design.drum.sector_half_angle_deg > free.design.drum.sector_half_angle_deg
    assert failing(asked) == {}


@pytest.mark.parametrize("name", ["mbcdm", "siso_bevel", "siso_spur", "miso_spur"])
def test_a_renamed_part_is_an_error(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    layout = layout_of(load_design(PARAMS / f"{name}.yaml").drive)
    bill = layout.bill()
    for old, item in (("stop_pin", "stop_pin"), ("hub_set_screw_1", "hub_set_screw_#")):
        wanted = item.replace("#", "")
        items = [replace(i, name=i.name.replace(wanted, "renamed")) for i in bill.items]
        assert old in {i.name for i in bill.items}
        monkeypatch.setattr(layout, "bill", lambda items=items: replace(bill, items=items))
        with pytest.raises(LookupError, match=item):
            layout.assembly_order  # noqa: B018 - raises


def test_a_first_stage_of_several_cables_has_all_its_parts() -> None:
    """Its sectors join one by one, on a shaft that is bonded in them."""
    text = "name: twice\nconfiguration: siso_spur\ntravel: {half_angle_deg: 35.0}\nloads: {peak_torque_Nm: 4.0}\n"
    text += "first_stage: {total_ratio: 24.0, design: {transmission: {parallel: 2}}}\n"
    layout = layout_of(load_text(text).drive)
    joined = [name for step in layout.assembly_order for name in step.items]
    assert sorted(joined) == sorted(item.name for item in layout.bill().items)
    (first,) = [step for step in layout.assembly_order if "first_drum_1" in step.items]
    assert "Wet the shaft with retaining compound. Push sector 1" in first.text
