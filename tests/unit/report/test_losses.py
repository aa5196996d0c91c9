"""The losses in `analyse`: text and JSON carry the same figures, within 80 columns, for every kind of layout.

Masses that are estimates, by the part of the catalogue entry's source about the mass.

The report on the preload: shares that agree with other reports, the procedure's files, logs and nuts.

Cable paths and torsional modes in the report and in `mbcdm analyse`.
"""

import json
import shutil
import subprocess
import sys
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest

import mbcdm_cad as mc
from mbcdm_cad.api.design import DriveDesign
from mbcdm_cad.design.blocks import Payload
from mbcdm_cad.design.catalogue import package_entries
from mbcdm_cad.design.drive import Drive
from mbcdm_cad.layouts import preload
from mbcdm_cad.layouts.loader import layout_of, load_text, new_design_text
from mbcdm_cad.layouts.miso_bevel.layout import BevelLayout
from mbcdm_cad.layouts.structure import structure_of
from mbcdm_cad.layouts.turns import Modes, modes_of, turns_of
from mbcdm_cad.model.equilibrium import solve_equilibrium
from mbcdm_cad.model.stiffness import sticking_stiffness_Nm_rad
from mbcdm_cad.report.analysis_report import analyse_design, path_data, path_data_or_reason
from mbcdm_cad.report.data import mass_is_estimated
from mbcdm_cad.report.losses import losses_report, losses_shown
from tests.support.checked import of_params
from tests.support.reference import PARAMS


@cache
def report_of(name: str):  # type: ignore[no-untyped-def]
    return DriveDesign(of_params(name)).analyse()


@pytest.mark.parametrize("name", ["mbcdm", "siso_spur", "gallery/capstan"])
def test_json_and_text_carry_the_same_figures(name: str) -> None:
    report = report_of(name)
    block, lines = report.to_dict()["losses"], report.text(80).splitlines()
    against, along = block["motions"][0], block["motions"][2]
    assert (against["way"], along["way"]) == ("against the load", "with the load")
    start = next(k for k, line in enumerate(lines) if line.startswith("Losses while"))
    own = lines[start : lines.index("", start)]
    for cause, torque in against["by_cause_Nm"].items():
        line = next(line for line in own if line.strip().startswith(cause + "  "))
        assert f"{torque[-1]:.4f}" in line
    line = next(line for line in own if line.split()[:1] == [f"{against['load_Nm'][-1]:.3g}"] and "%" in line)
    assert f"{against['efficiency'][-1]:.1%}" in line
    assert f"{along['efficiency'][-1]:.1%}" in line
    assert max(len(line) for line in own) <= 80
    assert f"{block['backdrive']['running_Nm']:.3g} +-" in " ".join(own)


def test_the_copper_lowers_the_efficiency_most_at_low_speed() -> None:
    report = report_of("gallery/capstan")
    block = report.to_dict()["losses"]
    rows = block["electrical"]["efficiency"]
    at_peak = [row[-1] for row in rows]
    assert at_peak == sorted(at_peak)
    assert all(value < block["motions"][0]["efficiency"][-1] for value in at_peak)


def test_a_motor_without_electrical_values_has_no_electrical_efficiency() -> None:
    losses = losses_report(report_of("gallery/capstan").layout)
    bare = replace(losses, motor=replace(losses.motor, torque_constant_mNm_A=None))
    found = bare.to_dict()
    assert found["electrical"] is None and losses_shown(found)["over_speed"] is None


@pytest.mark.parametrize("name", ["mbcdm", "gallery/capstan"])
def test_bus_power_is_what_payload_friction_and_copper_take(name: str) -> None:
    """The efficiencies by the motors' own torque and speed: V I of each motor against load times speed."""
    losses = losses_report(report_of(name).layout)
    found, constant, ohms = (
        losses.to_dict()["electrical"],
        losses.motor.torque_constant_mNm_A,
        losses.motor.resistance_ohm,
    )
    assert found is not None and constant is not None and ohms is not None
    turns = float(np.max(losses.train.d.input_turns)) * losses.train.gear_ratio
    for block, motion, way in ((found, losses.motions[0], 1), (found["back"], losses.motions[2], -1)):
        current = way * motion.motor_Nm / (constant * 1e-3)
        for speed, row in zip(np.radians(found["drum_speed_deg_s"]), block["efficiency"], strict=True):
            volts = way * (constant * 1e-3) * turns * speed + ohms * current
            bus, given = (volts * current).sum(axis=0), motion.load_Nm * speed
            for k, efficiency in enumerate(row):
                expected = given[k] / bus[k] if way > 0 else max(-bus[k] / given[k], 0.0)
                assert efficiency is None or efficiency == pytest.approx(expected, abs=1e-9), (way, speed, k)


