"""Changes during a run: found with time and figures before and after, and not found where nothing changed."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from mbcdm_cad.layouts.loader import load_design
from mbcdm_cad.loop.as_built import as_built_text
from mbcdm_cad.loop.effects.change import time_of_change
from mbcdm_cad.loop.prepare.prepared import played
from mbcdm_cad.loop.result import LoopResult
from mbcdm_cad.loop.search.engine import close_loop
from mbcdm_cad.measurement.run import Run, Sensors
from mbcdm_cad.routes import Floats
from tests.support.bench_change import simulate_change
from tests.support.bench_data import through_files

DESIGN = Path(__file__).parents[3] / "params" / "mbcdm.yaml"
RATIO, NOISE_RAD, STEP_RAD = 8.0, 3e-5, 2e-5
T = np.arange(0.0, 100.0, 0.02)
ANGLE = 0.6 * np.sin(2.0 * np.pi * T / 9.0)


def found(reading: Floats, seed: int = 0) -> LoopResult:
    """The loop's result for a drive of which only the ratio is known."""
    noisy = reading + NOISE_RAD * np.random.default_rng(seed).normal(size=T.size)
    run = Run(T, RATIO * ANGLE[None], noisy, sensors=Sensors(STEP_RAD, STEP_RAD), input_names=("input",), ratio=RATIO)
    return close_loop(None, [run])


def test_a_ratio_that_changes_is_named_with_its_time_and_its_figures() -> None:
    result = found(ANGLE * (1.0 + 2e-3 * (T > 41.3)))
    (named,) = result.effects
    assert (named.name, named.stage, named.form) == ("change", "ratio_error", "at once"), result.sentence
    share, at = named.parameters["share"], named.parameters["at_s"]
    assert share.low < 2e-3 < share.high and share.high - share.low < 2e-4, share
    assert at.low < 41.3 < at.high and at.high - at.low < 1.0, at
    assert named.physical["before_share"] == 0.0 and named.physical["after_share"] == pytest.approx(share.value), (
        named.physical
    )
    assert result.verdict == "explained" and result.errors.after.value == pytest.approx(NOISE_RAD, rel=0.1)


def test_play_that_grows_during_the_run_is_told_from_play() -> None:
    result = found(played(ANGLE, 5e-4) + (T > 60.0) * (played(ANGLE, 5e-4) - ANGLE))
    by_name = {named.name: named for named in result.effects}
    assert set(by_name) == {"lash", "change"} and by_name["change"].stage == "lash", result.sentence
    physical = by_name["change"].physical
    assert physical["before_play_rad"] == pytest.approx(1e-3, rel=0.05), physical
    assert physical["after_play_rad"] == pytest.approx(2e-3, rel=0.05), physical


@pytest.mark.parametrize(
    "drift", [0.0 * T, 3e-4 * (1.0 - np.exp(-T / 20.0)), 1e-4 * np.log1p(T / 0.5)], ids=["nothing", "warming", "creep"]
)
def test_nothing_has_changed_in_a_run_that_only_drifts(drift: Floats) -> None:
    result = found(ANGLE + drift, 3)
    assert "change" not in {named.name for named in result.effects}, result.sentence


def test_the_time_of_a_change_is_found_beside_what_was_there_before() -> None:
    shape = np.sin(T)
    assert time_of_change(T, shape, 2.0 * shape + 0.5 * shape * (T > 33.0)) == pytest.approx(33.0, abs=0.1)


def test_the_design_as_built_has_what_the_drive_has_afterwards() -> None:
    loaded = load_design(DESIGN)
    result = found(ANGLE * (1.0 + 1e-3) * (1.0 + 2e-3 * (T > 41.3)))
    text = as_built_text(loaded, result)
    assert "change" not in text.split("as_built:")[1] and text.count("name: ratio_error") == 1, text
    share = float(text.split("name: share, value: ")[1].split(",")[0])
    assert share == pytest.approx(3.0e-3, rel=0.05), text


@pytest.mark.slow
@pytest.mark.parametrize("case", ["modulus_low", "friction"])
def test_a_drive_that_changes_on_a_bench_of_other_code_is_named(case: str) -> None:
    drive = load_design(DESIGN).drive
    simulated, at_s = simulate_change(drive, case, 40001)
    result = close_loop(drive, [replace(through_files(simulated, drive.input_names), source="run.csv")])
    members = [*result.effects, *(one for group in result.one_of for one in group)]
    (named,) = [one for one in members if one.stage == simulated.effects[0].name]
    at = named.parameters["at_s"]
    assert at.low - 0.1 < at_s < at.high + 0.1, (at_s, at, result.sentence)
