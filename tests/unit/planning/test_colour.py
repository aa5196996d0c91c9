"""The colour of the noise is found in a residual that curves could follow, and says what the noise does along an
effect."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.signal import lfilter

from mbcdm_cad.loop.prepare.noise import Noise, noise_of
from mbcdm_cad.loop.prepare.prepared import Prepared, prepare
from mbcdm_cad.loop.prepare.setup import declared
from mbcdm_cad.measurement.run import Run, Sensors
from mbcdm_cad.planning.prediction_noise import along, coloured
from mbcdm_cad.routes import Floats

RATIO, RATE_HZ = 9.0, 50.0
SENSORS = Sensors(output_resolution_rad=2e-6 * np.sqrt(12.0))


def run() -> Prepared:
    """A drive of ratio 9 swept +-0.4 rad, 5 s each way, under steps of the load."""
    rng = np.random.default_rng(5)
    t = np.arange(0.0, 100.0, 1.0 / RATE_HZ)
    drum = 0.4 * np.sin(2.0 * np.pi * 0.1 * t)
    load = rng.uniform(-1.0, 1.0, 200)[np.searchsorted(np.cumsum(rng.uniform(2.0, 6.0, 200)), t)]
    return prepare(Run(t, np.stack([RATIO * drum, RATIO * drum]), drum, load, sensors=SENSORS), RATIO)[1]


def lasting(size: int, memory_s: float, rng: np.random.Generator) -> Floats:
    """Noise of RMS 1 whose correlation falls as exp(-t / memory)."""
    keep = np.exp(-1.0 / (RATE_HZ * memory_s))
    kicks = np.sqrt(1.0 - keep**2) * rng.normal(size=size)
    kicks[0] = rng.normal()
    return np.asarray(lfilter([1.0], [1.0, -keep], kicks))


@pytest.mark.parametrize("memory_s", [0.1, 0.4, 0.8, 2.0])
def test_the_memory_of_the_noise_is_found(memory_s: float) -> None:
    p, white, slow = run(), 8e-6, 4e-6
    setup = declared(None, RATIO, p)
    seen = []
    for seed in range(8):
        rng = np.random.default_rng(seed)
        angle = 2e-4 * p.output_rad**2  # an effect in the pilot is no noise
        residual = angle + white * rng.normal(size=p.time_s.size) + slow * lasting(p.time_s.size, memory_s, rng)
        seen.append(coloured(noise_of([setup], [residual]), setup, residual))
    memories = [noise.memory_s for noise in seen]
    slows = [noise.coloured_rad for noise in seen]
    print(
        f"memory {memory_s} s: found {np.round(memories, 2)}, slow part {np.round(1e6 * np.array(slows), 1)} urad of 4"
    )
    assert 0.6 * memory_s < np.median(memories) < 1.5 * memory_s, memories
    assert np.median(slows) == pytest.approx(slow, rel=0.2), slows
    for noise in seen:
        assert np.hypot(noise.white_rad, noise.coloured_rad) == pytest.approx(noise.total_rad), noise


def test_the_likely_colours_hold_the_true_one() -> None:
    p, white, slow, memory_s = run(), 8e-6, 4e-6, 0.4
    setup = declared(None, RATIO, p)
    true = slow**2 / (slow**2 + white**2) * memory_s
    inside, wide = 0, []
    for seed in range(20):
        rng = np.random.default_rng(100 + seed)
        residual = white * rng.normal(size=p.time_s.size) + slow * lasting(p.time_s.size, memory_s, rng)
        noise = coloured(noise_of([setup], [residual]), setup, residual)
        low, high = np.quantile([share * memory for share, memory in noise.likely], [0.05, 0.95])
        inside += low < true < high
        wide.append(high / low)
    print(f"inside the middle 90 % in {inside} of 20; its ends are a factor {np.median(wide):.2f} apart")
    assert inside >= 15 and np.median(wide) < 4.0


def test_a_floor_of_declared_steps_is_left_as_it_is() -> None:
    p = run()
    setup = declared(None, RATIO, p)
    still = 1e-9 * lasting(p.time_s.size, 0.4, np.random.default_rng(1))
    noise = noise_of([setup], [still])
    assert noise.total_rad == noise.declared_rad and coloured(noise, setup, still) == noise


@pytest.mark.parametrize("period_s", [0.4, 4.0, 20.0])
def test_noise_along_a_column_is_that_of_many_draws(period_s: float) -> None:
    noise = Noise(5e-6, 4e-6, 3e-6, 0.5, 0.0, "as the test has it")
    t = np.arange(0.0, 40.0, 1.0 / RATE_HZ)
    column = np.sin(2.0 * np.pi * t / period_s)
    rng = np.random.default_rng(3)
    products = [
        column @ (noise.white_rad * rng.normal(size=t.size) + noise.coloured_rad * lasting(t.size, 0.5, rng))
        for _ in range(4000)
    ]
    drawn = float(np.var(products)) / float(column @ column) / noise.total_rad**2
    print(f"period {period_s} s: {along(column, noise, 1.0 / RATE_HZ):.3g} along the column, drawn {drawn:.3g}")
    assert along(column, noise, 1.0 / RATE_HZ) == pytest.approx(drawn, rel=0.08)


def test_more_samples_only_help_against_white_noise() -> None:
    column = np.sin(np.linspace(0.0, 20.0, 1000))
    white, slow = Noise(1e-6, 1e-6, 0.0, 0.0, 0.0, "white"), Noise(1e-6, 0.0, 1e-6, 2.0, 0.0, "slow")
    assert along(column, white, 0.04) == 1.0
    assert along(column, white, 0.04, 0.01) == pytest.approx(0.25)
    assert along(column, slow, 0.04, 0.01) == along(column, slow, 0.04) > 20.0
