"""The time step compared with closed forms, with simple springs instead of cables.

The implicit step with dry friction: the conditions of contact hold for any initial guess.
"""

from __future__ import annotations

from math import pi, sqrt
from pathlib import Path

import numpy as np
import pytest

from mbcdm_cad.layouts.loader import load_design
from mbcdm_cad.rig.dynamic import plant
from mbcdm_cad.rig.dynamic.plant import _descend, solve_friction
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

SPRING_N_M = 5.5e5
RADII = ((6.0e-3, 54.0e-3, -1.0), (6.4e-3, 57.6e-3, 1.0))
ROTOR_INERTIA, PULLEY_INERTIA, DRUM_INERTIA = 3.75e-4, 1e-7, 1e-4
PRELOAD = 70.0


class Springs:
    """One input, two preloaded springs in the cables' place, a drum."""

    def __init__(self, h: float, drum_drag: float = 0.0, **row: float) -> None:
        self.h = h
        self.inputs = np.zeros((1, plant.INPUT_COLUMNS))
        self.inputs[0, [plant.ROTOR, plant.PULLEY, plant.STIFFNESS]] = ROTOR_INERTIA, PULLEY_INERTIA, 1e4
        for name, value in row.items():
            self.inputs[0, getattr(plant, name.upper())] = value
        self.cables = np.array([[s, inner, outer, SPRING_N_M, 0.0, 0.0] for inner, outer, s in RADII])
        self.drum = np.array([DRUM_INERTIA, drum_drag, *[0.0] * 7])
        self.plant = plant.Plant(self.inputs, self.cables, np.zeros(2, np.int64), self.drum)
        self.state = plant.State(np.zeros(3), np.zeros(3), np.zeros(3), np.zeros(3))
        self.q, self.v = self.state.q, self.state.v
        self.account = np.zeros(plant.ACCOUNTS)
        self.tension = self.pull()

    def stretch(self) -> np.ndarray:
        return self.cables[:, 0] * (self.cables[:, 1] * self.q[1] - self.cables[:, 2] * self.q[2])

    def pull(self) -> np.ndarray:
        return PRELOAD + SPRING_N_M * self.stretch()

    def step(self, motor: float = 0.0, load: float = 0.0, brake: float = 0.0) -> None:
        before, tension = self.stretch(), self.tension
        torques = plant.Torques(np.array([motor]), load, brake)
        plant.advance(self.plant, self.state, tension, torques, self.h, self.account)
        self.tension = self.pull()
        self.account[plant.CABLE_WORK] += ((tension + self.tension) / 2.0 * (self.stretch() - before)).sum()


def test_free_mode_has_the_frequency_of_two_inertias_and_a_spring() -> None:
    outer = SPRING_N_M * (0.054**2 + 0.0576**2)
    # The input seen at the drum is 81 times its inertia; the gearhead's spring is in series.
    gear = 1e4 * 81.0
    stiffness = 1.0 / (1.0 / outer + 1.0 / gear)
    reduced = 1.0 / (1.0 / DRUM_INERTIA + 1.0 / (81.0 * ROTOR_INERTIA))
    expected = sqrt(stiffness / reduced) / 2.0 / pi
    h = 2e-7
    system = Springs(h)
    system.inputs[0, plant.PULLEY] = 1e-10
    bias = PRELOAD * 0.4e-3  # what the unequal radii ask of the motor
    system.q[0] = bias / 1e4
    system.q[2] = 1e-6
    system.tension = system.pull()
    path = []
    for _ in range(int(10.0 / expected / h)):
        system.step(motor=bias)
        path.append(system.q[2] - system.q[1] / 9.0)
    path_array = np.array(path) - np.mean(path)
    crossings = np.flatnonzero((path_array[:-1] < 0) & (path_array[1:] >= 0))
    found = (crossings.size - 1) / ((crossings[-1] - crossings[0]) * h)
    assert found == pytest.approx(expected, rel=0.01), f"{found:.1f} Hz, closed form {expected:.1f} Hz"


