"""Logs as people have them: rows written several times, a device that was not ready, an input that counts backwards."""

from pathlib import Path

import numpy as np
import pytest
import yaml

from mbcdm_cad.errors import InputError
from mbcdm_cad.measurement.draft import draft_text
from mbcdm_cad.measurement.file import load_file
from mbcdm_cad.measurement.reading import load_measurement, read_run
from mbcdm_cad.measurement.roles import Expected
from mbcdm_cad.measurement.run import Run
from mbcdm_cad.measurement.vet import refusals, vet

_random = np.random.default_rng(11)
TIME = np.arange(4000) * 0.02
OUTPUT = 0.4 * np.sin(2.0 * np.pi * TIME / 16.0) + 2e-5 * _random.standard_normal(TIME.size)


def write(folder: Path, rows: np.ndarray, ratio: float = 8.0, **fields: object) -> Path:
    text = "t,motor,joint\n" + "\n".join(",".join(f"{value:.9g}" for value in row) for row in rows) + "\n"
    (folder / "run.csv").write_text(text)
    columns = {
        "time": {"column": "t", "unit": "s"},
        "input": {"column": "motor", "unit": "rad"},
        "output": {"column": "joint", "unit": "rad"},
    }
    path = folder / "run.yaml"
    path.write_text(yaml.safe_dump({"data": "run.csv", "ratio": ratio, "columns": columns, **fields}))
    return path


def rows(ratio: float = 8.0) -> np.ndarray:
    return np.stack([TIME, ratio * OUTPUT, OUTPUT], axis=1)


def read(path: Path) -> Run:
    return load_measurement(path)


def test_rows_that_repeat_the_time_are_left_out_where_broken_rows_are(tmp_path: Path) -> None:
    doubled = np.repeat(rows(), 4, axis=0)
    with pytest.raises(InputError, match=r"time stands still.*broken_rows: skip"):
        read(write(tmp_path, doubled))
    found = read_run(load_file(write(tmp_path, doubled, broken_rows="skip")))
    assert found.run.time_s.size == TIME.size, found.run.time_s.size
    assert "12000 rows of run.csv repeat the time of the row before: left out" in found.notes, found.notes


def test_a_fault_after_rows_that_were_left_out_is_told_with_its_line(tmp_path: Path) -> None:
    doubled = np.repeat(rows(), 2, axis=0)
    doubled[6000:6002, 1] = 1e6
    with pytest.raises(InputError) as caught:
        read(write(tmp_path, doubled, broken_rows="skip"))
    assert caught.value.problems[0].line == 6002, str(caught.value)


@pytest.mark.parametrize("count", [4, 120, 700])
def test_a_block_of_one_figure_at_the_start_is_told_with_its_lines(tmp_path: Path, count: int) -> None:
    """Not as another ratio or sign, to which the block leads."""
    made = rows()
    made[:count, 1:] = (370085.6, -370085.6)
    with pytest.raises(InputError) as caught:
        read(write(tmp_path, made))
    said = [problem.what for problem in caught.value.problems]
    assert said[0] == f"lines 2 to {count + 1} hold one figure of the input, far from all others", said
    assert len(said) == 2 and "output" in said[1], said


def test_a_drive_that_rests_first_is_no_such_block(tmp_path: Path) -> None:
    made = rows()
    made[:700, 1:] = made[700, 1:]
    assert read(write(tmp_path, made)).time_s.size == TIME.size


@pytest.mark.parametrize("ratio", [1.0, 1.03, 3.0])
def test_an_input_that_counts_backwards_is_told_so_also_at_ratio_1(tmp_path: Path, ratio: float) -> None:
    made = rows(1.0 if ratio < 2.0 else ratio)
    made[:, 1] *= -1.0
    (note,) = refusals(vet(read(write(tmp_path, made, ratio)), None))
    assert "turns against the output" in note.text and "swapped" not in note.text, note
    assert "scale: -1" in note.remedy, note


@pytest.mark.parametrize("cycles", [50, 100])
def test_a_run_of_whole_periods_has_a_slope(tmp_path: Path, cycles: int) -> None:
    """Pairs of samples that are whole periods apart show noise alone, and once hid the slope of 100 cycles."""
    made = rows()
    made[:, 2] = 0.4 * np.sin(2.0 * np.pi * cycles * np.arange(4000) / 4000) + 1e-3 * _random.standard_normal(4000)
    made[:, 1] = 8.0 * made[:, 2] + 8e-3 * _random.standard_normal(4000)
    assert refusals(vet(read(write(tmp_path, made)), None)) == []


