"""The finding in plain words: a clause for every effect, rounded figures, true sentences; the correction."""

import json
import re
import shutil
import subprocess
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from mbcdm_cad.layouts.loader import layout_of, load_design
from mbcdm_cad.loop.correction import Correction, correction_files, correction_of, directions
from mbcdm_cad.loop.effect import Effect
from mbcdm_cad.loop.effects import library
from mbcdm_cad.loop.page import certainty, described, finding, rounded, steps
from mbcdm_cad.loop.prepare.prepared import prepare
from mbcdm_cad.loop.readable import Value, readable, size_of
from mbcdm_cad.loop.result import NEAR_FLOOR, Errors, LoopResult, Named, result_text
from mbcdm_cad.loop.search.engine import close_loop
from mbcdm_cad.loop.search.fit import Fitter
from mbcdm_cad.loop.search.unknown import Unknown
from mbcdm_cad.measurement.run import Run, Sensors
from mbcdm_cad.measurement.vet import refusals, vet
from mbcdm_cad.routes import Floats

D = layout_of(load_design(Path(__file__).parents[3] / "params" / "mbcdm.yaml").drive).si


def effects() -> list[Effect]:
    """Every effect: of a drive that is known, with temperature and without, and of a ratio alone."""
    t = np.arange(0.0, 80.0, 0.05)
    angle = 0.4 * np.sin(t)
    full = Run(t, np.stack([9.0 * angle, 9.0 * angle]), angle, np.cos(t), 20.0 + t / 80.0)
    ready, cold = prepare(full, 9.0)[0], prepare(replace(full, temperature_C=None), 9.0)[0]
    offered = [*library(D, ready), *library(D, cold), *library(None, ready)]
    return list({effect.label: effect for effect in offered}.values())


EFFECTS = {effect.label: effect for effect in effects()}


def named(label: str, share: float | None = None) -> Named:
    effect = EFFECTS[label]
    figures = {figure.name: Value(0.25, 0.24, 0.26) for figure in effect.reported()}
    if share is not None:
        figures["share"] = Value(share, 1.05 * share, 0.95 * share)
    where = effect.where_to_look, effect.separate_by, effect.physics
    key = effect.name, effect.form, effect.stage, effect.cables
    return Named(*key, figures, {}, (), *where, 0.0, {}, {}, effect.plain)


@pytest.mark.parametrize("label", EFFECTS)
def test_every_effect_has_a_clause_without_identifiers(label: str) -> None:
    words = described(named(label))
    print(words)
    assert EFFECTS[label].plain and words != EFFECTS[label].plain, words
    assert not set("_{}") & set(words) and "  " not in words, words


@pytest.mark.parametrize(
    ("name", "value", "shown"),
    [
        ("share", Value(-0.39963, -0.40134, -0.39785), "40.0 %"),
        ("play_rad", Value(1.2344e-3, 1.1e-3, 1.4e-3), "1.2 mrad"),
        ("play_rad", Value(3.014e-3, 3.014e-3, float("inf")), "at least 3 mrad"),
        ("eccentricity_m", Value(9.948e-6, 9.878e-6, 10.02e-6), "9.95 um"),
        ("torque_Nm", Value(0.1203, 0.1203, 0.1203), "120 mN m"),
    ],
)
def test_figures_are_rounded_to_their_intervals(name: str, value: Value, shown: str) -> None:
    assert rounded(name, value) == shown


def result(verdict: str, effects: tuple[Named, ...] = (), sets: tuple[tuple[Named, ...], ...] = ()) -> LoopResult:
    errors = Errors(Value(2e-4, 1e-4, 3e-4), Value(5e-6, 4e-6, 6e-6), 3e-4, 1e-5, 5e-6, 1.0, "half sweeps 2, 3")
    return LoopResult(verdict, effects, sets, None, errors, (), (), (), (), {})


