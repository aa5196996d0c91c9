"""Vetting: wrong declarations are found and reported, a correct run gives no finding."""

import datetime
import os
import shutil
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from mbcdm_cad.cli import run as mbcdm
from mbcdm_cad.layouts.registry import layout_of
from mbcdm_cad.measurement.file import load_file
from mbcdm_cad.measurement.reading import load_measurement, read_run
from mbcdm_cad.measurement.run import Run, Sensors
from mbcdm_cad.measurement.vet import arranged, refusals, vet, vetted_runs, vetting_lines
from mbcdm_cad.measurement.vet_signals import load_levels, order_left
from tests.support.bench_data import CASES, simulate_case, write_run
from tests.support.reference import ROOT
from tests.unit.measurement.sound_runs import DRIVE, SENSORS, Write, sound_run, table

RUN = sound_run()
RATIO = float(np.mean(layout_of(DRIVE).si.total_ratio))
FEW = ("null", "ratio_radii", "lash_input_left", "slip_anchor", "drum_short")


def kinds(run: Run, level: str | None = None) -> set[str]:
    return {finding.kind for finding in vet(run, DRIVE) if level in (None, finding.level)}


@pytest.mark.parametrize(
    ("design", "columns", "first"),
    [
        (("left", "right"), ("right", "left"), "left"),
        (("port", "star"), ("star", "port"), "port"),
        (("port", "star"), ("left", "right"), "left"),
    ],
)
def test_inputs_come_in_the_order_of_the_design(design: tuple[str, str], columns: tuple[str, str], first: str) -> None:
    cables = tuple(replace(c, input_name=design[DRIVE.input_names.index(c.input_name)]) for c in DRIVE.cables)
    drive = replace(DRIVE, input_names=design, cables=cables)
    run = replace(RUN, input_names=columns, input_rad=RUN.input_rad * np.array([[1.0], [1.001]]))
    found = arranged(run, drive)
    assert found.input_names[0] == first, found.input_names
    assert (found.input_rad[0] == run.input_rad[columns.index(first)]).all()
    assert not refusals(vet(found, drive)), refusals(vet(found, drive))
    strange = refusals(vet(replace(found, input_names=("one", "two")), drive))
    assert strange and "are not those of the design" in str(strange[0]), strange


def test_motor_turns_become_those_of_the_inputs() -> None:
    gearhead = DRIVE.gearhead.ratio
    sensors = Sensors(input_resolution_rad=gearhead * 1.9175e-4, output_resolution_rad=1.3635e-6)
    run = replace(RUN, input_rad=gearhead * RUN.input_rad, motor_side=(True, True), sensors=sensors)
    found = arranged(run, DRIVE)
    np.testing.assert_allclose(found.input_rad, RUN.input_rad, rtol=1e-12)
    assert found.sensors.input_resolution_rad == pytest.approx(1.9175e-4) and found.motor_side == ()
    assert not refusals(vet(found, DRIVE)), refusals(vet(found, DRIVE))
    said = "; ".join(str(note) for note in refusals(vet(replace(run, motor_side=()), DRIVE)))
    assert f"the gearhead's {gearhead:g}" in said and "set side: motor" in said, said


def with_inputs(factor_left: float, factor_right: float) -> Run:
    return replace(RUN, input_rad=RUN.input_rad * np.array([[factor_left], [factor_right]]))


def test_a_sound_run_is_left_in_peace() -> None:
    found = vet(RUN, DRIVE)
    assert not [str(finding) for finding in found if finding.level != "fact"]
    said = "\n".join(str(finding) for finding in found)
    assert "12 half sweep(s)" in said and "load levels 0.1, 0.9 N m" in said, said