def test_a_table_with_one_channel_a_row_is_told_as_such(tmp_path: Path) -> None:
    lines = []
    for t, motor, joint in rows():
        lines += [f"{t:.6f},{motor:.6f},", f"{t + 0.004:.6f},,{joint:.6f}"]
    path = write(tmp_path, rows()[:2], broken_rows="skip")
    (tmp_path / "run.csv").write_text("t,motor,joint\n" + "\n".join(lines) + "\n")
    with pytest.raises(InputError, match="each holds one channel with its own time"):
        read(path)
    assert "rows: own_times" in draft_text(tmp_path / "run.csv", Expected.of_ratio(8.0))


def _counts(angle_rad: np.ndarray, per_turn: int) -> np.ndarray:
    return np.round(angle_rad / (2.0 * np.pi) * per_turn).astype(int) % per_turn


def _drafted(log: Path) -> Run:
    """The run of a log by its draft alone, whose entries are the reader's and not a person's."""
    file = log.with_suffix(".yaml")
    file.write_text(draft_text(log, Expected.of_ratio(8.0)))
    return load_measurement(file)


def _is_the_run(run: Run, step: float) -> None:
    assert run.time_s.size >= TIME.size - 2
    at = run.time_s - run.time_s[0]
    assert np.allclose(run.output_rad - run.output_rad[0], np.interp(at, TIME, OUTPUT - OUTPUT[0]), atol=step)
    assert np.std(run.input_rad[0] - 8.0 * run.output_rad) < 8.0 * step


def test_a_log_of_ros_with_one_topic_a_row_and_its_time_in_two_columns(tmp_path: Path) -> None:
    lines, begun = ["sec,nanosec,topic,data"], 1795000000 * 10**9
    for t, angle in zip(TIME, OUTPUT, strict=True):
        for late, topic, figure in ((0, "/stepper/angle_rad", 8.0 * angle), (1_500_000, "/arm/angle_rad", angle)):
            at = begun + round(t * 1e9) + late
            lines.append(f"{at // 10**9},{at % 10**9},{topic},{figure:.9f}")
    (tmp_path / "topics.csv").write_text("\n".join(lines) + "\n")
    _is_the_run(_drafted(tmp_path / "topics.csv"), 4e-4)


def test_a_log_of_json_lines_is_read_but_for_its_greeting_and_a_line_that_was_cut(tmp_path: Path) -> None:
    lines = ['{"event": "boot", "firmware": "2.1"}']
    lines += [
        f'{{"ts": {1795000000 + t:.3f}, "motor": {{"count": {motor}, "ok": true}}, "joint": {{"count": {joint}}}}}'
        for t, motor, joint in zip(TIME, _counts(8.0 * OUTPUT, 4096), _counts(OUTPUT, 16384), strict=True)
    ]
    log = tmp_path / "run.jsonl"
    log.write_text("\n".join([*lines, lines[-1][:30]]) + "\n")
    _is_the_run(_drafted(log), 2.0 * np.pi / 16384)
    log.write_text("\n".join([*lines[1:], *('{"motor": 1, "ts": 2}' for _ in lines)]) + "\n")
    with pytest.raises(InputError, match="4000 of 8001 lines have other fields than most"):
        _drafted(log)


def test_counts_in_hexadecimal_digits_are_figures_and_frames_of_a_can_bus_are_told(tmp_path: Path) -> None:
    motor, joint = _counts(8.0 * OUTPUT, 4096), _counts(OUTPUT, 16384)
    lines = [f"{t:.3f},0x{a:04X},0x{b:04X}" for t, a, b in zip(TIME, motor, joint, strict=True)]
    (tmp_path / "hex.csv").write_text("\n".join(["Time,Motor_Pos,Arm_Pos", *lines]) + "\n")
    _is_the_run(_drafted(tmp_path / "hex.csv"), 2.0 * np.pi / 16384)
    for frame in ("(1795000000.010400) can0 102#0D6F", "  can0  102   [2]  0D 6F"):
        (tmp_path / "candump.log").write_text("\n".join([frame] * 200) + "\n")
        with pytest.raises(InputError, match=r"frames of a CAN bus.*DBC"):
            draft_text(tmp_path / "candump.log", Expected.of_ratio(8.0))


def test_too_many_broken_rows_are_told_with_what_the_first_holds(tmp_path: Path) -> None:
    path = write(tmp_path, rows(), broken_rows="skip")
    lines = (tmp_path / "run.csv").read_text().split("\n")
    lines[7:-1:9] = [line.rpartition(",")[0] + ",OVERRANGE" for line in lines[7:-1:9]]
    (tmp_path / "run.csv").write_text("\n".join(lines))
    with pytest.raises(InputError, match="the first has no number in 'joint' \\('OVERRANGE'\\)"):
        read(path)
