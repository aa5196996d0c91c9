"""The samples on which the cables are simulated: what lies between them is as if every sample were simulated."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from mbcdm_cad.layouts.loader import layout_of, load_design
from mbcdm_cad.loop.effects import library
from mbcdm_cad.loop.prepare.lines import MOST_ORDER, order_spectrum
from mbcdm_cad.loop.search.fit import Fitter
from mbcdm_cad.measurement.run import Run, Sensors
from mbcdm_cad.model.hysteresis import simulate
from mbcdm_cad.planning.plan import planned_fitter
from mbcdm_cad.routes import Floats

DRIVE = load_design(Path(__file__).parents[3] / "params" / "mbcdm.yaml").drive
SIZES = {"friction (bearing torque)": [0.2], "lash input_right (play at an input)": [5e-3, 0.0]}


def run(flank_s: float) -> Run:
    """A sine under a brake that changes its sign within ``flank_s``."""
    t = np.arange(0.0, 60.0, 0.01)
    drum = 0.45 * np.sin(2.0 * np.pi * t / 10.0)
    load = 0.8 * np.tanh(np.cos(2.0 * np.pi * t / 10.0) * 10.0 / (np.pi * flank_s))
    inputs = np.stack([9.0 * drum, 9.0 * drum])
    return Run(
        t, inputs, simulate(layout_of(DRIVE).si, inputs, load).drum_angle_rad, load, sensors=Sensors(1e-6, 1e-9, None)
    )


def change(fitter: Fitter, label: str) -> Floats:
    """Change of the prediction by an effect."""
    effect = next(one for one in library(fitter.d, fitter.runs[0]) if one.label == label)
    with_it = fitter.predict([effect], [np.array(SIZES[label])], np.zeros(1))
    return fitter.centred(with_it - fitter.predict([], [], np.zeros(1)), fitter.used)


@pytest.mark.parametrize("label", SIZES)
@pytest.mark.parametrize("flank_s", [0.05, 0.5])
def test_a_friction_and_a_play_change_sides_when_they_do_on_every_sample(label: str, flank_s: float) -> None:
    few = planned_fitter(DRIVE, run(flank_s))
    p = replace(few.runs[0])
    p.__dict__["coarse"] = np.arange(p.time_s.size)
    every = Fitter(few.d, few.ratio, [p], few.known)
    exact, found = (change(one, label)[few.used] for one in (every, few))
    error = float(np.sqrt(np.mean((found - exact) ** 2)))
    share = few.runs[0].coarse.size / p.time_s.size
    print(
        f"{label}, flank {flank_s} s: effect {1e6 * exact.std():.1f} urad RMS, error {1e6 * error:.2f} urad, "
        f"{share:.0%} of the samples simulated"
    )
    assert exact.std() > 1e-5, "an effect that shows nothing would test nothing"
    assert error < 0.03 * exact.std()
    assert share < 0.4


# Order spectrum: a line stands where it is and as high as it is; nothing else does, however sweeps meet the angles.


def swept(samples: int = 16_000) -> np.ndarray:
    """Triangles at +-0.45 rad whose sweeps meet the same angles again, with 1 mrad of smooth rounding."""
    t = np.arange(samples) * 0.01
    return 0.45 * (2.0 / np.pi) * np.arcsin(0.998 * np.sin(2.0 * np.pi * 0.0625 * t))


def test_slow_trend_makes_no_fast_line() -> None:
    angle = swept()
    orders, amplitude = order_spectrum(angle, 1e-4 * np.sin(angle + 0.3))
    ghost = float(amplitude[orders > 100.0].max())
    assert ghost < 1e-8, f"a line of {ghost:.2g} rad where there is none"


@pytest.mark.parametrize("order", [45.0, 684.0, 2100.0])
def test_line_over_a_trend(order: float) -> None:
    angle = swept()
    orders, amplitude = order_spectrum(angle, 2e-5 * np.cos(order * angle + 1.0) + 1e-4 * np.sin(angle))
    fast = orders > 30.0
    k = int(np.argmax(np.where(fast, amplitude, 0.0)))
    assert abs(orders[k] - order) < 0.5 * 2.0 * np.pi / float(np.ptp(angle)), f"{orders[k]:.1f} for {order}"
    # At high orders a bin is a good part of a wave, and bins without a sample are filled from their neighbours.
    low = 0.5 if order > 2000.0 else 0.95
    assert low * 2e-5 < amplitude[k] < 1.02 * 2e-5, amplitude[k]


def test_no_order_beyond_what_is_looked_for() -> None:
    orders, _ = order_spectrum(swept(), np.zeros(16_000))
    assert orders[-1] <= MOST_ORDER
