"""A drafted measurement file reads the data correctly: units, signs, encoders before the gearhead, forces."""

from collections.abc import Sequence
from datetime import UTC, datetime, timedelta
from pathlib import Path

import numpy as np
import pytest
import yaml

from mbcdm_cad.cli import run as mbcdm
from mbcdm_cad.errors import InputError
from mbcdm_cad.measurement.draft import draft_text
from mbcdm_cad.measurement.file import load_file
from mbcdm_cad.measurement.reading import load_measurement, read_run
from mbcdm_cad.measurement.roles import Expected
from mbcdm_cad.measurement.run import Run
from mbcdm_cad.measurement.vet import arranged, refusals, vet
from tests.support.reference import REFERENCE as DESIGN
from tests.unit.measurement.sound_runs import DRIVE, sound_run

RUN = sound_run()
DEG = 57.29577951308232


def drafted(
    folder: Path, columns: dict[str, np.ndarray], sign: str = ",", comma: bool = False, title: str = ""
) -> tuple[str, Run]:
    """The draft for a logger's file of these columns, and the run that it reads, as the design has it."""
    rows = [sign.join(f"{value:.10g}" for value in row) for row in np.stack(list(columns.values()), axis=1)]
    text = title + "\n".join([sign.join(columns), *rows]) + "\n"
    (folder / "run.csv").write_text(text.replace(".", ",") if comma else text)
    draft = draft_text(folder / "run.csv", Expected.of_drive(DRIVE))
    (folder / "run.yaml").write_text(draft.replace("lever_arm_mm: '?'", "lever_arm_mm: 120"))
    return draft, arranged(load_measurement(folder / "run.yaml"), DRIVE)


def same(run: Run) -> None:
    np.testing.assert_allclose(run.output_rad, RUN.output_rad, atol=2e-4)
    np.testing.assert_allclose(run.input_rad, RUN.input_rad, atol=2e-3)
    assert not refusals(vet(run, DRIVE)), refusals(vet(run, DRIVE))


def test_plain_names_and_units(tmp_path: Path) -> None:
    draft, run = drafted(
        tmp_path,
        {
            "t": RUN.time_s,
            "q_left [rad]": RUN.input_rad[0],
            "q_right [rad]": RUN.input_rad[1],
            "q_out [rad]": RUN.output_rad,
            "tau": RUN.load_Nm,
            "state": np.ones_like(RUN.time_s),
        },
    )
    same(run)
    assert "guessed" in draft and "not used: state" in draft, draft
    np.testing.assert_allclose(run.load_Nm, RUN.load_Nm, rtol=1e-8)


def test_counts_before_the_gearhead_degrees_and_a_load_cell(tmp_path: Path) -> None:
    counts = np.round(RUN.input_rad * DRIVE.gearhead.ratio * 512.0 / (2.0 * np.pi))
    draft, run = drafted(
        tmp_path,
        {
            "time_ms": 1e3 * RUN.time_s,
            "motor_left": -counts[0],
            "motor_right": counts[1],
            "drum": DEG * RUN.output_rad,
            "load_cell (N)": RUN.load_Nm / 0.12,
        },
    )
    assert "side: motor" in draft and "counts_per_turn: 512" in draft and "scale: -1" in draft, draft
    assert "unit: deg" in draft and "put the arm of the load cell" in draft, draft
    same(run)
    np.testing.assert_allclose(run.load_Nm, RUN.load_Nm, rtol=1e-6)


def test_a_table_of_semicolons_and_decimal_commas(tmp_path: Path) -> None:
    columns = {"t": RUN.time_s, "left": RUN.input_rad[0], "right": RUN.input_rad[1], "drum": RUN.output_rad}
    draft, run = drafted(tmp_path, columns, ";", comma=True)
    assert "decimal: comma" in draft, draft
    same(run)


