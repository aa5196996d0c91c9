"""Runs that differ: own values beside shared ones, odds of a change, trends over dates, mistakes in the file."""

import datetime
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.stats import multivariate_normal

import mbcdm_cad as mc
from mbcdm_cad import cli
from mbcdm_cad.errors import InputError
from mbcdm_cad.loop.judge import is_study, load_study
from mbcdm_cad.loop.search.engine import close_loop
from mbcdm_cad.loop.search.own import log_odds_of_change
from mbcdm_cad.loop.trend import best_course
from mbcdm_cad.measurement.run import KNOWN_LOAD, Run, Sensors, TorqueClass

RATIO, NOISE_RAD, STEP_RAD = 8.0, 3e-5, 2e-5
T = np.arange(0.0, 60.0, 0.02)
ANGLE = 0.6 * np.sin(2.0 * np.pi * T / 7.0)
SHARES = (1e-3, 2e-3, 3e-3, 4e-3)
FILE = """\
data: {name}.csv
ratio: 8.0
columns:
  time: {{column: t, unit: s}}
  input: {{column: a, unit: rad}}
  output: {{column: b, unit: rad}}
sensors: {{input_resolution_rad: 2.0e-5, output_resolution_rad: 2.0e-5}}
"""


def reading(share: float, seed: int) -> np.ndarray:
    """A ratio that is wrong by a share, and a line of 0.3 mrad at 40 cycles a turn, which all runs have."""
    noise = NOISE_RAD * np.random.default_rng(seed).normal(size=T.size)
    return np.asarray(ANGLE * (1.0 + share) + 3e-4 * np.sin(40.0 * ANGLE) + noise)


def run(share: float, seed: int) -> Run:
    sensors = Sensors(STEP_RAD, STEP_RAD)
    one = Run(T, RATIO * ANGLE[None], reading(share, seed), sensors=sensors, input_names=("input",), ratio=RATIO)
    object.__setattr__(one, "source", f"run {seed}")
    return one


def study(folder: Path, shares: tuple[float, ...], text: str = "", dates: bool = True) -> Path:
    (folder / "design.yaml").write_text((Path(__file__).parents[3] / "params" / "mbcdm-short.yaml").read_text())
    rows = []
    for k, share in enumerate(shares):
        table = np.column_stack([T, RATIO * ANGLE, reading(share, k)])
        np.savetxt(folder / f"r{k}.csv", table, delimiter=",", header="t,a,b", comments="")
        (folder / f"r{k}.yaml").write_text(FILE.format(name=f"r{k}"))
        date = f", date: {datetime.date(2026, 3, 1) + datetime.timedelta(days=10 * k)}" if dates else ""
        rows.append(f"  - {{run: r{k}.yaml{date}}}\n")
    path = folder / "study.yaml"
    path.write_text(f"design: design.yaml\n{text or 'differs: [ratio_error]'}\nruns:\n" + "".join(rows))
    return path


def test_each_run_has_its_own_value_and_all_share_the_rest() -> None:
    result = close_loop(None, [run(share, k) for k, share in enumerate(SHARES)], [("ratio_error",)] * 4)
    (own,) = result.own
    for share, one in zip(SHARES, own.runs, strict=True):
        value = one.figures["share"]
        assert abs(value.value - share) < 2.0 * (value.high - value.low), (share, value)
        assert value.value == pytest.approx(share, abs=1e-4), (share, value)
    assert own.log_odds > np.log(1e6) and "changed between the runs" in own.changed, own.changed
    assert [named.name for named in result.effects] == ["ripple"], result.sentence


def test_a_run_that_does_not_differ_is_told_so() -> None:
    result = close_loop(None, [run(0.0, k) for k in range(3)], [(), (), ("ratio_error",)])
    (own,) = result.own
    assert own.log_odds < -np.log(5.0) and "did not change from the other runs" in own.changed, own.changed


def test_the_odds_are_those_of_two_normal_models() -> None:
    values, covariance, likely = np.array([0.01, 0.03]), np.diag([1e-4, 2e-4]), np.array([0.1])
    same, moved = (multivariate_normal(np.zeros(2), c) for c in (covariance, covariance + 0.01 * np.eye(2)))
    odds = log_odds_of_change(values, covariance, np.repeat(likely, 2), 2, False)
    assert odds == pytest.approx(moved.logpdf(values) - same.logpdf(values), rel=1e-9)
    shifted = log_odds_of_change(values + 7.0, covariance, np.repeat(likely, 2), 2, True)
    assert shifted == pytest.approx(log_odds_of_change(values, covariance, np.repeat(likely, 2), 2, True), abs=1e-3)


@pytest.mark.parametrize(("shape", "name"), [(lambda d: d, "evenly"), (np.log1p, "settling"), (lambda d: 0 * d, "not")])
def test_the_course_is_found_with_its_slope(shape: object, name: str) -> None:
    days = np.arange(0.0, 140.0, 7.0)
    noise = np.random.default_rng(5).normal(size=days.size)
    values = 0.1 - 0.02 * shape(days) / max(float(np.ptp(shape(days))), 1e-9) + 5e-4 * noise  # type: ignore[operator]
    course = best_course(days, values, 2.5e-7 * np.eye(days.size))
    assert course.name.startswith(name), (course.name, course.log_odds)
    assert course.at(days) == pytest.approx(values, abs=2.5e-3)


