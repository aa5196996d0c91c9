"""The logger's file as a table of floats, read in blocks; NumPy's parser reads a block that has only rows of figures.

Memory depends on the columns that are used and not on the file. A block with comments, blank lines or broken rows is
read line by line, so that each message gives its line.

ROS topics in one CSV, PlotJuggler and InfluxDB write the first kind, EPICS archives and CAN loggers the second. Every
quantity is interpolated linearly onto the times of the output, which stays as it was logged. Where a quantity was not
logged for long, the samples there are left out.
"""

import re
import warnings
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from datetime import UTC, datetime, time
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from mbcdm_cad.errors import InputError, shortened
from mbcdm_cad.measurement.logformat import ARROW, ISO_CLOCK, LONGEST_LINE, Format, figure_of, too_long, wrong
from mbcdm_cad.routes import Floats

BLOCK_BYTES = 8 << 20
# Share of rows that may be left out as broken; more than that is another format.
MOST_BROKEN = 0.02
LISTED_LINES = 5
# No sensor measures such a value; instruments write it (9.9e37) for an overload.
OVERLOAD = 1e30
_FIRST_DAY = datetime(2000, 1, 1)
_DATE = re.compile(r"\d{1,4}[-/:.]\d{1,2}[-/:.]\d{1,4}|\d{1,2}:\d\d")
DECIMALS = (
    "decimal commas and commas between columns look alike: export with semicolons or tabs, and set decimal: comma"
)
EMPTY_CELL = shortened("")
# What exports of topics with time stamps of their own look like.
ONE_CHANNEL_A_ROW = (
    "the rows have empty cells, as where each holds one channel with its own time: set rows: own_times, which "
    "interpolates each quantity onto the times of the output"
)
_DECIMAL_COMMA = re.compile(r"[-+]?\d+,\d+([eE][-+]?\d+)?\Z")


@dataclass(frozen=True, eq=False)
class DataTable:
    """``values`` (columns used, n) without broken rows; their number, and the lines of the first of them.

    ``skipped_lines`` are all lines from ``begin_line`` on that are not rows, in order.
    """

    values: Floats
    broken: int
    broken_lines: tuple[int, ...]
    begin_line: int
    skipped_lines: NDArray[np.int64]

    def line_of(self, row: int) -> int:
        """Line in the file of a row."""
        line = self.begin_line + row
        while True:
            moved = self.begin_line + row + int(np.searchsorted(self.skipped_lines, line, side="right"))
            if moved == line:
                return line
            line = moved

    def only(self, kept: NDArray[np.bool_]) -> "DataTable":
        """The table with the rows ``kept`` (n,) alone."""
        lines = np.arange(self.begin_line, self.begin_line + kept.size + self.skipped_lines.size)
        of_rows = np.setdiff1d(lines, self.skipped_lines)[: kept.size]
        skipped = np.union1d(self.skipped_lines, of_rows[~kept])
        return replace(self, values=self.values[:, kept], skipped_lines=skipped)


def clock_s(text: str) -> float:
    """Seconds of a date and time, or of a time of day, as ISO 8601 writes them. Raises ValueError for other text."""
    try:
        moment = datetime.fromisoformat(text.strip())
    except ValueError:
        moment = datetime.combine(_FIRST_DAY, time.fromisoformat(text.strip()))
    return (moment - (_FIRST_DAY if moment.tzinfo is None else _FIRST_DAY.replace(tzinfo=UTC))).total_seconds()


def read_table(
    path: Path,
    layout: Format,
    columns: Sequence[int],
    skip_broken: bool,
    clock: int | None = None,
    most_broken: float = MOST_BROKEN,
) -> DataTable:
    """The columns (from 0) of all rows, ``clock`` being that of dates and times. ``most_broken``: share of the rows.

    Raises InputError for a broken row unless they are to be skipped.
    """
    reader = _Reader(path, layout, columns, skip_broken, clock)
    parts = [reader.block(first_line, text) for first_line, text in _blocks(path, layout.begin_line)]
    kept = sum(part.shape[0] for part in parts)
    remedy = ONE_CHANNEL_A_ROW if reader.empty_cells > 0.5 * reader.broken else ""
    left_out(path, reader.broken, kept + reader.broken, reader.broken_lines, reader.first_fault, remedy, most_broken)
    values = np.empty((len(columns), kept))
    for part in reversed(parts):  # frees the memory of each part once it is copied
        values[:, kept - part.shape[0] : kept] = part.T
        kept -= parts.pop().shape[0]
    return DataTable(
        values, reader.broken, tuple(reader.broken_lines), layout.begin_line, np.array(reader.skipped, dtype=np.int64)
    )


