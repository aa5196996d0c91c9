"""Counters of two inputs begin anywhere: zeros that the cables could not bear are taken from the run."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mbcdm_cad.layouts.loader import layout_of, load_design
from mbcdm_cad.loop.search.engine import close_loop
from mbcdm_cad.measurement.run import Run, Sensors
from mbcdm_cad.measurement.vet import arranged, vet
from mbcdm_cad.model.hysteresis import simulate

DRIVE = load_design(Path(__file__).parents[3] / "params" / "mbcdm.yaml").drive
STEP = 2e-5


def bench(seed: int = 1) -> Run:
    """Two servos that track unlike, by some tenths of a milliradian, under a load of its own rhythm."""
    rng = np.random.default_rng(seed)
    t = np.arange(0.0, 100.0, 0.04)
    angle = 0.45 * np.sin(2.0 * np.pi * t / 9.0)
    load = 0.6 * np.sin(2.0 * np.pi * t / 5.1) + 0.4 * np.sin(2.0 * np.pi * t / 17.3)
    unlike = [1e-4 * np.sin(2.0 * np.pi * t / rng.uniform(2.0, 6.0) + rng.uniform(0.0, 6.28)) for _ in range(2)]
    inputs = np.stack([9.0 * angle + one for one in unlike])
    drum = simulate(layout_of(DRIVE).si, inputs, load).drum_angle_rad + 5e-6 * rng.standard_normal(t.size)
    return Run(t, STEP * np.round(inputs / STEP), drum, load, sensors=Sensors(STEP, 1e-6, 0.005))


def moved(run: Run, zeros: tuple[float, float]) -> Run:
    return replace(run, input_rad=run.input_rad + np.array(zeros)[:, None])


def test_a_run_with_zeros_of_its_own_is_left_as_it_is() -> None:
    run = bench()
    assert arranged(run, DRIVE) is run


@given(left=st.floats(-60.0, 60.0), right=st.floats(-60.0, 60.0))
@settings(max_examples=30, deadline=None)
def test_whatever_the_counters_show_at_the_start_the_inputs_are_nearly_alike(left: float, right: float) -> None:
    run = bench()
    found = arranged(moved(run, (left, right)), DRIVE)
    apart = float(np.abs(np.diff(found.input_rad, axis=0)).max())
    true = float(np.abs(np.diff(run.input_rad, axis=0)).max())
    assert apart <= true + 3e-2, f"zeros at {left} and {right} rad: {1e3 * apart:.3f} mrad are left between the inputs"
    assert arranged(found, DRIVE).zeros == found.zeros, "what was taken once is not taken again"
    if abs(left - right) > 0.1:
        assert apart <= 2.0 * true, f"{1e3 * apart:.3f} mrad are left, the servos differ by {1e3 * true:.3f}"
        assert [note.kind for note in vet(found, DRIVE)].count("zeros_apart") == 1


@pytest.mark.parametrize("zeros", [(1.2, 0.9), (0.0, 1e-1), (30.0, 30.0)])
def test_the_finding_does_not_hang_on_the_zeros(zeros: tuple[float, float]) -> None:
    """With zeros of 0.3 rad apart taken as they are, the cables would be torn: the friction starts from nowhere."""
    result = close_loop(DRIVE, [moved(bench(), zeros)])
    assert result.verdict == "none", result.sentence
    assert result.errors.before.value < 1.1 * 5.2e-6, f"{1e6 * result.errors.before.value:.2f} urad are left"
