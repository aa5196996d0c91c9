"""A draft decides by the data: lists in cells, clocks, one angle alone, paths and columns that begin again."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest
import yaml

from mbcdm_cad.errors import InputError
from mbcdm_cad.measurement.draft import draft_text
from mbcdm_cad.measurement.file import load_file
from mbcdm_cad.measurement.reading import read_run
from mbcdm_cad.measurement.roles import Expected

_random = np.random.default_rng(5)
T = 0.02 * np.arange(1500)
SWING = np.sin(2.0 * np.pi * T / 7.3) + 0.2 * np.sin(2.0 * np.pi * T / 2.9)


def noise(size: float) -> np.ndarray:
    return size * _random.standard_normal(T.size)


def log(folder: Path, names: str, columns: Sequence[np.ndarray], sign: str = ",", head: str = "") -> Path:
    rows = (sign.join(f"{v:.9g}" if abs(v) < 1e9 else f"{v:.0f}" for v in row) for row in zip(*columns, strict=True))
    (folder / "log.csv").write_text(head + "\n".join([names, *rows]) + "\n", encoding="utf-8")
    return folder / "log.csv"


def drafted(data: Path, ratio: float) -> dict[str, dict[str, object]]:
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
    columns = drafted(tmp_path / "log.csv", 3.0)
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
    found = drafted(log(tmp_path, names, columns, sign), ratio)
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
    found = drafted(log(tmp_path, names, [time, count, raw]), ratio)
    called = names.split(",")
    told = {found[role]["column"]: found[role] for role in ("input", "output")}
    assert told[called[2]]["counts_per_turn"] == told[called[2]]["wraps_at"] == wraps, found
    assert told[called[1]]["counts_per_turn"] == other, found
