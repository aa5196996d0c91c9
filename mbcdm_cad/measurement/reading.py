"""Read the data of a measurement file: convert to SI units, correct signs, refuse runs that cannot be used."""

import hashlib
import math
import re
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from mbcdm_cad.design.yamltree import FieldPath
from mbcdm_cad.errors import did_you_mean, shortened
from mbcdm_cad.measurement.binarylog import is_bag, opened
from mbcdm_cad.measurement.datafile import DECIMALS, Channel, DataTable, read_channels, read_table
from mbcdm_cad.measurement.file import MeasurementFile, load_file
from mbcdm_cad.measurement.kinds import KINDS, Rows, kind_of
from mbcdm_cad.measurement.loads import pendulum_load_Nm
from mbcdm_cad.measurement.logformat import DECIBEL, ISO_CLOCK, Format, Unit, find_format, line_with, unit_of
from mbcdm_cad.measurement.run import KNOWN_LOAD, ResponseTable, Run, Sensors, TorqueClass
from mbcdm_cad.measurement.schema import CURRENT, NO_PLATE, Column, MotorBlock, ResponseBlock, SensorFigures
from mbcdm_cad.routes import Floats

# A step of more than this share of the range may be one back as well as one forward, with some room for noise.
FULL_SENSE = 0.4


@dataclass(frozen=True, eq=False)
class Reading:
    """A run with ``notes``, sentences about its reading that are reasons for doubt, and ``turns``, how often its angles
    begin again, which is none."""

    run: Run
    notes: tuple[str, ...]
    turns: tuple[str, ...] = ()


def load_measurement(path: str | Path) -> Run:
    """The run of a measurement file. Raises InputError with file, line and remedy."""
    return read_run(load_file(path)).run


def read_run(file: MeasurementFile) -> Reading:
    """The data of a measurement file as a run. Raises InputError, also where the file holds published figures."""
    content = file.content
    if content.data is None or content.columns is None:
        raise file.refusal(("published",), "no run in this file", remedy="give a file with data")
    data = _data_path(file, content.data)
    try:
        log = opened(data)
        layout = (
            find_format(data, content.delimiter, content.decimal, content.comment, content.skip_rows, content.header)
            if log is None
            else log.layout
        )
        asked = file.asked
        indices = [
            column_index(file, ("columns", quantity, "column"), column.column, layout, data)
            for quantity, column in asked.items()
        ]
        time = content.columns.time
        clock = indices[0] if time is not None and time.unit.strip() == ISO_CLOCK else None
        if log is not None:
            table = log.table(indices, _channels(file, indices), content.broken_rows == "skip")
        elif content.rows == "own_times" or content.channel_column is not None:
            table = _of_channels(file, layout, data, indices, clock is not None)
        else:
            kind = KINDS[content.kind]
            skip = kind.by_hand or content.broken_rows == "skip"
            table = read_table(data, layout, indices, skip, clock, kind.most_broken)
        repeated = 0
        if content.broken_rows == "skip":
            # A logger that is faster than its device writes each sample several times.
            new = np.append(True, np.diff(table.values[0]) != 0.0)
            repeated = int(np.count_nonzero(~new))
            table = table.only(new) if repeated else table
        sha256 = _sha256(data)
    except OSError as error:
        what = f"cannot be read: {error.strerror or error}"
        raise file.refusal(("data",), what, shortened(content.data), remedy="check the path") from None
    if content.columns.time is None:
        asked = {"time": Column(column="row", unit="s"), **asked}
        at = np.arange(table.values.shape[1]) / (content.sample_rate_Hz or 1.0)
        table = replace(table, values=np.vstack([at, table.values]))
    turns = [
        _count_turns(file, quantity, column, row)
        for (quantity, column), row in zip(asked.items(), table.values, strict=True)
    ]
    run = _in_si(file, asked, table, data.name, sha256)
    kind_of(run).refuse_unusable(Rows(file, run, table, data))
    notes = _notes_on_columns(file.asked, layout, indices, data)
    if repeated:
        notes.append(f"{repeated} rows of {data.name} repeat the time of the row before: left out")
    if table.broken:
        lines = ", ".join(str(line) for line in table.broken_lines)
        more = ", ..." if table.broken > len(table.broken_lines) else ""
        notes.append(f"{table.broken} broken rows of {data.name} left out (lines {lines}{more})")
    return Reading(run, tuple(notes), tuple(note for note in turns if note))


def _of_channels(file: MeasurementFile, layout: Format, data: Path, indices: list[int], clock: bool) -> DataTable:
    """The table of a log whose channels have their own times."""
    named_by = None
    if file.content.channel_column is not None:
        named_by = column_index(file, ("channel_column",), file.content.channel_column, layout, data)
        for quantity, column in file.asked.items():
            if column.channel is None and quantity != "time":
                where: FieldPath = ("columns", quantity)
                remedy = "give channel: the name of its rows in channel_column"
                raise file.refusal(where, "no channel, where rows hold one each", remedy=remedy)
    time = file.asked["time"]
    return read_channels(data, layout, indices[0], _channels(file, indices), named_by, clock, time.wraps_at)