def test_the_finding_says_what_how_sure_and_what_to_do() -> None:
    one, other = named("preload_error cable_4 (one cable)", -0.4), named("cable_friction (rope on pulley)", -0.4)
    nothing, single, either = result("none"), result("explained", (one,)), result("explained", (), ((one, other),))
    assert finding(nothing).startswith("Nothing is missing") and certainty(nothing) == "" and steps(nothing) == []
    assert finding(single) == "The tension of cable 4 is 40 % lower than the design file says."
    assert "38 to 42 %" in certainty(single) and "plucking" in steps(single)[0], (certainty(single), steps(single))
    assert finding(either).startswith("Either the tension of cable 4") and " or the friction" in finding(either)
    assert "cannot show" in certainty(either) and "re-tension" in steps(either)[0], (certainty(either), steps(either))
    left = Unknown(8e-6, 2e-5, 5e-6, (), (), 0.1, (), (7e-6, 9e-6))
    assert finding(replace(result("unknown"), unknown=left)) == "Something unknown is left, 8 urad RMS."
    partly = replace(single, unknown=left, verdict="partly_explained")
    assert finding(partly).endswith("the design file says; something unknown is left, 8 urad RMS.")


def test_a_size_without_bounds_is_not_told_as_at_least_nothing() -> None:
    open_ = Value(1e-4, 0.0, np.inf)
    assert rounded("compliance_rad_Nm", open_) == "a size that these runs leave open"


def odd_bench(seed: int) -> Run:
    """A bench with some faults of drive, sensors and logger at once, of any size, and noise that may be of any kind."""
    rng = np.random.default_rng([seed, 35])
    rate, cycles = float(rng.choice([10.0, 20.0, 40.0])), float(rng.uniform(0.6, 8.0))
    t = np.arange(0.0, 60.0, 1.0 / rate)
    ratio = float(rng.choice([1.0, 3.0, 9.5, 40.0]))
    phase = 2.0 * np.pi * cycles * t / t[-1]
    angle = float(rng.choice([0.2, 0.5, 3.0])) * (np.sin(phase) if rng.random() < 0.6 else np.arcsin(np.sin(phase)))
    load = (
        None if rng.random() < 0.4 else rng.uniform(0.1, 2.0) * np.sin(2.0 * np.pi * t / rng.uniform(3.0, 40.0) + 1.0)
    )
    size = float(10.0 ** rng.uniform(-4.0, -2.0))

    def maybe(shape: Floats) -> Floats:
        return size * rng.normal() * shape if rng.random() < 0.2 else np.zeros_like(t)

    out = angle.copy()
    path = np.cumsum(np.abs(np.diff(angle, prepend=angle[0])))
    shapes = [
        np.cos(angle + 1.0),
        np.cos(7.3 * angle),
        t / t[-1],
        np.log1p(t / 3.0),
        np.sign(t - rng.uniform(5.0, 55.0)),
    ]
    shapes += [angle, angle**2, np.gradient(angle, t), path, np.sign(np.gradient(angle, t))]
    shapes += [np.exp(-((angle - 0.1) ** 2) / 0.002), np.abs(np.gradient(angle, t)) ** 1.5]
    if load is not None:
        shapes += [load, np.sign(load), load * np.abs(load), np.where(t > 30.0, load, 0.0)]
    out = out + sum(maybe(shape) for shape in shapes)
    white = float(10.0 ** rng.uniform(-5.0, -3.0))
    noise = white * rng.standard_normal(t.size)
    kind = rng.integers(0, 5)
    if kind == 1:
        noise *= 1.0 + 5.0 * (t > 30.0)
    elif kind == 2:
        noise = noise + white * np.cumsum(rng.standard_normal(t.size)) / 5.0
    elif kind == 3:
        noise *= 0.2 + 5.0 * np.abs(np.gradient(angle, t))
    elif kind == 4 and load is not None:
        noise *= 0.2 + 5.0 * np.abs(load)
    sensors = Sensors(None if rng.random() < 0.5 else ratio * white, None if rng.random() < 0.5 else white, None)
    return Run(t, (ratio * angle)[None], out + noise, load, sensors=sensors, input_names=("input",), ratio=ratio)


