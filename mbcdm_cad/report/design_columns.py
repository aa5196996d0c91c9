"""Columns of figures of many designs, in readable units, with their output as text, plain data and data frames."""

from __future__ import annotations

import math
from abc import abstractmethod
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import fields
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from mbcdm_cad.errors import MbcdmError, did_you_mean
from mbcdm_cad.model.bulk import BulkFigures
from mbcdm_cad.report.table import ReportTable, data_frame

if TYPE_CHECKING:
    import pandas

Values = NDArray[Any]
# Figures with a row for a load that opposes positive rotation, and one for the other direction.
_BOTH_WAYS = ("turn_rad", "peak_torque_Nm")
# Angles that are shown in degrees; the others, of backlash, in mrad.
_IN_DEGREES = ("wrap", "fleet_angle")


class DesignColumns:
    """Columns by name, each with one value for each design. Iteration and indexing use columns."""

    @property
    @abstractmethod
    def columns(self) -> Mapping[str, Values]:
        """All columns by name, each (n,)."""

    @abstractmethod
    def summary(self) -> str:
        """How many designs there are, in one line."""

    def __getitem__(self, name: str) -> Values:
        """One column, (n,). Raises ``MbcdmError`` for a name that none has."""
        if name not in self.columns:
            raise MbcdmError(f"{name}: no such column; {did_you_mean(name, self.columns)}")
        return self.columns[name]

    def __iter__(self) -> Iterator[str]:
        """Names of the columns."""
        return iter(self.columns)

    def to_dict(self) -> dict[str, list[Any]]:
        """Columns as lists, ready for JSON: None if there is no figure."""
        return {name: [_or_none(value) for value in column.tolist()] for name, column in self.columns.items()}

    def to_pandas(self) -> pandas.DataFrame:
        """One row a design. ``MbcdmError`` without pandas."""
        return data_frame(dict(self.columns))

    def text(self, width: int | None = None) -> str:
        """How many designs there are, and the range of each column."""
        return "\n".join([self.summary(), *self._ranges().text(width, "  ")])

    def __str__(self) -> str:
        """As :meth:`text`."""
        return self.text()

    def _repr_html_(self) -> str:
        """For notebooks: the range of each column."""
        return f"<p>{self.summary()}</p>{self._ranges().html()}"

    def _ranges(self) -> ReportTable:
        rows = []
        for name, column in self.columns.items():
            if column.dtype == float and np.isfinite(column).any():
                rows.append((name, float(np.nanmin(column)), float(np.nanmax(column))))
        return ReportTable(("column", "lowest", "highest"), tuple(rows))


def figure_columns(figures: BulkFigures, cable_names: Sequence[str]) -> dict[str, Values]:
    """The figures by name and unit; those of a cable with its name, those of both directions as plus and minus."""
    found: dict[str, Values] = {}
    for field in fields(figures):
        values = np.asarray(getattr(figures, field.name))
        if values.ndim == 1:
            found |= _column(field.name, values)
        elif field.name in _BOTH_WAYS:
            for way, row in zip(("plus", "minus"), values, strict=True):
                stem, _, unit = field.name.rpartition("_")
                found |= _column(f"{stem}_{way}_{unit}", row)
        else:
            for cable, row in zip(cable_names, values, strict=True):
                found |= {f"{name}[{cable}]": column for name, column in _column(field.name, row).items()}
    return found


def _column(name: str, values: Values) -> dict[str, Values]:
    """A column in a readable unit, with which its name then ends."""
    stem, _, unit = name.rpartition("_")
    if unit == "rad":
        degrees = any(word in stem for word in _IN_DEGREES)
        return {f"{stem}_deg": np.degrees(values)} if degrees else {f"{stem}_mrad": values * 1e3}
    return {f"{stem}_mm": values * 1e3} if unit == "m" else {name: values}


def _or_none(value: Any) -> Any:
    return None if isinstance(value, float) and not math.isfinite(value) else value


def varied_columns(ranges: Mapping[str, Any], *, grid: bool) -> dict[str, Values]:
    """The fields that vary by their dotted names, each (n,): paired row by row, or all combinations.

    Raises ``MbcdmError`` for arrays of different lengths or none.
    """
    names = [name.replace("__", ".") for name in ranges]
    arrays = [np.atleast_1d(np.asarray(values)) for values in ranges.values()]
    columns = _combined(arrays) if grid else _paired(names, arrays)
    if not columns or not len(columns[0]):
        raise MbcdmError("no designs to analyse; give at least one field with at least one value")
    return dict(zip(names, columns, strict=True))


def _paired(names: Sequence[str], arrays: Sequence[Values]) -> list[Values]:
    n = max((len(array) for array in arrays), default=0)
    for name, array in zip(names, arrays, strict=True):
        if array.ndim != 1 or len(array) not in (1, n):
            raise MbcdmError(
                f"{name}: values of shape {array.shape} beside others of length {n}; give each field one value, or as "
                "many as the longest, or grid=True for all combinations"
            )
    return [np.broadcast_to(array, (n,)) for array in arrays]


def _combined(arrays: Sequence[Values]) -> list[Values]:
    return [mesh.ravel() for mesh in np.meshgrid(*arrays, indexing="ij")] if arrays else []
