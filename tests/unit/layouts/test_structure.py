"""Compliance by cause of the four references: what it consists of, and what follows from what."""

from dataclasses import replace
from functools import cache
from math import inf
from pathlib import Path

import pytest

from mbcdm_cad.api.design import DriveDesign
from mbcdm_cad.design.drive import Drive
from mbcdm_cad.layouts.loader import layout_of, load_design
from mbcdm_cad.layouts.sector import SectorLayout
from mbcdm_cad.layouts.siso_spur.layout import SpurLayout
from mbcdm_cad.layouts.structure import structure_of
from mbcdm_cad.layouts.turns import implied_moduli_GPa
from mbcdm_cad.model.stiffness import drum_backlash
from tests.support.checked import of_params

PARAMS = Path(__file__).parents[3] / "params"
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
    assert report.structure is not None
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
