"""Whole runs of the dynamic rig: laws for any cables."""

from dataclasses import replace
from math import pi, sqrt
from pathlib import Path

import numpy as np
import pytest
import yaml

from benchmarks.studies.paper_experiments import first_saturated_Nm, given_way_Nm, reversal_swings_rad
from mbcdm_cad.errors import InputError
from mbcdm_cad.layouts.loader import layout_of, load_design
from mbcdm_cad.model.capability import torque_at_input_limit_Nm
from mbcdm_cad.model.hysteresis import simulate
from mbcdm_cad.rig import quasistatic
from mbcdm_cad.rig.chain import chains
from mbcdm_cad.rig.command import simulate_command
from mbcdm_cad.rig.dynamic import plant, train
from mbcdm_cad.rig.dynamic.plant import _descend, solve_friction
from mbcdm_cad.rig.dynamic.run import DynamicRun, run_dynamic
from mbcdm_cad.rig.dynamic.simulate import simulate_dynamic, truth_of
from mbcdm_cad.rig.dynamic.train import DynamicRig, EncoderSpec, inertias, rig_of
from mbcdm_cad.rig.experiment import DynamicExperiment, RigError, read_experiment
from tests.support.reference import DRIVE, ROOT


def quiet(rig: DynamicRig) -> DynamicRig:
    """The rig with encoders without counts or noise."""
    none = EncoderSpec(0.0)
    return replace(rig, encoders=(none, none), drum_encoder=none, torque_noise_Nm=0.0)


def missing_J(run: DynamicRun) -> float:
    """Energy that the account does not find."""
    e = run.energy_J
    spent = sum(e[name] for name in ("load", "rotor_friction", "pulley_friction", "drum_friction", "viscous", "cables"))
    return e["motor"] - spent - e["stored"]


def test_energy_balance_of_a_braked_run() -> None:
    run = run_dynamic(quiet(rig_of(DRIVE)), train.sine(0.05, 0.5, 2, 1000.0), brake_Nm=0.91)
    through = run.energy_J["motor"]
    assert abs(missing_J(run)) < 2e-3 * through, f"{missing_J(run):.3e} J of {through:.3e} J missing"
    # A brake of 0.91 N m over what the drum travelled.
    travelled = np.abs(np.diff(run.drum_rad)).sum()
    assert run.energy_J["drum_friction"] == pytest.approx(0.91 * travelled, rel=5e-3)


def test_friction_of_the_bearings_by_speed_and_load_takes_the_energy_of_its_law() -> None:
    """The law once more, over the logged motion; the load drives the drum in every other half sweep."""
    law = train.LoadSpec(0.0, 1.0, 1e-3, 0.0, 0.0, 0.02, 0.2, 0.02, 0.1, 0.2, 0.1)
    reference = train.sine(0.05, 0.5, 2, 1000.0)
    run = run_dynamic(quiet(rig_of(DRIVE, law)), reference, 0.5 * np.ones(reference.shape[0]), log_rate_Hz=1000.0)
    w = np.gradient(run.drum_rad, run.time_s)
    limit = 0.02 + 0.02 * np.exp(-np.abs(w) / 0.1) + 0.5 * np.where(w > 0.0, 0.2, 0.1)
    expected = float(np.sum(limit * np.abs(w)) * (run.time_s[1] - run.time_s[0]))
    assert run.energy_J["drum_friction"] == pytest.approx(expected, rel=0.01)
    assert abs(missing_J(run)) < 2e-3 * run.energy_J["motor"]


def test_same_seed_same_run() -> None:
    rig = rig_of(DRIVE)
    rig = replace(rig, encoders=tuple(replace(e, noise_rad=1e-5) for e in rig.encoders))
    reference = train.sine(0.01, 1.0, 1, 1000.0)
    first, again, other = (run_dynamic(rig, reference, brake_Nm=0.3, seed=s) for s in (3, 3, 4))
    for name in ("drum_rad", "measured_input_rad", "measured_torque_Nm", "tension_N"):
        assert getattr(first, name).tobytes() == getattr(again, name).tobytes(), name
        assert getattr(first, name).tobytes() != getattr(other, name).tobytes(), name