def balance_error(h: float) -> tuple[float, float]:
    """What the account misses and what went through it, J, for a run with every loss in it."""
    system = Springs(
        h,
        drum_drag=5e-3,
        drag=2e-3,
        loss=0.47,
        viscous=1e-4,
        stiffness=30.0,
        lash=1e-3,
        mesh=1e-4,
        mesh_order=76.0,
        cogging=2e-3,
    )
    start = plant.stored(system.plant, system.state)
    for k in range(int(0.4 / h)):
        system.step(motor=0.1 * np.sin(2 * pi * 5.0 * k * h), load=0.2 * np.sin(2 * pi * 3.0 * k * h), brake=0.05)
    a = system.account
    lost = a[[plant.ROTOR_LOSS, plant.PULLEY_LOSS, plant.DRUM_LOSS, plant.VISCOUS_LOSS]]
    spent = a[plant.LOAD_WORK] + a[plant.CABLE_WORK] + lost.sum()
    missing = a[plant.MOTOR_WORK] - spent - (plant.stored(system.plant, system.state) - start)
    assert lost.min() >= 0.0 and lost[0] > 0.0 and lost[2] > 0.0, f"losses {lost} J"
    return float(missing), float(abs(a[plant.MOTOR_WORK]) + abs(a[plant.LOAD_WORK]))


def test_energy_balance_closes_with_the_step() -> None:
    coarse, through = balance_error(4e-5)
    fine, _ = balance_error(1e-5)
    assert abs(fine) < 0.02 * through, f"{fine:.3e} J of {through:.3e} J missing at a step of 10 us"
    assert abs(fine) < 0.5 * abs(coarse), f"missing {coarse:.3e} J at 40 us, {fine:.3e} J at 10 us"


def test_drum_held_by_the_brake_stands_still_and_the_balance_is_the_spring_s() -> None:
    system = Springs(1e-4, viscous=0.05)
    for _ in range(20000):
        system.step(motor=0.05, brake=2.0)
    assert system.q[2] == 0.0 and system.v[2] == 0.0
    torque = SPRING_N_M * (6.0e-3**2 + 6.4e-3**2) * system.q[1]
    assert torque + PRELOAD * 0.4e-3 == pytest.approx(0.05, rel=1e-3)


@pytest.mark.parametrize(("sign", "share"), [(1.0, 1.0 / 0.68), (-1.0, 2.0 - 1.0 / 0.68)])
def test_gearhead_s_efficiency_forward_and_backward(sign: float, share: float) -> None:
    """Motor torque at which a carried load of 0.1 N m just moves forward, or just moves backward."""
    load_at_drum = 0.1 * 9.0
    speeds = []
    for offset in (-0.01, 0.01):
        system = Springs(1e-4, loss=1.0 / 0.68 - 1.0, viscous=1e-3)
        motor = 0.1 * share * (1.0 + sign * offset)
        for k in range(12000):
            slowly = min(1.0, k / 8000)
            system.step(motor=motor * slowly, load=load_at_drum * slowly)
        speeds.append(sign * system.v[0])
    assert abs(speeds[0]) < 1e-3 < speeds[1], f"speeds {speeds} rad/s, 1 % below and above the closed form"


def case(rng: np.random.Generator, n: int = 6) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    root = rng.normal(size=(n, n))
    matrix = root @ root.T * 10 ** rng.uniform(-3, 3) + np.diag(10 ** rng.uniform(-6, 1, n))
    limit = np.where(rng.random(n) < 0.3, 0.0, 10 ** rng.uniform(-2, 0.5, n))
    return matrix, rng.normal(size=n), limit


def test_balance_and_friction_law_hold_for_any_guess() -> None:
    rng = np.random.default_rng(0)
    worst, stuck = 0.0, 0
    for _ in range(2000):
        matrix, b, limit = case(rng)
        guess = rng.integers(-1, 2, b.size).astype(float)
        v, push = np.zeros(b.size), np.zeros(b.size)
        solve_friction(matrix, b, limit, guess, v, push)
        balance = np.abs(matrix @ v - b - push).max()
        beyond = (np.abs(push) - limit).max()
        slides = np.abs(np.where(v != 0.0, push + limit * np.sign(v), 0.0)).max()
        worst = max(worst, balance, beyond, slides)
        stuck += int(((v == 0.0) & (limit > 0.0)).sum())
    assert worst < 1e-9, f"worst contradiction {worst:.3g}"
    assert stuck > 500, f"only {stuck} coordinates stuck: the cases test nothing"


def test_coordinate_descent_finds_the_same() -> None:
    rng = np.random.default_rng(1)
    for _ in range(50):
        root = rng.normal(size=(4, 4))
        matrix, b, limit = root @ root.T + np.eye(4), rng.normal(size=4), rng.uniform(0.0, 1.0, 4)
        found = []
        for solve in (solve_friction, _descend):
            v, push = np.zeros(4), np.zeros(4)
            solve(matrix, b, limit, np.zeros(4), v, push)
            found.append(np.concatenate([v, push]))
        assert found[1] == pytest.approx(found[0], abs=1e-9)


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