def test_page_and_report_show_every_cause_and_their_sum() -> None:
    block = report_of("mbcdm").to_dict()["losses"]
    shown = losses_shown(block)
    for column, key in enumerate(("unloaded", "against", "along")):
        assert sum(row[key] for row in shown["rows"]) == pytest.approx(shown["all"][column])
    assert shown["peak_Nm"] == pytest.approx(3.15)
    forward, back = (line["y"] for line in shown["chart"]["lines"])
    assert all(f > b for f, b in zip(forward, back, strict=True))


@pytest.mark.parametrize("name", ["mbcdm", "siso_spur"])
def test_the_motors_tell_a_load_to_half_of_what_they_give_more_on_the_way_against_it(name: str) -> None:
    report = report_of(name).to_dict()
    found, (against, _, along, _) = report["losses"]["transparency"], report["losses"]["motions"]
    drive = of_params(name).drive
    turns = layout_of(drive).losses.d.input_turns * drive.gearhead.ratio
    # Each in the direction of motion, and the two move in opposite ones.
    more = np.array([*against["motor_mNm"].values()]) + np.array([*along["motor_mNm"].values()])
    at_drum = 0.5e-3 * (turns.reshape(-1, 1) * more).sum(axis=0)
    assert found["load_known_to_Nm"] == pytest.approx(at_drum.tolist(), rel=1e-6)
    assert found["rotors_kg_m2"] == pytest.approx(report["motor"]["reflected_inertia_kg_m2"])
    assert "transparency: a hand" in report_of(name).text(80)


@pytest.mark.parametrize(
    ("kind", "name", "estimated"),
    [
        ("motors", "motor-2.9mNm-15", False),  # the paper gives 18 g; only sizes are of a class
        ("gearheads", "gearhead-76-16", True),
        ("encoders", "encoder-17", True),
        ("encoders", "encoder-24-ring", True),
        ("bearings", "618/4", False),  # ratings are estimates, masses are not
        ("bearings", "618/3", True),
        ("screws", "M2x6", False),
        ("screws", "M2x5", True),
        ("ropes", "FF-081", True),
    ],
)
def test_estimate_is_told_by_the_clause_on_the_mass(kind: str, name: str, estimated: bool) -> None:
    source = package_entries(kind)[name]["source"]
    assert mass_is_estimated(source) is estimated, source


def test_source_silent_on_the_mass_counts_as_a_whole() -> None:
    assert mass_is_estimated("estimate") and not mass_is_estimated("Maker's data sheet, edition 7")


@pytest.fixture(scope="module")
def design() -> mc.DriveDesign:
    return mc.load(PARAMS / "mbcdm.yaml")


def log_of(design: mc.DriveDesign, path: Path, factors: list[float], at_motor: bool = False) -> Path:
    """A log of the first input's ramps on a drive whose preloads differ by factors, without noise."""
    layout = layout_of(design.drive)
    si = layout.loads.si
    changed = replace(preload._held(layout, at_motor), d=si.with_(preload_N=si.preload_N * np.array(factors)))
    angle = preload.ramps(layout)[0].angle_rad
    torque = changed.torque_Nm(0, angle) / (layout.drive.gearhead.ratio if at_motor else 1.0)
    rows = [f"{a},{t}" for a, t in zip(angle, torque, strict=True)]
    path.write_text("\n".join([f"angle_rad,{'motor_' * at_motor}torque_Nm", *rows]))
    return path


def test_figures_are_those_of_other_reports(design: mc.DriveDesign) -> None:
    rule = design.preload().rule
    own = next(row for row in rule.table if row.factor == 1.0)
    assert own.swing_mrad == pytest.approx(design.analyse().figures.reversal_swing_mrad, rel=1e-6)
    assert own.life_factor == 1.0
    assert rule.slack_N < rule.knee_N < rule.preload_N < rule.most_N
    # Each column one way: less swing, less life, more friction.
    for name, sense in (
        ("swing_mrad", -1),
        ("life_factor", -1),
        ("rope_Nm", 1),
        ("bearings_Nm", 1),
        ("lowest_share", 1),
    ):
        values = np.array([getattr(row, name) for row in rule.table])
        assert np.all(sense * np.diff(values) > 0.0), (name, values)


