"""What a planned run would tell apart: ratio from the drum's first order only over a long travel."""

from types import SimpleNamespace

import numpy as np
import pytest

from mbcdm_cad.layouts.loader import layout_of
from mbcdm_cad.loop.effects import library
from mbcdm_cad.loop.prepare.prepared import prepare
from mbcdm_cad.loop.result import Named, Noise
from mbcdm_cad.measurement.run import Run, Sensors
from mbcdm_cad.model.hysteresis import simulate
from mbcdm_cad.planning.best_run import next_run, wrong_choice
from tests.support.reference import DRIVE

NOISE = Noise(5e-6, 5e-6, 0.0, 0.0, 4.4e-6, "as the test has it")
STEP_S = 0.04


def planned(amplitude_rad: float, load_Nm: float | None = 0.9) -> Run:
    t = np.arange(0.0, 90.0, STEP_S)
    angle = amplitude_rad * np.sin(2.0 * np.pi * t / 11.0)
    load = (load_Nm or 0.0) * np.sin(2.0 * np.pi * t / 5.1)
    inputs = np.stack([9.0 * angle, 9.0 * angle])
    drum = simulate(layout_of(DRIVE).si, inputs, load).drum_angle_rad
    return Run(t, inputs, drum, None if load_Nm is None else load, sensors=Sensors(1.9175e-4, 1.3635e-6, 0.005))


def named(name: str, stage: str | None, fitted: dict[str, float]) -> Named:
    run = prepare(planned(0.1), 9.0)[0]
    one = next(e for e in library(layout_of(DRIVE).si, run) if e.name == name and e.stage == stage)
    return Named(name, one.form, stage, one.cables, {}, {}, (), "", one.separate_by, "", 0.0, fitted)


RATIO = named("ratio_error", None, {"share": 3e-4})
DRUM = named("once_per_rev", "drum", {"cosine_rad": 0.0, "sine_rad": 3e-4})
SOFT = named("stiffness_error", None, {"share": -0.3})
EASY = named("cable_friction", None, {"share": -0.05})
TENSE = named("preload_error", None, {"share": -0.05})


@pytest.mark.parametrize("members", [(RATIO, DRUM), (DRUM, RATIO)])
def test_a_long_travel_tells_the_ratio_from_the_drum(members: tuple[Named, Named]) -> None:
    short, long = (wrong_choice(DRIVE, planned(amplitude), members, NOISE, STEP_S) for amplitude in (0.05, 0.6))
    print(f"wrong over 100 mrad with {short:.2g}, over 1.2 rad with {long:.2g}")
    assert short == pytest.approx(0.5, abs=0.01) and long < 1e-5


def test_more_noise_tells_less_and_more_samples_more() -> None:
    run, loud = planned(0.6), Noise(1e-5, 1e-5, 0.0, 0.0, 4.4e-6, "louder")
    plain = wrong_choice(DRIVE, run, (RATIO, DRUM), loud, STEP_S)
    assert wrong_choice(DRIVE, run, (RATIO, DRUM), NOISE, STEP_S) < plain
    assert wrong_choice(DRIVE, run, (RATIO, DRUM), loud, STEP_S / 10.0) < plain
    slow = Noise(1e-5, 0.0, 1e-5, 2.0, 4.4e-6, "with a memory")
    assert wrong_choice(DRIVE, run, (RATIO, DRUM), slow, STEP_S) > plain


def test_what_a_run_cannot_show_it_cannot_tell() -> None:
    assert wrong_choice(DRIVE, planned(0.4, None), (RATIO, SOFT), NOISE, STEP_S) == 0.5
    assert wrong_choice(DRIVE, planned(0.4), (RATIO, SOFT), NOISE, STEP_S) < 1e-6


def proposed(*sets: tuple[Named, ...]) -> object:
    """What ``--next`` proposes after a run of 90 s."""
    return next_run(DRIVE, [planned(0.1)], SimpleNamespace(one_of=sets, noise=NOISE))


def test_a_set_that_no_run_separates_gets_no_proposal_but_what_would_help() -> None:
    following = proposed((EASY, TENSE))
    print(following.words())
    assert not following.useful and following.wrong_after > 0.2
    assert following.words().startswith("no run within") and EASY.separate_by in following.words()


def test_of_two_sets_the_proposed_run_settles_the_one_that_it_can() -> None:
    following = proposed((EASY, TENSE), (RATIO, DRUM))
    print(following.words())
    assert following.useful and following.members == (RATIO, DRUM)
