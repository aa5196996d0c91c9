"""Logs as people have them: repeated rows, a late device, a backward count; the load from currents and weights."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import yaml
from hypothesis import given, settings
from hypothesis import strategies as st

from mbcdm_cad.errors import InputError
from mbcdm_cad.layouts.loader import layout_of
from mbcdm_cad.loop.prepare.prepared import prepare
from mbcdm_cad.loop.search.engine import close_loop
from mbcdm_cad.measurement import loads
from mbcdm_cad.measurement.draft import draft_text, measurement_page
from mbcdm_cad.measurement.file import load_file
from mbcdm_cad.measurement.reading import load_measurement, read_run
from mbcdm_cad.measurement.roles import Expected
from mbcdm_cad.measurement.run import KNOWN_LOAD, Run, Sensors, TorqueClass
from mbcdm_cad.measurement.schema import MotorBlock, Pendulum
from mbcdm_cad.measurement.vet import arranged, refusals, vet, vetted_runs
from mbcdm_cad.measurement.vet_signals import reach_findings
from mbcdm_cad.model.hysteresis import simulate
from tests.support.reference import DRIVE

_random = np.random.default_rng(11)
TIME = np.arange(4000) * 0.02
OUTPUT = 0.4 * np.sin(2.0 * np.pi * TIME / 16.0) + 2e-5 * _random.standard_normal(TIME.size)


def write(folder: Path, rows: np.ndarray, ratio: float = 8.0, **fields: object) -> Path:
    text = "t,motor,joint\n" + "\n".join(",".join(f"{value:.9g}" for value in row) for row in rows) + "\n"
    (folder / "run.csv").write_text(text)
    columns = {
        "time": {"column": "t", "unit": "s"},
        "input": {"column": "motor", "unit": "rad"},
        "output": {"column": "joint", "unit": "rad"},
    }
    path = folder / "run.yaml"
    path.write_text(yaml.safe_dump({"data": "run.csv", "ratio": ratio, "columns": columns, **fields}))
    return path


def rows(ratio: float = 8.0) -> np.ndarray:
    return np.stack([TIME, ratio * OUTPUT, OUTPUT], axis=1)


def read(path: Path) -> Run:
    return load_measurement(path)


def test_rows_that_repeat_the_time_are_left_out_where_broken_rows_are(tmp_path: Path) -> None:
    doubled = np.repeat(rows(), 4, axis=0)
    with pytest.raises(InputError, match=r"time stands still.*broken_rows: skip"):
        read(write(tmp_path, doubled))
    found = read_run(load_file(write(tmp_path, doubled, broken_rows="skip")))
    assert found.run.time_s.size == TIME.size, found.run.time_s.size
    assert "12000 rows of run.csv repeat the time of the row before: left out" in found.notes, found.notes


def test_a_fault_after_rows_that_were_left_out_is_told_with_its_line(tmp_path: Path) -> None:
    doubled = np.repeat(rows(), 2, axis=0)
    doubled[6000:6002, 1] = 1e6
    with pytest.raises(InputError) as caught:
        read(write(tmp_path, doubled, broken_rows="skip"))
    assert caught.value.problems[0].line == 6002, str(caught.value)


@pytest.mark.parametrize("count", [4, 120, 700])
def test_a_block_of_one_figure_at_the_start_is_told_with_its_lines(tmp_path: Path, count: int) -> None:
    """Not as another ratio or sign, to which the block leads."""
    made = rows()
    made[:count, 1:] = (370085.6, -370085.6)
    with pytest.raises(InputError) as caught:
        read(write(tmp_path, made))
    said = [problem.what for problem in caught.value.problems]
    assert said[0] == f"lines 2 to {count + 1} hold one figure of the input, far from all others", said
    assert len(said) == 2 and "output" in said[1], said


def test_a_drive_that_rests_first_is_no_such_block(tmp_path: Path) -> None:
    made = rows()
    made[:700, 1:] = made[700, 1:]
    assert read(write(tmp_path, made)).time_s.size == TIME.size


@pytest.mark.parametrize("ratio", [1.0, 1.03, 3.0])
def test_an_input_that_counts_backwards_is_told_so_also_at_ratio_1(tmp_path: Path, ratio: float) -> None:
    made = rows(1.0 if ratio < 2.0 else ratio)
    made[:, 1] *= -1.0
    (note,) = refusals(vet(read(write(tmp_path, made, ratio)), None))
    assert "turns against the output" in note.text and "swapped" not in note.text, note
    assert "scale: -1" in note.remedy, note


@pytest.mark.parametrize("cycles", [50, 100])
def test_a_run_of_whole_periods_has_a_slope(tmp_path: Path, cycles: int) -> None:
    """Pairs of samples that are whole periods apart show noise alone, and once hid the slope of 100 cycles."""
    made = rows()
    made[:, 2] = 0.4 * np.sin(2.0 * np.pi * cycles * np.arange(4000) / 4000) + 1e-3 * _random.standard_normal(4000)
    made[:, 1] = 8.0 * made[:, 2] + 8e-3 * _random.standard_normal(4000)
    assert refusals(vet(read(write(tmp_path, made)), None)) == []


def test_a_table_with_one_channel_a_row_is_told_as_such(tmp_path: Path) -> None:
    lines = []
    for t, motor, joint in rows():
        lines += [f"{t:.6f},{motor:.6f},", f"{t + 0.004:.6f},,{joint:.6f}"]
    path = write(tmp_path, rows()[:2], broken_rows="skip")
    (tmp_path / "run.csv").write_text("t,motor,joint\n" + "\n".join(lines) + "\n")
    with pytest.raises(InputError, match="each holds one channel with its own time"):
        read(path)
    assert "rows: own_times" in draft_text(tmp_path / "run.csv", Expected.of_ratio(8.0))


def _counts(angle_rad: np.ndarray, per_turn: int) -> np.ndarray:
    return np.round(angle_rad / (2.0 * np.pi) * per_turn).astype(int) % per_turn


def _drafted(log: Path) -> Run:
    """The run of a log by its draft alone, whose entries are the reader's and not a person's."""
    file = log.with_suffix(".yaml")
    file.write_text(draft_text(log, Expected.of_ratio(8.0)))
    return load_measurement(file)


def _is_the_run(run: Run, step: float) -> None:
    assert run.time_s.size >= TIME.size - 2
    at = run.time_s - run.time_s[0]
    assert np.allclose(run.output_rad - run.output_rad[0], np.interp(at, TIME, OUTPUT - OUTPUT[0]), atol=step)
    assert np.std(run.input_rad[0] - 8.0 * run.output_rad) < 8.0 * step


def test_a_log_of_ros_with_one_topic_a_row_and_its_time_in_two_columns(tmp_path: Path) -> None:
    lines, begun = ["sec,nanosec,topic,data"], 1795000000 * 10**9
    for t, angle in zip(TIME, OUTPUT, strict=True):
        for late, topic, figure in ((0, "/stepper/angle_rad", 8.0 * angle), (1_500_000, "/arm/angle_rad", angle)):
            at = begun + round(t * 1e9) + late
            lines.append(f"{at // 10**9},{at % 10**9},{topic},{figure:.9f}")
    (tmp_path / "topics.csv").write_text("\n".join(lines) + "\n")
    _is_the_run(_drafted(tmp_path / "topics.csv"), 4e-4)


def test_a_log_of_json_lines_is_read_but_for_its_greeting_and_a_line_that_was_cut(tmp_path: Path) -> None:
    lines = ['{"event": "boot", "firmware": "2.1"}']
    lines += [
        f'{{"ts": {1795000000 + t:.3f}, "motor": {{"count": {motor}, "ok": true}}, "joint": {{"count": {joint}}}}}'
        for t, motor, joint in zip(TIME, _counts(8.0 * OUTPUT, 4096), _counts(OUTPUT, 16384), strict=True)
    ]
    log = tmp_path / "run.jsonl"
    log.write_text("\n".join([*lines, lines[-1][:30]]) + "\n")
    _is_the_run(_drafted(log), 2.0 * np.pi / 16384)
    log.write_text("\n".join([*lines[1:], *('{"motor": 1, "ts": 2}' for _ in lines)]) + "\n")
    with pytest.raises(InputError, match="4000 of 8001 lines have other fields than most"):
        _drafted(log)


def test_counts_in_hexadecimal_digits_are_figures_and_frames_of_a_can_bus_are_told(tmp_path: Path) -> None:
    motor, joint = _counts(8.0 * OUTPUT, 4096), _counts(OUTPUT, 16384)
    lines = [f"{t:.3f},0x{a:04X},0x{b:04X}" for t, a, b in zip(TIME, motor, joint, strict=True)]
    (tmp_path / "hex.csv").write_text("\n".join(["Time,Motor_Pos,Arm_Pos", *lines]) + "\n")
    _is_the_run(_drafted(tmp_path / "hex.csv"), 2.0 * np.pi / 16384)
    for frame in ("(1795000000.010400) can0 102#0D6F", "  can0  102   [2]  0D 6F"):
        (tmp_path / "candump.log").write_text("\n".join([frame] * 200) + "\n")
        with pytest.raises(InputError, match=r"frames of a CAN bus.*DBC"):
            draft_text(tmp_path / "candump.log", Expected.of_ratio(8.0))


def test_too_many_broken_rows_are_told_with_what_the_first_holds(tmp_path: Path) -> None:
    path = write(tmp_path, rows(), broken_rows="skip")
    lines = (tmp_path / "run.csv").read_text().split("\n")
    lines[7:-1:9] = [line.rpartition(",")[0] + ",OVERRANGE" for line in lines[7:-1:9]]
    (tmp_path / "run.csv").write_text("\n".join(lines))
    with pytest.raises(InputError, match="the first has no number in 'joint' \\('OVERRANGE'\\)"):
        read(path)


T = np.arange(0.0, 20.0, 0.005)
TURNS = np.array([9.0])
MOTOR = MotorBlock(torque_constant_Nm_A=0.02, gear_ratio=50, efficiency=0.8, rotor_inertia_kg_m2=2e-7, friction_Nm=1e-4)


def current(load: np.ndarray, speed: np.ndarray, acceleration: np.ndarray) -> np.ndarray:
    """Current that moves the rotor against a load on the drum: torques at the rotor, and power lost in the gearhead."""
    at_output = load / TURNS[0]
    forward = at_output * speed > 0.0
    ideal = at_output / 50.0
    at_rotor = np.where(forward, ideal / 0.8, ideal * (2.0 - 1.0 / 0.8))
    return np.asarray((at_rotor + 1e-4 * np.sign(speed) + 2e-7 * 50.0 * acceleration) / 0.02)


@pytest.mark.parametrize("frequency_Hz", [0.2, 10.0])
def test_the_load_comes_back_from_the_current(frequency_Hz: float) -> None:
    w, t = 2.0 * np.pi * frequency_Hz, T if frequency_Hz < 1.0 else T / 10.0
    angle = 2.0 * np.sin(w * t) / max(1.0, frequency_Hz)
    speed, acceleration = np.gradient(angle, t), -(w**2) * angle
    load = 0.8 * np.sin(0.37 * w * t) + 0.1
    found = loads.motors_load_Nm(MOTOR, current(load, speed, acceleration)[None], angle[None], t, TURNS)
    moving = np.abs(speed) > 0.2 * np.std(speed)
    inner = slice(t.size // 20, -t.size // 20)
    assert np.abs(found - load)[inner][moving[inner]].max() < 0.02, np.abs(found - load)[inner][moving[inner]].max()
    assert np.abs(found - load)[inner].max() < 0.1


def test_a_servo_that_hunts_at_the_turns_makes_no_extreme_of_the_load() -> None:
    """About a turn of the motion it turns round and round: a wrong sense turns the loss of the gearhead round."""
    lines = np.random.default_rng(1).uniform(0.3, 2.5, 6)
    angle = 1.8 * np.sin(2.0 * np.pi * T / 12.0) + 0.01 * sum(np.sin(2.0 * np.pi * f * T + f) for f in lines)
    speed, load = np.gradient(angle, T), 1.2 * np.sin(2.0 * np.pi * T / 8.7)
    amperes = current(load, speed, np.gradient(speed, T))
    found = loads.motors_load_Nm(MOTOR, amperes[None], angle[None], T, TURNS)
    assert np.abs(found).max() < 1.1 * np.abs(load).max(), np.abs(found).max()


def test_what_is_not_given_is_that_of_the_catalogue() -> None:
    found = loads.figures_of(MotorBlock(torque_constant_Nm_A=0.01), DRIVE)
    assert (found.gear_ratio, found.efficiency) == (DRIVE.gearhead.ratio, DRIVE.gearhead.efficiency)
    assert found.rotor_inertia_kg_m2 == pytest.approx(1e-7 * DRIVE.motor.rotor_inertia_g_cm2)
    assert found.torque_constant_Nm_A == 0.01


def written(folder: Path, columns: str, rest: str = "") -> Path:
    angle = 0.3 * np.sin(2.0 * np.pi * T / 4.0)
    table = np.column_stack([T, 9.0 * angle, 9.0 * angle, angle, 0.1 * np.sign(np.cos(T)), 0.1 * np.sign(np.cos(T))])
    np.savetxt(folder / "r.csv", table, delimiter=",", header="t,l,r,o,il,ir", comments="")
    path = folder / "r.yaml"
    path.write_text(
        "data: r.csv\ncolumns:\n  time: {column: t, unit: s}\n  input_left: {column: l, unit: rad}\n"
        "  input_right: {column: r, unit: rad}\n  output: {column: o, unit: rad}\n" + columns + rest
    )
    return path


BOTH = "  current_left: {column: il, unit: A}\n  current_right: {column: ir, unit: mA, scale: 1000}\n"


def test_a_file_with_currents_has_a_load_of_the_motors_class(tmp_path: Path) -> None:
    rest = "motor: {torque_constant_Nm_A: 0.002, torque_constant_share: 0.03}\n"
    run = load_measurement(written(tmp_path, BOTH, rest))
    assert run.load_Nm is None and run.current_A is not None and run.current_A.shape[0] == 2
    assert np.allclose(run.current_A[0], run.current_A[1])
    assert (run.sensors.torque_class.what, run.sensors.torque_class.share) == ("motors' current", 0.06)
    (vetted,) = vetted_runs([load_file(written(tmp_path, BOTH, rest))], DRIVE)
    (told,) = (str(note) for note in vetted.findings if note.kind == "motors_current")
    assert "to 0.06 of its gain" in told and "a known weight on an arm" in told
    assert vetted.run.load_Nm is not None and np.ptp(vetted.run.load_Nm) > 0.01


def test_samples_at_which_friction_hides_the_load_are_not_used(tmp_path: Path) -> None:
    rest = "motor: {torque_constant_Nm_A: 0.002, torque_constant_share: 0.03}\n"
    (vetted,) = vetted_runs([load_file(written(tmp_path, BOTH, rest))], DRIVE)
    _, whole = prepare(vetted.run, float(TURNS[0]))
    slow = np.abs(np.cos(2.0 * np.pi * whole.time_s / 4.0))[whole.sweep > 0] < 0.15
    used = whole.used[whole.sweep > 0]
    assert not used[slow].any() and used[~slow].mean() > 0.9, (used[slow].mean(), used[~slow].mean())


@pytest.mark.parametrize("wrong", [-0.06, 0.04])
def test_a_weight_on_an_arm_gives_the_torque_constant(wrong: float) -> None:
    angle = 0.4 * np.sin(2.0 * np.pi * T / 6.0)
    speed, acceleration = np.gradient(9.0 * angle, T), np.gradient(np.gradient(9.0 * angle, T), T)
    arm = Pendulum(mass_kg=1.0, arm_mm=100.0, inertia_kg_m2=0.001)
    weight = loads.pendulum_load_Nm(arm, angle, T)
    amperes = current(weight + 0.1 * np.sign(speed) + 0.05, speed, acceleration)
    noisy = amperes + 2e-4 * np.random.default_rng(1).normal(size=T.size)
    known = Sensors(torque_class=TorqueClass(0.01, 0.0, what=KNOWN_LOAD))
    stated = MOTOR.model_copy(update={"torque_constant_Nm_A": MOTOR.torque_constant_Nm_A * (1.0 + wrong)})
    run = Run(T, 9.0 * angle[None], angle, weight, sensors=known, current_A=noisy[None], motor=stated)
    found = loads.with_motors_load(run, None, TURNS)
    assert found.load_Nm is not None and found.sensors.torque_class.of_currents
    moving = np.abs(speed) > 0.3 * np.std(speed)
    factor, _ = np.polyfit(weight[moving] + 0.1 * np.sign(speed[moving]), found.load_Nm[moving], 1)
    assert factor == pytest.approx(1.0, abs=0.005), factor
    # The friction is in the load until the turn itself, where the currents do not show it.
    off = np.abs(found.load_Nm - weight - 0.1 * np.sign(speed) - 0.05)
    assert np.quantile(off, 0.99) < 0.01, np.quantile(off, 0.99)
    assert found.sensors.torque_class.gain_sigma == pytest.approx(0.005 * 0.05 / np.hypot(0.005, 0.05))
    assert loads.with_motors_load(found, None, TURNS) is found


@pytest.mark.parametrize(
    ("gain", "constant", "share", "level"),
    [(1.0, 0.05, 0.01, "fact"), (1.3, 0.03, 0.01, "doubt"), (1.04, 0.005, 0.06, "fact")],
)
def test_currents_beside_a_torque_sensor_tell_losses_from_its_gain(
    gain: float, constant: float, share: float, level: str
) -> None:
    """Friction worked out by hand: 0.1 N m and 5 % of the load, by the sense of motion."""
    angle = 0.4 * np.sin(2.0 * np.pi * T / 6.0)
    speed, acceleration = np.gradient(9.0 * angle, T), np.gradient(np.gradient(9.0 * angle, T), T)
    load = 0.8 * np.sin(2.0 * np.pi * T / 4.3) + 0.2
    amperes = current(load + (0.1 + 0.05 * np.abs(load)) * np.sign(speed), speed, acceleration)
    rng = np.random.default_rng(3)
    measured = gain * load + 0.01 * rng.normal(size=T.size)
    run = Run(
        T,
        9.0 * angle[None],
        angle,
        measured,
        sensors=Sensors(torque_class=TorqueClass(share)),
        current_A=(amperes + 1e-3 * rng.normal(size=T.size))[None],
        motor=MOTOR.model_copy(update={"torque_constant_share": constant}),
    )
    found = loads.with_motors_load(run, None, TURNS)
    beside = found.beside
    assert beside is not None and beside.gain == pytest.approx(1.0 / gain, abs=0.01), beside
    assert beside.dry_Nm == pytest.approx(0.1, abs=0.01) and beside.share == pytest.approx(0.05 / gain, abs=0.012), (
        beside
    )
    (note,) = (one for one in reach_findings(found, float(TURNS[0]), None) if one.kind == "currents_beside")
    assert note.level == level, note
    assert found.load_Nm is not None and found.sensors.torque_class.what == "torque sensor"
    if share > 0.05:  # a good torque constant beside a poor sensor: its gain is mended
        assert np.std(found.load_Nm) == pytest.approx(np.std(load), rel=0.01)
        assert found.sensors.torque_class.share < 0.025
    else:
        np.testing.assert_array_equal(found.load_Nm, measured)
    assert loads.with_motors_load(found, None, TURNS) is found
    # A brake goes with the motion: no gain is told from losses.
    braked = replace(run, load_Nm=0.5 * np.sign(speed))
    (note,) = (
        one for one in reach_findings(loads.with_motors_load(braked, None, TURNS), 9.0, None) if "beside" in one.kind
    )
    assert "look alike" in note.text, note


@pytest.mark.parametrize(
    ("columns", "rest", "words"),
    [
        (BOTH, "load: none\n", "given beside load"),
        (BOTH + "  load_torque: {column: il, unit: N*m}\n", "kind: creep\n", "only a run of kind motion"),
        (
            "",
            "inertia_plate: {inertia_kg_m2: 0.02}\n",
            "inertia_plate: has no effect on a run of kind motion; say kind",
        ),
        ("  excitation: {column: il, unit: A}\n", "", "excitation: has no effect"),
        (BOTH.split("\n")[0] + "\n", "", "currents are not those of the inputs"),
        (BOTH, "ratio: 9\n", "lacks torque_constant_Nm_A"),
        ("  current_left: {column: il, unit: V}\n", "", "no unit of current"),
    ],
)
def test_mistakes_are_told(columns: str, rest: str, words: str, tmp_path: Path) -> None:
    with pytest.raises(InputError, match=words):
        load_measurement(written(tmp_path, columns, rest))


def test_a_torque_constant_that_nobody_knows_is_asked_for(tmp_path: Path) -> None:
    if DRIVE.motor.torque_constant_mNm_A is not None:
        pytest.skip("the catalogue has the torque constant of this motor")
    with pytest.raises(InputError, match="no torque constant"):
        vetted_runs([load_file(written(tmp_path, BOTH))], DRIVE)


MASS_KG, ARM_M, INERTIA, VERTICAL = 1.5, 0.2, 0.01, 0.3
PENDULUM = {
    "mass_kg": MASS_KG,
    "arm_mm": 1e3 * ARM_M,
    "inertia_kg_m2": INERTIA,
    "vertical_deg": float(np.degrees(VERTICAL)),
}


def written_run(folder: Path, t: np.ndarray, motor: np.ndarray, out: np.ndarray, load: object) -> Path:
    table = np.column_stack([t, motor, out])
    np.savetxt(folder / "run.csv", table, delimiter=",", header="t,motor,out", comments="", fmt="%.9f")
    columns = {
        "time": {"column": "t", "unit": "s"},
        "input": {"column": "motor", "unit": "rad"},
        "output": {"column": "out", "unit": "rad"},
    }
    path = folder / "run.yaml"
    path.write_text(yaml.safe_dump({"data": "run.csv", "ratio": 5.0, "columns": columns, "load": load}))
    return path


def swung(hz: float, seconds: float, step_s: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Time, angle, and the torque of the weight from the angle's own derivatives."""
    t = np.arange(0.0, seconds, step_s)
    w = 2.0 * np.pi * hz
    angle = 0.4 * np.sin(w * t)
    inertia = INERTIA + MASS_KG * ARM_M**2
    torque = MASS_KG * 9.80665 * ARM_M * np.sin(angle - VERTICAL) - inertia * 0.4 * w**2 * np.sin(w * t)
    return t, angle, torque


