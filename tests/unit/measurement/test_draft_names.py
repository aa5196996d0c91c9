"""A draft comes out for whatever a logger calls its columns, and takes angles for angles.

The run is made here: a drive of 8:1, with speeds, a command that leads the motor, a current and flags beside the
angles, each with noise of its own. Every header has the true columns of input and output beside it.
"""

from pathlib import Path

import numpy as np
import pytest
import yaml

from mbcdm_cad.cli import run as mbcdm
from mbcdm_cad.errors import InputError
from mbcdm_cad.measurement.draft import draft_text
from mbcdm_cad.measurement.reading import load_measurement
from mbcdm_cad.measurement.roles import Expected

RATIO = 8.0
DEG = 180.0 / np.pi
_random = np.random.default_rng(7)
TIME = np.arange(3000) * 0.02
OUTPUT = 0.5 * np.sin(2.0 * np.pi * TIME / 20.0)
INPUT = RATIO * OUTPUT + 1.5e-3 * np.sign(np.cos(2.0 * np.pi * TIME / 20.0))


def noisy(values: np.ndarray, sigma: float) -> np.ndarray:
    return values + sigma * _random.standard_normal(values.size)


SIGNALS = {
    "t": TIME,
    "t_ms": np.round(1e3 * TIME),
    "motor": noisy(INPUT, 2e-4),
    "joint": noisy(OUTPUT, 5e-5),
    "motor_deg": DEG * noisy(INPUT, 2e-4),
    "joint_deg": DEG * noisy(OUTPUT, 5e-5),
    "motor_counts": np.round(INPUT * 16384 / (2.0 * np.pi)),
    "joint_counts": np.round(OUTPUT * 16384 / (2.0 * np.pi)),
    "motor_turns": noisy(INPUT, 2e-4) / (2.0 * np.pi),
    "joint_turns": noisy(OUTPUT, 5e-5) / (2.0 * np.pi),
    "motor_speed": noisy(np.gradient(INPUT, TIME), 0.02),
    "joint_speed": noisy(np.gradient(OUTPUT, TIME), 0.004),
    "command": np.roll(INPUT, -2),
    "torque": noisy(0.3 * np.sign(np.cos(2.0 * np.pi * TIME / 20.0)), 0.01),
    "current": noisy(0.8 * np.cos(2.0 * np.pi * TIME / 20.0), 0.05),
    "flag": np.zeros_like(TIME),
    "t_us": np.round(1e6 * TIME),
    "t_ns": np.round(1e9 * TIME) + 1.7e18,
    "row": np.arange(TIME.size, dtype=float),
    "word": np.full(TIME.size, np.nan),
    "command_deg": DEG * np.roll(INPUT, -2),
    "command_counts": np.round(np.roll(INPUT, -2) * 16384 / (2.0 * np.pi)),
    "motor_turn_speed": noisy(np.gradient(INPUT, TIME), 0.02) / (2.0 * np.pi),
    "warm": noisy(25.0 + TIME / 60.0, 0.05),
}
# The header, the signals of its columns, and the columns of input and output, from 0.
HEADERS: list[tuple[str, str, int, int]] = [
    ("t,q_m,q_l,tau", "t motor joint torque", 1, 2),
    (
        "timestamp,actuator_position,actuator_velocity,link_position,link_velocity",
        "t motor motor_speed joint joint_speed",
        1,
        3,
    ),
    ("time,motorPos,motorVel,jointPos,jointVel,motorTorque", "t motor motor_speed joint joint_speed torque", 1, 3),
    ("Time [s],Motor angle [deg],Output angle [deg],Torque [Nm]", "t motor_deg joint_deg torque", 1, 2),
    ("t,cmd_pos,fb_pos,load_pos", "t command motor joint", 2, 3),
    ("time_ms,enc_a,enc_b", "t_ms motor_counts joint_counts", 1, 2),
    ("time,theta1,theta2,dtheta1,dtheta2", "t motor joint motor_speed joint_speed", 1, 2),
    ("sec,input_deg,output_deg,temp_c", "t motor_deg joint_deg warm", 1, 2),
    ("/motor/position,/joint/position,time", "motor joint t", 0, 1),
    ("Zeit,Antrieb_Winkel,Abtrieb_Winkel,Strom", "t motor joint current", 1, 2),
    (
        "t,axis0.encoder.pos_estimate,axis1.encoder.pos_estimate,axis0.motor.current_control.Iq_measured",
        "t motor_turns joint_turns current",
        1,
        2,
    ),
    ("time,speed,current,angle,knee_angle", "t motor_speed current motor joint", 3, 4),
    ("time,setpoint,motor,pendulum_arm", "t command motor joint", 2, 3),
    ("ticks,status,servo,horn_pot", "t_ms flag motor joint", 2, 3),
    ("time,primary_encoder,secondary_encoder", "t motor_counts joint_counts", 1, 2),
    ("t,rotor,lever", "t motor joint", 1, 2),
    ("clock,mot_cur,mot_vel,mot_pos,drum_pos", "t current motor_speed motor joint", 3, 4),
    ("time,joint_pos,motor_pos", "t joint motor", 2, 1),
    ("time,col1,col2,col3", "t motor_speed motor joint", 2, 3),
    ("a,b,c", "t motor joint", 1, 2),
]

