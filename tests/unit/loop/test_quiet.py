"""The smoothing of the load: steps stay steps, waves lose little, noise falls."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mbcdm_cad.loop.prepare.quiet import locally_fitted, quiet_load
from mbcdm_cad.measurement.run import Run
from mbcdm_cad.routes import Floats

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
