"""Logs as people have them: rows written several times, a device that was not ready, an input that counts backwards."""

from __future__ import annotations

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


def test_a_table_with_one_channel_a_row_is_told_as_such(tmp_path: Path) -> None:
    lines = []
    for t, motor, joint in rows():
        lines += [f"{t:.6f},{motor:.6f},", f"{t + 0.004:.6f},,{joint:.6f}"]
    path = write(tmp_path, rows()[:2], broken_rows="skip")
    (tmp_path / "run.csv").write_text("t,motor,joint\n" + "\n".join(lines) + "\n")
    with pytest.raises(InputError, match="each holds one channel with its own time"):
        read(path)
    assert "rows: own_times" in draft_text(tmp_path / "run.csv", Expected.of_ratio(8.0))