def test_measured_angles_are_whole_counts_and_the_delay_shifts_them() -> None:
    rig = rig_of(DRIVE)
    reference = train.sine(0.05, 0.5, 1, 1000.0)
    run = run_dynamic(rig, reference, log_rate_Hz=1000.0)
    counts = run.measured_input_rad / rig.encoders[0].resolution_rad
    assert np.abs(counts - np.round(counts)).max() < 1e-6
    assert np.abs(run.measured_input_rad - run.input_rad).max() <= rig.encoders[0].resolution_rad * 0.501
    late = replace(quiet(rig), encoders=(EncoderSpec(0.0, delay_s=0.004),) * 2)
    run = run_dynamic(late, reference, log_rate_Hz=1000.0)
    shift = np.abs(run.measured_input_rad[:, 4:] - run.input_rad[:, :-4]).max()
    assert shift == 0.0, f"readings 4 ms old differ by {shift:.3g} rad from the angles 4 ms ago"


def test_loops_hold_the_inputs_on_average() -> None:
    run = run_dynamic(rig_of(DRIVE), train.sine(0.05, 0.1, 1.5, 1000.0), brake_Nm=0.91)
    error = run.input_rad[:, 500:] - 9.0 * run.reference_rad[500:]
    assert np.abs(error).mean() < 2e-3, f"inputs are off by {np.abs(error).mean():.2e} rad on average"


def test_sensor_reads_the_brake_while_the_drum_turns() -> None:
    load = train.LoadSpec(bearing_drag_Nm=0.05)
    run = run_dynamic(quiet(rig_of(DRIVE, load)), train.sine(0.05, 0.1, 0.5, 1000.0), brake_Nm=0.5)
    turning = (run.time_s > 1.0) & (run.time_s < 2.0)
    assert run.torque_Nm[turning] == pytest.approx(0.5, abs=1e-6), "bearing drag is behind the sensor"


def test_inertia_plate_is_felt_as_torque() -> None:
    plate = 2e-3
    reference = train.sine(0.05, 1.0, 3, 1000.0)
    run = run_dynamic(quiet(rig_of(DRIVE, train.LoadSpec(inertia_kg_m2=plate))), reference, log_rate_Hz=1000.0)
    wave = np.exp(2j * np.pi * run.time_s[1000:])  # whole turns of the 1 Hz line
    torque, angle = (abs(np.vdot(wave, x[1000:])) * 2 / wave.size for x in (run.torque_Nm, run.drum_rad))
    assert torque == pytest.approx(plate * (2 * np.pi) ** 2 * angle, rel=0.01), "torque is plate times acceleration"


@pytest.mark.slow
def test_a_brake_with_a_higher_static_level_sticks_and_slips() -> None:
    def jumps(ratio: float) -> float:
        load = train.LoadSpec(inertia_kg_m2=1e-3, static_ratio=ratio, static_speed_rad_s=5e-3)
        run = run_dynamic(
            quiet(rig_of(DRIVE, load)), train.sine(0.002, 0.05, 1, 1000.0), brake_Nm=0.91, log_rate_Hz=1000.0
        )
        speed = np.abs(np.diff(run.drum_rad)) * 1000.0
        return float(speed[2000:].max())

    smooth, rough = jumps(1.0), jumps(1.3)
    assert rough > 3.0 * smooth, f"fastest {smooth:.2e} rad/s with one level, {rough:.2e} rad/s with 1.3 at standstill"


def test_lash_adds_to_what_rotor_and_pulley_turn_against_each_other() -> None:
    def twist(lash: float) -> float:
        rig = quiet(rig_of(DRIVE))
        rig = replace(rig, gearheads=tuple(replace(g, lash_rad=lash) for g in rig.gearheads))
        run = run_dynamic(rig, train.sine(0.02, 0.2, 2, 1000.0), brake_Nm=0.91, log_rate_Hz=1000.0)
        turned = (run.rotor_rad - run.input_rad)[1, 2000:]
        torque = run.torque_Nm[2000:]
        return float(np.median(turned[torque > 0.9]) - np.median(turned[torque < -0.9]))

    tight, loose = twist(0.0), twist(0.02)
    assert loose - tight == pytest.approx(0.02, rel=0.05), f"twists {tight:.5f} and {loose:.5f} rad"


