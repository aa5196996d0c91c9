"""A recorded cycle of the duty: a CSV of time, angle and load whose header names the units.

time_s,angle_deg,torque_Nm
0.0,0.0,1.2
"""

import csv
import io
import re
from dataclasses import dataclass, replace
from itertools import pairwise
from math import degrees, isfinite
from pathlib import Path
from typing import Any

from mbcdm_cad.design.blocks import DutyBlock, Loads
from mbcdm_cad.design.yamltree import read_text
from mbcdm_cad.errors import InputError, Problem, shortened

# Units of each column, as factors to s, deg and N m.
UNITS = {
    "time": {"s": 1.0, "ms": 1e-3, "min": 60.0, "h": 3600.0},
    "angle": {"deg": 1.0, "rad": degrees(1.0), "mrad": degrees(1e-3)},
    "torque": {"Nm": 1.0, "mNm": 1e-3, "kNm": 1e3},
}
_HEAD = "time_s,angle_deg,torque_Nm"
_MOST_LISTED = 5
# Rows that stand in for a record where parts are chosen; the checks use the record itself.
_SIZING_ROWS = 48


@dataclass(frozen=True)
class DutySamples:
    """A recorded cycle: times that grow, angles of the output, loads on the drum; ``name``: of its file."""

    name: str
    time_s: tuple[float, ...]
    angle_deg: tuple[float, ...]
    torque_Nm: tuple[float, ...]


@dataclass(frozen=True, kw_only=True)
class RecordedDuty(DutyBlock):
    """A duty whose record was read."""

    samples: DutySamples


def with_record(loads: Loads, path: Path, travel_deg: float) -> Loads:
    """The loads with the record that their duty names, read beside the design file ``path``.

    Raises ``InputError`` with the lines of the record that do not do: loads above the peak torque, angles further apart
    than the travel, times that do not grow, what is no number.
    """
    duty = loads.duty
    if duty is None or duty.record is None:
        return loads
    file = path.parent / duty.record
    table, lines = _table(file)
    problems = _beyond(str(file), table, lines, loads.peak_torque_Nm, travel_deg)
    if problems:
        raise InputError(problems[:_MOST_LISTED])
    samples = DutySamples(duty.record, *(tuple(column) for column in zip(*table, strict=True)))
    return replace(loads, duty=RecordedDuty(**{**vars(duty), "samples": samples}))


def rows_of(name: str, path: Path) -> tuple[list[dict[str, float]], float]:
    """Rows of the same heat as the record, in its order, and its period, s: what sizing rules read in its place."""
    table, _ = _table(path.parent / name)
    first, period = table[0][0], table[-1][0] - table[0][0]
    parts: dict[int, list[tuple[float, float, float]]] = {}
    for (begin, start, before), (end, stop, after) in pairwise(table):
        part = min(int((end - first) / period * _SIZING_ROWS), _SIZING_ROWS - 1)
        heat = (before * before + before * after + after * after) / 3.0
        parts.setdefault(part, []).append((end - begin, abs(stop - start), heat))
    rows = []
    for steps in parts.values():
        whole = sum(step for step, _, _ in steps)
        load = (sum(step * heat for step, _, heat in steps) / whole) ** 0.5
        speed = sum(moved for _, moved, _ in steps) / whole
        rows.append({"torque_Nm": load, "share": whole / period, "speed_deg_s": speed})
    return rows, period


