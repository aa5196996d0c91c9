"""Mistakes between bench and command, one by one: refused with line and remedy, or judged with a note."""

from __future__ import annotations

import datetime
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from logger_samples import Write, table
from sound_runs import DRIVE, SENSORS, sound_run

from mbcdm_cad.cli import run as mbcdm
from mbcdm_cad.measurement.file import load_file
from mbcdm_cad.measurement.vet import vetted_runs, vetting_lines

DESIGN = str(Path(__file__).parents[3] / "params" / "mbcdm.yaml")
DEG = 180.0 / np.pi
NAMES = ("t", "q_left", "q_right", "q_out", "tau")
QUANTITIES = ("time", "input_left", "input_right", "output", "load_torque")
ANGLES = ("q_left", "q_right", "q_out")


class JudgedError(Exception):
    """Raised in place of the search: reading and vetting let the run pass."""


@cache
def _columns() -> dict[str, np.ndarray]:
    run = sound_run()
    assert run.load_Nm is not None
    return dict(zip(NAMES, (run.time_s, *run.input_rad, run.output_rad, run.load_Nm), strict=True))


@cache
def _csv() -> str:
    return table(_columns())


def csv(**changed: np.ndarray) -> str:
    """The sound run with some columns changed."""
    return table(_columns() | changed) if changed else _csv()


def scaled(factor: float, *names: str) -> str:
    return csv(**{name: factor * _columns()[name] for name in names})


def exchanged(one: str, other: str) -> str:
    return csv(**{one: _columns()[other], other: _columns()[one]})


def with_line(number: int, change: Callable[[list[str]], list[str]]) -> str:
    """One line of the CSV (from 1), its cells changed."""
    lines = csv().split("\n")
    lines[number - 1] = ",".join(change(lines[number - 1].split(",")))
    return "\n".join(lines)


def with_cell(text: str, name: str = "q_out", number: int = 500) -> str:
    at = NAMES.index(name)
    return with_line(number, lambda cells: [*cells[:at], text, *cells[at + 1 :]])


def with_time(shown: Callable[[float], str]) -> str:
    head, *rows = csv().strip().split("\n")
    return "\n".join([head, *(shown(float(row.split(",", 1)[0])) + "," + row.split(",", 1)[1] for row in rows)]) + "\n"


def under_header(row: str) -> str:
    return csv().replace("\n", f"\n{row}\n", 1)


def first_rows(count: int) -> str:
    return "\n".join(csv().split("\n")[: count + 1]) + "\n"


def broken(count: int) -> str:
    """Every second row of the first ones cut short."""
    lines = csv().split("\n")
    for k in range(count):
        lines[2 + 2 * k] = lines[2 + 2 * k][:4]
    return "\n".join(lines)


def counted(bits: int, per_turn: float) -> np.ndarray:
    """The output as a counter shows it that runs over."""
    return (np.round(_columns()["q_out"] * per_turn / (2.0 * np.pi)) + 2 ** (bits - 2)) % 2**bits


def mapping(**changed: Any) -> dict[str, Any]:
    """The right measurement file with fields or, by a quantity's name, fields of its column changed; None: left out."""
    content: dict[str, Any] = {
        "data": "run.csv",
        "columns": {
            quantity: {"column": name, "unit": {"t": "s", "tau": "N*m"}.get(name, "rad")}
            for quantity, name in zip(QUANTITIES, NAMES, strict=True)
        },
        "sensors": {name: value for name, value in vars(SENSORS).items() if isinstance(value, float)},
    }
    for key, value in changed.items():
        if key in QUANTITIES and value is not None:
            content["columns"][key] = content["columns"][key] | value
        elif key in QUANTITIES:
            del content["columns"][key]
        else:
            content[key] = value
    return content


def in_unit(unit: str, *quantities: str) -> dict[str, Any]:
    return mapping(**{quantity: {"unit": unit} for quantity in quantities})


@dataclass(frozen=True)
class Mistake:
    """Data and mapping, what must be said, and where: ``file`` of run.csv and run.yaml, ``line`` of the former."""

    words: str
    data: Callable[[], str | bytes] = csv
    content: Callable[[], dict[str, Any]] = mapping
    file: str = "run.yaml"
    line: int = 0