@pytest.mark.parametrize(
    ("run", "kind", "field", "words"),
    [
        (with_inputs(-1, -1), "reversed_output", "output", "scale: -1"),
        (with_inputs(-1, 1), "reversed_input", "input_left", "left input turns against"),
        (with_inputs(1, -1), "reversed_input", "input_right", "right input turns against"),
        (with_inputs(57.29578, 57.29578), "unit", "input_left", "degrees declared as radians"),
        (with_inputs(1, 57.29578), "unit", "input_right", "degrees declared as radians"),
        (with_inputs(2, 2), "unit", "input_left", "counts_per_turn half"),
        (with_inputs(1, 0.25), "unit", "input_right", "the reverse of counts_per_turn a quarter"),
        (replace(RUN, output_rad=RUN.output_rad * 57.29578), "unit", "output", "output too large by 57.3, degrees"),
        (with_inputs(3, 3), "ratio", "input_left", "slope between inputs and output 27"),
        (
            replace(RUN, output_rad=RUN.input_rad[1], input_rad=np.stack([RUN.input_rad[0], RUN.output_rad])),
            "swapped",
            "output",
            "output and input_right look swapped",
        ),
        (
            replace(RUN, output_rad=RUN.load_Nm, load_Nm=RUN.output_rad),
            "swapped",
            "output",
            "output and load_torque look swapped",
        ),
        (
            replace(RUN, output_rad=57.29578 * RUN.output_rad, input_rad=57.29578 * RUN.input_rad),
            "travel",
            "output",
            "degrees declared as radians",
        ),
        (
            replace(RUN, input_rad=np.stack([RUN.input_rad[0], np.random.default_rng(1).normal(size=RUN.time_s.size)])),
            "unrelated",
            "input_right",
            "does not follow the right input",
        ),
        (replace(RUN, load_Nm=-RUN.load_Nm), "reversed_load", "load_torque", "scale: -1 on load_torque"),
        (replace(RUN, load_Nm=1000.0 * RUN.load_Nm), "load", "load_torque", "mN*m declared as N*m?"),
        (replace(RUN, input_rad=RUN.input_rad[:1], input_names=("input",)), "inputs", "columns", "1 input column"),
        (replace(RUN, input_rad=np.mod(RUN.input_rad, 2.0 * np.pi)), "wrapped", "input_left", "jumps by a full turn"),
    ],
)
def test_wrong_columns_are_refused_with_field_and_remedy(run: Run, kind: str, field: str, words: str) -> None:
    found = refusals(vet(run, DRIVE))
    said = [f"{finding.kind} {finding.field}: {finding}" for finding in found]
    assert any(f.kind == kind and f.field[-1] == field and words in str(f) for f in found), said
    assert all(finding.remedy for finding in found), said
    others = {"reversed_output", "reversed_input", "unit", "swapped", "travel", "reversed_load"} - {kind}
    assert not [finding.kind for finding in found if finding.kind in others], said


def test_a_late_sensor_is_not_a_load_of_the_wrong_sign() -> None:
    """A motor that helps the motion: the load is least where the late output is farthest behind."""
    speed = np.gradient(RUN.input_rad[0], RUN.time_s)
    load = 0.5 - 0.6 * speed / np.abs(speed).max()
    now = RUN.input_rad.mean(axis=0) / RATIO - 1e-4 * load
    late = np.interp(RUN.time_s - 5e-3, RUN.time_s, now)
    found = vet(replace(RUN, output_rad=late, load_Nm=load), DRIVE)
    assert not [str(f) for f in found if f.kind in ("reversed_load", "load", "unit")], [str(f) for f in found]


def clipped(run: Run) -> Run:
    return replace(run, output_rad=np.clip(run.output_rad, -0.2, 1.0))


@pytest.mark.parametrize(
    ("run", "kind", "words"),
    [
        (clipped(RUN), "saturated", "output stays at its lowest figure, -0.2 rad"),
        (
            replace(RUN, load_Nm=np.minimum(RUN.load_Nm, 0.88)),
            "saturated",
            "load torque is at its highest figure, 0.88",
        ),
        (replace(RUN, time_s=RUN.time_s + 3.0 * (RUN.time_s > 20.0)), "gaps", "the longest 3.01 s at 20 s"),
        (sound_run(half_sweeps=1), "one_sweep", "nothing repeats"),
        (sound_run(load="constant"), "constant_load", "the load is constant (0.5002 N m)"),
    ],
)
def test_doubts_are_told_and_the_run_still_judged(run: Run, kind: str, words: str) -> None:
    found = vet(run, DRIVE)
    assert not refusals(found), [str(finding) for finding in found]
    assert any(f.kind == kind and f.level == "doubt" and words in str(f) for f in found), [str(f) for f in found]