# Headers of public loggers and of scripts in public repositories, with the signals of their columns.
PUBLIC: list[tuple[str, str, int, int]] = [
    # rostopic echo -p: times in ns, names of the joints as text.
    (
        "%time,field.header.seq,field.header.stamp,field.header.frame_id,field.name0,field.name1,field.position0,"
        "field.position1,field.velocity0,field.velocity1,field.effort0,field.effort1",
        "t_ns row t_ns word word word motor joint motor_speed joint_speed current torque",
        6,
        7,
    ),
    # PlotJuggler's export.
    (
        "__time,/joint_states/actuator/position,/joint_states/actuator/velocity,/joint_states/knee/position",
        "t motor motor_speed joint",
        1,
        3,
    ),
    (
        "__time,/js/position[0],/js/position[1],/js/velocity[0],/js/velocity[1]",
        "t motor joint motor_speed joint_speed",
        1,
        2,
    ),
    # ODrive: liveplotter, and a logger of its S1.
    (
        "time,axis0.encoder.pos_estimate,axis0.encoder.vel_estimate,axis1.encoder.pos_estimate,axis0.controller.input_pos",
        "t motor_turns motor_turn_speed joint_turns command",
        1,
        3,
    ),
    (
        "timestamp_ms,mode,command_value,measured_position_deg,measured_velocity_deg_s,measured_torque_Nm,"
        "command_current_A,joint_encoder_deg",
        "t_ms flag command motor_deg motor_speed torque current joint_deg",
        3,
        7,
    ),
    # moteus: registers of a controller and a second encoder.
    (
        "timestamp,servo.mode,servo.position,servo.velocity,servo.torque,servo.q_current,servo.abs_position",
        "t flag motor_turns motor_turn_speed torque current joint_turns",
        2,
        6,
    ),
    # Unitree's motor state beside the one that its encoder of the rotor gives.
    (
        "time,mode,q,dq,ddq,tau_est,q_raw,dq_raw,temperature",
        "t flag joint joint_speed joint_speed torque motor motor_speed warm",
        6,
        2,
    ),
    # A controller of a joint's test stand: clock of the processor, both positions, current, counts.
    (
        "mcu_timestamp,host_timestamp_received,motor_position,joint_position,iq,torque,motor_encoder",
        "t_us t_us motor joint current torque motor_counts",
        2,
        3,
    ),
    # Dephy's actuators: names as state_time, mot_ang.
    (
        "state_time,mot_ang,mot_vel,mot_acc,mot_cur,mot_volt,ank_ang,ank_vel,temperature",
        "t_ms motor_counts motor_speed motor_speed current current joint_counts joint_speed warm",
        1,
        6,
    ),
    # A joint's logger with fault, load, angle by potentiometer and encoder.
    (
        "Elapsed Time(ms),R_hip_fault,R_hip_Load,R_hip_deg,R_hip_enc,R_hip_T_des",
        "t_ms flag torque joint_deg motor_counts command",
        4,
        3,
    ),
    # Saleae Logic: exports of its analysers and of decoded quadrature counters.
    ("Time [s],Motor [counts],Joint [counts],Index", "t motor_counts joint_counts flag", 1, 2),
    # dSPACE ControlDesk and Simulink: paths of the model in the names.
    (
        '"time","Model Root/Encoder Motor/Pos [rad]","Model Root/Encoder Load/Pos [rad]","Model Root/Controller/u"',
        "t motor joint command",
        1,
        2,
    ),
    # LabVIEW writes the task's channels.
    ("Time,cDAQ1Mod1/ctr0 Motor Angle (deg),cDAQ1Mod1/ctr1 Load Angle (deg)", "t motor_deg joint_deg", 1, 2),
    # TwinCAT Scope and CODESYS trace.
    (
        "Time;GVL.Axis1.NcToPlc.ActPos;GVL.fJointAngle;GVL.Axis1.NcToPlc.ActVelo;GVL.Axis1.PlcToNc.SetPos",
        "t motor_deg joint_deg motor_speed command_deg",
        1,
        2,
    ),
    # EtherCAT drives by their objects.
    (
        "time,Position actual value (0x6064),Velocity actual value (0x606C),Torque actual value (0x6077),"
        "Second encoder (0x60E4)",
        "t motor_counts motor_speed current joint_counts",
        1,
        4,
    ),
    # Maxon EPOS Studio's recorder.
    (
        "Time [ms];Position actual value [inc];Velocity actual value averaged [rpm];"
        "Current actual value averaged [mA];Auxiliary encoder [inc]",
        "t_ms motor_counts motor_speed current joint_counts",
        1,
        4,
    ),
    # Dynamixel: present and goal position in ticks, and an AS5600 on the arm.
    (
        "millis,goal_position,present_position,present_velocity,present_load,as5600_raw",
        "t_ms command_counts motor_counts motor_speed current joint_counts",
        2,
        5,
    ),
    # VESC Tool's log of one controller.
    (
        "ms_today;input_voltage;temp_mos_max;current_motor;d_axis_current;q_axis_current;erpm;duty_cycle;tachometer;encoder_position",
        "t_ms current warm current current current motor_speed current motor_counts joint_deg",
        8,
        9,
    ),
    # SCPI and data acquisition: dates, channel numbers.
    ("Scan,Time (Seconds),101 (Motor deg),102 (Arm deg),103 (VDC)", "row t motor_deg joint_deg torque", 2, 3),
    # Simscape and OpenModelica results.
    ("time,motor.phi,motor.w,motor.tau,load.phi,load.w", "t motor motor_speed torque joint joint_speed", 1, 4),
    # Beckhoff, B&R: German names.
    (
        "Zeit [s];Sollposition;Istposition Motor [°];Istposition Gelenk [°];Motorstrom [A]",
        "t command_deg motor_deg joint_deg current",
        2,
        3,
    ),
    # Japanese and French names.
    ("temps,consigne,angle_moteur,angle_sortie,courant", "t command motor joint current", 2, 3),
]


