"""Play at an input: on a face while torque is carried, floating where none is, on the side of the bias at rest."""

from pathlib import Path

import numpy as np
import pytest

from mbcdm_cad.layouts.loader import layout_of, load_design
from mbcdm_cad.loop.effect import Effect
from mbcdm_cad.loop.effects.lash import offer
from mbcdm_cad.loop.prepare.prepared import Prepared, prepare
from mbcdm_cad.loop.prepare.setup import Setup, Simulator, declared, input_torque_Nm, respond, taken_up
from mbcdm_cad.loop.search.engine import close_loop
from mbcdm_cad.measurement.run import Run, Sensors
from mbcdm_cad.model.si import DriveSI

DRIVE = load_design(Path(__file__).parents[3] / "params" / "mbcdm.yaml").drive
D: DriveSI = layout_of(DRIVE).si
PLAY = 1e-3


def run(load_Nm: float) -> Prepared:
    """The drum stands; the load goes up and down."""
    t = np.arange(0.0, 40.0, 0.05)
    angle = 1e-3 * np.sin(2.0 * np.pi * t / 8.0)
    load = load_Nm * np.sin(2.0 * np.pi * t / 20.0)
    return prepare(Run(t, np.stack([9.0 * angle, 9.0 * angle]), angle, load), 9.0)[1]


def at_input(name: str, p: Prepared) -> Effect:
    return next(e for e in offer(D, p) if e.stage == f"input_{name}")


def lag_of(setup: Setup, changed: Setup, index: int) -> np.ndarray:
    shift = taken_up(changed).shift_rad
    assert shift is not None
    return -shift[index]


@pytest.mark.parametrize("index", [0, 1])
def test_on_a_face_or_without_torque(index: int) -> None:
    p = run(0.9)
    setup = declared(D, 9.0, p)
    changed = at_input(D.input_names[index], p).apply(setup, np.array([PLAY, 0.0]), Simulator())
    torque = input_torque_Nm(changed, index)
    bias = float(np.sum(D.sigma * D.input_radius_m * D.preload_N * D.of_input(index)))
    start = PLAY / 2.0 * np.sign(bias)
    lag = lag_of(setup, changed, index) + start
    inside = np.abs(lag) < 0.49 * PLAY
    assert np.ptp(lag) == pytest.approx(PLAY, rel=1e-6)
    floating, on_faces = np.abs(torque[inside]).max(initial=0.0), np.abs(torque).max()
    assert floating < 0.05 * on_faces, f"torque while floating {floating:.2e} N m, on the faces {on_faces:.2e} N m"
    assert (torque[lag > 0.499 * PLAY] > -1e-3).all()
    assert (torque[lag < -0.499 * PLAY] < 1e-3).all()


def test_drum_with_play_is_that_of_the_pulleys_where_they_are() -> None:
    p = run(0.9)
    changed = at_input(D.input_names[0], p).apply(declared(D, 9.0, p), np.array([PLAY, 2e-4]), Simulator())
    changed = at_input(D.input_names[1], p).apply(changed, np.array([0.5 * PLAY, 0.0]), Simulator())
    away = np.abs(respond(changed) - respond(taken_up(changed))).max()
    assert away < 1e-12, f"{away:.2e} rad from the angle that the cables give with the pulleys in these places"


def test_bias_holds_one_face_under_a_small_load() -> None:
    p = run(0.05)
    setup = declared(D, 9.0, p)
    for name in D.input_names:
        changed = at_input(name, p).apply(setup, np.array([PLAY, 0.0]), Simulator())
        lag = lag_of(setup, changed, D.input_names.index(name))
        assert np.abs(lag).max() < 1e-9, (name, np.abs(lag).max())


def test_with_play_at_both_inputs_both_pulleys_are_on_a_face_or_without_torque() -> None:
    p = run(0.9)
    setup = declared(D, 9.0, p)
    changed = setup
    for name in D.input_names:
        changed = at_input(name, p).apply(changed, np.array([PLAY, 0.0]), Simulator())
    for index in range(D.n_inputs):
        torque = input_torque_Nm(changed, index)
        bias = float(np.sum(D.sigma * D.input_radius_m * D.preload_N * D.of_input(index)))
        lag = lag_of(setup, changed, index) + 0.5 * PLAY * np.sign(bias)
        inside = np.abs(lag) < 0.49 * PLAY
        left = 1e3 * np.abs(torque[inside]).max(initial=0.0)
        print(f"input {index}: floats in {inside.mean():.0%}, torque there at most {left:.2f} mN m")
        assert left < 0.05e3 * np.abs(torque).max()
        assert (torque[lag > 0.499 * PLAY] > -1e-3).all() and (torque[lag < -0.499 * PLAY] < 1e-3).all()


def test_play_that_is_never_crossed_is_given_as_at_least_what_was_crossed() -> None:
    """Any larger play fits as well, so the fit may end anywhere above; the result states the smallest that does."""
    rng = np.random.default_rng(5)
    t = np.arange(0.0, 120.0, 0.04)
    angle = 0.45 * np.sin(2.0 * np.pi * t / 9.0)
    load = 0.8 * np.tanh(np.cos(2.0 * np.pi * t / 9.0) / 0.05) + 0.3 * np.sin(2.0 * np.pi * t / 31.0)
    whole = prepare(Run(t, np.stack([9.0 * angle, 9.0 * angle]), angle, load), 9.0)[1]
    setup = declared(D, 9.0, whole)
    true = 2e-2
    drum = respond(at_input(D.input_names[0], whole).apply(setup, np.array([true, 0.0]), Simulator()))
    read = np.interp(t, whole.time_s, drum) + 4e-6 * rng.standard_normal(t.size)
    inputs = np.stack([9.0 * angle, 9.0 * angle])
    result = close_loop(DRIVE, [Run(t, inputs, read, load, sensors=Sensors(2e-5, 1e-6, 0.005))])
    (found,) = result.effects
    play = found.parameters["play_rad"]
    assert (found.name, found.stage) == ("lash", "input_left"), result.sentence
    assert np.isinf(play.high) and play.low == play.value, play
    assert 2e-4 < play.low <= 1.05 * true, f"at least {1e3 * play.low:.3f} mrad, true {1e3 * true} mrad"
    assert "or more" in result.sentence, result.sentence