@pytest.mark.slow
def test_a_longer_step_converges_to_the_same_run() -> None:
    def swing(step_s: float) -> float:
        rig = replace(quiet(rig_of(DRIVE)), step_s=step_s)
        return float(
            np.mean(reversal_swings_rad(run_dynamic(rig, train.sine(0.02, 0.2, 2, 1000.0), brake_Nm=0.91), DRIVE))
        )

    coarse, usual, fine = swing(5e-4), swing(1e-4), swing(5e-5)
    assert abs(usual - fine) < 2e-7, f"swings {coarse:.7f}, {usual:.7f}, {fine:.7f} rad at 500, 100, 50 us"
    assert abs(coarse - fine) < 2e-6, f"swings {coarse:.7f}, {usual:.7f}, {fine:.7f} rad at 500, 100, 50 us"


def test_reference_s_speed_and_acceleration_are_its_derivatives() -> None:
    reference = train.sine(0.1, 0.5, 1, 10000.0)
    for order in (1, 2):
        slope = np.gradient(reference[:, order - 1], 1e-4)[1:-1]
        error = np.abs(slope - reference[1:-1, order]).max() / np.abs(slope).max()
        assert error < 1e-3, f"derivative {order} differs by {error:.2e} of its size"
    assert reference[0] == pytest.approx([0.0, 0.0, 0.0]), "it does not start from rest"


def test_rates_that_do_not_divide_are_refused() -> None:
    with pytest.raises(ValueError, match="log_rate_Hz"):
        run_dynamic(rig_of(DRIVE), train.standstill(0.01, 1000.0), log_rate_Hz=300.0)
    with pytest.raises(ValueError, match="step_s"):
        run_dynamic(replace(rig_of(DRIVE), step_s=3e-4), train.standstill(0.01, 1000.0))


def ideal(**changes: object) -> DynamicRig:
    """Lossless motors and gearheads, encoders without counts: what the analytic model assumes."""
    rig = rig_of(DRIVE, ideal_gearhead=True)
    none = EncoderSpec(0.0)
    motors = tuple(replace(m, coulomb_Nm=0.0, viscous_Nms=0.0) for m in rig.motors)
    changed = replace(rig, motors=motors, encoders=(none, none), drum_encoder=none, torque_noise_Nm=0.0)
    return replace(changed, **changes)  # type: ignore[arg-type]


def ramp(rig: DynamicRig, sign: float) -> tuple[float, float]:
    """Load at which the first input is at its limit, and at which the drum is off by 20 mrad, N m."""
    slope, rate = 0.2, rig.loops[0].rate_Hz
    reference = train.standstill(4.4 / slope, rate)
    run = run_dynamic(rig, reference, sign * slope / rate * np.arange(reference.shape[0], dtype=float))
    return first_saturated_Nm(run, [loop.torque_limit_Nm for loop in rig.loops]), given_way_Nm(run)


@pytest.mark.parametrize(("sign", "known_Nm"), [(1.0, 3.747), (-1.0, 3.194)])
@pytest.mark.slow
def test_drive_limit_both_ways(sign: float, known_Nm: float) -> None:
    """The first input saturates where the analytic model says; the drum holds on until both do, at 3.967 N m."""
    limit = DRIVE.motor.rated_torque_mNm * 1e-3 * DRIVE.gearhead.ratio
    expected = float(torque_at_input_limit_Nm(layout_of(DRIVE).si, limit, int(sign)).min())
    first, gives_way = ramp(ideal(), sign)
    assert expected == pytest.approx(known_Nm, abs=2e-3)
    assert first == pytest.approx(expected, rel=0.01), f"rig {first:.4f} N m, model {expected:.4f} N m"
    assert gives_way == pytest.approx(2.0 * limit * 9.0, rel=0.03), f"{gives_way:.3f} N m with the ramp's lag"


def test_braked_run_is_the_analytic_model_where_its_assumptions_hold() -> None:
    """Wraps that stand still: the drum stands where the model puts it at the same input angles and load."""
    rig = ideal(transport=False)
    run = run_dynamic(rig, train.sine(0.05, 0.2, 2, 1000.0), brake_Nm=0.91)
    model = simulate(layout_of(DRIVE).si, run.input_rad, run.torque_Nm)
    still = np.abs(np.gradient(run.torque_Nm, run.time_s)) < 1.0
    error = np.abs(run.drum_rad - model.drum_angle_rad)[still].max()
    size = np.abs(model.drum_angle_rad - run.input_rad.mean(axis=0) / 9.0)[still].max()
    assert error < 0.005 * size, f"{error * 1e6:.3f} urad of {size * 1e6:.1f} urad beside the model"