def write(folder: Path, header: str, signals: str) -> Path:
    rows = np.stack([SIGNALS[name] for name in signals.split()], axis=1)
    path = folder / "run.csv"
    sign = ";" if ";" in header else ","
    lines = (
        sign.join("base" if np.isnan(value) else f"{value:.9g}" if value < 1e15 else f"{value:.0f}" for value in row)
        for row in rows
    )
    path.write_text("\n".join([header, *lines]) + "\n")
    return path


@pytest.mark.parametrize(
    ("header", "signals", "motor", "joint"), HEADERS + PUBLIC, ids=[header for header, *_ in HEADERS + PUBLIC]
)
def test_the_angles_are_found(tmp_path: Path, header: str, signals: str, motor: int, joint: int) -> None:
    draft = draft_text(write(tmp_path, header, signals), Expected.of_ratio(RATIO))
    columns, names = yaml.safe_load(draft)["columns"], header.replace('"', "").split(";" if ";" in header else ",")
    assert columns["output"]["column"] == names[joint], draft
    assert columns["input"]["column"] == names[motor], draft
    (tmp_path / "run.yaml").write_text(draft)
    run = load_measurement(tmp_path / "run.yaml")
    slope = float(np.ptp(run.input_rad[0]) / np.ptp(run.output_rad))
    assert slope == pytest.approx(RATIO, rel=0.01), f"ratio as read {slope}\n{draft}"


def test_figures_without_names_are_told_by_number(tmp_path: Path) -> None:
    path = write(tmp_path, "x", "t motor joint")
    path.write_text(path.read_text().split("\n", 1)[1])
    columns = yaml.safe_load(draft_text(path, Expected.of_ratio(RATIO)))["columns"]
    assert [columns[name]["column"] for name in ("time", "input", "output")] == [1, 2, 3], columns