def test_what_is_no_run_is_refused_and_nothing_is_overwritten(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "run.csv").write_text("a,b\n" + "7,5\n" * 200)
    with pytest.raises(InputError, match="no column looks like the output"):
        draft_text(tmp_path / "run.csv", Expected.of_drive(DRIVE))
    columns = {"t": RUN.time_s, "left": RUN.input_rad[0], "right": RUN.input_rad[1], "drum": RUN.output_rad}
    drafted(tmp_path, columns)
    before = (tmp_path / "run.yaml").read_bytes()
    assert mbcdm(["measurement-init", str(tmp_path / "run.csv"), str(DESIGN)]) == 2
    assert "exists already" in capsys.readouterr().err and (tmp_path / "run.yaml").read_bytes() == before
    assert mbcdm(["measurement-init", str(tmp_path / "run.csv"), str(DESIGN), "--out", str(tmp_path / "new.yaml")]) == 0
    assert mbcdm(["measurement-init", str(tmp_path / "none.csv"), str(DESIGN)]) == 2


@pytest.mark.parametrize(("name", "unit"), [("cell_N", "N"), ("torque_Nm", "Nm"), ("load_n", "N*m")])
def test_the_end_of_a_name_states_the_unit_of_the_load(tmp_path: Path, name: str, unit: str) -> None:
    columns = {"t": RUN.time_s, "left": RUN.input_rad[0], "right": RUN.input_rad[1], "drum": RUN.output_rad}
    draft, _ = drafted(tmp_path, {**columns, name: RUN.load_Nm})
    assert f'"{name}", unit: {unit}' in draft, draft


def test_whole_numbers_do_not_hide_the_decimal_comma_nor_a_title_the_names(tmp_path: Path) -> None:
    """Counters are figures with either decimal sign; a title has fewer cells than the table below it."""
    counts = np.round(RUN.input_rad * DRIVE.gearhead.ratio * 4096.0 / (2.0 * np.pi))
    columns = {
        "Zeit [ms]": 1e3 * RUN.time_s,
        "Motor L [counts]": counts[0],
        "Motor R [counts]": counts[1],
        "Abtrieb [deg]": DEG * RUN.output_rad,
        "Kanal 7 [N]": RUN.load_Nm / 0.12,
    }
    draft, run = drafted(tmp_path, columns, ";", comma=True, title="Messung;Pruefstand 3\n")
    assert "decimal: comma" in draft and "skip_rows: 1 " in draft, draft
    assert 'load_torque: {column: "Kanal 7 [N]", unit: N' in draft, draft
    same(run)
    np.testing.assert_allclose(run.load_Nm, RUN.load_Nm, rtol=1e-6)


def test_encoders_of_one_turn_are_counted_on(tmp_path: Path) -> None:
    """Two absolute encoders of 14 bits on the motors and one in degrees on the drum, which passes from 360 to 0."""
    turns = RUN.input_rad * DRIVE.gearhead.ratio / (2.0 * np.pi)
    counts = np.floor(np.mod(turns + np.array([[0.3], [0.7]]), 1.0) * 16384.0)
    columns = {
        "t_s": RUN.time_s,
        "mot_left": counts[0],
        "mot_right": counts[1],
        "drum_deg": np.mod(DEG * RUN.output_rad + 3.0, 360.0),
        "tau_Nm": RUN.load_Nm,
    }
    draft, run = drafted(tmp_path, columns)
    assert draft.count("wraps_at: 16384") == 2 and "wraps_at: 360" in draft, draft
    step = 2.0 * np.pi / 16384.0 / DRIVE.gearhead.ratio
    for measured, true in zip(run.input_rad, RUN.input_rad, strict=True):
        np.testing.assert_allclose(measured - measured[0], true - true[0], atol=2.0 * step)
    turned = run.output_rad - RUN.output_rad
    np.testing.assert_allclose(turned, turned[0], atol=1e-7)


def test_dates_are_a_time(tmp_path: Path) -> None:
    """A script's isoformat(), which leaves out the fraction of a whole second."""
    columns = {"left": RUN.input_rad[0], "right": RUN.input_rad[1], "drum": RUN.output_rad, "tau": RUN.load_Nm}
    began = datetime(2026, 3, 1, 23, 59, 30, tzinfo=UTC)
    rows = zip(RUN.time_s, *columns.values(), strict=True)
    lines = [",".join(["timestamp", *columns])]
    lines += [",".join([(began + timedelta(seconds=t)).isoformat(), *(f"{v:.10g}" for v in rest)]) for t, *rest in rows]
    (tmp_path / "run.csv").write_text("\n".join(lines) + "\n")
    draft = draft_text(tmp_path / "run.csv", Expected.of_drive(DRIVE))
    assert 'time: {column: "timestamp", unit: iso8601}' in draft, draft
    (tmp_path / "run.yaml").write_text(draft)
    run = arranged(load_measurement(tmp_path / "run.yaml"), DRIVE)
    np.testing.assert_allclose(run.time_s - run.time_s[0], RUN.time_s - RUN.time_s[0], atol=1.1e-6)
    same(run)


