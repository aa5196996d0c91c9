"""A second run of the loop, with the drive as built, finds nothing left."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from mbcdm_cad.design import load_design
from mbcdm_cad.design.loader import load_text
from mbcdm_cad.loop.as_built import as_built_text
from mbcdm_cad.loop.engine import close_loop
from mbcdm_cad.loop.run import Run, Sensors
from mbcdm_cad.model.hysteresis import simulate
from mbcdm_cad.model.si import to_si

REFERENCE = Path(__file__).parents[3] / "params" / "mbcdm.yaml"
STEP = 1.9175e-4


def measured(share: float, ratio_error: float) -> Run:
    """A run of a drive with a stiffer rope and an encoder scale that is off, quantised as the bench's sensors are."""
    rng = np.random.default_rng(4)
    t = np.arange(0.0, 120.0, 0.04)
    angle = 0.45 * np.sin(2.0 * np.pi * t / 11.0)
    load = 0.9 * np.sign(np.sin(2.0 * np.pi * t / 17.3 + 0.4)) + 0.3 * np.sin(2.0 * np.pi * t / 5.1)
    load = np.convolve(load, np.hanning(25) / np.hanning(25).sum(), "same")
    d = to_si(load_design(REFERENCE).drive)
    d = d.with_(modulus_Pa=d.modulus_Pa * (1.0 + share))
    inputs = np.stack([9.0 * angle, 9.0 * angle])
    drum = simulate(d, inputs, load).drum_angle_rad + ratio_error * angle
    read = STEP * np.floor(inputs / STEP + np.array([[0.3], [0.8]]))
    output = 1.3635e-6 * np.round(drum / 1.3635e-6)
    torque = load + 0.005 * rng.standard_normal(t.size)
    return Run(t, read, output, torque, sensors=Sensors(STEP, 1.3635e-6, 0.005))


@pytest.mark.parametrize(
    ("share", "ratio_error", "names"), [(0.3, 0.0, {"stiffness_error"}), (0.0, 4e-4, {"ratio_error"})]
)
def test_nothing_is_left_of_what_was_named(share: float, ratio_error: float, names: set[str]) -> None:
    loaded, run = load_design(REFERENCE), measured(share, ratio_error)
    first = close_loop(loaded.drive, [run])
    print(first.sentence)
    assert {named.name for named in first.effects} == names, first.sentence
    assert not first.one_of, first.sentence
    as_built = load_text(as_built_text(loaded, first, "run.csv"), REFERENCE)
    second = close_loop(as_built.drive, [run])
    print(second.sentence)
    assert second.verdict == "none", second.sentence
    assert second.errors.before.value == pytest.approx(first.errors.after.value, rel=0.05)