@pytest.mark.parametrize("at_motor", [False, True], ids=["shaft", "motor"])
def test_a_log_gives_preloads_and_the_turns_that_set_them_right(
    design: mc.DriveDesign, tmp_path: Path, at_motor: bool
) -> None:
    log = log_of(design, tmp_path / "left.csv", [1.2, 0.85, 1.0, 1.0], at_motor)
    report = design.preload(logs={"left": log})
    assert [t.measured_N for t in report.turns] == pytest.approx([84.0, 59.5, 70.0, 70.0], rel=0.01)
    assert report.turns[0].turns < 0.0 < report.turns[1].turns
    assert "turns of its nut" in str(report)


def test_the_files_state_the_knee_and_run(design: mc.DriveDesign, tmp_path: Path) -> None:
    report = design.preload(tmp_path)
    folder = report.folder
    assert folder is not None
    code = (folder / "preload_ramp.c").read_text()
    assert "@" not in code and "LARGEST_RAD 0." in code
    if shutil.which("cc"):
        subprocess.run(
            ["cc", "-c", "-Wall", "-Werror", "-o", str(tmp_path / "o"), str(folder / "preload_ramp.c")], check=True
        )
    log = log_of(design, tmp_path / "left.csv", [1.1, 0.9, 1.0, 1.0])
    script = [sys.executable, str(folder / "preload_ramp.py"), str(PARAMS / "mbcdm.yaml"), f"left={log}"]
    told = subprocess.run(script, check=True, capture_output=True, text=True).stdout
    assert "Found:" in told and "cable_1" in told


def test_bad_logs_are_refused_with_file_and_line(design: mc.DriveDesign, tmp_path: Path) -> None:
    path = tmp_path / "log.csv"
    path.write_text("angle,torque_Nm\n0,1\n")
    with pytest.raises(mc.MbcdmError, match=r"log.csv:1: no column angle_rad"):
        design.preload(logs={"left": path})
    path.write_text("angle_rad,torque_Nm\n0,1\nx,2\n")
    with pytest.raises(mc.MbcdmError, match=r"log.csv:3: no number in 'angle_rad'"):
        design.preload(logs={"left": path})
    path.write_text("angle_rad,torque_Nm\n" + 300 * "0.1,0.1\n")
    with pytest.raises(mc.MbcdmError, match="angle_rad does not change"):
        design.preload(logs={"left": path})
    # A straight line has no knee: the preloads are known to many times themselves only, and give no turns of nuts.
    path.write_text("angle_rad,torque_Nm\n" + "".join(f"{0.01 * k},{0.1 * k}\n" for k in range(200)))
    with pytest.raises(mc.MbcdmError, match="do not follow from this ramp"):
        design.preload(logs={"left": path})
    with pytest.raises(mc.MbcdmError, match="no input middle"):
        design.preload(logs={"middle": log_of(design, path, [1.0] * 4)})
    spur = mc.load(PARAMS / "siso_spur.yaml").preload()
    assert not spur.ramps and "slips there" in str(spur)


@pytest.fixture(scope="module")
def drive() -> Drive:
    return load_text(new_design_text("mbcdm")).drive


def test_analyse_prints_paths_and_travel(drive: Drive) -> None:
    found = analyse_design(drive)
    text, data = found.text(), json.loads(json.dumps(found.to_dict(), allow_nan=False))["paths"]
    assert "usable travel -35.25 to +35.25 deg" in text
    for c in data["cables"]:
        assert f"{c['name']:<10} length {c['length_mm']:.2f} mm" in text
        assert f"input contact ({c['input_contact_mm'][0]:.3f}" in text
    assert data["limits_positive"][0]["cause"] == "hard stop"


def test_a_design_without_a_layout_still_has_its_figures(drive: Drive) -> None:
    """No dimensions to lay out: the reason stands in place of the paths."""
    overlapping = replace(drive, centre_distance_mm=12.0)
    paths, why = path_data_or_reason(overlapping)
    assert paths is None and "centre distance" in why, why