def test_what_the_run_can_tell() -> None:
    assert "load_follows_speed" in kinds(sound_run(load="brake")) and "load_follows_speed" not in kinds(RUN)
    bare = replace(RUN, load_Nm=None, sensors=Sensors())
    said = "\n".join(str(finding) for finding in vet(bare, DRIVE))
    assert "no load_torque: kinematics only" in said, said
    assert "input_resolution_rad, output_resolution_rad not given" in said and "torque_noise" not in said, said
    short = "\n".join(str(finding) for finding in vet(sound_run(0.03), DRIVE))
    assert "drum order 1 and ratio_error cannot be separated over this travel" in short, short
    long = "\n".join(str(finding) for finding in vet(sound_run(0.45), DRIVE))
    assert "drum order 1 differs from a ratio error by 0.0085" in long, long


def test_a_drive_of_which_only_the_ratio_is_known() -> None:
    one = replace(RUN, input_rad=RUN.input_rad[:1], input_names=("input",), ratio=9.0, load_Nm=None)
    assert not refusals(vet(one, None)), [str(finding) for finding in vet(one, None)]
    found = refusals(vet(replace(one, ratio=1.0 / 9.0), None))
    assert found and found[0].kind in ("swapped", "ratio"), [str(finding) for finding in found]


@pytest.mark.parametrize(("travel_deg", "share"), [(120.0, 0.0025), (300.0, 0.16)])
def test_share_of_order_one_beside_a_ratio(travel_deg: float, share: float) -> None:
    angle = np.radians(np.linspace(-0.5, 0.5, 4001) * travel_deg)
    assert order_left(angle, 1.0) == pytest.approx(share, rel=0.02)


def test_load_levels_are_found_only_where_the_load_rests() -> None:
    rng = np.random.default_rng(2)
    steps = np.repeat([-0.9, -0.3, 0.3, 0.9], 500) + rng.normal(0.0, 0.005, 2000)
    assert load_levels(steps) == pytest.approx([-0.9, -0.3, 0.3, 0.9], abs=0.01)
    assert load_levels(np.sin(np.linspace(0.0, 20.0, 2000))) == []


def test_an_angle_that_only_jumps_between_two_places_is_vetted() -> None:
    jumps = np.where(np.arange(RUN.time_s.size) > 3000, 0.4, 0.0)
    run = replace(RUN, output_rad=jumps, input_rad=np.tile(9.0 * jumps, (2, 1)))
    assert "one_sweep" in kinds(run, "doubt") and order_left(jumps, 1.0) < 1e-12


@pytest.mark.parametrize(
    "name", [name if name in FEW else pytest.param(name, marks=pytest.mark.slow) for name in CASES]
)
def test_a_sound_run_is_judged_whatever_is_wrong_with_the_drive(name: str, tmp_path: Path) -> None:
    """Runs with every effect, and with causes outside the vocabulary, are neither refused nor doubted."""
    write_run(tmp_path, "run", simulate_case(DRIVE, name, 7), DRIVE.input_names)
    found = vet(load_measurement(tmp_path / "run.yaml"), DRIVE)
    assert not [str(finding) for finding in found if finding.level != "fact"]


DESIGN = str(Path(__file__).parents[3] / "params" / "mbcdm.yaml")
DEG = 180.0 / np.pi
NAMES = ("t", "q_left", "q_right", "q_out", "tau")
QUANTITIES = ("time", "input_left", "input_right", "output", "load_torque")
ANGLES = ("q_left", "q_right", "q_out")


class JudgedError(BaseException):
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


MAPPINGS = sorted((ROOT / "params" / "measurements" / "davinci").glob("*.yaml"))
DATA = Path(os.environ.get("MBCDM_SHARED_DATA", ROOT.parent / "shared" / "data")) / "davinci"


