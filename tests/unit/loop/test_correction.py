"""The correction table: what repeats is taken off, the rest is left out, and the C function says what Python says."""

import json
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest

from mbcdm_cad.loop.correction import Correction, correction_of, directions
from mbcdm_cad.loop.correction_files import correction_files
from mbcdm_cad.loop.effects import library
from mbcdm_cad.loop.prepare.prepared import prepare
from mbcdm_cad.loop.search.fit import Fitter
from mbcdm_cad.measurement.run import Run
from mbcdm_cad.routes import Floats

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