def _channels(file: MeasurementFile, indices: Sequence[int]) -> list[Channel]:
    """The quantities but the time, each with the column that it is read from."""
    return [
        Channel(quantity, index, column.channel or "", column.wraps_at)
        for (quantity, column), index in zip(file.asked.items(), indices, strict=True)
        if quantity != "time"
    ]


def _notes_on_columns(asked: dict[str, Column], layout: Format, indices: list[int], data: Path) -> list[str]:
    """Notes where the layout of the data is doubtful."""
    notes = []
    inputs = [(index, asked[name].channel) for name, index in zip(asked, indices, strict=True) if "input" in name]
    if len(set(inputs)) < len(inputs):
        notes.append("both inputs use the same column: differences between them are not measured")
    if layout.units_line:
        first, last = layout.header_line + 1, layout.units_line
        lines = f"line {last}" if first >= last else f"lines {first} to {last}"
        notes.append(f"no figures on {lines} of {data.name}: taken for units and left out")
    for (quantity, column), index in zip(asked.items(), indices, strict=True):
        told = layout.told(index)[1]
        logged = unit_of(quantity, told)
        # A scale may convert one unit into the other.
        differ = logged is not None and logged != _unit(quantity, column)
        if differ and abs(column.scale) == 1.0:
            notes.append(
                f"{data.name} has {quantity} in {told} by its own header, but {column.unit} in the measurement file; "
                "check which is correct"
            )
    return notes


def _data_path(file: MeasurementFile, data: str) -> Path:
    path = file.path.parent / data
    try:
        if path.is_file() or is_bag(path):
            return path
        what = "not a regular file" if path.exists() else "there is no such file"
    except (OSError, ValueError) as error:
        what = f"cannot be read: {error}"
    remedy = "give the path of the logger's file, relative to this one"
    raise file.refusal(("data",), what, shortened(data), remedy=remedy)


def column_index(file: MeasurementFile, where: FieldPath, asked: str | int, layout: Format, data: Path) -> int:
    """Index in the data, from 0, of the column that the field ``where`` names or numbers."""
    if isinstance(asked, int):
        if asked <= layout.fields:
            return asked - 1
        what, limit = f"not a column of {data.name}", f"1 to {layout.fields}"
        raise file.refusal(where, what, str(asked), limit, remedy="count from 1")
    found = [index for index, name in enumerate(layout.names[: layout.fields]) if name == asked.strip()]
    if len(found) == 1 and not layout.unnamed:
        return found[0]
    line = f"line {layout.header_line} of {data.name}" if layout.header_line else data.name
    if not layout.names:
        what, remedy = f"{data.name} has no header with names", "give its number, counted from 1"
    elif len(found) > 1:
        what, remedy = f"{len(found)} columns of that name on {line}", "give its number, counted from 1"
    elif found:
        what = f"{layout.fields} cells a row under the {len(layout.names)} names on {line}"
        remedy = DECIMALS if layout.sign == "," else "give its number, counted from 1"
    else:
        what = f"no such column {'on' if layout.header_line else 'in'} {line}"
        elsewhere = line_with(data, asked.strip()) if layout.header_line else 0
        known = [name for name in layout.names if name.isprintable()]
        longer = [name for name in known if re.match(re.escape(asked.strip()) + r"\W", name, re.IGNORECASE)]
        if longer and len(known) > 1:
            remedy = f"did you mean {shortened(longer[0])}?"
        elif elsewhere == layout.header_line and len(known) == 1:
            remedy = "the names there cannot be separated: check delimiter"
        elif elsewhere > layout.header_line:
            remedy = f"the name is on line {elsewhere}: set skip_rows: {elsewhere - 1}"
        else:
            remedy = shortened(did_you_mean(asked, known), 300).strip("'\"")
    raise file.refusal(where, what, shortened(asked), remedy=remedy)


def _count_turns(file: MeasurementFile, quantity: str, column: Column, row: Floats) -> str:
    """Count the whole turns of an angle that begins again at ``wraps_at``, in place; the note for it.

    Raises InputError where a step between two samples is so large that its sense cannot be told.
    """
    if column.wraps_at is None:
        return ""
    before = row.copy()
    row[:] = np.unwrap(before, period=column.wraps_at)
    steps = np.abs(np.diff(row))
    if steps.size and float(np.quantile(steps, 0.999)) > FULL_SENSE * column.wraps_at:
        what = f"{quantity} moves by up to {steps.max():.6g} from sample to sample: its sense cannot be told"
        limit = f"{FULL_SENSE * column.wraps_at:g}, {FULL_SENSE:g} of wraps_at"
        remedy = "check wraps_at, log more samples a second, or move slower"
        field: FieldPath = ("columns", quantity, "wraps_at")
        raise file.refusal(field, what, f"{column.wraps_at:g}", limit, remedy=remedy)
    passes = int(np.count_nonzero(np.abs(np.diff(row) - np.diff(before)) > 0.5 * column.wraps_at))
    if not passes and quantity == "time":  # counted where the rows were read
        return ""
    counted = "whole ranges" if quantity == "time" else "whole turns"
    return f"{quantity} begins again {passes} time(s), after every {column.wraps_at:g}: {counted} are counted"