@pytest.mark.parametrize("hz", [0.1, 1.0, 10.0])
def test_the_torque_of_a_weight_is_that_of_the_closed_form(tmp_path: Path, hz: float) -> None:
    t, angle, torque = swung(hz, 12.0 / hz, 0.01 / max(hz, 0.5))
    noisy = angle + 2e-6 * np.random.default_rng(1).standard_normal(t.size)
    run = load_measurement(written_run(tmp_path, t, 5.0 * angle, noisy, {"pendulum": PENDULUM}))
    assert run.load_Nm is not None
    inside = slice(t.size // 12, -t.size // 12)
    inertia = (INERTIA + MASS_KG * ARM_M**2) * 0.4 * (2.0 * np.pi * hz) ** 2
    wrong = float(np.abs(run.load_Nm - torque)[inside].max()) / max(inertia, MASS_KG * 9.80665 * ARM_M)
    assert wrong < 0.01, f"{wrong:.2%} of the largest torque at {hz} Hz"


def test_the_acceleration_of_uneven_samples() -> None:
    t = np.cumsum(np.random.default_rng(2).uniform(0.8e-3, 1.2e-3, 4000))
    found = loads.motion_of(0.3 * np.sin(20.0 * t), t)[1]
    assert np.allclose(found[100:-100], -120.0 * np.sin(20.0 * t[100:-100]), atol=2.0), np.abs(found).max()


@pytest.mark.parametrize(("hz", "swings"), [(0.15, 12), (1.5, 40)])
def test_a_soft_shaft_is_found_with_a_weight_in_place_of_a_torque_sensor(
    tmp_path: Path, hz: float, swings: int
) -> None:
    """Slowly by the weight alone, fast with its inertia: at 1.5 Hz that is 9 times the weight's own change."""
    t, angle, torque = swung(hz, swings / hz, 0.02 / hz / 2.0)
    out = angle - 2e-3 * torque + 2e-5 * np.random.default_rng(3).standard_normal(t.size)
    run = load_measurement(written_run(tmp_path, t, 5.0 * angle, out, {"pendulum": PENDULUM}))
    result = close_loop(None, [run])
    names = [one.name for one in result.effects] + [one.name for group in result.one_of for one in group]
    assert "stiffness_error" in names, result.sentence
    found = next(one for one in (*result.effects, *sum(result.one_of, ())) if one.name == "stiffness_error")
    assert found.parameters["compliance_rad_Nm"].value == pytest.approx(2e-3, rel=0.05), result.sentence


def test_a_pendulum_is_refused_with_its_line(tmp_path: Path) -> None:
    t, angle, _ = swung(0.2, 20.0, 0.05)
    with pytest.raises(InputError, match=r"run.yaml:\d+: load.*mass_kg"):
        load_file(written_run(tmp_path, t, angle, angle, {"pendulum": {"mass_kg": -1.0, "arm_mm": 100.0}}))
    with pytest.raises(InputError, match=r"run.yaml:\d+: load"):
        load_file(written_run(tmp_path, t, angle, angle, "some"))


def test_the_reference_page_has_the_load() -> None:
    assert "| `vertical_deg` | deg |" in measurement_page() and "`load: none`" in measurement_page()


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
