"""Inertias, gearhead and position controller compared with closed forms."""

from __future__ import annotations

from math import pi
from pathlib import Path

import numpy as np
import pytest

from mbcdm_cad.layouts.loader import load_design
from mbcdm_cad.rig.dynamic.rig import inertias
from mbcdm_cad.rig.dynamic.train import (
    LAST,
    SPEED,
    STATES,
    SUM,
    ControllerSpec,
    GearheadSpec,
    MotorSpec,
    control,
    gearhead_of,
    motor_of,
    shaft_torque,
)

DRIVE = load_design(Path(__file__).parents[3] / "params" / "mbcdm.yaml").drive


def test_inertias_of_the_reference_drive() -> None:
    """Against the solids of the built design with all that turns with them, and all at the drum, kg m2."""
    found = inertias(DRIVE)
    assert found.bodies_kg_m2["drum"] == pytest.approx(9.931e-5, rel=0.005)
    assert found.bodies_kg_m2["input_left"] == pytest.approx(1.704e-7, rel=0.02)
    assert found.at_drum_kg_m2 == pytest.approx(6.0966e-2, rel=0.002)


def test_shaft_torque_has_a_dead_zone_of_the_lash() -> None:
    assert shaft_torque(0.5e-3, 1e-3, 30.0) == (0.0, 0.0)
    assert shaft_torque(1.5e-3, 1e-3, 30.0)[0] == pytest.approx(0.03)
    assert shaft_torque(-1.5e-3, 1e-3, 30.0)[0] == pytest.approx(-0.03)


def test_gearhead_loss_gives_its_efficiency() -> None:
    gear = gearhead_of(DRIVE)
    # Driven forward at constant speed the rotor's side carries the load and the loss.
    load = 0.1
    assert load / (load + gear.loss_share * load) == pytest.approx(DRIVE.gearhead.efficiency)
    assert gearhead_of(DRIVE, ideal=True).loss_share == 0.0


@pytest.mark.parametrize(
    "bad", [{"efficiency": 0.0}, {"efficiency": 1.2}, {"lash_rad": -1e-3}, {"stiffness_Nm_rad": 0.0}]
)
def test_gearhead_refuses_what_cannot_be(bad: dict[str, float]) -> None:
    with pytest.raises(ValueError, match=next(iter(bad))):
        GearheadSpec(76.0, **bad)


def test_motor_limit_is_the_paper_s() -> None:
    motor = motor_of(DRIVE)
    assert motor.torque_limit_Nm == pytest.approx(2.9e-3)
    with pytest.raises(ValueError, match="torque_limit_Nm"):
        MotorSpec(1e-7, 0.0)


def follow(spec: ControllerSpec, reference: np.ndarray, load: float = 0.0) -> tuple[np.ndarray, np.ndarray]:
    """A free inertia under the loop; angle and command at each period."""
    gains, state = np.array(spec.gains()), np.zeros(STATES)
    angle = speed = 0.0
    angles, commands = [], []
    fine = 10
    for target in reference:
        command = control(gains, state, target, angle)
        for _ in range(fine):
            speed += (command - load) / spec.inertia_kg_m2 / spec.rate_Hz / fine
            angle += speed / spec.rate_Hz / fine
        angles.append(angle)
        commands.append(command)
    return np.array(angles), np.array(commands)


def test_step_response_is_that_of_the_three_poles() -> None:
    spec = ControllerSpec(4e-4, 1e3, bandwidth_Hz=5.0, rate_Hz=20000.0, velocity_filter_Hz=5000.0)
    reference = np.tile([0.01, 0.0, 0.0], (10000, 1))
    angle, _ = follow(spec, reference)
    # Reference to angle with the feed-forward of a step left out: zeros from P and I, poles as stated.
    p, w = 2 * pi * 5.0, 6 * pi * 5.0
    poles = np.roots([1.0, 2 * w, w * w + 2 * w * p, w * w * p])
    zeros = np.array([2 * w * p, w * w * p])
    time = (np.arange(10000) + 1) / spec.rate_Hz
    exact = np.full(time.size, 0.01)
    for i, pole in enumerate(poles):
        others = np.prod([pole - other for k, other in enumerate(poles) if k != i])
        exact += np.real(0.01 * np.polyval(zeros, pole) / pole / others * np.exp(pole * time))
    error = np.abs(angle - exact).max()
    assert error < 2e-4, f"step of 10 mrad: off by {error * 1e3:.3f} mrad"


def test_a_steady_load_leaves_no_error_and_feed_forward_follows() -> None:
    spec = ControllerSpec(4e-4, 0.22, bandwidth_Hz=5.0)
    still, command = follow(spec, np.zeros((3000, 3)), load=0.05)
    assert still[-1] == pytest.approx(0.0, abs=1e-9)
    assert command[-1] == pytest.approx(0.05, rel=1e-6)
    time = np.arange(4000) / spec.rate_Hz
    omega = 2 * pi * 0.5
    wave = 0.45 * np.stack([1 - np.cos(omega * time), omega * np.sin(omega * time), omega**2 * np.cos(omega * time)], 1)
    moved, _ = follow(spec, wave)
    error = np.abs(moved - wave[:, 0])[1000:].max()
    assert error < 0.45 * 0.005, f"0.5 Hz with feed-forward: off by {error:.2e} rad of 0.9"


def test_integral_does_not_wind_up_beyond_the_limit() -> None:
    gains, state = np.array(ControllerSpec(4e-4, 0.22).gains()), np.zeros(STATES)
    for _ in range(5000):
        assert control(gains, state, np.array([10.0, 0.0, 0.0]), 0.0) == 0.22
    assert abs(state[SUM]) <= 0.22, f"integral stands at {state[SUM]:.3g} N m"
    assert state[LAST] == 0.0 and state[SPEED] == 0.0


def test_loop_refuses_a_rate_it_cannot_hold() -> None:
    with pytest.raises(ValueError, match="rate_Hz"):
        ControllerSpec(4e-4, 0.22, bandwidth_Hz=100.0, rate_Hz=1000.0)