def _in_si(file: MeasurementFile, asked: dict[str, Column], table: DataTable, source: str, sha256: str) -> Run:
    """The table's rows converted to SI in place, so that a long run is in memory only once."""
    rows: dict[str, Floats] = {}
    for (quantity, column), row in zip(asked.items(), table.values, strict=True):
        unit = _unit(quantity, column) or Unit(1.0)
        row -= column.zero
        row *= column.scale * unit.factor
        row += unit.shift
        rows[quantity] = row
    names = tuple(name.removeprefix("input_") for name in rows if name.startswith("input"))
    inputs = table.values[1 : 1 + len(names)]
    if "frequency" in rows:
        inputs = np.zeros((0, rows["time"].size))
    if not names and file.content.ratio is not None:
        names, inputs = ("input",), np.zeros((1, rows["time"].size))
    drawn = [name.replace("input", CURRENT) for name in rows if name.startswith("input")]
    motor = file.content.motor if any(name.startswith(CURRENT) for name in rows) else None
    given, known, load_Nm = file.content.sensors, file.content.load, rows.get("load_torque")
    if known is not None:
        zero = np.zeros_like(rows["output"])
        load_Nm = zero if known == "none" else pendulum_load_Nm(known.pendulum, rows["output"], rows["time"])
    sensors = Sensors(
        given.input_resolution_rad or _step_of_counts(asked, [name for name in asked if name.startswith("input")]),
        given.output_resolution_rad or _step_of_counts(asked, [name for name in asked if name == "output"]),
        given.torque_noise_Nm,
        given.input_noise_rad,
        given.output_noise_rad,
        _torque_class(given, known is not None, motor if "load_torque" not in rows else None),
    )
    return Run(
        rows["time"],
        inputs,
        rows.get("output", np.zeros_like(rows["time"])),
        load_Nm,
        rows.get("temperature"),
        sensors,
        names,
        source,
        sha256,
        file.content.ratio,
        tuple(asked[name].side == "motor" for name in asked if name.startswith("input")),
        counted=file.content.parts,
        current_A=None if motor is None else np.stack([rows[name] for name in drawn]),
        motor=motor,
        kind=file.content.kind,
        excitation=rows.get("excitation"),
        plate=file.content.inertia_plate or NO_PLATE,
        table=_response_table(file, asked, rows) if "frequency" in rows else None,
    )


def _response_table(file: MeasurementFile, asked: dict[str, Column], rows: dict[str, Floats]) -> ResponseTable:
    """An analyser's table, by rising frequency."""
    block = file.content.response or ResponseBlock.model_construct()
    gain = rows["gain"]
    if asked["gain"].unit.strip() == DECIBEL:
        gain = 10.0 ** (np.clip(gain, -1e3, 1e3) / 20.0)
    order = np.unique(rows["frequency"], return_index=True)[1]
    value = (np.maximum(gain, 0.0) * np.exp(1j * rows["phase"]))[order]
    stated = block.amplitude_Nm if block.over == "torque" else block.amplitude_rad
    amplitude = rows.get("amplitude", None if stated is None else np.full(gain.size, stated))
    coherence, amplitude = (None if row is None else row[order] for row in (rows.get("coherence"), amplitude))
    return ResponseTable(rows["frequency"][order], value, block.over, block.turns, coherence, amplitude)


def _unit(quantity: str, column: Column) -> Unit | None:
    """The unit of a column, with what its unit needs beside it."""
    return unit_of(quantity, column.unit, column.counts_per_turn, column.lever_arm_mm, column.radius_mm)


def _torque_class(given: SensorFigures, known: bool, motor: MotorBlock | None) -> TorqueClass:
    """The class of the torque sensor, of a known load or else of the motors' currents, with usual figures in place of
    those that are not stated."""
    usual = TorqueClass(lag_s=0.0, what=KNOWN_LOAD) if known else TorqueClass()
    if motor is not None and not known:
        usual = TorqueClass.of_motors(motor.torque_constant_share)
    share, lag = given.torque_class_share, given.torque_lag_s
    if share is not None:
        usual = replace(usual, share=share, zero_share=None, gain_sigma=None, stated=True)
    return usual if lag is None else replace(usual, lag_s=lag, stated=True)


def _step_of_counts(asked: dict[str, Column], names: list[str]) -> float | None:
    """One count of an encoder in rad, the coarsest of several; None where the column is not in counts."""
    steps = [
        2.0 * math.pi / column.counts_per_turn * abs(column.scale)
        for column in (asked[name] for name in names)
        if column.counts_per_turn is not None
    ]
    return max(steps, default=None)


def _sha256(path: Path) -> str:
    """Hash of the file, or of those of a bag's folder in the order of their names."""
    files = sorted(one for one in path.iterdir() if one.is_file()) if path.is_dir() else [path]
    hashes = []
    for one in files:
        with open(one, "rb") as file:
            hashes.append(hashlib.file_digest(file, "sha256"))
    if not path.is_dir():
        return hashes[0].hexdigest()
    return hashlib.sha256(b"".join(found.digest() for found in hashes)).hexdigest()
