"""The noise floor from the data: what does not repeat is noise, and what benches do beside the drive is no effect."""

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import yaml
from hypothesis import given
from hypothesis import strategies as st
from scipy.signal import butter, lfilter

from mbcdm_cad.errors import InputError
from mbcdm_cad.loop.effects import library
from mbcdm_cad.loop.judge import LoopReport, judge
from mbcdm_cad.loop.page import finding
from mbcdm_cad.loop.prepare.prepared import Prepared, prepare
from mbcdm_cad.loop.prepare.samples import locally_fitted, quiet_load, slow_difference, told_from_noise
from mbcdm_cad.loop.result import Noise, doubt_of
from mbcdm_cad.loop.search.by_evidence import Search
from mbcdm_cad.loop.search.evidence import NoiseModel
from mbcdm_cad.loop.search.fit import Fitter
from mbcdm_cad.measurement.file import load_file
from mbcdm_cad.measurement.run import Run, Sensors
from mbcdm_cad.routes import Floats

RATIO = 9.0
# A step of the output that makes 2 urad RMS.
SENSORS = Sensors(output_resolution_rad=2e-6 * np.sqrt(12.0))


def run(load: str = "steps", sweeps: int = 16, rate_hz: float = 100.0) -> Prepared:
    """A drive of ratio 9 swept +-0.4 rad, 5 s each way."""
    rng = np.random.default_rng(5)
    t = np.arange(0.0, 5.0 * sweeps, 1.0 / rate_hz)
    drum = 0.4 * np.sin(2.0 * np.pi * 0.1 * t)
    if load == "steps":
        tau = rng.uniform(-1.0, 1.0, 200)[np.searchsorted(np.cumsum(rng.uniform(2.0, 6.0, 200)), t)]
    else:
        tau = np.interp(t, np.arange(0.0, t[-1] + 3.0, 2.0), rng.uniform(-1.0, 1.0, int((t[-1] + 3.0) / 2.0) + 1))
    return prepare(Run(t, np.stack([RATIO * drum, RATIO * drum]), drum, tau, sensors=SENSORS), RATIO)[1]


def coloured(size: int, memory: int, seed: int) -> Floats:
    """Noise of RMS 1 that forgets itself in so many samples."""
    rng, out, keep = np.random.default_rng(seed), np.empty(size), np.exp(-1.0 / memory)
    out[0] = rng.normal()
    for k in range(1, size):
        out[k] = keep * out[k - 1] + np.sqrt(1.0 - keep**2) * rng.normal()
    return out


def found(p: Prepared, residual: Floats) -> NoiseModel:
    """The noise of a search that begins at this residual."""
    p = replace(p, output_rad=p.output_rad + residual)
    fitter = Fitter(None, RATIO, [p])
    return Search(fitter, library(None, p), fitter.fit()).white.noise


@pytest.mark.parametrize("load", ["steps", "by hand"])
@pytest.mark.parametrize(("white", "slow"), [(5e-6, 0.0), (4e-6, 6e-6)])
def test_white_and_coloured_noise_are_told_with_their_sizes(load: str, white: float, slow: float) -> None:
    p = run(load)
    rng = np.random.default_rng(1)
    noise = found(p, white * rng.normal(size=p.time_s.size) + slow * coloured(p.time_s.size, 50, 2))
    # Curves of an unknown cause take a part of slow noise.
    assert noise.floor_rad == pytest.approx(np.hypot(white, slow), rel=0.25 if slow else 0.1), noise
    assert noise.white_rad == pytest.approx(white, rel=0.15), noise
    assert noise.coloured_rad == pytest.approx(slow, rel=0.35, abs=0.3 * white), noise
    if slow:
        assert 0.2 < noise.memory_s < 1.0, noise


REPEATS = {
    "a bow in angle": lambda p: 2e-4 * p.output_rad**2,
    "a wave of the inputs": lambda p: 2e-5 * np.sin(9.0 * p.output_rad),
    "a fast line": lambda p: 2e-5 * np.sin(300.0 * p.output_rad),
    "a soft shaft": lambda p: 4e-5 * p.load_Nm,
    "a late sensor": lambda p: 2e-4 * p.speed_rad_s,
    "a sense of motion": lambda p: 2e-5 * np.sign(p.speed_rad_s),
    "warming": lambda p: 4e-5 * (1.0 - np.exp(-p.time_s / 20.0)),
    "a step": lambda p: 3e-5 * (p.time_s > 37.0),
}


