"""What ordinary benches do, on runs written by hand: numbers only, none of the loop's own code makes them."""

import re
from pathlib import Path

import numpy as np
import pytest
import yaml

from mbcdm_cad.errors import InputError
from mbcdm_cad.loop.judge import LoopReport, judge
from mbcdm_cad.loop.page.plain import finding
from mbcdm_cad.measurement.file import load_file

DESIGN = {
    "name": "bench",
    "configuration": "siso_spur",
    "travel": {"half_angle_deg": 45.0},
    "transmission": {"input_to_drum": 3.0},
    "loads": {"peak_torque_Nm": 2.0},
}


def followed(x: np.ndarray, play: float) -> np.ndarray:
    """Play taken up by motion."""
    y = x.copy()
    for k in range(1, x.size):
        y[k] = min(max(y[k - 1], x[k] - play / 2.0), x[k] + play / 2.0)
    return y


def measured(
    folder: Path, t: np.ndarray, motor: np.ndarray, out: np.ndarray, name: str = "run", **fields: object
) -> Path:
    """A CSV and its measurement file; ``tau`` and ``warm`` are a load and a temperature."""
    rows: dict[str, object] = {"t": t, "motor": motor, "out": out}
    rows |= {key: fields.pop(key) for key in ("tau", "warm") if key in fields}
    told = {"t": "time s", "motor": "input rad", "out": "output rad"}
    told |= {"tau": "load_torque N*m", "warm": "temperature degC"}
    columns = {(words := told[key].split())[0]: {"column": key, "unit": words[1]} for key in rows}
    table = np.column_stack([*rows.values()])  # type: ignore[arg-type]
    np.savetxt(folder / f"{name}.csv", table, delimiter=",", header=",".join(rows), comments="", fmt="%.7f")
    path = folder / f"{name}.yaml"
    path.write_text(yaml.safe_dump({"data": f"{name}.csv", "columns": columns, **fields}))
    return path


def with_a_rest(seed: int) -> tuple[np.random.Generator, np.ndarray, np.ndarray]:
    """Noise, time and angle at two speeds and with a rest, so that the path is no time."""
    t = np.arange(0.0, 90.0, 0.04)
    moved = np.where(t < 40.0, t, np.where(t < 50.0, 40.0, 40.0 + 1.5 * (t - 50.0)))
    return np.random.default_rng(seed), t, 0.5 * np.sin(2.0 * np.pi * moved / 8.0)


def judged(folder: Path, *files: Path) -> LoopReport:
    from mbcdm_cad.layouts.loader import load_design

    design = folder / "design.yaml"
    design.write_text(yaml.safe_dump(DESIGN))
    return judge(load_design(design), [load_file(file) for file in files])


def names(report: LoopReport) -> list[str]:
    return [one.name for one in report.result.effects]


def value(report: LoopReport, figure: str, effect: int = 0) -> float:
    return report.result.effects[effect].parameters[figure].value


@pytest.mark.parametrize("late", [0.03, -0.02])
def test_a_late_input_is_told_from_a_late_output(tmp_path: Path, late: float) -> None:
    rng = np.random.default_rng(3)
    t = np.arange(0.0, 60.0, 0.04)
    out, motor = (0.5 * np.sin(2.0 * np.pi * (t - lag) / 8.0) for lag in (max(-late, 0.0), max(late, 0.0)))
    noisy = out + 1e-4 * rng.standard_normal(t.size)
    report = judged(tmp_path, measured(tmp_path, t, 8.0 * motor, noisy, ratio=8.0))
    assert names(report) == ["delay"] and abs(value(report, "delay_s") + late) < 5e-4, report.result.sentence
    first, second = ("input", "output") if late > 0.0 else ("output", "input")
    said = report.result.effects[0].physics
    assert f"the {first} is read later than the {second}" in said, said
    assert f"{first} is read" in finding(report.result).lower(), finding(report.result)


@pytest.mark.parametrize("side", ["both", "negative"])
def test_a_counter_that_loses_counts_is_named_by_its_share_of_the_path(tmp_path: Path, side: str) -> None:
    rng, t, angle = with_a_rest(4)
    step = np.diff(angle, prepend=angle[0])
    lost = 0.003 * (np.abs(step) if side == "both" else np.maximum(-step, 0.0))
    out = angle + np.cumsum(lost) + 1e-4 * rng.standard_normal(t.size)
    report = judged(tmp_path, measured(tmp_path, t, 5.0 * angle, out, ratio=5.0))
    assert names(report) == ["lost_counts"], report.result.sentence
    assert side in report.result.effects[0].form
    assert value(report, "share") == pytest.approx(0.003, rel=0.01), report.result.sentence


def test_a_drift_in_time_is_no_lost_counts(tmp_path: Path) -> None:
    rng, t, angle = with_a_rest(5)
    out = angle + 2e-4 * t + 1e-4 * rng.standard_normal(t.size)
    report = judged(tmp_path, measured(tmp_path, t, 5.0 * angle, out, ratio=5.0))
    assert names(report) == ["thermal_drift"], report.result.sentence
    assert value(report, "rate_rad_s") == pytest.approx(2e-4, rel=0.02), report.result.sentence


def test_a_part_that_warms_behind_the_thermometer_does_not_creep(tmp_path: Path) -> None:
    """The answer of a first-order lag of 20 s to air that warms with 30 s, in closed form."""
    rng, t, angle = with_a_rest(11)
    behind = 1.0 - 3.0 * np.exp(-t / 30.0) + 2.0 * np.exp(-t / 20.0)
    out = angle - 2e-3 * behind + 1e-4 * rng.standard_normal(t.size)
    file = measured(tmp_path, t, 5.0 * angle, out, ratio=5.0, warm=20.0 + 5.0 * (1.0 - np.exp(-t / 30.0)))
    report = judged(tmp_path, file)
    assert names(report) == ["thermal_drift"], report.result.sentence
    assert value(report, "turn_rad_K") == pytest.approx(-4e-4, rel=0.02), report.result.sentence
    assert value(report, "time_constant_s") == pytest.approx(20.0, rel=0.1), report.result.sentence