def left_out(
    path: Path, broken: int, of: int, lines: Sequence[int], fault: str, remedy: str = "", most: float = MOST_BROKEN
) -> None:
    """Raise InputError where so many rows are broken that the format is another one; ``most``: share of the rows."""
    if broken > most * of:
        remedy = remedy or f"the first has {fault}; check delimiter, decimal, comment, skip_rows and columns"
        value, limit = f"{broken} of {of}", f"{most:.0%} of the rows"
        raise wrong(path, int(lines[0]), "too many broken rows", remedy, value, limit)


def _blocks(path: Path, begin_line: int) -> Iterator[tuple[int, str]]:
    """Whole lines in blocks of about BLOCK_BYTES from ``begin_line`` on, each with the number of its first line."""
    line, rest = begin_line, b""
    with open(path, "rb") as file:
        for _ in range(begin_line - 1):
            file.readline()
        while read := file.read(BLOCK_BYTES):
            block = rest + read
            end = block.rfind(b"\n") + 1
            block, rest = block[:end], block[end:]
            if len(rest) > LONGEST_LINE:
                raise too_long(path, line + block.count(b"\n"))
            if block:
                yield line, block.decode("latin-1")
                line += block.count(b"\n")
        if rest:
            yield line, rest.decode("latin-1")


class _Reader:
    """Reads the blocks of one file and records the rows that it leaves out."""

    def __init__(
        self, path: Path, layout: Format, columns: Sequence[int], skip_broken: bool, clock: int | None
    ) -> None:
        self.path, self.layout, self.columns, self.skip_broken = path, layout, list(columns), skip_broken
        self.clock = clock
        self.converters: dict[int | str, Callable[[str], float]] | None = None if clock is None else {clock: clock_s}
        self.broken = 0
        self.broken_lines: list[int] = []
        self.first_fault = ""
        self.empty_cells = 0
        self.skipped: list[int] = []

    def block(self, first_line: int, text: str) -> Floats:
        """Rows of one block, shape (rows, columns asked for)."""
        if self.layout.decimal_comma:
            text = text.replace(",", ".")
        lines = text.removesuffix("\n").split("\n")
        rows = self._at_once(text, lines)
        return self._by_line(first_line, lines) if rows is None else rows

    def _at_once(self, text: str, lines: list[str]) -> Floats | None:
        """The whole block by NumPy's parser; None if any line is not a row of finite figures."""
        sign, fields = self.layout.sign, self.layout.fields
        if self.layout.labelled or any(mark in text for mark in (self.layout.comment, *'"_[', ARROW)):
            return None
        widths = {len(line.split()) for line in lines} if sign is None else {line.count(sign) + 1 for line in lines}
        if widths != {fields}:
            return None
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")  # NumPy warns of a block without rows, which is allowed here
                rows = np.loadtxt(
                    lines, delimiter=sign, comments=None, ndmin=2, usecols=self.columns, converters=self.converters
                )
        except ValueError:
            return None
        return rows if rows.shape[0] == len(lines) and bool((np.abs(rows) < OVERLOAD).all()) else None

    def _by_line(self, first_line: int, lines: list[str]) -> Floats:
        rows: list[list[float]] = []
        for number, line in enumerate(lines, first_line):
            if not line.strip() or line.lstrip().startswith(self.layout.comment):
                self.skipped.append(number)
                continue
            try:
                rows.append(self._row(number, line))
            except InputError as error:
                if not self.skip_broken:
                    raise
                self.broken += 1
                self.skipped.append(number)
                first = error.problems[0]
                self.first_fault = self.first_fault or f"{first.what}{f' ({first.value})' if first.value else ''}"
                self.empty_cells += error.problems[0].value == EMPTY_CELL
                if len(self.broken_lines) < LISTED_LINES:
                    self.broken_lines.append(number)
        return np.array(rows, dtype=float).reshape(-1, len(self.columns))

    def _row(self, number: int, line: str) -> list[float]:
        cells = self.layout.cells(line)
        if len(cells) != self.layout.fields:
            remedy = DECIMALS if self.layout.unnamed and self.layout.sign == "," else ""
            found = f"{len(cells)} columns"
            raise self._fault(number, "a row of another length", found, f"{self.layout.fields}", remedy)
        return [self._figure(number, index, cells[index]) for index in self.columns]

    def _figure(self, number: int, index: int, cell: str) -> float:
        names = self.layout.names
        name = shortened(names[index]) if index < len(names) else f"column {index + 1}"
        try:
            if index == self.clock:
                return clock_s(cell)
            value = figure_of(cell) if "_" not in cell else None  # float() accepts 1_000, which no logger writes
        except ValueError:
            value = None
        if value is None:
            remedy = ""
            if index == self.clock:
                remedy = "write dates as 2026-03-01T12:00:00.010, or set the unit of the time to that of its figures"
            elif _DATE.match(cell):
                remedy = (
                    f"set unit: {ISO_CLOCK} for dates such as 2026-03-01T12:00:00.010; "
                    "else export the time as a number, in seconds from the start or any other unit of time"
                )
            elif _DECIMAL_COMMA.match(cell):
                remedy = "set decimal: comma in the measurement file"
            raise self._fault(number, f"no number in {name}", shortened(cell), "", remedy)
        if not np.isfinite(value):
            raise self._fault(number, f"no finite number in {name}", shortened(cell), "")
        if abs(value) >= OVERLOAD:
            raise self._fault(number, f"an overload in {name}", shortened(cell), "")
        return value

    def _fault(self, number: int, what: str, value: str, limit: str, remedy: str = "") -> InputError:
        remedy = remedy or "correct or remove the row, or set broken_rows: skip in the measurement file"
        return wrong(self.path, number, what, remedy, value, limit)


