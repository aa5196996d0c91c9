"""A draft comes out for whatever a logger calls its columns, and takes angles for angles.

The run is made here: a drive of 8:1, with speeds, a command that leads the motor, a current and flags beside the
angles, each with noise of its own. Every header has the true columns of input and output beside it.
"""

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
    "t_us": np.round(1e6 * TIME),
    "t_ns": np.round(1e9 * TIME) + 1.7e18,
    "row": np.arange(TIME.size, dtype=float),
    "word": np.full(TIME.size, np.nan),
    "command_deg": DEG * np.roll(INPUT, -2),
    "command_counts": np.round(np.roll(INPUT, -2) * 16384 / (2.0 * np.pi)),
    "motor_turn_speed": noisy(np.gradient(INPUT, TIME), 0.02) / (2.0 * np.pi),
    "warm": noisy(25.0 + TIME / 60.0, 0.05),
}
# Headers and the signals of their columns in turn, those of input and output marked.
LINES = [
    line for line in (Path(__file__).parent / "headers.txt").read_text("utf-8").splitlines() if line and line[0] != "#"
]


def write(folder: Path, header: str, signals: str) -> Path:
    rows = np.stack([SIGNALS[name] for name in signals.split()], axis=1)
    path = folder / "run.csv"
    sign = ";" if ";" in header else ","
    lines = (
        sign.join("base" if np.isnan(value) else f"{value:.9g}" if value < 1e15 else f"{value:.0f}" for value in row)
        for row in rows
    )
    path.write_text("\n".join([header, *lines]) + "\n")
    return path


@pytest.mark.parametrize(("header", "marked"), list(zip(LINES[::2], LINES[1::2], strict=True)), ids=LINES[::2])
def test_the_angles_are_found(tmp_path: Path, header: str, marked: str) -> None:
    signals = marked.replace("*", "")
    motor, joint = (
        next(k for k, one in enumerate(marked.split()) if one.startswith(f"*{w}")) for w in ("motor", "joint")
    )
    draft = draft_text(write(tmp_path, header, signals), Expected.of_ratio(RATIO))
    columns, names = yaml.safe_load(draft)["columns"], header.replace('"', "").split(";" if ";" in header else ",")
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


@pytest.mark.parametrize("before", ["", "Bench of joint 4\nhoming... ok\n"])
@pytest.mark.parametrize("sign", [",", "\t", " "])
def test_rows_of_a_serial_plotter_have_the_names_before_colons(tmp_path: Path, sign: str, before: str) -> None:
    rows = zip(SIGNALS["motor_deg"], SIGNALS["joint_deg"], strict=True)
    lines = [f"motor:{m:.4f}{sign}joint:{j:.4f}" for m, j in rows]
    (tmp_path / "run.txt").write_text(before + "\n".join(lines) + "\n")
    draft = draft_text(tmp_path / "run.txt", Expected.of_ratio(RATIO))
    (tmp_path / "run.yaml").write_text(draft)
    with pytest.raises(InputError, match=r"run.yaml:\d: sample_rate_Hz: not a number"):
        load_measurement(tmp_path / "run.yaml")
    (tmp_path / "run.yaml").write_text(draft.replace("'?'", "50"))
    run = load_measurement(tmp_path / "run.yaml")
    assert run.time_s[1] == pytest.approx(0.02) and np.allclose(run.output_rad, SIGNALS["joint_deg"] / DEG, atol=1e-6)