def test_no_helix_no_error_of_the_path(drive: Drive) -> None:
    """A helix of (nearly) no lead runs as the pitch circles do."""
    steep, flat = (path_data(BevelLayout(replace(drive, helix_lead_mm=lead))) for lead in (0.87, 1e-6))
    worst = [max(map(abs, data["drum_turn_urad"])) for data in (steep, flat)]
    assert worst[0] > 100 and worst[1] < 1e-3, f"{worst} urad"


def test_real_wraps_turn_the_drum_no_further_than_endless_ones(drive: Drive) -> None:
    d = layout_of(drive).si
    endless = abs(float(solve_equilibrium(d, 0.91).drum_angle_rad)) * 1e3
    with_wraps = path_data(BevelLayout(drive))["test_turn_mrad"]
    for way in ("positive", "negative"):
        assert len(with_wraps[way]) == 9
        for turn in with_wraps[way]:
            assert 0.8 * endless < abs(turn) <= endless * (1 + 1e-9), f"{turn} mrad, {endless} with endless wraps"
    assert with_wraps["positive"][4] * with_wraps["negative"][4] < 0


def test_torsional_modes_follow_the_inertias(drive: Drive) -> None:
    layout = BevelLayout(drive)
    stiffness = float(sticking_stiffness_Nm_rad(layout_of(drive).si))
    turns = {body.name: body.turns_per_drum for body in layout_of(drive).si.routes.passed}

    def modes(drum_kg_m2: float, inputs_kg_m2: float = 3e-6) -> Modes:
        inputs = dict.fromkeys((body.name for body in layout_of(drive).si.routes.inputs), inputs_kg_m2)
        own = BevelLayout(drive)
        own.__dict__["inertias_kg_m2"] = {"drum": drum_kg_m2, "guide": 2e-5 / turns["guide"] ** 2} | inputs
        return modes_of(own)

    found = modes(1e-4)
    expected = np.sqrt(stiffness / 1.2e-4) / (2 * np.pi)
    assert found.cables_alone_Hz == pytest.approx(expected)
    # In series with the cables: all that gives between the inputs' encoders and the drum's land.
    assert structure_of(layout) is not None
    before = 1e-6 * sum(c.urad_Nm for c in structure_of(layout).causes if not (c.in_drum or c.before_input))
    held = np.sqrt(1.0 / (1.0 / stiffness + before) / 1.2e-4) / (2 * np.pi)
    assert found.lowest_inputs_held_Hz == pytest.approx(held) and held < expected
    assert modes(4 * 1.2e-4 - 2e-5).lowest_inputs_held_Hz == pytest.approx(held / 2)
    assert len(found.inputs_free_Hz) == 4, found.inputs_free_Hz
    near = min(modes(1e-4, 1e3).inputs_free_Hz, key=lambda f: abs(f - held))
    assert near == pytest.approx(held, rel=1e-5), "inputs too heavy to move are held"


def test_a_payload_swings_on_cables_and_structure(drive: Drive) -> None:
    """So heavy that the drum counts little, it is one mass on all that gives: 0.2 kg at 150 mm, 4.5 g m2."""
    payload = Payload(mass_kg=0.2, distance_mm=150.0)
    heavy = replace(drive, loads=replace(drive.loads, payload=payload))
    modes, turns = modes_of(layout_of(heavy)), turns_of(layout_of(heavy))
    one_mass = np.sqrt(turns.felt.sticking_stiffness_Nm_rad / 4.5e-3) / (2 * np.pi)
    assert modes.payload_kg_m2 == pytest.approx(4.5e-3)
    # The drum, with 3 % of the inertia, takes less than that off.
    assert 0.98 * one_mass < modes.lowest_inputs_held_Hz < one_mass, (modes, one_mass)
    assert modes.cables_alone_Hz == modes_of(layout_of(drive)).cables_alone_Hz
    assert "payload of 0.0045 kg m^2" in analyse_design(heavy).text()


def test_a_design_without_parts_has_no_modes_and_says_why(drive: Drive, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("mbcdm_cad.parts.drum_sector.part.DrumSector._terms", lambda self: 1 / 0)
    found = analyse_design(replace(drive, name="without"))
    assert "No modes: the dimensions have no solution: division by zero" in found.text()
    assert found.to_dict()["modes"] is None