# A quantity that was not logged for so many of its usual steps is not interpolated there.
LONGEST_GAP_STEPS = 10.0
# Samples of a quantity that are needed.
FEWEST = 2


@dataclass(frozen=True)
class Channel:
    """Where one quantity stands: the index of its column, the name of its channel if rows have names, its range if it
    begins again after one."""

    quantity: str
    column: int
    name: str = ""
    wraps_at: float | None = None


def read_channels(
    path: Path,
    layout: Format,
    time: int,
    channels: Sequence[Channel],
    named_by: int | None = None,
    clock: bool = False,
    time_wraps_at: float | None = None,
) -> DataTable:
    """Time and channels as rows of a table, on the times of the channel called output, else of the one with most.

    ``named_by`` is the column with the names of the channels, None for a table with empty cells. ``time_wraps_at``:
    where the time begins again, from row to row of the file whatever their channels. Raises InputError for a channel
    without samples.
    """
    tables = _series(path, layout, (time, named_by, clock), channels, time_wraps_at)
    return aligned(path, channels, tables, layout.begin_line)


def aligned(path: Path, channels: Sequence[Channel], tables: Sequence[Floats], begin_line: int) -> DataTable:
    """Time and channels as rows of a table, from the times, figures and lines (3, m) of each channel.

    Raises InputError for a channel without samples, and where they were not logged together.
    """
    for channel, table in zip(channels, tables, strict=True):
        if table.shape[1] < FEWEST:
            where = f"channel {channel.name!r}" if channel.name else f"column {channel.column + 1}"
            what = f"no samples of {channel.quantity} in {where}"
            raise wrong(path, begin_line, what, "check its name and column")
    tables = [table[:, np.unique(table[0], return_index=True)[1]] for table in tables]
    times = [table[0] for table in tables]
    base = next((k for k, c in enumerate(channels) if c.quantity == "output"), int(np.argmax([t.size for t in times])))
    at = times[base]
    kept = (at >= max(float(t[0]) for t in times)) & (at <= min(float(t[-1]) for t in times))
    for own in times:
        steps = np.diff(own)
        after = np.clip(np.searchsorted(own, at), 1, own.size - 1) - 1
        kept &= steps[after] <= LONGEST_GAP_STEPS * float(np.median(steps))
    if not kept.any():
        what = "at no time were all quantities logged"
        raise wrong(path, begin_line, what, "check that all are of one run")
    rows: list[Floats] = [at[kept]]
    for channel, (own, found, _) in zip(channels, tables, strict=True):
        whole = found if channel.wraps_at is None else np.unwrap(found, period=channel.wraps_at)
        rows.append(np.interp(at[kept], own, whole))
    lines = tables[base][2].astype(np.int64)
    skipped = np.setdiff1d(np.arange(begin_line, lines.max() + 1), lines[kept])
    return DataTable(np.stack(rows), 0, (), begin_line, skipped)


def _series(
    path: Path, layout: Format, place: tuple[int, int | None, bool], channels: Sequence[Channel], wraps: float | None
) -> list[Floats]:
    """Times, figures and lines (3, m) of each channel, as they stand in the file."""
    time, named_by, clock = place
    found: list[list[tuple[float, float, int]]] = [[] for _ in channels]
    begun, last = 0.0, -np.inf
    with open(path, encoding="utf-8", errors="replace") as file:
        for number, line in enumerate(file, 1):
            if number < layout.begin_line or not line.strip() or line.lstrip().startswith(layout.comment):
                continue
            cells = layout.cells(line)
            if layout.decimal_comma:
                cells = [cell.replace(",", ".") for cell in cells]
            try:
                at = clock_s(cells[time]) if clock else float(cells[time])
            except (ValueError, IndexError):
                continue
            if wraps is not None:
                begun += wraps if at + begun < last - 0.5 * wraps else 0.0
                last = at = at + begun
            for k, channel in enumerate(channels):
                if named_by is not None and (named_by >= len(cells) or cells[named_by] != channel.name):
                    continue
                cell = cells[channel.column] if channel.column < len(cells) else ""
                try:
                    value = figure_of(cell)
                except ValueError:
                    continue
                if np.isfinite(value):
                    found[k].append((at, value, number))
    return [np.array(rows, dtype=float).reshape(-1, 3).T for rows in found]
