"""Logs whose channels have their own times: empty cells, one channel a row; drafts of them; binary logs by name."""

import math
from pathlib import Path

import numpy as np
import pytest

import mbcdm_cad as mc
from mbcdm_cad.errors import InputError
from mbcdm_cad.measurement.reading import load_measurement

RATIO = 3.0
OWN = {"motor": (np.arange(0.0, 20.0, 0.01) + 3e-4, RATIO), "joint": (np.arange(0.0, 20.0, 0.02) + 5.1e-3, 1.0)}


def angle(t: np.ndarray) -> np.ndarray:
    return np.asarray(0.5 * np.sin(2.0 * math.pi * t / 4.0))


def rows() -> list[tuple[float, str, float]]:
    found = [(float(t), name, float(turns * angle(t))) for name, (times, turns) in OWN.items() for t in times]
    return sorted(found)


def written(folder: Path, kind: str) -> Path:
    path = folder / f"{kind}.csv"
    if kind == "long":
        lines = ["stamp,topic,value", *(f"{t:.4f},{name},{value:.9g}" for t, name, value in rows())]
    else:
        lines = ["t,motor,joint"]
        lines += [f"{t:.4f},{v:.9g}," if name == "motor" else f"{t:.4f},,{v:.9g}" for t, name, v in rows()]
    path.write_text("\n".join(lines) + "\n")
    return path


@pytest.mark.parametrize("kind", ["wide", "long"])
def test_the_draft_reads_each_channel_at_its_times(kind: str, tmp_path: Path) -> None:
    path = written(tmp_path, kind)
    text = mc.draft_measurement(path, ratio=RATIO)
    assert ("rows: own_times" in text) == (kind == "wide") and ("channel_column" in text) == (kind == "long"), text
    measured = path.with_suffix(".yaml")
    measured.write_text(text)
    run = load_measurement(measured)
    joint = OWN["joint"][0]
    assert run.time_s == pytest.approx(joint[(joint >= 3e-4) & (joint <= OWN["motor"][0][-1])], abs=1e-4)
    assert run.output_rad == pytest.approx(angle(run.time_s), abs=1e-8)
    # A straight line between two samples 0.01 s apart is wrong by an eighth of the curvature times the step squared.
    bent = RATIO * 0.5 * (math.pi / 2.0) ** 2 * 0.01**2 / 8.0
    assert np.abs(run.input_rad[0] - RATIO * angle(run.time_s)).max() < 1.1 * bent


def test_a_gap_of_one_channel_is_left_out(tmp_path: Path) -> None:
    lines = [line for line in written(tmp_path, "wide").read_text().split("\n") if not ("," in line and _in_gap(line))]
    (tmp_path / "gap.csv").write_text("\n".join(lines))
    (tmp_path / "gap.yaml").write_text(
        "data: gap.csv\nrows: own_times\nratio: 3\ncolumns:\n  time: {column: t, unit: s}\n"
        "  input: {column: motor, unit: rad}\n  output: {column: joint, unit: rad}\n"
    )
    run = load_measurement(tmp_path / "gap.yaml")
    assert not np.any((run.time_s > 5.01) & (run.time_s < 5.99)) and run.time_s[-1] > 19.9


def _in_gap(line: str) -> bool:
    cells = line.split(",")
    return cells[0] != "t" and 5.0 < float(cells[0]) < 6.0 and cells[1] != ""


def test_a_channel_that_is_not_there_is_told(tmp_path: Path) -> None:
    written(tmp_path, "long")
    text = (
        "data: long.csv\nchannel_column: topic\nratio: 3\ncolumns:\n  time: {column: stamp, unit: s}\n"
        "  input: {column: value, channel: motr, unit: rad}\n  output: {column: value, channel: joint, unit: rad}\n"
    )
    (tmp_path / "r.yaml").write_text(text)
    with pytest.raises(InputError, match="no samples of input in channel 'motr'"):
        load_measurement(tmp_path / "r.yaml")
    (tmp_path / "r.yaml").write_text(text.replace("channel: motr, ", ""))
    with pytest.raises(InputError, match="no channel, where rows hold one each"):
        load_measurement(tmp_path / "r.yaml")
