"""A plan of readings by hand keeps its promise: what it says will be named is named, half of it is not."""

from pathlib import Path

import numpy as np
import pytest

from mbcdm_cad.layouts.loader import layout_of, load_design
from mbcdm_cad.loop.search.engine import close_loop
from mbcdm_cad.measurement.run import Run, Sensors
from mbcdm_cad.model.hysteresis import simulate
from mbcdm_cad.planning.plan import RunPlan, plan_of
from mbcdm_cad.routes import Floats

DRIVE = load_design(Path(__file__).parents[3] / "params" / "siso_spur.yaml").drive
STEP, NOISE = 2e-6, 3e-6


def by_hand(kind: str, time_s: Floats, load_Nm: Floats, added_rad: Floats, seed: int) -> Run:
    """Readings with the input locked; the file states the step, and nobody the noise."""
    rng = np.random.default_rng(seed)
    still = np.zeros((1, time_s.size))
    drum = (
        simulate(layout_of(DRIVE).si, still, load_Nm).drum_angle_rad + added_rad + rng.normal(0.0, NOISE, time_s.size)
    )
    output = STEP * np.round(drum / STEP)
    sensors = Sensors(output_resolution_rad=STEP)
    return Run(time_s, still, output, load_Nm, sensors=sensors, input_names=("main",), kind=kind)  # type: ignore[arg-type]


def smallest(plan: RunPlan, label: str) -> float:
    found = next(one.smallest for one in plan.effects if one.label.startswith(label))
    assert found is not None
    return found


def named(run: Run) -> set[str]:
    result = close_loop(DRIVE, [run])
    return {one.name for one in (*result.effects, *(one for group in result.one_of for one in group))}


@pytest.mark.slow
def test_creep_is_named_from_the_size_that_the_plan_gives() -> None:
    t = np.geomspace(6.0, 60000.0, 30)
    load = np.full(t.size, 0.6)
    size = smallest(plan_of(DRIVE, by_hand("creep", t, load, np.zeros(t.size), 1)), "creep (logarithmic")
    for share, least, most in ((1.3, 11, 14), (0.25, 0, 4)):
        grown = -0.6 * share * size * np.log1p(t / 6.0)
        found = sum("creep" in named(by_hand("creep", t, load, grown, 10 + k)) for k in range(14))
        assert least <= found <= most, f"{found} of 14 at {share} of the size"


@pytest.mark.slow
def test_a_compliance_is_named_from_the_size_that_the_plan_gives() -> None:
    load = np.tile([0.2, -0.2, 0.4, -0.4, 0.6, -0.6], 4)
    rows = np.arange(load.size, dtype=float)
    plan = plan_of(DRIVE, by_hand("turning_points", rows, load, np.zeros(load.size), 1))
    size = smallest(plan, "stiffness_error (compliance")
    assert any(
        "friction" in rival.label for one in plan.effects if one.label.startswith("lash (") for rival in one.rivals
    )
    for share, least, most in ((1.5, 5, 6), (0.25, 0, 2)):
        found = sum(bool(named(by_hand("turning_points", rows, load, -share * size * load, 20 + k))) for k in range(6))
        assert least <= found <= most, f"{found} of 6 at {share} of the size"


def test_a_motion_without_a_load_proposes_readings_by_hand() -> None:
    t = np.arange(0.0, 60.0, 0.05)
    inputs = (9.9 * 0.4 * np.sin(2.0 * np.pi * t / 8.0))[None]
    run = Run(t, inputs, STEP * np.round(inputs[0] / 9.9 / STEP), None, input_names=("main",))
    words = plan_of(DRIVE, run).text()
    assert "record: turning_points" in words
    assert "a run by hand shows" in words