def untrue(result: LoopResult) -> list[str]:
    """Sentences of a result that its own figures deny."""
    e, found = result.errors, []
    text, page = result_text(result), finding(result) + " " + certainty(result)

    def hold(name: str, true: bool) -> None:
        if not true:
            found.append(f"{name}: {result.verdict}; {result.sentence}; floor {e.floor_rad:.4g}")

    explains = "explains the run" in result.sentence
    hold("explains the run is none", explains == (result.verdict == "none"))
    hold("nothing is missing is none", ("Nothing is missing" in page) == (result.verdict == "none"))
    if result.verdict in ("none", "explained"):
        hold("near the floor", e.after.value <= NEAR_FLOOR * e.floor_rad)
        hold("nothing unknown is left", result.unknown is None and "unknown" not in result.sentence)
    if result.verdict == "none":
        hold("the declared model alone", bool(result.within_class) or e.before.value <= NEAR_FLOOR * e.floor_rad)
        hold("no names", not result.effects and not result.one_of)
    if result.verdict in ("unknown", "partly_explained"):
        hold("what is left is described", result.unknown is not None and result.unknown.sentence() in result.sentence)
    if result.verdict == "explained":
        hold("names", bool(result.effects or result.one_of))
    for named in result.effects:
        hold(f"{named.words} in the sentence", f"{named.words} [" in result.sentence)
        for figure, value in named.parameters.items():
            hold(f"{figure} within its interval", value.low <= value.value <= value.high)
        size = next(iter(named.parameters.values()))
        if len(named.parameters) == 1 or named.name == "change":
            hold(f"{named.words} is not zero", not size.low <= 0.0 <= size.high)
    if said := re.search(r"held-out error ([\d.e+-]+ \w+) RMS before, ([\d.e+-]+ \w+) after", result.sentence):
        shown = readable("_rad", [e.before.value, e.after.value, e.floor_rad])[1]
        hold("errors of the sentence", list(said.groups()) == shown[:2])
    (row,) = re.findall(r"^with what was found +([\d.e+-]+)", text, re.M)
    hold("error of the table", row == f"{e.after.value / size_of('_rad', [e.before.value])[0]:.3g}")
    hold(
        "what was found explains nothing",
        bool(result.effects or result.one_of or result.helpful)
        or bool(result.within_class)
        or e.after.value == e.before.value,
    )
    for one in result.helpful:
        hold("odds", ("odds not known" in one.words) == (one.odds < 20.0))
    for doubt in result.doubts:
        if "noisier than declared" in doubt:
            assert result.noise is not None
            hold("noisier", result.noise.total_rad > 1.5 * result.noise.declared_rad > 0.0)
            hold("noise of a sensor is even", "hangs on" not in text)
    return found


@pytest.mark.filterwarnings("ignore::RuntimeWarning")
@pytest.mark.parametrize("seed", [*range(8), *(pytest.param(k, marks=pytest.mark.slow) for k in range(8, 30))])
def test_every_sentence_holds(seed: int) -> None:
    run = odd_bench(seed)
    if refusals(vet(run, None)):
        pytest.skip("refused before the loop")
    assert not (found := untrue(close_loop(None, [run]))), "\n".join(found)


RATIO = 9.0
NOISE_RAD = 5e-6


def run(error: Floats | float = 0.0, torque: bool = True) -> Run:
    """Two minutes of a drive that bends, lags behind its direction and gives way to its load; ``error`` besides."""
    rng = np.random.default_rng(3)
    t = np.arange(0.0, 120.0, 0.01)
    angle = 0.45 * np.sin(2.0 * np.pi * 0.08 * t)
    load = rng.uniform(-1.0, 1.0, 60)[np.searchsorted(np.cumsum(rng.uniform(2.0, 6.0, 60)), t)]
    true = 3e-4 * angle**2 + 4e-5 * np.sin(9.0 * angle) + 3e-5 * directions(angle, 0.01)
    true = true - (5e-5 * load if torque else 0.0)
    output = angle + true + NOISE_RAD * rng.standard_normal(t.size) + error
    return Run(t, np.stack([RATIO * angle, RATIO * angle]), output, load if torque else None)


def table(measured: Run, delay_s: float = 0.0) -> Correction:
    p = prepare(measured, RATIO)[1]
    fitter = Fitter(None, RATIO, [p])
    late = next(effect for effect in library(None, p) if effect.form == "late sensor")
    return correction_of(fitter, fitter.fit([late], [[delay_s]]) if delay_s else fitter.fit(), NOISE_RAD)