START = datetime.datetime(2026, 3, 1, 9, 0, 0)
REFUSED = {
    "column not there": Mistake("did you mean q_out?", content=lambda: mapping(output={"column": "q_outt"})),
    "column in capitals": Mistake("did you mean q_out?", content=lambda: mapping(output={"column": "Q_OUT"})),
    "name without its unit": Mistake("did you mean 'q_out [rad]'?", lambda: csv().replace("q_out", "q_out [rad]", 1)),
    "a column that is no name": Mistake(
        "columns.output.column: not of the right kind", content=lambda: mapping(output={"column": True})
    ),
    "unknown unit": Mistake("did you mean rad?", content=lambda: in_unit("radian", "output")),
    "unit in small letters": Mistake("did you mean Nm?", content=lambda: in_unit("nm", "load_torque")),
    "a length": Mistake("give radius_mm, the distance", content=lambda: in_unit("mm", "output")),
    "NaN": Mistake("no finite number in 'q_out'", lambda: with_cell("NaN"), file="run.csv", line=500),
    "text": Mistake("no number in 'q_out' (value 'ERR')", lambda: with_cell("ERR"), file="run.csv", line=500),
    "empty cell": Mistake("no number in 'q_out' (value '')", lambda: with_cell(""), file="run.csv", line=500),
    "overload": Mistake("an overload in 'tau'", lambda: with_cell("9.9e37", "tau"), file="run.csv", line=500),
    "glitch of an angle": Mistake(
        "1 figure(s) of the output far from", lambda: with_cell("655.35"), file="run.csv", line=500
    ),
    "glitch of the torque": Mistake(
        "1 figure(s) of the load torque far", lambda: with_cell("-9999", "tau"), file="run.csv", line=500
    ),
    "time backwards": Mistake(
        "cut the file where a new run begins", lambda: csv(t=np.mod(_columns()["t"], 30.0)), file="run.csv", line=3002
    ),
    "time stands": Mistake(
        "log the time with more digits", lambda: csv(t=np.round(_columns()["t"], 1)), file="run.csv", line=3
    ),
    "time is another column": Mistake(
        "is this column the time?", lambda: exchanged("t", "q_out"), file="run.csv", line=3
    ),
    "time as a date": Mistake(
        "export the time as a number",
        lambda: with_time(lambda t: (START + datetime.timedelta(seconds=t)).isoformat()),
        file="run.csv",
        line=2,
    ),
    "time of day": Mistake(
        "export the time as a number",
        lambda: with_time(lambda t: f"09:{int(t) // 60:02d}:{t % 60.0:06.3f}"),
        file="run.csv",
        line=2,
    ),
    "too few samples": Mistake("too few samples (value 60", lambda: first_rows(60), file="run.csv", line=1),
    "never moved": Mistake(
        "no motion: the drive was never moved", lambda: csv(**dict.fromkeys(ANGLES, np.full_like(_columns()["t"], 0.3)))
    ),
    "output never moved": Mistake("no motion of the output", lambda: scaled(0.0, "q_out")),
    "resolution in degrees": Mistake(
        "turns by fewer than 20 such steps", content=lambda: mapping(sensors={"output_resolution_rad": 0.5})
    ),
    "input and output swapped": Mistake("output and input_left look swapped", lambda: exchanged("q_left", "q_out")),
    "output and torque swapped": Mistake("output and load_torque look swapped", lambda: exchanged("tau", "q_out")),
    "all in degrees": Mistake("all angles look like degrees declared as radians", lambda: scaled(DEG, *ANGLES)),
    "output in degrees": Mistake("output too large by 57.3, degrees declared as radians", lambda: scaled(DEG, "q_out")),
    "inputs in degrees": Mistake("inputs too large by 57.3, degrees", lambda: scaled(DEG, "q_left", "q_right")),
    "left sign": Mistake("the left input turns against the output", lambda: scaled(-1.0, "q_left")),
    "output sign": Mistake("its sign is reversed; set scale: -1", lambda: scaled(-1.0, "q_out")),
    "torque sign": Mistake("load_torque has the wrong sign", lambda: scaled(-1.0, "tau")),
    "torque in mN m": Mistake("mN*m declared as N*m?", lambda: scaled(1e3, "tau")),
    "all radians called degrees": Mistake(
        "(radians declared as degrees?)", content=lambda: in_unit("deg", "input_left", "input_right", "output")
    ),
    "N m called mN m": Mistake("(N*m declared as mN*m?)", content=lambda: in_unit("mN*m", "load_torque")),
    "counts a quarter": Mistake(
        "counts_per_turn a quarter",
        lambda: scaled(8192.0 / (2.0 * np.pi), "q_out"),
        lambda: mapping(output={"unit": "counts", "counts_per_turn": 2048}),
    ),
    "counts without a turn": Mistake("give counts_per_turn too", content=lambda: in_unit("counts", "output")),
    "counts called radians": Mistake("are these counts, some 819", lambda: scaled(8192.0 / (2.0 * np.pi), "q_out")),
    "counts_per_turn beside rad": Mistake(
        "set unit: counts", content=lambda: mapping(output={"counts_per_turn": 8192})
    ),
    "a counter that runs over": Mistake(
        "a counter overflows",
        lambda: csv(q_out=counted(16, 2.0**20)),
        lambda: mapping(output={"unit": "counts", "counts_per_turn": 2**20}),
    ),
    "angle within a turn": Mistake(
        "jumps by a full turn", lambda: csv(q_left=np.mod(_columns()["q_left"], 2.0 * np.pi))
    ),
    "one column twice": Mistake("the column of input_left too", content=lambda: mapping(output={"column": "q_left"})),
    "names twice": Mistake("2 columns of that name", lambda: csv().replace("q_right", "q_left", 1)),
    "decimal comma": Mistake(
        "set decimal: comma", lambda: table(_columns(), ";").replace(".", ","), file="run.csv", line=2
    ),
    "decimal comma between commas": Mistake("export with semicolons", lambda: csv().replace(".", ",")),
    "another delimiter than told": Mistake(
        "check delimiter", lambda: table(_columns(), ";"), lambda: mapping(delimiter="comma")
    ),
    "lines above the header": Mistake(
        "the name is on line 3: set skip_rows: 2", lambda: "Logger;V2\nDate,2026-03-01\n" + csv()
    ),
    "UTF-16": Mistake("UTF-16", lambda: csv().encode("utf-16"), file="run.csv", line=1),
    "UTF-16 without a mark": Mistake("UTF-16", lambda: csv().encode("utf-16-le"), file="run.csv", line=1),
    "a spreadsheet": Mistake(
        "export the data as text", lambda: b"PK\x03\x04" + bytes(range(256)) * 9, file="run.csv", line=1
    ),
    "line ends of CR": Mistake("line ends of LF", lambda: csv().replace("\n", "\r"), file="run.csv", line=1),
    "broken last row": Mistake("a row of another length", lambda: csv()[:-25], file="run.csv", line=6001),
    "thousands of broken rows": Mistake("a row of another length", lambda: broken(2500), file="run.csv", line=3),
    "thousands of broken rows to skip": Mistake(
        "too many broken rows (value 2500 of 6000",
        lambda: broken(2500),
        lambda: mapping(broken_rows="skip"),
        file="run.csv",
        line=3,
    ),
    "one input of two": Mistake("an input is missing", content=lambda: mapping(input_left=None)),
    "empty": Mistake("no rows", str, file="run.csv", line=1),
}