@pytest.mark.parametrize("passed_slip", [False, True])
def test_slow_run_is_the_quasi_static_rig(passed_slip: bool) -> None:
    """The same chains in balance at each sample: drum and tensions agree where nothing accelerates."""
    rig = ideal(passed_slip=passed_slip)
    run = run_dynamic(rig, train.sine(0.05, 0.1, 1, 1000.0), brake_Nm=0.91, log_rate_Hz=200.0)
    n, cables = run.time_s.size, rig.cables
    pulleys, drum, tension = np.empty((2, n)), np.empty(n), np.empty((4, n))
    none = np.zeros((4, n))
    held = np.array([[np.inf, 0.0], [np.inf, 0.0]])
    state = chains(cables, passed_slip=passed_slip)
    of = np.array([c.input_index for c in cables])
    angle = np.ascontiguousarray(run.input_rad)
    course = quasistatic.QuasistaticCourse(
        of,
        held,
        angle,
        none,
        none,
        run.drum_rad,
        run.torque_Nm,
        np.zeros((4, 3, 0)),
        np.zeros((0, 2), dtype=np.int64),
        np.zeros(4),
        np.zeros(run.drum_rad.size),
    )
    failed = quasistatic.run(state, course, pulleys, drum, tension)
    assert failed < 0
    still = np.abs(np.gradient(run.torque_Nm, run.time_s)) < 1.0
    error = np.abs(run.drum_rad - drum)[still].max()
    pull = np.abs(run.tension_N - tension)[:, still].max()
    assert error < 1.5e-6, f"drum differs by {error * 1e6:.3f} urad"
    assert pull < 0.1, f"tensions differ by {pull:.3f} N"


def test_carried_rope_widens_the_loop() -> None:
    """What the model leaves out on purpose: about an eighth more at +-50 mrad under 0.91 N m."""
    widths = []
    for transport in (False, True):
        run = run_dynamic(ideal(transport=transport), train.sine(0.05, 0.2, 2, 1000.0), brake_Nm=0.91)
        error = (run.drum_rad - run.input_rad.mean(axis=0) / 9.0)[500:]
        widths.append(float(np.ptp(error)))
    assert 1.08 < widths[1] / widths[0] < 1.20, f"widths {widths} rad"


@pytest.mark.slow
def test_shorter_pieces_change_little() -> None:
    swings = []
    for piece_rad in (0.04, 0.02, 0.01):
        run = run_dynamic(ideal(piece_rad=piece_rad), train.sine(0.05, 0.2, 2, 1000.0), brake_Nm=0.91)
        swings.append(float(np.ptp((run.drum_rad - run.input_rad.mean(axis=0) / 9.0)[500:])))
    assert abs(swings[1] - swings[2]) < 0.01 * swings[2], f"widths {swings} rad at pieces of 40, 20, 10 mrad"


def test_eccentric_guide_turns_the_drum_and_keeps_the_energy_balance() -> None:
    """A path that depends on the angles must pull on the pulleys too: without that, energy would not balance."""
    rig = ideal(paths=(lambda inputs, drum: np.outer([-1e-5, 1e-5, 1e-5, -1e-5], np.sin(6.0 * drum)),))
    run = run_dynamic(rig, train.sine(0.2, 0.5, 2, 1000.0), brake_Nm=0.2)
    plain = run_dynamic(ideal(), train.sine(0.2, 0.5, 2, 1000.0), brake_Nm=0.2)
    turned, still = (r.drum_rad - r.input_rad.mean(axis=0) / 9.0 for r in (run, plain))
    shift = np.abs(turned - still)
    e = run.energy_J
    spent = sum(e[name] for name in ("load", "rotor_friction", "pulley_friction", "drum_friction", "viscous", "cables"))
    missing = e["motor"] - spent - e["stored"]
    assert shift.max() > 5e-5, f"the path moved the drum by {shift.max():.2e} rad only"
    assert abs(missing) < 5e-3 * e["motor"], f"{missing:.2e} J of {e['motor']:.2e} J missing"


REFERENCE = load_design(ROOT / "params" / "mbcdm.yaml").drive
SHORT = """
rig: dynamic
name: short
duration_s: 2.0
motion: {shape: sine, amplitude_mrad: 20.0, frequency_Hz: 0.5}
load: {brake_Nm: 0.5}
"""