@pytest.mark.parametrize("labels", [True, False])
def test_a_serial_monitor_writes_a_time_of_day_and_an_arrow(tmp_path: Path, labels: bool) -> None:
    rows = zip(TIME, SIGNALS["motor_deg"], SIGNALS["joint_deg"], strict=True)
    names = ("motor:", "joint:") if labels else ("", "")
    lines = [f"12:{int(t // 60):02d}:{t % 60:06.3f} -> {names[0]}{m:.4f},{names[1]}{j:.4f}" for t, m, j in rows]
    (tmp_path / "run.txt").write_text("\n".join(lines) + "\n")
    (tmp_path / "run.yaml").write_text(draft_text(tmp_path / "run.txt", Expected.of_ratio(RATIO)))
    run = load_measurement(tmp_path / "run.yaml")
    assert np.allclose(np.diff(run.time_s), 0.02) and np.allclose(run.input_rad, SIGNALS["motor_deg"] / DEG, atol=1e-6)


def test_a_motion_camera_numbers_its_frames(tmp_path: Path) -> None:
    """Vicon writes the device, the rate, names of the subjects, the columns, their units; no time."""
    head = "Devices\n50\n,,Motor,Joint\nFrame,Sub Frame,Pot motor,Pot joint\n,,deg,deg\n"
    rows = enumerate(zip(SIGNALS["motor_deg"], SIGNALS["joint_deg"], strict=True), 1)
    (tmp_path / "run.csv").write_text(head + "".join(f"{k},0,{m:.4f},{j:.4f}\n" for k, (m, j) in rows))
    draft = draft_text(tmp_path / "run.csv", Expected.of_ratio(RATIO))
    (tmp_path / "run.yaml").write_text(draft.replace("'?'", "50"))
    run = load_measurement(tmp_path / "run.yaml")
    assert run.time_s[-1] == pytest.approx(TIME[-1]), draft
    assert np.allclose(run.output_rad, SIGNALS["joint_deg"] / DEG, atol=1e-6), draft


def test_a_dial_gauge_on_an_arm_is_an_angle(tmp_path: Path) -> None:
    rows = np.stack([TIME, SIGNALS["motor_deg"], 80.0 * SIGNALS["joint"]], axis=1)
    lines = [",".join(f"{value:.6f}" for value in row) for row in rows]
    (tmp_path / "run.csv").write_text("\n".join(["t,motor_deg,gauge_mm", *lines]) + "\n")
    draft = draft_text(tmp_path / "run.csv", Expected.of_ratio(RATIO))
    output = yaml.safe_load(draft)["columns"]["output"]
    assert output["unit"] == "mm" and output["radius_mm"] == pytest.approx(80.0, rel=1e-3), draft
    text = draft.replace(f"radius_mm: {output['radius_mm']:g}", "radius_mm: 80")
    (tmp_path / "run.yaml").write_text(text)
    assert np.allclose(load_measurement(tmp_path / "run.yaml").output_rad, SIGNALS["joint"], atol=1e-6)
    (tmp_path / "run.yaml").write_text(text.replace(", radius_mm: 80", ""))
    with pytest.raises(InputError, match=r"a length without its radius.*give radius_mm"):
        load_measurement(tmp_path / "run.yaml")
    (tmp_path / "run.yaml").write_text(text.replace("unit: mm", "unit: deg"))
    with pytest.raises(InputError, match="radius_mm: given beside unit deg"):
        load_measurement(tmp_path / "run.yaml")


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("time: {column: t, unit: s}\n  ", "", "columns.time: missing.*sample_rate_Hz"),
        ("data:", "sample_rate_Hz: 50\ndata:", "sample_rate_Hz: given beside columns.time"),
        ("time: {column: t, unit: s}", "time:", "columns.time"),
    ],
)
def test_a_run_needs_one_time(tmp_path: Path, old: str, new: str, words: str) -> None:
    write(tmp_path, "t,motor,joint", "t motor joint")
    text = "data: run.csv\nratio: 8\ncolumns:\n  time: {column: t, unit: s}\n  "
    text += "input: {column: motor, unit: rad}\n  output: {column: joint, unit: rad}\n"
    (tmp_path / "run.yaml").write_text(text.replace(old, new))
    with pytest.raises(InputError, match=words):
        load_measurement(tmp_path / "run.yaml")