def _table(file: Path) -> tuple[list[list[float]], list[int]]:
    """Time, angle and torque of each row, in s, deg, N m, and the rows' lines."""
    text = read_text(file, "record of a duty", "; loads.duty.record is relative to the design file")
    head = next((line for line in text.splitlines() if line.strip() and not line.lstrip().startswith("#")), "")
    reader = csv.reader(io.StringIO(text), delimiter=";" if ";" in head else ",")
    places: dict[str, tuple[int, float]] = {}
    rows: list[list[float]] = []
    lines: list[int] = []
    problems: list[Problem] = []
    for cells in reader:
        if not any(cell.strip() for cell in cells) or cells[0].lstrip().startswith("#"):
            continue
        if not places:
            places = _head(str(file), reader.line_num, cells)
            continue
        try:
            row = [float(cells[at]) * factor for at, factor in places.values()]
            if not all(isfinite(value) for value in row):
                raise ValueError
            rows.append(row)
            lines.append(reader.line_num)
        except (ValueError, IndexError):
            remedy = "write one figure for each column of the header, with a decimal point"
            problems.append(
                Problem(str(file), reader.line_num, "", "not three numbers", shortened(",".join(cells)), "", remedy)
            )
    if problems:
        raise InputError(problems[:_MOST_LISTED])
    if len(rows) < 2:
        remedy = f"begin it with {_HEAD} and write a line for each sample"
        raise InputError([Problem(str(file), 1, "", "too short", f"{len(rows)} samples", "2 samples or more", remedy)])
    for k, (before, after) in enumerate(pairwise(rows), 1):
        if after[0] <= before[0]:
            what, limit = f"{after[0]:g} s after {before[0]:g} s", "each time later than the one before"
            remedy = "sort the record and remove what is there twice"
            raise InputError([Problem(str(file), lines[k], "time", "does not grow", what, limit, remedy)])
    return rows, lines


def _head(file: str, line: int, cells: list[str]) -> dict[str, tuple[int, float]]:
    """Column and factor of time, angle and torque."""
    found: dict[str, tuple[int, float]] = {}
    for at, cell in enumerate(cells):
        name, _, unit = re.sub(r"[\s\[\]()·*]+", "_", cell.strip()).strip("_").partition("_")
        units = UNITS.get(name.lower())
        if units is not None and (spelt := unit.replace("_", "")) in units:
            found[name.lower()] = at, units[spelt]
    missing = [name for name in UNITS if name not in found]
    if missing:
        known = "; ".join(f"{name}_{'|'.join(UNITS[name])}" for name in missing)
        what = f"no column with the {' and the '.join(missing)} and its unit"
        raise InputError([Problem(file, line, "", what, shortened(",".join(cells)), known, f"write {_HEAD}")])
    return {name: found[name] for name in UNITS}


def _beyond(file: str, table: list[list[float]], lines: list[int], peak_Nm: float, travel_deg: float) -> list[Problem]:
    """What the record asks beyond the design's peak torque and travel."""
    problems = []
    worst = max(range(len(table)), key=lambda k: abs(table[k][2]))
    if abs(table[worst][2]) > peak_Nm:
        limit, remedy = f"loads.peak_torque_Nm {peak_Nm:g}", "raise loads.peak_torque_Nm, or correct the record"
        value = f"{table[worst][2]:g} N m"
        problems.append(Problem(file, lines[worst], "torque", "more than the peak torque", value, limit, remedy))
    low, high = (end(range(len(table)), key=lambda k: table[k][1]) for end in (min, max))
    span = table[high][1] - table[low][1]
    if span > travel_deg * (1.0 + 1e-9):
        value, limit = f"{span:g} deg from end to end", f"{travel_deg:g} deg"
        remedy = "widen travel, or correct the record; an angle of the motor is no angle of the output"
        problems.append(Problem(file, lines[high], "angle", "more than the whole travel", value, limit, remedy))
    return problems


def by_rows(data: dict[str, Any], path: Path) -> dict[str, Any] | None:
    """Put rows, see :func:`rows_of`, in place of the record that ``data`` names; the block before, if it has one."""
    loads = data.get("loads")
    duty = loads.get("duty") if isinstance(loads, dict) else None
    if not isinstance(duty, dict) or not isinstance(duty.get("record"), str) or duty.get("rows"):
        return None
    rows, period = rows_of(duty["record"], path)
    data["loads"] = {**data["loads"], "duty": {**duty, "record": None, "rows": rows, "period_s": period}}
    return duty