def read(text: str, folder: Path) -> DynamicExperiment:
    path = folder / "experiment.yaml"
    path.write_text(text)
    experiment = read_experiment(path)
    assert isinstance(experiment, DynamicExperiment)
    return experiment


def test_files_of_a_run_are_a_measurement_with_its_truth_apart(tmp_path: Path) -> None:
    said = simulate_command(REFERENCE, read(SHORT, tmp_path), tmp_path / "out")
    folder = tmp_path / "out" / "short"
    assert sorted(p.name for p in folder.iterdir()) == ["short.csv", "short.png", "short.truth.yaml", "short.yaml"]
    rows = np.genfromtxt(folder / "short.csv", delimiter=",", names=True)
    assert rows.dtype.names == ("t", "q_left", "q_right", "q_out", "tau") and rows.size == 200
    assert np.abs(rows["tau"]).max() == pytest.approx(0.5, abs=0.03)
    measurement = yaml.safe_load((folder / "short.yaml").read_text())
    assert measurement["columns"]["load_torque"] == {"column": "tau", "unit": "N*m"}
    assert [e["name"] for e in yaml.safe_load((folder / "short.truth.yaml").read_text())["effects"]] == [
        "winding_history"
    ]
    assert "200 samples" in said
    before = {p.name: p.read_bytes() for p in folder.iterdir()}
    simulate_command(REFERENCE, read(SHORT, tmp_path), tmp_path / "out")
    assert {p.name: p.read_bytes() for p in folder.iterdir()} == before, "the same file gave other bytes"


@pytest.mark.slow
def test_every_cause_is_in_the_truth_and_changes_the_run(tmp_path: Path) -> None:
    plain, _, _ = simulate_dynamic(REFERENCE, read(SHORT, tmp_path))
    changes = {
        "drives: {cogging_share: 0.05}": "ripple",
        "drives: {mesh_error_urad: 100.0}": "ripple",
        "drives: {lash_mrad: 5.0}": "lash",
        "bearings: {drum_Nm: 0.05}": "friction",
        "bearings: {guide_Nm: 0.005}": "friction",
        "sensors: {output_delay_s: 0.01}": "delay",
        "physics: {guide_slip: true}": "passed_slip",
        "effects: [{effect: preload, share: -0.2}]": "preload_error",
        "effects: [{effect: eccentric_pulley, stage: guide, eccentricity_um: 20.0}]": "once_per_rev",
    }
    for line, name in changes.items():
        experiment = read(SHORT + line, tmp_path)
        run, bench, _ = simulate_dynamic(REFERENCE, experiment)
        assert name in [entry["name"] for entry in truth_of(experiment, bench)], line
        moved = np.abs(run.measured_drum_rad - plain.measured_drum_rad).max()
        assert moved > 2e-6, f"{line}: the output moved by {moved:.2e} rad"


def test_brake_that_sticks_is_told(tmp_path: Path) -> None:
    experiment = read(SHORT.replace("brake_Nm: 0.5", "brake_Nm: 0.5, static_ratio: 1.3"), tmp_path)
    assert experiment.load.static_ratio == 1.3
    _, bench, _ = simulate_dynamic(REFERENCE, experiment)
    assert "brake_stick_slip" in [entry["name"] for entry in truth_of(experiment, bench)]


@pytest.mark.parametrize(
    ("text", "word"),
    [
        (SHORT + "drives: {lash: 3}\n", "lash"),
        (SHORT.replace("duration_s: 2.0", "duration_s: -1"), "duration_s"),
        (SHORT.replace("dynamic", "static"), "rig"),
        (SHORT + "effects: [{effect: nothing}]\n", "unknown effect"),
    ],
)
def test_bad_files_are_refused_with_their_line(text: str, word: str, tmp_path: Path) -> None:
    with pytest.raises(InputError, match=word) as caught:
        read(text, tmp_path)
    assert all(problem.line > 0 for problem in caught.value.problems)