def test_a_large_line_has_no_overtones_that_are_not_there(tmp_path: Path) -> None:
    """Amplitude times order 0.6: over the wrong reading the line would have five overtones."""
    rng = np.random.default_rng(6)
    t = np.arange(0.0, 120.0, 0.04)
    angle = 3.0 * np.pi * (0.5 - np.arcsin(np.sin(2.0 * np.pi * t / 12.0 + 0.3)) / np.pi)
    out = angle + 0.12 * np.cos(5.0 * angle + 0.5) + 2e-3 * rng.standard_normal(t.size)
    report = judged(tmp_path, measured(tmp_path, t, angle, out, ratio=1.0))
    assert names(report) == ["ripple"], report.result.sentence
    assert value(report, "amplitude_rad") == pytest.approx(0.12, rel=0.01), report.result.sentence
    assert value(report, "cycles_per_output_rev") == pytest.approx(5.0, abs=0.02), report.result.sentence


def test_a_ratio_that_changes_along_one_stroke_is_a_bow_and_no_eccentric_disc(tmp_path: Path) -> None:
    rng = np.random.default_rng(7)
    t = np.arange(0.0, 15.0, 0.02)
    out = 0.75 * np.clip((t - 7.5) / 6.5, -1.0, 1.0)
    noisy = out + 3e-4 * rng.standard_normal(t.size)
    report = judged(tmp_path, measured(tmp_path, t, 12.0 * (out + 0.15 * out**2), noisy, ratio=12.0))
    assert names(report) == ["bow"] and not report.result.one_of, report.result.sentence
    assert value(report, "height_rad") == pytest.approx(0.5 * 0.15 * 0.75**2, rel=0.02), report.result.sentence
    assert "of the time" in report.result.errors.held_out, report.result.errors.held_out


@pytest.mark.parametrize("way", ["ratio", "load: none", "zeros"])
def test_play_without_a_load_is_the_same_finding_however_the_missing_load_is_told(tmp_path: Path, way: str) -> None:
    rng = np.random.default_rng(8)
    t = np.arange(0.0, 80.0, 0.04)
    angle = 0.5 * np.sin(2.0 * np.pi * t / 16.0)
    out = followed(angle, 0.012) + 5e-5 * rng.standard_normal(t.size)
    given: dict[str, object] = {"ratio": {"ratio": 3.0}, "load: none": {"load": "none"}, "zeros": {"tau": 0.0 * t}}[way]
    report = judged(tmp_path, measured(tmp_path, t, 3.0 * angle, out, **given))  # type: ignore[arg-type]
    assert names(report) == ["lash"], report.result.sentence
    assert value(report, "play_rad") == pytest.approx(0.012, rel=0.01), report.result.sentence


def test_no_load_beside_a_torque_column_is_refused(tmp_path: Path) -> None:
    t = np.arange(0.0, 8.0, 0.02)
    with pytest.raises(InputError, match=r"run.yaml:\d+: load: given beside columns.load_torque"):
        load_file(measured(tmp_path, t, t, t, tau=t, load="none"))


def test_trials_in_several_files_repeat_each_other(tmp_path: Path) -> None:
    """Six files of one cycle: the same finding as from one file of six cycles."""
    rng = np.random.default_rng(9)
    t = np.arange(0.0, 10.0, 0.02)
    angle = 0.5 * np.sin(2.0 * np.pi * t / 10.0)
    files = []
    for k in range(6):
        begin = np.concatenate([angle, angle])
        out = followed(begin, 0.02)[t.size :] + 0.004 * np.cos(angle - 0.7) + 1e-4 * rng.standard_normal(t.size)
        files.append(measured(tmp_path, t, 3.0 * angle, out, name=f"trial{k}", ratio=3.0))
    report = judged(tmp_path, *files)
    # Beside a play of four times the wave another curve of the angle is nearly as good within this travel: a set.
    assert names(report) == ["lash"] and report.verdict == "explained", report.result.sentence
    assert "nothing repeats" not in report.text(), report.text()
    (lash,), (waves,) = report.result.effects, report.result.one_of
    wave = waves[0]
    assert wave.name == "once_per_rev", report.result.sentence
    assert lash.parameters["play_rad"].value == pytest.approx(0.02, rel=0.01)
    assert wave.parameters["amplitude_rad"].value == pytest.approx(0.004, rel=0.1)
    numbers = [int(word) for word in re.findall(r"half sweep (\d)", report.result.errors.held_out)]
    assert numbers and max(numbers) <= 3, report.result.errors.held_out


def test_what_looks_the_same_is_only_what_fits_as_well(tmp_path: Path) -> None:
    """The forms of lost counts differ by a ratio error, which these runs tell."""
    rng = np.random.default_rng(10)
    t = np.arange(0.0, 80.0, 0.04)
    angle = 0.5 * np.sin(2.0 * np.pi * t / 8.0)
    path = np.cumsum(np.abs(np.diff(angle, prepend=angle[0])))
    out = angle + 0.003 * path + 1e-4 * rng.standard_normal(t.size)
    report = judged(tmp_path, measured(tmp_path, t, 5.0 * angle, out, ratio=5.0))
    assert names(report) == ["lost_counts"] and report.result.effects[0].equivalent == (), report.text()