def real_run(name: str, folder: Path) -> Run:
    """One run, its measurement file put beside the data by a link."""
    if not DATA.is_dir():
        pytest.skip(f"the real runs are not here ({DATA}); set MBCDM_SHARED_DATA to the folder that holds davinci/")
    mapping = folder / f"{name}.yaml"
    shutil.copy(ROOT / "params" / "measurements" / "davinci" / mapping.name, mapping)
    file = load_file(mapping)
    if not (data := folder / str(file.content.data)).exists():
        data.symlink_to((DATA / data.name).resolve())
    return read_run(file).run


@pytest.mark.parametrize("name", [path.stem for path in MAPPINGS])
def test_both_drives_of_each_run_are_read_and_vetted(name: str, tmp_path: Path) -> None:
    run = real_run(name, tmp_path)
    # Stroke of 30 degrees each way; 1 kHz for 20 s although the header says ms.
    assert 0.9 < np.ptp(run.output_rad) < 1.1, np.ptp(run.output_rad)
    assert run.time_s.size >= 19_977 and np.median(np.diff(run.time_s)) == pytest.approx(1e-3)
    found = vet(run, None)
    assert not refusals(found), [str(finding) for finding in found]
    assert not [f for f in found if f.kind in ("ratio", "gaps", "saturated")], [str(finding) for finding in found]


def test_friction_of_the_cable_grows_with_the_load_and_not_with_the_speed(tmp_path: Path) -> None:
    """From the torques on both sides of it, by the terms of the loop's friction: as an expert saw by hand."""
    from benchmarks.studies.real_drives import friction_of_cable

    pairs = [(real_run(f"run_{r}_gearbox", tmp_path), real_run(f"run_{r}_cable", tmp_path)) for r in ("00", "05", "20")]
    found, left = friction_of_cable(pairs)
    constant, viscous, share = zip(found.value[1:], found.half_width()[1:], strict=True)
    assert share[0] - share[1] > 0.1 and constant[0] > 3.0 * constant[1] > 0.0, found.value
    assert abs(viscous[0]) < viscous[1] < 0.01, found.value
    assert left < 0.2 * 0.06, f"{left * 1e3:.1f} mN m of 60 mN m"


def test_the_mappings_are_there() -> None:
    assert [path.stem for path in MAPPINGS] == [
        f"run_{r}_{d}" for r in ("00", "05", "20") for d in ("cable", "gearbox")
    ]


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "seen_by_hand_rad", "width_rad"),
    [("run_00_gearbox", 0.031, 0.004), ("run_00_cable", 2 * 0.026, 2 * 0.004)],
)
def test_the_loop_finds_the_lost_motion_seen_by_hand(
    name: str, seen_by_hand_rad: float, width_rad: float, tmp_path: Path
) -> None:
    from mbcdm_cad.loop.search.engine import close_loop

    result = close_loop(None, [real_run(name, tmp_path)])
    said = [named for group in (result.effects, *result.one_of) for named in group]
    play = [named.parameters["play_rad"].value for named in said if named.name == "lash"]
    assert play and abs(play[0] - seen_by_hand_rad) < width_rad, (play, result.sentence)
    # Nobody gave radii, preload or rope: it must not claim that nothing else is there.
    assert result.verdict == "partly_explained", result.sentence
    assert result.errors.after.value < 0.25 * result.errors.before.value, result.sentence


@pytest.mark.slow
def test_three_runs_together_tell_the_lost_motion_of_the_cable(tmp_path: Path) -> None:
    from mbcdm_cad.loop.search.engine import close_loop

    result = close_loop(None, [real_run(f"run_{run}_cable", tmp_path) for run in ("00", "05", "20")])
    # Under their load a play and a friction that winds up what is soft are the same motion.
    assert not result.effects and len(result.one_of) == 1, result.sentence
    found = {named.name: named for named in result.one_of[0]}
    assert set(found) == {"lash", "friction"}, result.sentence
    play = found["lash"].parameters["play_rad"]
    assert abs(play.value - 0.052) < 0.006, (play, result.sentence)
    assert play.low < 0.052 < play.high and result.verdict == "partly_explained", result.sentence