@pytest.mark.parametrize("cause", REPEATS)
def test_what_repeats_or_happens_once_is_no_noise(cause: str) -> None:
    p = run()
    white = 5e-6 * np.random.default_rng(1).normal(size=p.time_s.size)
    noise = found(p, white + REPEATS[cause](p))
    assert noise.floor_rad == pytest.approx(5e-6, rel=0.2), (cause, noise)


def test_the_declared_steps_bound_the_floor_from_below() -> None:
    p = run()
    noise = found(p, 1e-7 * np.random.default_rng(1).normal(size=p.time_s.size))
    assert noise.floor_rad == pytest.approx(2e-6, rel=0.05), noise
    loud = Noise(9e-6, 9e-6, 0.0, 0.0, 2e-6, "")
    words = doubt_of(loud, "run.csv")
    assert loud.far_above and "noisier than declared" in words and "2 urad" in words, words


@pytest.mark.parametrize(("hz", "rate_hz"), [(0.2, 100.0), (1.0, 100.0), (2.5, 50.0), (2.5, 1000.0)])
def test_servos_that_track_unlike_are_kept_and_the_noise_is_not(hz: float, rate_hz: float) -> None:
    t = np.arange(0.0, 100.0, 1.0 / rate_hz)
    motion = 1.8e-4 * np.sin(2.0 * np.pi * hz * t) * (1.0 + 0.4 * np.sin(t / 7.0))
    noise = 9e-5 * np.random.default_rng(1).normal(size=t.size)
    kept, shortest_s = told_from_noise(motion + noise, 1e-6, 1.0 / rate_hz)
    miss = float(np.sqrt(np.mean((kept - motion)[50:-50] ** 2)))
    assert miss < 0.35 * 9e-5 and shortest_s < 1.0 / hz, (miss, shortest_s)


@pytest.mark.parametrize("loud", [1.0, 2.0])
def test_a_wandering_difference_keeps_its_power(loud: float) -> None:
    """The power of the motion eases the friction of the cables; the least square error would leave too little of it."""
    rate_hz, seconds = 50.0, 200.0
    rng = np.random.default_rng(3)
    shares, least_square = [], []
    for _ in range(6):
        wander = lfilter(*butter(2, [0.1, 1.5], "bandpass", fs=rate_hz), rng.normal(size=int(rate_hz * seconds)))
        wander *= 1e-4 / np.std(wander)
        noisy = wander + loud * 1e-4 * rng.normal(size=wander.size)
        kept, _ = told_from_noise(noisy, 1e-6, 1.0 / rate_hz)
        shares.append(float(np.var(kept) / np.var(wander)))
        # Per line the motion is so many times the noise; a Wiener filter keeps the square of its share of the power.
        over = 1.0 / loud**2 * 0.5 * rate_hz / 1.4
        least_square.append(over / (1.0 + over))
    print(
        f"noise {loud} of the motion: kept {np.mean(shares):.3f} of its power, by least squares {least_square[0]:.3f}"
    )
    assert np.mean(shares) == pytest.approx(1.0, abs=0.05)
    assert np.mean(shares) > np.mean(least_square)


def test_what_is_only_noise_is_taken_out() -> None:
    noise = 1e-4 * np.random.default_rng(1).normal(size=10_000)
    kept, _ = told_from_noise(noise, 1e-6, 0.01)
    assert float(np.sqrt(np.mean(kept**2))) < 0.1 * 1e-4, float(np.sqrt(np.mean(kept**2)))