@pytest.mark.parametrize("greeting", ["Encoder test v3\nhoming... ok\n", "logger: joint 4; started 10:00\n", "\n"])
def test_a_greeting_is_not_taken_for_the_names(tmp_path: Path, greeting: str) -> None:
    path = write(tmp_path, "ms,steps,angle", "t_ms motor_counts joint_deg")
    path.write_text(greeting + path.read_text())
    draft = draft_text(path, Expected.of_ratio(RATIO))
    columns = yaml.safe_load(draft)["columns"]
    assert [columns[name]["column"] for name in ("time", "input", "output")] == ["ms", "steps", "angle"], draft
    assert f"skip_rows: {greeting.strip().count(chr(10)) + 1}" in draft or not greeting.strip(), draft


def test_labview_text_has_one_name_more_than_columns(tmp_path: Path) -> None:
    path = write(tmp_path, "x", "t motor joint")
    rows = path.read_text().split("\n", 1)[1].replace(",", "\t")
    head = "LabVIEW Measurement\t\nSeparator\tTab\n***End_of_Header***\t\n\t\nChannels\t2\t\nSamples\t3000\t3000\n"
    path.write_text(
        head + "X0\t0.0\t0.0\nDelta_X\t0.02\t0.02\n***End_of_Header***\nX_Value\tmotor\toutput\tComment\n" + rows
    )
    columns = yaml.safe_load(draft_text(path, Expected.of_ratio(RATIO)))["columns"]
    assert [columns[name]["column"] for name in ("time", "input", "output")] == ["X_Value", "motor", "output"], columns


def test_an_angle_that_begins_again_has_as_many_counts_a_turn(tmp_path: Path) -> None:
    """Both statements of the draft agree, also where the drive's encoder is said to be another one."""
    counts = np.round(OUTPUT * 3 * 4096 / (2.0 * np.pi)) + 300.0
    assert counts.min() < 0.0 < counts.max()
    rows = zip(TIME, SIGNALS["motor"] * 3, np.mod(counts, 4096), strict=True)
    path = tmp_path / "run.csv"
    path.write_text("t,servo,joint_enc\n" + "\n".join(f"{t:.3f},{m:.6f},{c:.0f}" for t, m, c in rows) + "\n")
    known = Expected("bench", ("input",), RATIO, 1.0, 9.0, 32768.0)
    output = yaml.safe_load(draft_text(path, known))["columns"]["output"]
    assert output["counts_per_turn"] == output["wraps_at"] == 4096, output


