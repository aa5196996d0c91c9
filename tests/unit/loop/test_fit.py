"""The joint fit and what it is fed: prepared runs, Wald figures, what is held out, generic curves."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
import pytest
from mujoco import sysid
from numpy.typing import NDArray
from scipy.optimize import lsq_linear
from scipy.stats import norm

import mbcdm_cad as mc
from benchmarks.studies.clustered import cell_grams, cluster_estimate
from mbcdm_cad.layouts.loader import layout_of, load_design
from mbcdm_cad.loop.effect import Effect
from mbcdm_cad.loop.effects import library
from mbcdm_cad.loop.prepare import setup
from mbcdm_cad.loop.prepare.prepared import prepare
from mbcdm_cad.loop.prepare.samples import held_sweeps, held_words
from mbcdm_cad.loop.prepare.setup import MOST_ORDER, order_spectrum
from mbcdm_cad.loop.result import LoopResult
from mbcdm_cad.loop.search.engine import close_loop
from mbcdm_cad.loop.search.fit import Fitter, _bounded_step
from mbcdm_cad.measurement.run import Run, Sensors
from mbcdm_cad.model.hysteresis import simulate
from mbcdm_cad.planning.plan import planned_fitter
from mbcdm_cad.routes import Floats
from tests.support.reference import DRIVE

D = layout_of(load_design(Path(__file__).parents[3] / "params" / "mbcdm.yaml").drive).si
RATIO = float(np.mean(D.total_ratio))
STEP = 1.9175e-4


def fitter() -> Fitter:
    """A minute of sines with a rope 10 % stiffer and a ratio 2e-4 off."""
    rng = np.random.default_rng(3)
    t = np.arange(0.0, 60.0, 0.04)
    angle = 0.45 * np.sin(2.0 * np.pi * t / 7.0)
    load = 0.9 * np.sin(2.0 * np.pi * t / 11.0) + 0.3 * np.sin(2.0 * np.pi * t / 5.1)
    inputs = np.stack([RATIO * angle, RATIO * angle])
    drum = simulate(D.with_(modulus_Pa=1.1 * D.modulus_Pa), inputs, load).drum_angle_rad + 2e-4 * angle
    read = STEP * np.floor(inputs / STEP + rng.random((2, 1)))
    run = Run(t, read, 1.3635e-6 * np.round(drum / 1.3635e-6), load, sensors=Sensors(STEP, 1.3635e-6, 0.005))
    return Fitter(D, RATIO, [prepare(run, RATIO)[1]])


def effect(f: Fitter, label: str) -> Effect:
    return next(e for e in library(D, f.runs[0]) if e.label == label)


MODULUS = "stiffness_error (modulus of the rope)"
SCALE = "ratio_error (pitch radius or encoder scale)"
LATE = "delay (late sensor)"


def test_kinds() -> None:
    f = fitter()
    kinds = {e.label: f.kind(e) for e in library(D, f.runs[0])}
    assert [kinds[e] for e in (MODULUS, "friction (bearing torque)", "once_per_rev guide (eccentric pulley)")] == [
        0
    ] * 3
    assert kinds["winding_history (profiles move with the pulleys)"] == 1, kinds
    assert [kinds[e] for e in (SCALE, LATE, "lash (play at the output)")] == [2] * 3


def test_friction_at_the_drum_loads_the_cables_and_not_the_shaft() -> None:
    f = fitter()
    friction, drag, shaft = (
        effect(f, label)
        for label in ("friction (bearing torque)", "delay (viscous drag)", "stiffness_error (compliance in series)")
    )
    rubs = [np.array([0.2]), np.array([0.3])]
    without = f.predict((friction, drag), rubs, np.zeros(f.free.size))
    with_it = f.predict((friction, drag, shaft), [*rubs, np.array([1e-4])], np.zeros(f.free.size))
    assert with_it - without == pytest.approx(-1e-4 * f.runs[0].load_Nm, abs=1e-12)


def test_what_only_adds_costs_no_simulation(monkeypatch: pytest.MonkeyPatch) -> None:
    calls = 0
    real = setup.respond

    def counted(*arguments: Any) -> Floats:
        nonlocal calls
        calls += 1
        return real(*arguments)

    monkeypatch.setattr(setup, "respond", counted)
    f = fitter()
    effects = [effect(f, SCALE), effect(f, MODULUS), effect(f, LATE)]
    f.predict(effects, [np.zeros(1)] * 3, np.zeros(1))
    first = calls
    for share in (1e-4, 2e-4, 3e-4):
        f.predict(effects, [np.array([share]), np.zeros(1), np.array([share])], np.zeros(1))
    assert calls == first, f"{calls - first} simulations for what only adds to the reading"
    f.predict(effects, [np.zeros(1), np.array([0.1]), np.zeros(1)], np.zeros(1))
    assert calls == first + 1


def test_order_of_effects_does_not_matter() -> None:
    f = fitter()
    one, two = effect(f, SCALE), effect(f, MODULUS)
    there = f.predict([one, two], [np.array([2e-4]), np.array([0.1])], np.zeros(1))
    back = f.predict([two, one], [np.array([0.1]), np.array([2e-4])], np.zeros(1))
    assert np.array_equal(there, back)


def test_slopes_from_elsewhere_end_at_the_same_values() -> None:
    f = fitter()
    effects = [effect(f, MODULUS), effect(f, SCALE)]
    exact = f.fit(effects, [[0.0], [0.0]])
    far = f.fit(effects, [[0.4], [1e-3]], iterations=0)
    quick = f.fit(effects, [[0.4], [1e-3]], slopes=far.jacobian, fresh=False, iterations=12)
    apart = [abs(float(q[0] / e[0]) - 1.0) for q, e in zip(quick.values, exact.values, strict=True)]
    assert exact.values[0][0] == pytest.approx(0.1, rel=0.03)
    assert exact.values[1][0] == pytest.approx(2e-4, rel=0.03)
    assert max(apart) < 2e-2, apart


def test_a_step_that_meets_a_bound_is_the_best_within_it() -> None:
    rng = np.random.default_rng(5)
    stopped = 0
    for _ in range(200):
        columns, aim = rng.normal(size=(30, 4)), rng.normal(size=30)
        columns[:, 1] = columns[:, 0] + 0.05 * columns[:, 1]  # as an offset of two encoders resembles an effect
        bounds = np.full((2, 4), np.inf) * [[-1.0], [1.0]]
        bounds[:, 0] = -rng.random(), rng.random()
        step = _bounded_step(columns.T @ columns, columns.T @ aim, 0.0, bounds)
        best = lsq_linear(columns, aim, bounds, tol=1e-12)
        assert step == pytest.approx(best.x, abs=1e-5), (step, best.x)
        stopped += bool(best.active_mask[0])
    assert stopped > 20, f"only {stopped} steps met the bound"


SIZES = {"friction (bearing torque)": [0.2], "lash input_right (play at an input)": [5e-3, 0.0]}


def run(flank_s: float) -> Run:
    """A sine under a brake that changes its sign within ``flank_s``."""
    t = np.arange(0.0, 60.0, 0.01)
    drum = 0.45 * np.sin(2.0 * np.pi * t / 10.0)
    load = 0.8 * np.tanh(np.cos(2.0 * np.pi * t / 10.0) * 10.0 / (np.pi * flank_s))
    inputs = np.stack([9.0 * drum, 9.0 * drum])
    return Run(
        t, inputs, simulate(layout_of(DRIVE).si, inputs, load).drum_angle_rad, load, sensors=Sensors(1e-6, 1e-9, None)
    )


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


# Order spectrum: a line stands where it is and as high as it is; nothing else does, however sweeps meet the angles.


def swept(samples: int = 16_000) -> np.ndarray:
    """Triangles at +-0.45 rad whose sweeps meet the same angles again, with 1 mrad of smooth rounding."""
    t = np.arange(samples) * 0.01
    return 0.45 * (2.0 / np.pi) * np.arcsin(0.998 * np.sin(2.0 * np.pi * 0.0625 * t))


def test_slow_trend_makes_no_fast_line() -> None:
    angle = swept()
    orders, amplitude = order_spectrum(angle, 1e-4 * np.sin(angle + 0.3))
    ghost = float(amplitude[orders > 100.0].max())
    assert ghost < 1e-8, f"a line of {ghost:.2g} rad where there is none"


@pytest.mark.parametrize("order", [45.0, 684.0, 2100.0])
def test_line_over_a_trend(order: float) -> None:
    angle = swept()
    orders, amplitude = order_spectrum(angle, 2e-5 * np.cos(order * angle + 1.0) + 1e-4 * np.sin(angle))
    fast = orders > 30.0
    k = int(np.argmax(np.where(fast, amplitude, 0.0)))
    assert abs(orders[k] - order) < 0.5 * 2.0 * np.pi / float(np.ptp(angle)), f"{orders[k]:.1f} for {order}"
    # At high orders a bin is a good part of a wave, and bins without a sample are filled from their neighbours.
    low = 0.5 if order > 2000.0 else 0.95
    assert low * 2e-5 < amplitude[k] < 1.02 * 2e-5, amplitude[k]


def test_no_order_beyond_what_is_looked_for() -> None:
    orders, _ = order_spectrum(swept(), np.zeros(16_000))
    assert orders[-1] <= MOST_ORDER


SWEEPS, SECTORS, IN_CELL = 20, 8, 40


def layout() -> tuple[Floats, NDArray[np.int64], NDArray[np.int64]]:
    one = np.linspace(-1.0, 1.0, SECTORS * IN_CELL)
    angle = np.concatenate([one if k % 2 == 0 else one[::-1] for k in range(SWEEPS)])
    sweep = np.repeat(np.arange(SWEEPS), one.size)
    sector = np.minimum((angle + 1.0) / 2.0 * SECTORS, SECTORS - 1).astype(np.int64)
    return angle, sweep, sector


def residual(rng: np.random.Generator, angle: Floats, sweep: NDArray[np.int64]) -> Floats:
    """Noise, a texture that repeats in angle, a level of each sweep."""
    at = np.linspace(-1.0, 1.0, 60)
    texture = np.interp(angle, at, rng.standard_normal(60))
    return texture + 0.5 * rng.standard_normal(SWEEPS)[sweep] + rng.standard_normal(angle.size)


def test_grams_are_those_of_the_samples() -> None:
    angle, sweep, sector = layout()
    x = np.column_stack([angle, angle**2])
    y = np.cos(5.0 * angle)
    cells = cell_grams(x, y, sweep, sector)
    table = np.column_stack([np.ones(angle.size), x, y])
    assert cells.gram.shape == (SWEEPS * SECTORS, 4, 4)
    np.testing.assert_allclose(cells.total, table.T @ table, rtol=1e-12, atol=1e-9)
    chosen = (sweep == 3) & (sector == 5)
    k = int(np.flatnonzero((cells.sweep == 3) & (cells.sector == 5))[0])
    np.testing.assert_allclose(cells.gram[k], table[chosen].T @ table[chosen], rtol=1e-12, atol=1e-9)


def test_level_on_residuals_that_repeat_in_angle() -> None:
    """A slope in angle, tested at 5 %, on residuals that have none."""
    angle, sweep, sector = layout()
    rng = np.random.default_rng(11)
    clustered = plain = 0
    for _ in range(400):
        y = residual(rng, angle, sweep)
        clustered += cluster_estimate(angle[:, None], y, sweep, sector).probability([0]) < 0.05
        slope = float(angle @ (y - y.mean()) / (angle @ angle))
        left = y - y.mean() - slope * angle
        z = slope / (left.std() / np.sqrt(angle @ angle))
        plain += 2.0 * norm.sf(abs(z)) < 0.05
    assert clustered / 400 < 0.10, clustered
    assert plain / 400 > 0.4, plain


def test_true_slope_is_found_and_covered() -> None:
    angle, sweep, sector = layout()
    rng = np.random.default_rng(5)
    covered = found = 0
    for _ in range(200):
        y = residual(rng, angle, sweep) + 3.0 * angle
        one = cluster_estimate(angle[:, None], y, sweep, sector)
        covered += abs(one.value[0] - 3.0) <= one.half_width()[0]
        found += one.probability([0]) < 0.05 / 14
    assert 0.85 <= covered / 200 <= 0.995, covered
    assert found / 200 > 0.95, found


def test_nuisance_takes_its_part_and_twins_are_not_told_apart() -> None:
    angle, sweep, sector = layout()
    rng = np.random.default_rng(2)
    y = residual(rng, angle, sweep) + 3.0 * angle
    twin = np.column_stack([angle, 2.0 * angle])
    one = cluster_estimate(twin, y, sweep, sector)
    assert one.probability([0]) == one.probability([1]) == 1.0
    beside = cluster_estimate(np.column_stack([angle, angle + 1e-3 * np.sin(9.0 * angle)]), y, sweep, sector)
    assert beside.probability([0]) > 0.01


def sweeps(loads: list[float], count: int) -> tuple[np.ndarray, Floats, Floats]:
    one = np.linspace(-0.5, 0.5, 50)
    output = np.concatenate([one if k % 2 == 0 else one[::-1] for k in range(count)])
    sweep = np.repeat(np.arange(count), one.size)
    return sweep, output, np.array(loads)[sweep % len(loads)]


@pytest.mark.parametrize("rhythm", [1, 2, 3, 4, 5, 6, 8])
@pytest.mark.parametrize("count", [12, 16, 17, 24])
def test_loads_and_directions_are_those_of_the_whole(rhythm: int, count: int) -> None:
    levels = list(np.cos(np.pi * np.arange(rhythm) * 3 / max(rhythm, 1)) * np.linspace(1.0, 0.3, rhythm))
    sweep, output, load = sweeps([float(v) for v in levels], count)
    held = held_sweeps(sweep, output, load)
    chosen = np.isin(sweep, held)
    assert 0.15 <= chosen.mean() <= 0.35, held
    assert {int(k) % 2 for k in held} == {0, 1}, held
    whole, part = float(np.std(load)), float(np.std(load[chosen]))
    assert part >= 0.5 * whole, (
        f"{count} half sweeps, {held} held back: spread of the load {whole:.3f}, there {part:.3f}"
    )


@pytest.mark.parametrize("seed", range(8))
def test_loads_that_change_within_half_sweeps_are_all_held_back(seed: int) -> None:
    """The loads jump at random times: half sweeps with the same mean load have different loads."""
    rng = np.random.default_rng(seed)
    sweep, output, _ = sweeps([0.0], 20)
    jumps = np.sort(rng.choice(np.arange(1, sweep.size), 30, replace=False))
    load = rng.uniform(-1.0, 1.0, 31)[np.searchsorted(jumps, np.arange(sweep.size), side="right")]
    held = np.isin(sweep, held_sweeps(sweep, output, load))
    edges = np.linspace(load.min(), load.max(), 5)
    whole, there = (np.histogram(part, edges)[0] / part.size for part in (load, load[held]))
    assert 0.15 <= held.mean() <= 0.35, held.mean()
    assert np.abs(whole - there).sum() / 2 < 0.22, f"shares of four bins of the load: all {whole}, held back {there}"


def test_few_or_unused_sweeps() -> None:
    sweep, output, load = sweeps([1.0], 3)
    assert held_sweeps(sweep, output, load).size == 1
    assert held_sweeps(sweep - 2, output, None).size == 0
    assert held_sweeps(sweep, output, None).size == 1


def test_words_name_numbers_of_the_run_and_loads() -> None:
    """The first half sweep of a run is not used, so the first that is has the number 2."""
    sweep, _, load = sweeps([0.9, -0.9], 8)
    assert held_words(np.array([1, 4]), sweep, load, False) == "half sweeps 3, 6 (mean loads -0.9 to 0.9 N m)"
    assert held_words(np.array([2, 6]), sweep, None, True) == "eighths 3, 7 of the time"
    assert held_words(np.array([], dtype=int), sweep, load, False) == "none"


def found(error: Callable[[np.ndarray, np.ndarray], np.ndarray]) -> LoopResult:
    """The finding on a sine of a drive of which the ratio is known; the error from angle and speed of the output."""
    t = np.arange(0.0, 120.0, 0.04)
    angle = 0.5 * np.sin(2.0 * np.pi * t / 11.0)
    out = angle + error(angle, np.gradient(angle, t)) + 1e-5 * np.random.default_rng(7).standard_normal(t.size)
    return close_loop(None, [Run(t, (5.0 * angle)[None], out, None, input_names=("input",), ratio=5.0)])


def test_the_square_of_the_speed_is_no_wave_that_looks_like_it_on_a_sine() -> None:
    """A wave of the drum has any phase: that of a parabola in the middle of the travel is chance."""
    result = found(lambda angle, speed: 2e-3 * speed**2)
    assert result.verdict == "unknown" and not result.effects and not result.one_of, result.sentence
    wave = found(lambda angle, speed: 2e-3 * np.cos(angle + 1.0))
    named = [one.name for one in wave.effects] + [one.name for group in wave.one_of for one in group]
    assert "once_per_rev" in named, wave.sentence


def test_a_walk_with_the_whole_path_is_not_a_walk_one_way_beside_a_wrong_ratio() -> None:
    def error(angle: np.ndarray, speed: np.ndarray) -> np.ndarray:
        path = np.cumsum(np.abs(np.diff(angle, prepend=angle[0])))
        return np.asarray(4e-5 * path + 2e-4 * np.cos(44.0 * angle))

    result = found(error)
    named = [one.name for one in result.effects] + [one.name for group in result.one_of for one in group]
    assert "ripple" in named and "ratio_error" not in named, result.sentence


REDUCTION, ARM_M, MASSES_KG, COMPLIANCE = 4.0, 0.2, (0.5, 1.0), 4e-3
GRAVITY = 9.80665
TIME = np.arange(0.0, 60.0, 0.02)
DRIVEN = np.radians(100.0) * np.sin(2.0 * np.pi * TIME / 10.0)


def arm(mass_kg: float, seed: int) -> np.ndarray:
    """Angle of the arm from hanging down, with noise: the shaft twists by its compliance times weight and inertia."""
    inertia = mass_kg * ARM_M**2
    acceleration = -((2.0 * np.pi / 10.0) ** 2) * DRIVEN
    angle = DRIVEN
    for _ in range(5):
        angle = DRIVEN - COMPLIANCE * (mass_kg * GRAVITY * ARM_M * np.sin(angle) + inertia * acceleration)
    return np.asarray(angle + 1e-4 * np.random.default_rng(seed).standard_normal(TIME.size))


RUNS = {mass_kg: arm(mass_kg, seed) for seed, mass_kg in enumerate(MASSES_KG)}


def by_the_loop(folder: Path) -> float:
    files = []
    for mass_kg, angle in RUNS.items():
        name = f"with_{1e3 * mass_kg:.0f}_g"
        table = np.column_stack([TIME, REDUCTION * DRIVEN, angle])
        np.savetxt(folder / f"{name}.csv", table, delimiter=",", header="t,motor_rad,arm_rad", comments="", fmt="%.7f")
        load = f"load: {{pendulum: {{mass_kg: {mass_kg}, arm_mm: {1e3 * ARM_M}}}}}\n"
        files.append(folder / f"{name}.yaml")
        files[-1].write_text(mc.draft_measurement(folder / f"{name}.csv", ratio=REDUCTION) + load)
    result = mc.close_loop(None, files).result
    assert [one.name for one in result.effects] == ["stiffness_error"], result.sentence
    found = result.effects[0].parameters["compliance_rad_Nm"]
    assert found.low < COMPLIANCE < found.high, result.sentence
    return found.value


def by_mujoco() -> float:
    """A hinge whose position is held to the motor's by a spring; its stiffness and damping are fitted."""
    fine = np.arange(0.0, TIME[-1], 0.002)
    sequences = []
    for mass_kg, angle in RUNS.items():
        spec = mujoco.MjSpec.from_string(
            f"""<mujoco><option timestep="0.002" gravity="0 0 -{GRAVITY}"/><worldbody><body>
            <joint name="arm" type="hinge" axis="0 -1 0" damping="0.02"/>
            <inertial pos="0 0 -{ARM_M}" mass="{mass_kg}" diaginertia="1e-9 1e-9 1e-9"/></body></worldbody>
            <actuator><position name="shaft" joint="arm" kp="100"/></actuator>
            <sensor><jointpos name="angle" joint="arm"/></sensor></mujoco>"""
        )
        model = spec.compile()
        start = sysid.create_initial_state(model, angle[:1], np.gradient(DRIVEN, TIME)[:1], np.empty(0))
        control = sysid.TimeSeries.from_control_names(fine, np.interp(fine, TIME, DRIVEN)[:, None], model)
        seen = sysid.TimeSeries.from_names(TIME, angle[:, None], model, ["angle"])
        sequences.append(sysid.ModelSequences(f"{mass_kg}", spec, "run", start, control, seen))
    wanted = sysid.ParameterDict(
        {
            "shaft": sysid.Parameter(
                "shaft", 100.0, 20.0, 1000.0, modifier=lambda s, p: sysid.apply_pgain(s, "shaft", p.value[0])
            )
        }
    )
    found, _ = sysid.optimize(wanted, sysid.build_residual_fn(models_sequences=sequences), verbose=False)
    return 1.0 / float(found["shaft"].value[0])


def test_loop_and_mujoco_find_the_same_compliance(tmp_path: Path) -> None:
    loop, other = by_the_loop(tmp_path), by_mujoco()
    print(f"compliance: {1e3 * COMPLIANCE} mrad/(N m) true, {1e3 * loop:.3f} by the loop, {1e3 * other:.3f} by MuJoCo")
    assert abs(loop / COMPLIANCE - 1.0) < 0.02 and abs(other / COMPLIANCE - 1.0) < 0.05, (loop, other)
    assert abs(loop / other - 1.0) < 0.05, (loop, other)