@pytest.mark.parametrize(
    ("head", "sign", "expected"),
    [
        ("Frequency (Hz),Channel 1 Magnitude (dB),Channel 2 Magnitude (dB),Channel 2 Phase (deg)", ",", "turns: 1}"),
        ("# Bode\n% Frequency (Hz), Gain (dB), Phase (deg)", ",", "response: {over: inputs}"),
        ("freq_rad/s\tmag\tphase_deg\tcoherence", "\t", "unit: rad/s}"),
        ("Frequenz [Hz];Betrag [dB];Phase [°]", ";", "over: torque"),
    ],
)
def test_a_table_of_gain_and_phase_is_one_of_an_analyser(head: str, sign: str, expected: str, tmp_path: Path) -> None:
    """As analysers and control suites write it: a reference channel, rad/s, falling frequencies, decimal commas."""
    f = np.geomspace(5.0, 200.0, 60)
    s, w = 2j * np.pi * f, 2.0 * np.pi * 70.0
    value = w**2 / (s**2 + 30.0 * s + w**2)
    gain, phase = 20.0 * np.log10(np.abs(value)), np.degrees(np.unwrap(np.angle(value)))
    columns = {
        "Frequency (Hz)": [f, 0.0 * f, gain, phase],
        "# Bode": [f, gain - 20.0 * np.log10(9.0), phase],
        "freq_rad/s\tmag": [2.0 * np.pi * f, np.abs(value) / 9.0, phase, 1.0 - 1e-4 * f],
        "Frequenz": [f[::-1], gain[::-1] - 80.0, phase[::-1]],
    }
    table = next(rows for begin, rows in columns.items() if head.startswith(begin))
    lines = [sign.join(f"{v:.7g}" for v in row) for row in np.stack(table, axis=1)]
    text = "\n".join([head, *((line.replace(".", ",") if sign == ";" else line) for line in lines)])
    (tmp_path / "bode.csv").write_text(text + "\n", encoding="utf-8")
    draft = draft_text(tmp_path / "bode.csv", Expected.of_drive(DRIVE))
    assert expected in draft and "kind: frequency_response" in draft, draft
    (tmp_path / "bode.yaml").write_text(draft, encoding="utf-8")
    read = load_measurement(tmp_path / "bode.yaml").table
    assert read is not None
    np.testing.assert_allclose(read.frequency_Hz, f, rtol=1e-5)
    np.testing.assert_allclose(read.value / np.abs(read.value[0]), value / np.abs(value[0]), rtol=1e-4)


_random = np.random.default_rng(5)
T = 0.02 * np.arange(1500)
SWING = np.sin(2.0 * np.pi * T / 7.3) + 0.2 * np.sin(2.0 * np.pi * T / 2.9)


def noise(size: float) -> np.ndarray:
    return size * _random.standard_normal(T.size)


def log(folder: Path, names: str, columns: Sequence[np.ndarray], sign: str = ",", head: str = "") -> Path:
    rows = (sign.join(f"{v:.9g}" if abs(v) < 1e9 else f"{v:.0f}" for v in row) for row in zip(*columns, strict=True))
    (folder / "log.csv").write_text(head + "\n".join([names, *rows]) + "\n", encoding="utf-8")
    return folder / "log.csv"


def drafted_file(data: Path, ratio: float) -> dict[str, dict[str, object]]:
    """The columns of the draft, which is read and whose slope is the ratio."""
    text = draft_text(data, Expected.of_ratio(ratio))
    file = data.with_suffix(".yaml")
    file.write_text(text, encoding="utf-8")
    run = read_run(load_file(file)).run
    slope = np.polyfit(run.output_rad, run.input_rad[0], 1)[0]
    assert abs(slope) == pytest.approx(ratio, rel=0.03), text
    columns: dict[str, dict[str, object]] = yaml.safe_load(text)["columns"]
    return columns