def test_a_ratio_is_enough(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    data = write(tmp_path, "time,motor_enc_deg,joint_enc_deg", "t motor_deg joint_deg")
    assert mbcdm(["measurement-init", str(data), "--ratio", "8"]) == 0
    assert yaml.safe_load((tmp_path / "run.yaml").read_text())["ratio"] == 8
    assert mbcdm(["measurement-init", str(data)]) == 2
    assert "give a design file or --ratio" in capsys.readouterr().err


def test_a_workbook_is_called_a_spreadsheet(tmp_path: Path) -> None:
    """Excel pads the first entries of its files with zeros, which is no UTF-16 text."""
    (tmp_path / "run.xlsx").write_bytes(b"PK\x03\x04" + bytes(600) + b"\n")
    with pytest.raises(InputError, match="a spreadsheet"):
        draft_text(tmp_path / "run.xlsx", Expected.of_ratio(RATIO))


@pytest.mark.parametrize("before", ["", "Bench of joint 4\nhoming... ok\n"])
@pytest.mark.parametrize("sign", [",", "\t", " "])
def test_rows_of_a_serial_plotter_have_the_names_before_colons(tmp_path: Path, sign: str, before: str) -> None:
    rows = zip(SIGNALS["motor_deg"], SIGNALS["joint_deg"], strict=True)
    lines = [f"motor:{m:.4f}{sign}joint:{j:.4f}" for m, j in rows]
    (tmp_path / "run.txt").write_text(before + "\n".join(lines) + "\n")
    draft = draft_text(tmp_path / "run.txt", Expected.of_ratio(RATIO))
    (tmp_path / "run.yaml").write_text(draft)
    with pytest.raises(InputError, match=r"run.yaml:\d: sample_rate_Hz: not a number"):
        load_measurement(tmp_path / "run.yaml")
    (tmp_path / "run.yaml").write_text(draft.replace("'?'", "50"))
    run = load_measurement(tmp_path / "run.yaml")
    assert run.time_s[1] == pytest.approx(0.02) and np.allclose(run.output_rad, SIGNALS["joint_deg"] / DEG, atol=1e-6)


@pytest.mark.parametrize("labels", [True, False])
def test_a_serial_monitor_writes_a_time_of_day_and_an_arrow(tmp_path: Path, labels: bool) -> None:
    rows = zip(TIME, SIGNALS["motor_deg"], SIGNALS["joint_deg"], strict=True)
    names = ("motor:", "joint:") if labels else ("", "")
    lines = [f"12:{int(t // 60):02d}:{t % 60:06.3f} -> {names[0]}{m:.4f},{names[1]}{j:.4f}" for t, m, j in rows]
    (tmp_path / "run.txt").write_text("\n".join(lines) + "\n")
    (tmp_path / "run.yaml").write_text(draft_text(tmp_path / "run.txt", Expected.of_ratio(RATIO)))
    run = load_measurement(tmp_path / "run.yaml")
    assert np.allclose(np.diff(run.time_s), 0.02) and np.allclose(run.input_rad, SIGNALS["motor_deg"] / DEG, atol=1e-6)


def test_a_motion_camera_numbers_its_frames(tmp_path: Path) -> None:
    """Vicon writes the device, the rate, names of the subjects, the columns, their units; no time."""
    head = "Devices\n50\n,,Motor,Joint\nFrame,Sub Frame,Pot motor,Pot joint\n,,deg,deg\n"
    rows = enumerate(zip(SIGNALS["motor_deg"], SIGNALS["joint_deg"], strict=True), 1)
    (tmp_path / "run.csv").write_text(head + "".join(f"{k},0,{m:.4f},{j:.4f}\n" for k, (m, j) in rows))
    draft = draft_text(tmp_path / "run.csv", Expected.of_ratio(RATIO))
    (tmp_path / "run.yaml").write_text(draft.replace("'?'", "50"))
    run = load_measurement(tmp_path / "run.yaml")
    assert run.time_s[-1] == pytest.approx(TIME[-1]), draft
    assert np.allclose(run.output_rad, SIGNALS["joint_deg"] / DEG, atol=1e-6), draft


def test_a_dial_gauge_on_an_arm_is_an_angle(tmp_path: Path) -> None:
    rows = np.stack([TIME, SIGNALS["motor_deg"], 80.0 * SIGNALS["joint"]], axis=1)
    lines = [",".join(f"{value:.6f}" for value in row) for row in rows]
    (tmp_path / "run.csv").write_text("\n".join(["t,motor_deg,gauge_mm", *lines]) + "\n")
    draft = draft_text(tmp_path / "run.csv", Expected.of_ratio(RATIO))
    output = yaml.safe_load(draft)["columns"]["output"]
    assert output["unit"] == "mm" and output["radius_mm"] == pytest.approx(80.0, rel=1e-3), draft
    text = draft.replace(f"radius_mm: {output['radius_mm']:g}", "radius_mm: 80")
    (tmp_path / "run.yaml").write_text(text)
    assert np.allclose(load_measurement(tmp_path / "run.yaml").output_rad, SIGNALS["joint"], atol=1e-6)
    (tmp_path / "run.yaml").write_text(text.replace(", radius_mm: 80", ""))
    with pytest.raises(InputError, match=r"a length without its radius.*give radius_mm"):
        load_measurement(tmp_path / "run.yaml")
    (tmp_path / "run.yaml").write_text(text.replace("unit: mm", "unit: deg"))
    with pytest.raises(InputError, match="radius_mm: given beside unit deg"):
        load_measurement(tmp_path / "run.yaml")


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("time: {column: t, unit: s}\n  ", "", "columns.time: missing.*sample_rate_Hz"),
        ("data:", "sample_rate_Hz: 50\ndata:", "sample_rate_Hz: given beside columns.time"),
        ("time: {column: t, unit: s}", "time:", "columns.time"),
    ],
)
def test_a_run_needs_one_time(tmp_path: Path, old: str, new: str, words: str) -> None:
    write(tmp_path, "t,motor,joint", "t motor joint")
    text = "data: run.csv\nratio: 8\ncolumns:\n  time: {column: t, unit: s}\n  "
    text += "input: {column: motor, unit: rad}\n  output: {column: joint, unit: rad}\n"
    (tmp_path / "run.yaml").write_text(text.replace(old, new))
    with pytest.raises(InputError, match=words):
        load_measurement(tmp_path / "run.yaml")