def test_the_day_at_a_limit_and_its_interval() -> None:
    days = np.arange(0.0, 100.0, 10.0)
    course = best_course(days, 1.0 - 0.004 * days, 1e-6 * np.eye(days.size))
    day, earliest, latest = course.days_at(0.4, 90.0)
    assert earliest is not None and day is not None and latest is not None
    assert day == pytest.approx(150.0, abs=1.0) and earliest < 150.0 < latest < earliest + 20.0, (earliest, latest)
    assert course.days_at(-1e3, 90.0) == (None, None, None)


def test_a_trend_has_table_picture_day_and_sentence(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = study(tmp_path, SHARES, "differs: [ratio_error]\nlimits: {ratio_error: 0.006}")
    assert is_study(path) and not is_study(tmp_path / "r0.yaml")
    report = mc.trend(path)
    (trend,) = report.trends
    assert trend.day is not None and abs((trend.day - datetime.datetime(2026, 4, 20)).days) <= 3, trend.sentence
    assert "reached on 2026-04" in trend.sentence and report.picture().startswith(b"\x89PNG")
    assert cli.run(["trend", str(path), "--json", str(tmp_path / "t.json")]) == 0
    printed = capsys.readouterr().out
    assert trend.sentence in printed and "r3.csv" in printed and (tmp_path / "t.json").exists(), printed


def test_what_was_put_right_between_the_runs_has_changed_and_follows_no_course(tmp_path: Path) -> None:
    """Of a drive of which only the ratio is known, too."""
    path = study(tmp_path, (1e-3, 2.5e-3, 4e-3, 1e-3, 2.5e-3, 4e-3))
    path.write_text(path.read_text().replace("design: design.yaml\n", ""))
    (trend,) = mc.trend(path).trends
    assert "changed between the runs, odds over 1e6 to 1, but on no course over the dates" in trend.sentence
    assert "put right between the runs" in trend.sentence, trend.sentence


def test_an_own_value_has_the_form_that_explains_its_runs() -> None:
    """Friction behind what is soft winds up first: at once in its place it would be beside a play of all runs."""
    halves, runs = (1e-3, 2e-3), []
    for k, half in enumerate(halves):
        held = np.zeros(T.size)
        for i in range(1, T.size):
            held[i] = min(max(held[i - 1], ANGLE[i] - half), ANGLE[i] + half)
        noise = NOISE_RAD * np.random.default_rng(k).normal(size=T.size)
        runs.append(replace(run(0.0, k), output_rad=held + noise, load_Nm=np.sin(ANGLE)))
    result = close_loop(None, runs, [("friction",)] * 2)
    (own,) = result.own
    assert own.form == "what is soft winds up" and not result.effects, (own.form, result.sentence)
    for half, one in zip(halves, own.runs, strict=True):
        assert one.figures["half_width_rad"].value == pytest.approx(half, rel=0.05), own.lines()


@pytest.mark.slow
def test_loads_of_two_runs_that_were_exchanged_name_no_compliance_below_zero() -> None:
    """One that changes at the start of a run to less than none once explained them."""
    runs = []
    for k, (load, stated) in enumerate(((1.57, 0.59), (0.59, 1.57))):
        true = 1.3 / 0.6 * ANGLE
        noise = 1.5e-4 * np.random.default_rng(k).normal(size=T.size)
        read = true - 2.86e-3 * load * np.sin(true - 0.1) + 2.1e-3 * np.cos(true + 1.0) + noise
        sensors = Sensors(STEP_RAD, STEP_RAD, torque_class=TorqueClass(lag_s=0.0, what=KNOWN_LOAD))
        one = replace(run(0.0, k), input_rad=RATIO * true[None], output_rad=read, sensors=sensors)
        runs.append(replace(one, load_Nm=stated * np.sin(true - 0.1)))
    result = close_loop(None, runs)
    changed = [one for one in result.effects if one.name.startswith("change")]
    assert not changed and result.unknown is not None, result.sentence


@pytest.mark.parametrize(
    ("text", "dates", "words"),
    [
        ("differs: [preload]", True, "nothing called 'preload' can differ"),
        ("# nothing", True, "nothing differs in every run"),
        ("differs: [ratio_error]", False, "no date"),
        ("differs: [ratio_error]\nlimits: {rope.modulus_GPa: 40}", True, "a limit that no figure has"),
        ("differs: [ratio_error]\nlimits: {delay: 40}", True, "a limit of what does not differ"),
        ("differ: [ratio_error]", True, "differ"),
    ],
)
def test_mistakes_are_told(
    text: str, dates: bool, words: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = study(tmp_path, SHARES, text, dates)
    assert cli.run(["trend", str(path)]) == 2
    assert words in capsys.readouterr().err


def test_dates_run_forward(tmp_path: Path) -> None:
    path = study(tmp_path, SHARES[:2])
    path.write_text(path.read_text().replace("2026-03-11", "2026-02-11"))
    with pytest.raises(InputError, match="before the run above"):
        load_study(path)


def test_a_wave_of_the_drum_without_a_load_is_named_alone() -> None:
    """Beside a load that never moves no compliance can take part in it."""
    wave = 1e-3 * np.sin(ANGLE + 0.5) + NOISE_RAD * np.random.default_rng(3).normal(size=T.size)
    result = close_loop(None, [replace(run(0.0, 0), output_rad=ANGLE + wave, load_Nm=np.zeros(T.size))])
    assert [(one.name, one.stage) for one in result.effects] == [("once_per_rev", "drum")], result.sentence
    assert not result.one_of, result.sentence
