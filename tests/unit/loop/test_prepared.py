"""The samples on which the cables are simulated: what lies between them is as if every sample were simulated."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from mbcdm_cad.layouts.loader import load_design
from mbcdm_cad.loop.effects import library
from mbcdm_cad.loop.search.fit import Fitter
from mbcdm_cad.measurement.run import Run, Sensors
from mbcdm_cad.model.hysteresis import simulate
from mbcdm_cad.model.si import to_si
from mbcdm_cad.planning.detectable import planned_fitter
from mbcdm_cad.routes import Floats

DRIVE = load_design(Path(__file__).parents[3] / "params" / "mbcdm.yaml").drive
SIZES = {"friction (bearing torque)": [0.2], "lash input_right (play at an input)": [5e-3, 0.0]}


def run(flank_s: float) -> Run:
    """A sine under a brake that changes its sign within ``flank_s``."""
    t = np.arange(0.0, 60.0, 0.01)
    drum = 0.45 * np.sin(2.0 * np.pi * t / 10.0)
    load = 0.8 * np.tanh(np.cos(2.0 * np.pi * t / 10.0) * 10.0 / (np.pi * flank_s))
    inputs = np.stack([9.0 * drum, 9.0 * drum])
    return Run(t, inputs, simulate(to_si(DRIVE), inputs, load).drum_angle_rad, load, sensors=Sensors(1e-6, 1e-9, None))


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