@pytest.mark.parametrize("apart_steps", [0.0, 1.5])
@pytest.mark.parametrize("period_s", [16.0, 32.0])
def test_counting_steps_at_a_steady_speed_moves_no_servo(period_s: float, apart_steps: float) -> None:
    step = 1.9175e-4
    t = np.arange(0.0, 160.0, 0.01)
    drum = 0.45 * (2.0 / np.pi) * np.arcsin(np.sin(2.0 * np.pi * t / period_s))
    apart = 0.5 * apart_steps * step * np.sin(2.0 * np.pi * 0.8 * t)
    counted = [step * np.floor((RATIO * drum + sign * apart) / step + shift) for sign, shift in ((1, 0.2), (-1, 0.75))]
    seen = Run(t, np.stack(counted), drum, sensors=Sensors(input_resolution_rad=step))
    kept = slow_difference(seen)[0][0]
    miss = float(np.std((kept - apart)[100:-100])) / step
    as_counted = float(np.std(counted[0] - counted[1] - 2.0 * apart)) / step
    assert as_counted > 0.25, f"difference as counted is {as_counted:.3f} steps off"
    assert 2.0 * miss < 0.12, f"difference as kept is {2.0 * miss:.3f} steps off"


# The smoothing of the load: steps stay steps, waves lose little, noise falls.


TIME_S = np.arange(0.0, 60.0, 0.01)
LOADS = {
    "square": 0.8 * np.sign(np.sin(2.0 * np.pi * TIME_S / 7.3)),
    "ramps": 0.8 * np.clip(12.0 * np.sin(2.0 * np.pi * TIME_S / 7.3), -1.0, 1.0),
    "triangle": 0.8 * (2.0 / np.pi) * np.arcsin(np.sin(2.0 * np.pi * TIME_S / 9.1)),
    "sine": 0.8 * np.sin(2.0 * np.pi * TIME_S / 5.1),
}
# RMS error over that of the sensor which is allowed. A mean over 0.21 s without a bias would leave 0.22.
MOST_LEFT = {"square": 0.15, "ramps": 0.45, "triangle": 0.2, "sine": 0.3}


def smoothed(load_Nm: Floats, noise_Nm: float, seed: int) -> Floats:
    read = load_Nm + noise_Nm * np.random.default_rng(seed).standard_normal(load_Nm.size)
    return quiet_load(Run(TIME_S, np.zeros((1, TIME_S.size)), np.zeros_like(TIME_S), read))[0]


@pytest.mark.parametrize("kind", LOADS)
@pytest.mark.parametrize("noise_Nm", [0.005, 0.02])
def test_noise_falls_whatever_the_load_does(kind: str, noise_Nm: float) -> None:
    errors = np.array([smoothed(LOADS[kind], noise_Nm, seed) - LOADS[kind] for seed in range(8)])
    left = float(np.sqrt(np.mean(errors**2))) / noise_Nm
    print(f"{kind}, sensor {1e3 * noise_Nm:g} mNm: {left:.3f} of the noise is left")
    assert left < MOST_LEFT[kind]


@pytest.mark.parametrize("kind", ["square", "ramps"])
def test_the_extreme_loads_are_those_of_the_load_and_not_of_the_noise(kind: str) -> None:
    """They are what the friction of the cables remembers."""
    noise_Nm = 0.02
    beyond = [float(np.abs(smoothed(LOADS[kind], noise_Nm, seed)).max()) - 0.8 for seed in range(8)]
    print(f"{kind}: largest load {np.mean(beyond) / noise_Nm:+.2f} of the noise beyond the true one")
    # Of 6000 samples the most extreme is 3.8 standard deviations away.
    assert abs(np.mean(beyond)) < 0.8 * noise_Nm


def test_a_load_without_noise_stays_as_it_is() -> None:
    for kind, load in LOADS.items():
        worst = float(np.abs(smoothed(load, 0.0, 0) - load).max())
        print(f"{kind}: {worst:.2g} Nm")
        assert worst < 2e-3, kind


@given(st.floats(-5.0, 5.0), st.floats(0.01, 100.0), st.integers(0, 1000))
def test_units_and_zero_of_the_load_do_not_matter(zero: float, unit: float, seed: int) -> None:
    values = np.random.default_rng(seed).standard_normal(300) + np.repeat([0.0, 6.0, 1.0], 100)
    plain, width = locally_fitted(values, 1.0, 65)
    other, other_width = locally_fitted(unit * (values + zero), unit, 65)
    # Rounding may decide where two confidence intervals touch.
    assert np.mean(width == other_width) > 0.99
    same = width == other_width
    assert np.abs(other / unit - zero - plain)[same].max() < 1e-6


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