def test_a_clock_that_was_reset_is_told_with_its_line(tmp_path: Path) -> None:
    columns = [np.where(T < 14.0, T, T - 14.0), 8.0 * SWING, SWING]
    text = draft_text(log(tmp_path, "uptime_s,motor,joint", columns), Expected.of_ratio(8.0))
    assert "log.csv:702: time runs backwards" in text and "cut the file where a new run begins" in text, text
    assert "log.csv:702" in text.split("\n")[0] and yaml.safe_load(text)["columns"]["time"]["column"] == "uptime_s"


@pytest.mark.parametrize("names", ["t,motor", "Zeit;Abtrieb", "ms\tencoder", "stamp,ref_count"])
def test_one_of_two_files_of_a_run_asks_for_the_other(names: str, tmp_path: Path) -> None:
    sign = next(s for s in ",;\t" if s in names)
    with pytest.raises(InputError, match=r"log.csv:2: one angle moves.*join the file that holds the other"):
        draft_text(log(tmp_path, names, [T, np.round(4096.0 * SWING)], sign), Expected.of_ratio(8.0))


@pytest.mark.parametrize(("unit", "second"), [("us", 1e6), ("ns", 1e9), ("ms", 1e3)])
def test_the_draft_counts_the_seconds_on(tmp_path: Path, unit: str, second: float) -> None:
    """A time in two columns: whole seconds, and what is over them."""
    time = 0.913 + T
    whole = np.floor(time + 1e-9)
    columns = [0.0 * T + 1.0, 8.0 * SWING, SWING, whole, np.round((time - whole) * second)]
    data = log(
        tmp_path, f"mode motor joint time_s time_{unit}", columns, " ", "logger: on a Saturday; Capacity: 1000\n"
    )
    text = draft_text(data, Expected.of_ratio(8.0))
    fields = yaml.safe_load(text)["columns"]["time"]
    assert fields == {"column": f"time_{unit}", "wraps_at": second, "unit": unit}, text
    data.with_suffix(".yaml").write_text(text)
    run = read_run(load_file(data.with_suffix(".yaml"))).run
    assert np.allclose(run.time_s - run.time_s[0], T - T[0], atol=2e-3 if unit == "ms" else 1e-6)


LISTS = [
    # Row of the table with the figures {m} and {j} of motor and joint; names; input, output.
    ("t,name,position", "{t:.3f},\"['motor', 'arm']\",\"[{m:.6f}, {j:.6f}]\"", "position/motor", "position/arm"),
    ("t,position,name", "{t:.3f},\"[{j:.6f}, {m:.6f}]\",\"['arm', 'motor']\"", "position/motor", "position/arm"),
    ("t,pos", '{t:.3f},"[{m:.6f},{j:.6f}]"', "pos[0]", "pos[1]"),
    ("t,pos", "{t:.3f},[{m:.6f} {j:.6f}]", "pos[0]", "pos[1]"),
    ("t;pos;ok", "{t:.3f};[{m:.6f}, {j:.6f}];1", "pos[0]", "pos[1]"),
    ("t\tq\tdq", "{t:.3f}\t[{m:.6f}, {j:.6f}]\t[0.0, 0.0]", "q[0]", "q[1]"),
    ("zeit,winkel,gelenke", '{t:.3f},"[{m:.6f}, {j:.6f}]","[Antrieb, Abtrieb]"', "winkel/Antrieb", "winkel/Abtrieb"),
    ("t,q", "{t:.3f},\"array('d', [{m:.6f}, {j:.6f}])\"", "q[0]", "q[1]"),
    ("t,seq,q", '{t:.3f},{k},"[ {m:.6f} , {j:.6f}, 0.5 ]"', "q[0]", "q[1]"),
    ("secs,nsecs,q", '{s},{n},"[{m:.6f}, {j:.6f}]"', "q[0]", "q[1]"),
]


@pytest.mark.parametrize(("names", "row", "motor", "joint"), LISTS)
def test_a_list_in_a_cell_is_as_many_columns(names: str, row: str, motor: str, joint: str, tmp_path: Path) -> None:
    figures = zip(T, 3.0 * SWING, SWING + noise(1e-4), strict=True)
    lines = [
        row.format(t=t, m=m, j=j, k=k, s=1700000000 + int(t + 1e-9), n=round(1e9 * (t + 1e-9 - int(t + 1e-9))))
        for k, (t, m, j) in enumerate(figures)
    ]
    (tmp_path / "log.csv").write_text("\n".join([names, *lines]) + "\n", encoding="utf-8")
    columns = drafted_file(tmp_path / "log.csv", 3.0)
    assert (columns["input"]["column"], columns["output"]["column"]) == (motor, joint), columns


