"""A draft comes out for whatever a logger calls its columns, and takes angles for angles.

The run is made here: a drive of 8:1, with speeds, a command that leads the motor, a current and flags beside the
angles, each with noise of its own. Every header has the true columns of input and output beside it.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import yaml

from mbcdm_cad.cli import run as mbcdm
from mbcdm_cad.errors import InputError
from mbcdm_cad.measurement.draft import draft_text
from mbcdm_cad.measurement.reading import load_measurement
from mbcdm_cad.measurement.roles import Expected

RATIO = 8.0
DEG = 180.0 / np.pi
_random = np.random.default_rng(7)
TIME = np.arange(3000) * 0.02
OUTPUT = 0.5 * np.sin(2.0 * np.pi * TIME / 20.0)
INPUT = RATIO * OUTPUT + 1.5e-3 * np.sign(np.cos(2.0 * np.pi * TIME / 20.0))


def noisy(values: np.ndarray, sigma: float) -> np.ndarray:
    return values + sigma * _random.standard_normal(values.size)


SIGNALS = {
    "t": TIME,
    "t_ms": np.round(1e3 * TIME),
    "motor": noisy(INPUT, 2e-4),
    "joint": noisy(OUTPUT, 5e-5),
    "motor_deg": DEG * noisy(INPUT, 2e-4),
    "joint_deg": DEG * noisy(OUTPUT, 5e-5),
    "motor_counts": np.round(INPUT * 16384 / (2.0 * np.pi)),
    "joint_counts": np.round(OUTPUT * 16384 / (2.0 * np.pi)),
    "motor_turns": noisy(INPUT, 2e-4) / (2.0 * np.pi),
    "joint_turns": noisy(OUTPUT, 5e-5) / (2.0 * np.pi),
    "motor_speed": noisy(np.gradient(INPUT, TIME), 0.02),
    "joint_speed": noisy(np.gradient(OUTPUT, TIME), 0.004),
    "command": np.roll(INPUT, -2),
    "torque": noisy(0.3 * np.sign(np.cos(2.0 * np.pi * TIME / 20.0)), 0.01),
    "current": noisy(0.8 * np.cos(2.0 * np.pi * TIME / 20.0), 0.05),
    "flag": np.zeros_like(TIME),
    "warm": noisy(25.0 + TIME / 60.0, 0.05),
}
# The header, the signals of its columns, and the columns of input and output, from 0.
HEADERS: list[tuple[str, str, int, int]] = [
    ("t,q_m,q_l,tau", "t motor joint torque", 1, 2),
    (
        "timestamp,actuator_position,actuator_velocity,link_position,link_velocity",
        "t motor motor_speed joint joint_speed",
        1,
        3,
    ),
    ("time,motorPos,motorVel,jointPos,jointVel,motorTorque", "t motor motor_speed joint joint_speed torque", 1, 3),
    ("Time [s],Motor angle [deg],Output angle [deg],Torque [Nm]", "t motor_deg joint_deg torque", 1, 2),
    ("t,cmd_pos,fb_pos,load_pos", "t command motor joint", 2, 3),
    ("time_ms,enc_a,enc_b", "t_ms motor_counts joint_counts", 1, 2),
    ("time,theta1,theta2,dtheta1,dtheta2", "t motor joint motor_speed joint_speed", 1, 2),
    ("sec,input_deg,output_deg,temp_c", "t motor_deg joint_deg warm", 1, 2),
    ("/motor/position,/joint/position,time", "motor joint t", 0, 1),
    ("Zeit,Antrieb_Winkel,Abtrieb_Winkel,Strom", "t motor joint current", 1, 2),
    (
        "t,axis0.encoder.pos_estimate,axis1.encoder.pos_estimate,axis0.motor.current_control.Iq_measured",
        "t motor_turns joint_turns current",
        1,
        2,
    ),
    ("time,speed,current,angle,knee_angle", "t motor_speed current motor joint", 3, 4),
    ("time,setpoint,motor,pendulum_arm", "t command motor joint", 2, 3),
    ("ticks,status,servo,horn_pot", "t_ms flag motor joint", 2, 3),
    ("time,primary_encoder,secondary_encoder", "t motor_counts joint_counts", 1, 2),
    ("t,rotor,lever", "t motor joint", 1, 2),
    ("clock,mot_cur,mot_vel,mot_pos,drum_pos", "t current motor_speed motor joint", 3, 4),
    ("time,joint_pos,motor_pos", "t joint motor", 2, 1),
    ("time,col1,col2,col3", "t motor_speed motor joint", 2, 3),
    ("a,b,c", "t motor joint", 1, 2),
]


def write(folder: Path, header: str, signals: str) -> Path:
    rows = np.stack([SIGNALS[name] for name in signals.split()], axis=1)
    path = folder / "run.csv"
    path.write_text("\n".join([header, *(",".join(f"{value:.9g}" for value in row) for row in rows)]) + "\n")
    return path


@pytest.mark.parametrize(("header", "signals", "motor", "joint"), HEADERS, ids=[header for header, *_ in HEADERS])
def test_the_angles_are_found(tmp_path: Path, header: str, signals: str, motor: int, joint: int) -> None:
    draft = draft_text(write(tmp_path, header, signals), Expected.of_ratio(RATIO))
    columns, names = yaml.safe_load(draft)["columns"], header.split(",")
    assert columns["output"]["column"] == names[joint], draft
    assert columns["input"]["column"] == names[motor], draft
    (tmp_path / "run.yaml").write_text(draft)
    run = load_measurement(tmp_path / "run.yaml")
    slope = float(np.ptp(run.input_rad[0]) / np.ptp(run.output_rad))
    assert slope == pytest.approx(RATIO, rel=0.01), f"ratio as read {slope}\n{draft}"


def test_figures_without_names_are_told_by_number(tmp_path: Path) -> None:
    path = write(tmp_path, "x", "t motor joint")
    path.write_text(path.read_text().split("\n", 1)[1])
    columns = yaml.safe_load(draft_text(path, Expected.of_ratio(RATIO)))["columns"]
    assert [columns[name]["column"] for name in ("time", "input", "output")] == [1, 2, 3], columns


@pytest.mark.parametrize("greeting", ["Encoder test v3\nhoming... ok\n", "logger: joint 4; started 10:00\n", "\n"])
def test_a_greeting_is_not_taken_for_the_names(tmp_path: Path, greeting: str) -> None:
    path = write(tmp_path, "ms,steps,angle", "t_ms motor_counts joint_deg")
    path.write_text(greeting + path.read_text())
    draft = draft_text(path, Expected.of_ratio(RATIO))
    columns = yaml.safe_load(draft)["columns"]
    assert [columns[name]["column"] for name in ("time", "input", "output")] == ["ms", "steps", "angle"], draft
    assert f"skip_rows: {greeting.strip().count(chr(10)) + 1}" in draft or not greeting.strip(), draft


def test_labview_text_has_one_name_more_than_columns(tmp_path: Path) -> None:
    path = write(tmp_path, "x", "t motor joint")
    rows = path.read_text().split("\n", 1)[1].replace(",", "\t")
    head = "LabVIEW Measurement\t\nSeparator\tTab\n***End_of_Header***\t\n\t\nChannels\t2\t\nSamples\t3000\t3000\n"
    path.write_text(
        head + "X0\t0.0\t0.0\nDelta_X\t0.02\t0.02\n***End_of_Header***\nX_Value\tmotor\toutput\tComment\n" + rows
    )
    columns = yaml.safe_load(draft_text(path, Expected.of_ratio(RATIO)))["columns"]
    assert [columns[name]["column"] for name in ("time", "input", "output")] == ["X_Value", "motor", "output"], columns


def test_an_angle_that_begins_again_has_as_many_counts_a_turn(tmp_path: Path) -> None:
    """Both statements of the draft agree, also where the drive's encoder is said to be another one."""
    counts = np.round(OUTPUT * 3 * 4096 / (2.0 * np.pi)) + 300.0
    assert counts.min() < 0.0 < counts.max()
    rows = zip(TIME, SIGNALS["motor"] * 3, np.mod(counts, 4096), strict=True)
    path = tmp_path / "run.csv"
    path.write_text("t,servo,joint_enc\n" + "\n".join(f"{t:.3f},{m:.6f},{c:.0f}" for t, m, c in rows) + "\n")
    known = Expected("bench", ("input",), RATIO, 1.0, 9.0, 32768.0)
    output = yaml.safe_load(draft_text(path, known))["columns"]["output"]
    assert output["counts_per_turn"] == output["wraps_at"] == 4096, output


def test_a_ratio_is_enough(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    data = write(tmp_path, "time,motor_enc_deg,joint_enc_deg", "t motor_deg joint_deg")
    assert mbcdm(["measurement-init", str(data), "--ratio", "8"]) == 0
    assert yaml.safe_load((tmp_path / "run.yaml").read_text())["ratio"] == 8
    assert mbcdm(["measurement-init", str(data)]) == 2
    assert "give a design file or --ratio" in capsys.readouterr().err


def test_a_workbook_is_called_a_spreadsheet(tmp_path: Path) -> None:
    """Excel pads the first entries of its files with zeros, which is no UTF-16 text."""
    (tmp_path / "run.xlsx").write_bytes(b"PK\x03\x04" + bytes(600) + b"\n")
    with pytest.raises(InputError, match="a spreadsheet"):
        draft_text(tmp_path / "run.xlsx", Expected.of_ratio(RATIO))