SAID = {
    "one sweep": Mistake("1 half sweep(s): nothing repeats", lambda: first_rows(480)),
    "constant load": Mistake("the load is constant", lambda: csv(tau=np.full_like(_columns()["t"], 0.4))),
    "a load that slackens the cables": Mistake("cables go slack", lambda: csv(tau=_columns()["tau"] + 20.0)),
    "ms called s": Mistake("is the time in ms", lambda: scaled(1e3, "t")),
    "s called ms": Mistake("is the time in s but declared as ms?", content=lambda: in_unit("ms", "time")),
    "sample numbers as time": Mistake("in sample numbers", lambda: csv(t=np.arange(_columns()["t"].size) + 0.0)),
    "counts of another encoder": Mistake(
        "slope between inputs and output 10.98",
        lambda: scaled(8192.0 / (2.0 * np.pi), "q_out"),
        lambda: mapping(output={"unit": "counts", "counts_per_turn": 10000}),
    ),
    "one column for both inputs": Mistake(
        "both inputs use the same column", content=lambda: mapping(input_right={"column": "q_left"})
    ),
    "row of units": Mistake("no figures on line 2 of run.csv", lambda: under_header("[s],[rad],[rad],[rad],[Nm]")),
    "rows of units and channels": Mistake(
        "no figures on lines 2 to 3 of run.csv", lambda: under_header("s,rad,rad,rad,N m\nch1,ch2,ch3,ch4,ch5")
    ),
    "other units in the names": Mistake(
        "run.csv has output in deg by its own header",
        lambda: csv().replace("q_out", "q_out [deg]", 1),
        lambda: mapping(output={"column": "q_out [deg]"}),
    ),
    "row of other units": Mistake(
        "run.csv has output in deg by its own header, but rad in the measurement file",
        lambda: under_header("s,rad,rad,deg,N m"),
    ),
    "some broken rows": Mistake(
        "50 broken rows of run.csv left out (lines 3, 5, 7, 9, 11, ...)",
        lambda: broken(50),
        lambda: mapping(broken_rows="skip"),
    ),
}