def test_lists_of_another_length_are_told_with_their_line(tmp_path: Path) -> None:
    lines = [f'{t:.3f},"[{3 * q:.6f}, {q:.6f}]"' for t, q in zip(T, SWING, strict=True)]
    lines[40] = '0.800,"[1.0]"'
    (tmp_path / "log.csv").write_text("\n".join(["t,pos", *lines]) + "\n")
    text = draft_text(tmp_path / "log.csv", Expected.of_ratio(3.0))
    assert "broken_rows: skip" in text, text
    (tmp_path / "log.yaml").write_text(text.replace("broken_rows: skip", "broken_rows: refuse"))
    with pytest.raises(InputError, match=r"log.csv:42: a row of another length"):
        read_run(load_file(tmp_path / "log.yaml"))


@pytest.mark.parametrize(
    ("names", "per_s", "range_", "head"),
    [
        ("Time[ms],Realtime Tick,Present Position,Goal Position", 1e3, 32768, "SERVO Graph,3,,\nItemCount,3,,\n"),
        ("t,tick,pos,goal", 1e3, 32768, ""),
        ("t,micros,pos,goal", 1e6, 2**32, ""),
        ("time_s,mcu_ms,angle,cmd", 1e3, 65536, ""),
        ("Zeit,Takt,Winkel,Soll", 1e3, 1e12, ""),
        ("a,b,c,d", 1e3, 1e12, ""),
        ("t,b,c,d", 1e6, 1e12, "Logger 7\n"),
        ("temps,horloge,angle,consigne", 1e3, 1e12, ""),
        ("time,clk_us,q,q_des", 1e6, 1e6, ""),
        ("t,device time,servo,target", 1.0, 1e12, ""),
    ],
)
def test_a_clock_is_no_angle(names: str, per_s: float, range_: float, head: str, tmp_path: Path) -> None:
    """A hand rocks the horn of a servo through its play while the goal rests; a second clock runs beside the time."""
    clock = np.mod(np.round(per_s * T * 1e3) / 1e3 + 28259, range_)
    time = np.round(1e3 * T) if "[ms]" in names else T
    horn = np.round(8.0 * SWING)
    data = log(tmp_path, names, [time, clock, horn, 0.0 * T], head=head)
    with pytest.raises(InputError, match=r"log.csv:\d+: one angle moves.*rests.*by 1\d of its figures") as told:
        draft_text(data, Expected.of_ratio(1.0))
    # Without a name that says time either of the two is the other's clock.
    assert any(f"{name} is a clock" in str(told.value) for name in names.split(",")[:2]), told.value
    assert "turning_points" in str(told.value)


@pytest.mark.parametrize(
    ("names", "copy", "sign"),
    [
        ("Frame,Time,dx,dy,RARawDistance,SNR", 1.0, 1.0),
        ("Frame,Time,dx,dy,RARawDistance,SNR", 1.0, -1.0),
        ("n,t,angle,b,angle_copy,c", 1.0, 1.0),
        ("n,t,q_rad,b,q_deg,c", 180.0 / np.pi, 1.0),
        ("n,t,turns,b,rad,c", 2.0 * np.pi, 1.0),
        ("Nr,Zeit,Winkel,Rauschen,Winkel 2,Pegel", 1.0, 1.0),
        ("row,sec,encoder1,volt,encoder2,lux", 1.0, 1.0),
        ("idx,temps,angle,bruit,angle_mrad,niveau", 1e3, 1.0),
        ("k,t,motor,x,joint,y", 1.0, 1.0),
        ("k,t,input,x,output,y", 1.0, -1.0),
    ],
)
def test_two_columns_that_are_equal_are_one_angle(names: str, copy: float, sign: float, tmp_path: Path) -> None:
    angle = SWING + noise(0.01)
    columns = [np.arange(T.size) + 1.0, 100.0 * T, angle, noise(0.1), sign * copy * angle, 30.0 + noise(0.5)]
    data = log(tmp_path, names, columns, head="Guiding begins at 21:12\nPixel scale = 1.50\n")
    called = names.split(",")
    with pytest.raises(InputError, match=f"{called[4]} equals {called[2]}.*a drive needs the angles of its input"):
        draft_text(data, Expected.of_ratio(1.0))


