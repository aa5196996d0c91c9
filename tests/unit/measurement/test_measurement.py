"""Reading of measurement files: units, signs, formats of loggers; refusals with file, line and remedy."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from mbcdm_cad.errors import InputError
from mbcdm_cad.measurement import datafile
from mbcdm_cad.measurement.file import load_file
from mbcdm_cad.measurement.reading import load_measurement, read_run
from mbcdm_cad.measurement.run import smoothed, smoothed_at
from mbcdm_cad.rig.experiment import read_experiment
from tests.unit.measurement.sound_runs import RATIO, Write, mapping, signals, table


def with_column(name: str, **fields: Any) -> dict[str, Any]:
    """The usual content with one column changed."""
    content = mapping()
    content["columns"][name] = content["columns"].get(name, {}) | fields
    return content


def refused(path: Path) -> str:
    """What the refusal says, checked to have a file, a line and a remedy."""
    with pytest.raises(InputError) as caught:
        load_measurement(path)
    for problem in caught.value.problems:
        assert problem.file and problem.line >= 1 and problem.what and problem.remedy, problem
    return str(caught.value)


def test_plain_run(write: Write) -> None:
    run = load_measurement(write(table(signals())))
    assert run.input_rad.shape == (2, 400) and run.input_names == ("left", "right"), run.input_rad.shape
    for values, name in ((run.time_s, "t"), (run.output_rad, "drum"), (run.load_Nm, "tau")):
        np.testing.assert_allclose(values, signals()[name], rtol=1e-8, atol=1e-9)
    assert len(run.sha256) == 64 and run.source == "run.csv"


@pytest.mark.parametrize(
    ("column", "name", "unit", "per_si"),
    [
        ("time", "t", "ms", 1e3),
        ("time", "t", "us", 1e6),
        ("time", "t", "min", 1 / 60),
        ("output", "drum", "mrad", 1e3),
        ("output", "drum", "urad", 1e6),
        ("output", "drum", "deg", 57.29577951308232),
        ("output", "drum", "arcmin", 3437.746770784939),
        ("output", "drum", "rev", 0.15915494309189535),
        ("load_torque", "tau", "mN*m", 1e3),
        ("load_torque", "tau", "N*mm", 1e3),
        ("load_torque", "tau", "kgf*cm", 10.197162129779283),
        ("load_torque", "tau", "ozf*in", 141.61193227806),
        ("load_torque", "tau", "lbf*ft", 0.7375621492773),
    ],
)
def test_units(write: Write, column: str, name: str, unit: str, per_si: float) -> None:
    data = signals()
    run = load_measurement(
        write(table(data | {name: data[name] * per_si}, digits="%.15g"), with_column(column, unit=unit))
    )
    read = {"time": run.time_s, "output": run.output_rad, "load_torque": run.load_Nm}[column]
    np.testing.assert_allclose(read, data[name], rtol=1e-8, atol=1e-12)


@pytest.mark.parametrize(("unit", "figure"), [("degC", 25.0), ("K", 298.15), ("degF", 77.0)])
def test_temperature(write: Write, unit: str, figure: float) -> None:
    data = signals() | {"temp": np.full(400, figure)}
    run = load_measurement(write(table(data), with_column("temperature", column="temp", unit=unit)))
    assert run.temperature_C is not None
    np.testing.assert_allclose(run.temperature_C, 25.0, atol=1e-9)


def test_counts_zero_and_sign(write: Write) -> None:
    data = signals()
    counts = np.round(-data["drum"] / (2 * np.pi) * 8192) + 100
    content = with_column("output", unit="counts", counts_per_turn=8192, scale=-1, zero=100)
    run = load_measurement(write(table(data | {"drum": counts}), content))
    step = 2 * np.pi / 8192
    assert np.abs(run.output_rad - data["drum"]).max() <= 0.5001 * step
    assert run.sensors.output_resolution_rad == pytest.approx(step)


@pytest.mark.parametrize(
    ("sign", "word"),
    [(",", "comma"), (";", "semicolon"), ("\t", "tab"), ("  ", "space"), (";", "auto"), ("\t", "auto")],
)
def test_delimiters(write: Write, sign: str, word: str) -> None:
    run = load_measurement(write(table(signals(), sign), mapping(delimiter=word)))
    np.testing.assert_allclose(run.output_rad, signals()["drum"], atol=1e-8)


def test_decimal_comma_and_line_ends(write: Write) -> None:
    text = table(signals(), ";").replace(".", ",").replace("\n", "\r\n")
    run = load_measurement(write(text, mapping(decimal="comma")))
    np.testing.assert_allclose(run.output_rad, signals()["drum"], atol=1e-8)


def test_byte_order_mark_quotes_and_latin_letters(write: Write) -> None:
    text = table(signals() | {"Temp °C": np.zeros(400)}).replace("left", '"left"', 1)
    for data in (b"\xef\xbb\xbf" + text.encode(), text.encode("latin-1")):
        run = load_measurement(write(data, with_column("temperature", column="Temp °C", unit="degC")))
        assert run.temperature_C is not None and run.time_s.size == 400


def test_header_in_a_comment_and_rows_to_skip(write: Write) -> None:
    text = "Bench 7\n\n% operator: none\n% " + table(signals())
    run = load_measurement(write(text, mapping(comment="%", skip_rows=1)))
    np.testing.assert_allclose(run.output_rad, signals()["drum"], atol=1e-8)


def test_columns_by_number_where_there_is_no_header(write: Write) -> None:
    text = table(signals()).split("\n", 1)[1]
    content = mapping()
    for number, column in enumerate(content["columns"].values(), 1):
        column["column"] = number
    run = load_measurement(write(text, content))
    assert run.time_s.size == 400
    assert "no header" in refused(write(text))


BROKEN = {
    "short": ("0.2,1.8", "another length"),
    "long": ("0.2,1,1,0.1,0.9,7,7", "another length"),
    "text": ("0.2,1,ERR,0.1,0.9", "no number in 'right'"),
    "nan": ("0.2,1,1,nan,0.9", "no finite number in 'drum'"),
    "empty": ("0.2,1,,0.1,0.9", "no number in 'right'"),
    "grouped": ("0.2,1_0,1,0.1,0.9", "no number in 'left'"),
    "zero byte": ("0.2,1,\x00,0.1,0.9", "no number in 'right'"),
}


@pytest.mark.parametrize("kind", BROKEN)
def test_broken_rows_are_refused_or_skipped(write: Write, kind: str) -> None:
    row, what = BROKEN[kind]
    lines = table(signals()).split("\n")
    lines[20] = row
    text = refused(write("\n".join(lines)))
    assert what in text and "run.csv:21:" in text and "broken_rows: skip" in text, text
    reading = read_run(load_file(write("\n".join(lines), mapping(broken_rows="skip"))))
    assert reading.run.time_s.size == 399 and reading.notes == ("1 broken rows of run.csv left out (lines 21)",)


def test_too_many_broken_rows(write: Write) -> None:
    lines = table(signals()).split("\n")
    lines[20:40] = ["7"] * 20
    text = refused(write("\n".join(lines), mapping(broken_rows="skip")))
    assert "too many broken rows (value 20 of 400" in text, text


def test_lines_are_right_across_blocks_and_comments(write: Write, monkeypatch: pytest.MonkeyPatch) -> None:
    lines = table(signals()).split("\n")
    lines[100:100] = ["# paused", ""]
    lines[300] = lines[299]
    for size in (64, 1000, 1 << 20):
        monkeypatch.setattr(datafile, "BLOCK_BYTES", size)
        text = refused(write("\n".join(lines)))
        assert "run.csv:301: time stands still" in text, (size, text)


def test_blocks_change_nothing(write: Write, monkeypatch: pytest.MonkeyPatch) -> None:
    path = write(table(signals()).rstrip("\n"))
    whole = load_measurement(path)
    monkeypatch.setattr(datafile, "BLOCK_BYTES", 100)
    parts = load_measurement(path)
    assert np.array_equal(whole.input_rad, parts.input_rad) and np.array_equal(whole.time_s, parts.time_s)


def test_refusals_of_the_mapping(write: Write) -> None:
    """Beside the mistakes that test_vet.py makes on the command line."""
    text = table(signals())
    assert "1 to 5" in refused(write(text, with_column("output", column=9)))
    assert "no such file" in refused(write(text, mapping(data="other.csv")))
    assert "not a regular file" in refused(write(text, mapping(data=".")))
    assert "did you mean columns?" in refused(write(text, mapping(colums={})))
    assert "nothing is left" in refused(write(text, with_column("output", scale=0)))
    assert "beside published" in refused(
        write(text, mapping(published=[{"quantity": "mass", "value": 342, "unit": "g", "where": "Table 1"}]))
    )
    content = mapping()
    content["columns"]["input"] = {"column": "left", "unit": "rad"}
    assert "given beside input_left" in refused(write(text, content))


FOREIGN = {
    "nothing": ("", "is empty"),
    "two documents": ("data: x\n---\ndata: y\n", "one document in a file"),
    "a tag": ("data: !!float 3\n", "tags are not part of"),
    "a merge key": ("<<: {data: x}\n", "merge keys are not part of"),
    "no YAML": ("data: [1\n", "is not valid YAML"),
    "too much": ("data: [" + "1," * 6000 + "1]\n", "need some hundred at most"),
    "far too much": ("a" * 2_000_000, "about 10 kB at most"),
    "the CSV itself": (table(signals()), "no measurement file: it has no fields"),
}


@pytest.mark.parametrize("which", FOREIGN)
def test_what_is_no_measurement_file_is_called_by_its_kind(which: str, tmp_path: Path) -> None:
    text, words = FOREIGN[which]
    path = tmp_path / "run.yaml"
    path.write_text(text)
    said = refused(path)
    assert words in said and "design" not in said and "mbcdm init" not in said, said
    experiment = ""
    try:
        read_experiment(path)
    except InputError as error:
        experiment = str(error).replace(str(path), "")
    assert experiment and not any(word in experiment for word in ("design", "mbcdm init", "measurement")), experiment


def test_refusals_of_the_data(write: Write) -> None:
    """Beside the mistakes that test_vet.py makes on the command line."""
    data = signals()
    assert "no motion of the input right" in refused(write(table(data | {"right": np.full(400, 0.3)})))
    assert "no rows below" in refused(write("t,left,right,drum,tau\n"))
    assert "a line too long" in refused(write("1" * 100_000))


def test_a_load_cell_on_an_arm_is_a_torque(write: Write) -> None:
    data = signals()
    text = table(data | {"tau": data["tau"] / 0.12})
    run = load_measurement(write(text, with_column("load_torque", unit="N", lever_arm_mm=120.0)))
    np.testing.assert_allclose(run.load_Nm, data["tau"], rtol=1e-8)
    assert "a force without its arm" in refused(write(text, with_column("load_torque", unit="N")))
    assert "given beside unit N*m" in refused(write(text, with_column("load_torque", lever_arm_mm=120.0)))


def test_encoders_on_the_motors_are_said_so(write: Write) -> None:
    run = load_measurement(write(table(signals()), with_column("input_left", side="motor")))
    assert run.motor_side == (True, False), run.motor_side
    assert "given for output" in refused(write(table(signals()), with_column("output", side="motor")))
    content = with_column("input_left", side="motor") | {"ratio": RATIO}
    assert "given beside ratio" in refused(write(table(signals()), content))


def renamed(first: str, second: str) -> dict[str, Any]:
    """The usual content with other names for the two inputs."""
    columns = mapping()["columns"]
    columns[f"input_{first}"], columns[f"input_{second}"] = columns.pop("input_left"), columns.pop("input_right")
    return mapping(columns=columns)


def test_inputs_are_called_as_the_design_calls_them(write: Write) -> None:
    run = load_measurement(write(table(signals()), renamed("port", "star")))
    assert run.input_names == ("port", "star"), run.input_names
    np.testing.assert_allclose(run.input_rad[1], signals()["right"], atol=1e-9)
    said = refused(
        write(
            table(signals()),
            renamed("port", "star")
            | {
                "data": "run.csv",
                "columns": {**renamed("port", "star")["columns"], "torque": {"column": "tau", "unit": "N*m"}},
            },
        )
    )
    assert "columns.torque: unknown field; did you mean load_torque?" in said, said
    wrong = renamed("port", "star")
    wrong["columns"]["input_star"]["unit"] = "furlong"
    assert "columns.input_star.unit: no unit" in refused(write(table(signals()), wrong))


def test_one_input_and_a_ratio(write: Write) -> None:
    columns = mapping()["columns"]
    columns["input"] = columns.pop("input_left")
    del columns["input_right"]
    run = load_measurement(write(table(signals()), mapping(columns=columns, ratio=RATIO)))
    assert run.input_rad.shape == (1, 400) and run.input_names == ("input",) and run.ratio == RATIO


def test_an_angle_that_begins_again_is_counted_on(write: Write) -> None:
    columns = signals()
    true = columns["left"].copy()
    columns["left"] = np.mod(np.degrees(true) + 350.0, 360.0)
    reading = read_run(load_file(write(table(columns), with_column("input_left", unit="deg", wraps_at=360))))
    np.testing.assert_allclose(reading.run.input_rad[0] - reading.run.input_rad[0, 0], true - true[0], atol=1e-7)
    assert any("whole turns are counted" in note for note in reading.turns), reading.turns


def test_turns_that_cannot_be_counted_are_refused(write: Write) -> None:
    """A range of twice the motion within a sample leaves no sense; a load has no turns."""
    fastest = float(np.abs(np.diff(signals()["left"])).max())
    text = refused(write(table(signals()), with_column("input_left", wraps_at=2.1 * fastest)))
    assert "its sense cannot be told" in text and "wraps_at" in text, text
    text = refused(write(table(signals()), with_column("load_torque", wraps_at=360)))
    assert "only an angle or a time begins again" in text, text


@pytest.mark.parametrize(
    "text", ["2026-03-01 09:{:02d}:{:02d}.{:06d}", "09:{:02d}:{:02d}.{:06d}", "20260301T09{:02d}{:02d}.{:06d}Z"]
)
@pytest.mark.parametrize("broken_rows", ["refuse", "skip"])
def test_dates_and_times_of_day(write: Write, text: str, broken_rows: str) -> None:
    columns = signals()
    us = [round(1e6 * t) for t in columns["t"]]
    lines = table(columns).splitlines()
    clocks = [text.format(t // 60_000_000, t // 1_000_000 % 60, t % 1_000_000) for t in us]
    rows = [lines[0], *(f"{clock},{line.split(',', 1)[1]}" for clock, line in zip(clocks, lines[1:], strict=True))]
    if broken_rows == "skip":  # which is then read line by line
        rows.insert(200, "2026-03-01 10:00")
    content = with_column("time", unit="iso8601") | {"broken_rows": broken_rows}
    run = load_measurement(write("\n".join(rows) + "\n", content))
    np.testing.assert_allclose(run.time_s - run.time_s[0], columns["t"] - columns["t"][0], atol=1e-6)


def test_what_is_no_date_is_refused_with_its_line(write: Write) -> None:
    text = refused(write(table(signals()), with_column("time", unit="iso8601")))
    assert "write dates as 2026-03-01T12:00:00.010" in text and "run.csv:2" in text, text


# Smoothing of a moving signal whose samples are not evenly spaced.


def test_jitter_and_gaps_of_the_logger_do_not_move_the_mean() -> None:
    rng = np.random.default_rng(5)
    step = 0.02
    times = (np.arange(2000) + 0.2 * rng.uniform(-0.5, 0.5, 2000)) * step
    times = times[(times < 12.0) | (times > 12.3)]
    angle = 0.5 * np.sin(0.8 * times)
    before = np.abs(smoothed(angle, 0.05, step) - angle).max()
    after = np.abs(smoothed_at(angle, times, 0.05, step) - angle)
    # A window of 0.05 s blurs a sine of this speed by 0.5 0.8^2 s^2 / 2 with s^2 = 5.3e-4 s^2 for two means of three.
    blur = 0.5 * 0.8**2 * 5.3e-4 / 2.0
    assert before > 5e-4 and np.quantile(after, 0.99) < 2.0 * blur and after.max() < 0.2 * before, (before, after.max())