PLAIN = {
    "another unit by a scale": Mistake(
        "",
        lambda: scaled(DEG, "q_out").replace("q_out", "q_out (deg)", 1),
        lambda: mapping(output={"column": "q_out (deg)", "scale": 1.0 / DEG}),
    ),
    "byte order mark": Mistake("", lambda: b"\xef\xbb\xbf" + csv().encode()),
    "semicolons": Mistake("", lambda: table(_columns(), ";")),
    "decimal comma as told": Mistake(
        "", lambda: table(_columns(), ";").replace(".", ","), lambda: mapping(decimal="comma")
    ),
    "header in comments": Mistake("", lambda: "# bench 7\n# " + csv()),
    "line ends of CR LF": Mistake("", lambda: csv().replace("\n", "\r\n")),
    "empty trailing columns": Mistake("", lambda: csv().replace("\n", ",,\n")),
    "trailing delimiter in rows": Mistake("", lambda: csv().replace("\n", ",\n").replace(",\n", "\n", 1)),
    "time since long ago": Mistake("", lambda: with_time(lambda t: f"{1.77e9 + t:.3f}")),
    "left and right swapped, which nobody can see": Mistake("", lambda: exchanged("q_left", "q_right")),
}


def said_of(write: Write, mistake: Mistake, monkeypatch: pytest.MonkeyPatch) -> tuple[Path, int]:
    """The exit code of the real command, its search left out."""

    def judged(*_: object) -> None:
        raise JudgedError

    monkeypatch.setattr("mbcdm_cad.loop.search.engine.close_loop", judged)
    path = write(mistake.data(), mistake.content())
    try:
        return path, mbcdm(["loop", DESIGN, str(path)])
    except JudgedError:
        return path, 0


@pytest.mark.parametrize("which", REFUSED)
def test_refused_with_file_line_and_remedy(
    which: str, write: Write, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    mistake = REFUSED[which]
    path, code = said_of(write, mistake, monkeypatch)
    said = capsys.readouterr()
    assert code == 2 and mistake.words in said.err and not said.out, said
    first = next(line for line in said.err.splitlines() if mistake.words in line)
    assert first.startswith(f"{path.with_name(mistake.file)}:{mistake.line or ''}") and "; " in first, first
    assert len(said.err.splitlines()) <= 3, said.err


@pytest.mark.parametrize("which", {**SAID, **PLAIN})
def test_judged_and_said(which: str, write: Write, monkeypatch: pytest.MonkeyPatch) -> None:
    mistake = {**SAID, **PLAIN}[which]
    path, code = said_of(write, mistake, monkeypatch)
    assert code == 0, which
    doubts = [line for one in vetted_runs([load_file(path)], DRIVE) for line in vetting_lines(one) if "doubt: " in line]
    assert any(mistake.words in line for line in doubts) if mistake.words else not doubts, doubts


def test_a_run_given_twice_is_refused(write: Write, capsys: pytest.CaptureFixture[str]) -> None:
    path = write(csv(), mapping())
    assert mbcdm(["loop", DESIGN, str(path), str(path)]) == 2
    assert "run.yaml:1: data: the same data as " in (said := capsys.readouterr().err) and "once" in said, said