def test_what_the_rig_cannot_do_is_said(tmp_path: Path) -> None:
    for effect in ("temperature, rise_K: 5.0", "motor_cogging, stage: input_left, torque_mNm: 0.1"):
        with pytest.raises(RigError, match="not on the dynamic rig"):
            simulate_dynamic(REFERENCE, read(SHORT + f"effects: [{{effect: {effect}}}]\n", tmp_path))
    with pytest.raises(RigError, match="cable_9"):
        simulate_dynamic(
            REFERENCE, read(SHORT + "effects: [{effect: preload, share: 0.1, cables: [cable_9]}]\n", tmp_path)
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


def test_inertias_of_the_reference_drive() -> None:
    """Against the solids of the built design with all that turns with them, and all at the drum, kg m2."""
    found = inertias(DRIVE)
    assert found.bodies_kg_m2["drum"] == pytest.approx(9.931e-5, rel=0.005)
    assert found.bodies_kg_m2["input_left"] == pytest.approx(1.704e-7, rel=0.02)
    at_inputs = np.array(found.inputs_kg_m2) + found.rotor_kg_m2 * found.gear_ratio**2
    total = found.drum_and_passed_kg_m2 + at_inputs @ [body.turns_per_drum**2 for body in found.routes.inputs]
    assert total == pytest.approx(6.0966e-2, rel=0.002)


def test_shaft_torque_has_a_dead_zone_of_the_lash() -> None:
    assert train.shaft_torque(0.5e-3, 1e-3, 30.0) == (0.0, 0.0)
    assert train.shaft_torque(1.5e-3, 1e-3, 30.0)[0] == pytest.approx(0.03)
    assert train.shaft_torque(-1.5e-3, 1e-3, 30.0)[0] == pytest.approx(-0.03)


def test_gearhead_loss_gives_its_efficiency() -> None:
    gear = train.gearhead_of(DRIVE)
    # Driven forward at constant speed the rotor's side carries the load and the loss.
    load = 0.1
    assert load / (load + gear.loss_share * load) == pytest.approx(DRIVE.gearhead.efficiency)
    assert train.gearhead_of(DRIVE, ideal=True).loss_share == 0.0


@pytest.mark.parametrize(
    "bad", [{"efficiency": 0.0}, {"efficiency": 1.2}, {"lash_rad": -1e-3}, {"stiffness_Nm_rad": 0.0}]
)
def test_gearhead_refuses_what_cannot_be(bad: dict[str, float]) -> None:
    with pytest.raises(ValueError, match=next(iter(bad))):
        train.GearheadSpec(76.0, **bad)


def test_motor_limit_is_the_paper_s() -> None:
    motor = train.motor_of(DRIVE)
    assert motor.torque_limit_Nm == pytest.approx(2.9e-3)
    with pytest.raises(ValueError, match="torque_limit_Nm"):
        train.MotorSpec(1e-7, 0.0)


def follow(spec: train.ControllerSpec, reference: np.ndarray, load: float = 0.0) -> tuple[np.ndarray, np.ndarray]:
    """A free inertia under the loop; angle and command at each period."""
    gains, state = np.array(spec.gains()), np.zeros(train.STATES)
    angle = speed = 0.0
    angles, commands = [], []
    fine = 10
    for target in reference:
        command = train.control(gains, state, target, angle)
        for _ in range(fine):
            speed += (command - load) / spec.inertia_kg_m2 / spec.rate_Hz / fine
            angle += speed / spec.rate_Hz / fine
        angles.append(angle)
        commands.append(command)
    return np.array(angles), np.array(commands)


def test_step_response_is_that_of_the_three_poles() -> None:
    spec = train.ControllerSpec(4e-4, 1e3, bandwidth_Hz=5.0, rate_Hz=20000.0, velocity_filter_Hz=5000.0)
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
    spec = train.ControllerSpec(4e-4, 0.22, bandwidth_Hz=5.0)
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
    gains, state = np.array(train.ControllerSpec(4e-4, 0.22).gains()), np.zeros(train.STATES)
    for _ in range(5000):
        assert train.control(gains, state, np.array([10.0, 0.0, 0.0]), 0.0) == 0.22
    assert abs(state[train.SUM]) <= 0.22, f"integral stands at {state[train.SUM]:.3g} N m"
    assert state[train.LAST] == 0.0 and state[train.SPEED] == 0.0


def test_loop_refuses_a_rate_it_cannot_hold() -> None:
    with pytest.raises(ValueError, match="rate_Hz"):
        train.ControllerSpec(4e-4, 0.22, bandwidth_Hz=100.0, rate_Hz=1000.0)
