"""The report on the preload: shares that agree with other reports, the procedure's files, logs and nuts."""

from __future__ import annotations

import shutil
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import mbcdm_cad as mc
from mbcdm_cad.layouts import preload

PARAMS = Path(__file__).parents[3] / "params"


@pytest.fixture(scope="module")
def design() -> mc.DriveDesign:
    return mc.load(PARAMS / "mbcdm.yaml")


def log_of(design: mc.DriveDesign, path: Path, factors: list[float], at_motor: bool = False) -> Path:
    """A log of the first input's ramps on a drive whose preloads differ by factors, without noise."""
    layout = design.drive.layout
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
    with pytest.raises(mc.MbcdmError, match=r"log.csv:3: not a number"):
        design.preload(logs={"left": path})
    with pytest.raises(mc.MbcdmError, match="no input middle"):
        design.preload(logs={"middle": log_of(design, path, [1.0] * 4)})
    spur = mc.load(PARAMS / "siso_spur.yaml").preload()
    assert not spur.ramps and "slips there" in str(spur)
