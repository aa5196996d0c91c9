"""Every sentence of a result holds against the figures beside it, over many odd runs of drives with one known ratio."""

import re

import numpy as np
import pytest

from mbcdm_cad.loop.page.plain import certainty, finding
from mbcdm_cad.loop.readable import readable, size_of
from mbcdm_cad.loop.result import NEAR_FLOOR, LoopResult, result_text
from mbcdm_cad.loop.search.engine import close_loop
from mbcdm_cad.measurement.run import Run, Sensors
from mbcdm_cad.measurement.vet import refusals, vet
from mbcdm_cad.routes import Floats


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