@pytest.mark.parametrize("torque", [True, False])
def test_what_repeats_is_taken_off_unseen_half_sweeps(torque: bool) -> None:
    found = table(run(torque=torque))
    assert found.before_rad > 30e-6 and found.after_rad < 1.15 * NOISE_RAD, (found.before_rad, found.after_rad)
    assert found.load_words == ("as measured" if torque else "that of the run, not known"), found.load_words
    middle = found.at(np.zeros(1), np.zeros(1), np.zeros(1))[0]
    assert abs(float(middle[0])) < 2e-6, middle


def test_the_correction_is_continuous_and_held_at_its_edges() -> None:
    found = table(run())
    angle = np.concatenate([np.linspace(-0.3, 0.2, 5001), np.linspace(0.2, -0.3, 5001)])
    values, held = found.at(angle, directions(angle, found.reversal_rad), np.full(angle.size, 0.4))
    steepest = 8e-5 / found.reversal_rad + 2e-3
    assert float(np.abs(np.diff(values)).max()) < steepest * 1e-4 and not held.any(), np.abs(np.diff(values)).max()
    beyond, flags = found.at(np.array([0.45, 0.9, 0.0]), np.ones(3), np.array([0.0, 0.0, 9.0]))
    assert list(flags[1:]) == [True, True] and beyond[0] == pytest.approx(beyond[1], abs=1e-5), (beyond, flags)


def test_what_hangs_on_speed_is_left_out_and_listed() -> None:
    plain = run()
    late = 1e-3 * np.gradient(plain.input_rad[0] / RATIO, plain.time_s)
    found = table(run(error=-late), delay_s=1e-3)
    assert len(found.left_out) == 1 and "late sensor" in found.left_out[0] and "speed" in found.left_out[0]
    assert found.after_rad < 1.2 * NOISE_RAD, found.after_rad


MAIN = """
#include <stdio.h>
#include "correction.h"
int main(void)
{
    double angle, direction = 0.0, load, before = 0.0;
    int held, first = 1;
    while (scanf("%lf %lf", &angle, &load) == 2) {
        direction = first ? 0.0 : mbcdm_direction(direction, angle - before);
        before = angle;
        first = 0;
        printf("%.12e ", mbcdm_correction(angle, direction, load, &held));
        printf("%d\\n", held);
    }
    return 0;
}
"""


@pytest.mark.skipif(shutil.which("cc") is None, reason="no C compiler here")
@pytest.mark.parametrize("torque", [True, False])
def test_the_c_function_says_the_same(tmp_path: Path, torque: bool) -> None:
    found = table(run(torque=torque))
    for name, text in correction_files(found, "a test").items():
        (tmp_path / name).write_bytes(text)
    (tmp_path / "main.c").write_text(MAIN)
    flags = ["-std=c99", "-Wall", "-Wextra", "-Werror", "-pedantic"]
    subprocess.run(["cc", *flags, "-o", "main", "main.c"], cwd=tmp_path, check=True)
    rng = np.random.default_rng(1)
    angle = np.cumsum(rng.normal(0.0, 2e-3, 3000))
    load = rng.uniform(-1.2, 1.2, angle.size)
    fed = "\n".join(f"{a!r} {b!r}" for a, b in zip(angle.tolist(), load.tolist(), strict=True))
    said = subprocess.run(["./main"], input=fed, cwd=tmp_path, capture_output=True, text=True, check=True).stdout
    rows = np.array([[float(word) for word in line.split()] for line in said.splitlines()])
    sense = directions(angle, found.reversal_rad)
    sense[0] = 0.0
    values, held = found.at(angle, sense, load)
    np.testing.assert_allclose(rows[:, 0], values, atol=1e-12)
    assert (rows[:, 1] == held).all()
    content = json.loads((tmp_path / "correction.json").read_text())
    lines = (tmp_path / "correction.csv").read_text().splitlines()
    figures = [float(line.split(",")[3]) for line in lines if line[0] not in "#a"]
    np.testing.assert_allclose(figures, np.ravel(content["correction_rad"]), rtol=1e-8)
    assert "mean of the input angles / total ratio + correction" in content["sign"]
