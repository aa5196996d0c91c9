"""Logs whose channels have time stamps of their own: in one table with empty cells, or one channel a row.

ROS topics in one CSV, PlotJuggler and InfluxDB write the first kind, EPICS archives and CAN loggers the second. Every
quantity is interpolated linearly onto the times of the output, which stays as it was logged. Where a quantity was not
logged for long, the samples there are left out.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from mbcdm_cad.errors import InputError, Problem
from mbcdm_cad.measurement.datafile import DataTable, clock_s
from mbcdm_cad.measurement.logformat import Format, figure_of
from mbcdm_cad.routes import Floats

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
    lines, times, values = _series(path, layout, (time, named_by, clock), channels, time_wraps_at)
    return aligned(path, channels, lines, times, values, layout.begin_line)


def aligned(
    path: Path,
    channels: Sequence[Channel],
    lines: Sequence[NDArray[np.int64]],
    times: Sequence[Floats],
    values: Sequence[Floats],
    begin_line: int,
) -> DataTable:
    """Time and channels as rows of a table, from the lines, times and figures of each channel.

    Raises InputError for a channel without samples, and where they were not logged together.
    """
    for channel, at in zip(channels, times, strict=True):
        if at.size < FEWEST:
            where = f"channel {channel.name!r}" if channel.name else f"column {channel.column + 1}"
            what = f"no samples of {channel.quantity} in {where}"
            raise InputError([Problem(str(path), begin_line, "", what, remedy="check its name and column")])
    order = [np.unique(at, return_index=True)[1] for at in times]
    lines = [row[k] for row, k in zip(lines, order, strict=True)]
    times = [row[k] for row, k in zip(times, order, strict=True)]
    values = [row[k] for row, k in zip(values, order, strict=True)]
    base = next((k for k, c in enumerate(channels) if c.quantity == "output"), int(np.argmax([t.size for t in times])))
    at = times[base]
    kept = (at >= max(float(t[0]) for t in times)) & (at <= min(float(t[-1]) for t in times))
    for own in times:
        steps = np.diff(own)
        after = np.clip(np.searchsorted(own, at), 1, own.size - 1) - 1
        kept &= steps[after] <= LONGEST_GAP_STEPS * float(np.median(steps))
    if not kept.any():
        what = "at no time were all quantities logged"
        raise InputError([Problem(str(path), begin_line, "", what, remedy="check that all are of one run")])
    rows: list[Floats] = [at[kept]]
    for channel, own, found in zip(channels, times, values, strict=True):
        whole = found if channel.wraps_at is None else np.unwrap(found, period=channel.wraps_at)
        rows.append(np.interp(at[kept], own, whole))
    last = int(lines[base].max())
    skipped = np.setdiff1d(np.arange(begin_line, last + 1), lines[base][kept])
    return DataTable(np.stack(rows), 0, (), begin_line, skipped)


def _series(
    path: Path, layout: Format, place: tuple[int, int | None, bool], channels: Sequence[Channel], wraps: float | None
) -> tuple[list[NDArray[np.int64]], list[Floats], list[Floats]]:
    """Lines, times and figures of each channel, as they stand in the file."""
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
    tables = [np.array(rows, dtype=float).reshape(-1, 3) for rows in found]
    return (
        [table[:, 2].astype(np.int64) for table in tables],
        [table[:, 0] for table in tables],
        [table[:, 1] for table in tables],
    )