@pytest.mark.parametrize(
    ("names", "per_turn", "ratio", "sign"),
    [
        ("ms_today;temp_motor;erpm;tacho_meter;tacho_abs_meter;encoder_position", 90, 5.0, ";"),
        ("time,temp_motor,rpm,tacho,tacho_abs,encoder", 84, 5.0, ","),
        ("t,t_motor,w,steps,odometer,angle_deg", 42, 9.0, ","),
        ("Zeit;Temperatur;Drehzahl;Zähler;Weg;Winkel", 200, 5.0, ";"),
        ("t,a,b,c,d,e", 400, 3.0, ","),
        ("t\ta\tb\tc\td\te", 4096, 3.0, "\t"),
        ("time,mot_temp,vel,hall,hall_total,resolver", 60, 12.0, ","),
        ("time,temp,speed,count,travelled,pot_deg", 2048, 6.0, ","),
        ("s,winding,omega,motor_cnt,trip,joint", 16384, 5.0, ","),
        ("temps,chaleur,vitesse,pas,chemin,sortie", 3200, 4.0, ","),
    ],
)
def test_a_path_and_a_temperature_are_no_angles(
    names: str, per_turn: int, ratio: float, sign: str, tmp_path: Path
) -> None:
    """A controller logs a temperature in few steps, a counter with the path beside it, and a wrapped angle."""
    motor = np.round(1.012 * ratio * 4.0 * SWING * per_turn)
    path = np.concatenate([[0.0], np.cumsum(np.abs(np.diff(motor)))])
    warm = 29.0 + 0.1 * (np.arange(T.size) % 10)
    angle = np.mod(360.0 * 4.0 * SWING + 355.0 + noise(0.05), 360.0)
    columns = [1e3 * T if "ms" in names else T, warm, np.gradient(motor) * 10.0, motor, path, angle]
    found = drafted_file(log(tmp_path, names, columns, sign), ratio)
    called = names.split(sign)
    assert found["input"] == {"column": called[3], "unit": "counts", "counts_per_turn": per_turn}, found
    assert found["output"] == {"column": called[5], "wraps_at": 360, "unit": "deg"}, found


@pytest.mark.parametrize(
    ("names", "wraps", "other", "ratio"),
    [
        ("millis,ref_count,as5048_raw", 16384, 40000, 1.0),
        ("t,reference,raw", 4096, 20000, 1.0),
        ("t,motor,magnet", 1024, 3200, 1.0),
        ("time,a,b", 16384, 36000, 1.0),
        ("Zeit,Antrieb,Abtrieb", 4096, 8000, 5.0),
        ("t,motor_enc,joint_enc", 8192, 2000, 10.0),
        ("stamp,servo,load_raw", 3600, 4096, 2.0),
        ("micros,stepper,as5600", 4096, 6400, 3.0),
        ("sec,m,l", 2**19, 10000, 4.0),
        ("t,in,out", 16384, 16384, 1.0),
    ],
)
def test_where_a_column_begins_again_is_a_turn(
    names: str, wraps: int, other: int, ratio: float, tmp_path: Path
) -> None:
    """An encoder of one turn spun one way against another whose counts follow from the slope."""
    out = 2.0 * np.pi * 0.37 * T + 0.012 * np.sin(2.0 * np.pi * 0.37 * T)
    raw = np.mod(np.round(out / (2.0 * np.pi) * wraps) + 8.0, wraps)
    count = np.round(ratio * 0.37 * T * other)
    time = np.round(1e3 * T) if "millis" in names else np.round(1e6 * T) if "micros" in names else T
    found = drafted_file(log(tmp_path, names, [time, count, raw]), ratio)
    called = names.split(",")
    told = {found[role]["column"]: found[role] for role in ("input", "output")}
    assert told[called[2]]["counts_per_turn"] == told[called[2]]["wraps_at"] == wraps, found
    assert told[called[1]]["counts_per_turn"] == other, found
