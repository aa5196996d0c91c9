"""Many designs that differ in some fields, analysed at once: columns of figures in readable units."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, fields
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from mbcdm_cad.configurations.changes import changed_drives
from mbcdm_cad.errors import MbcdmError, did_you_mean
from mbcdm_cad.model.bulk import BulkFigures, Requirements, analyse_many, stack_designs
from mbcdm_cad.model.ratings import requirements
from mbcdm_cad.model.si import to_si
from mbcdm_cad.report.table import ReportTable, data_frame

if TYPE_CHECKING:
    import pandas

    from mbcdm_cad.design.loaded import LoadedDesign

Column = NDArray[Any]
# Figures with a row for a load that opposes positive rotation, and one for the other way.
_BOTH_WAYS = ("turn_rad", "peak_torque_Nm")
# Angles that people read in degrees; the others, of backlash, in mrad.
_IN_DEGREES = ("wrap", "fleet_angle")


@dataclass(frozen=True, eq=False)
class Sweep:
    """Figures of n designs: ``varied`` fields by name, ``figures`` in SI, ``cable_names`` of their rows.

    Iterating and indexing goes over columns: the varied fields, then the figures in mm, N, N m, deg and, of backlash,
    mrad. A design that has no free span has ``valid`` False and NaN in its figures. ``reversal_swing_mrad`` is the
    backlash that a bench measures when the load changes sign; ``cable_backlash_mrad[NAME]`` is Eq. (14) of one cable.
    """

    name: str
    varied: Mapping[str, Column]
    figures: BulkFigures
    cable_names: tuple[str, ...]

    @cached_property
    def columns(self) -> dict[str, Column]:
        """All columns by name, each (n,)."""
        found = dict(self.varied)
        for field in fields(self.figures):
            values = np.asarray(getattr(self.figures, field.name))
            if values.ndim == 1:
                found |= _column(field.name, values)
            elif field.name in _BOTH_WAYS:
                for way, row in zip(("plus", "minus"), values, strict=True):
                    stem, _, unit = field.name.rpartition("_")
                    found |= _column(f"{stem}_{way}_{unit}", row)
            else:
                for cable, row in zip(self.cable_names, values, strict=True):
                    found |= {f"{name}[{cable}]": column for name, column in _column(field.name, row).items()}
        return found

    def __getitem__(self, name: str) -> Column:
        """One column, (n,). Raises ``MbcdmError`` for a name that none has."""
        if name not in self.columns:
            raise MbcdmError(f"{name}: no such column; {did_you_mean(name, self.columns)}")
        return self.columns[name]

    def __iter__(self) -> Iterator[str]:
        """Names of the columns."""
        return iter(self.columns)

    def __len__(self) -> int:
        """Number of designs."""
        return len(self.figures.valid)

    def to_dict(self) -> dict[str, list[Any]]:
        """Columns as lists, ready for JSON: None where there is no figure."""
        return {name: [_or_none(value) for value in column.tolist()] for name, column in self.columns.items()}

    def to_pandas(self) -> pandas.DataFrame:
        """One row a design. ``MbcdmError`` without pandas."""
        return data_frame(dict(self.columns))

    def text(self, width: int | None = None) -> str:
        """How many designs there are, and the range of each column."""
        return "\n".join([self._summary(), *self._ranges().text(width, "  ")])

    def __str__(self) -> str:
        """As :meth:`text`."""
        return self.text()

    def _repr_html_(self) -> str:
        """For notebooks: the range of each column."""
        return f"<p>{self._summary()}</p>{self._ranges().html()}"

    def _summary(self) -> str:
        return f"{self.name}: {len(self)} designs, {int(np.sum(self.figures.valid))} with a free span"

    def _ranges(self) -> ReportTable:
        rows = []
        for name, column in self.columns.items():
            if column.dtype == float and np.isfinite(column).any():
                rows.append((name, float(np.nanmin(column)), float(np.nanmax(column))))
        return ReportTable(("column", "lowest", "highest"), tuple(rows))


def sweep(loaded: LoadedDesign, ranges: Mapping[str, Any], *, grid: bool = False) -> Sweep:
    """Analyse the designs that ``ranges`` describe: for each field an array of values, one a design, or one for all.

    ``grid`` makes all combinations of the values instead, the last field varying fastest. Fields are named and
    validated as in :func:`mbcdm_cad.configurations.changes.with_changes`. Errors: ``InputError`` for a value that the
    file could not hold, ``MbcdmError`` for arrays of different lengths or none.
    """
    names = [name.replace("__", ".") for name in ranges]
    arrays = [np.atleast_1d(np.asarray(values)) for values in ranges.values()]
    columns = _combined(arrays) if grid else _paired(names, arrays)
    rows = [dict(zip(names, row, strict=True)) for row in zip(*columns, strict=True)]
    if not rows:
        raise MbcdmError("no designs to analyse; give at least one field with at least one value")
    drives = list(changed_drives(loaded, rows))
    asked = [requirements(drive) for drive in drives]
    need = Requirements(*(np.array([getattr(one, f.name) for one in asked]) for f in fields(Requirements)))
    figures = analyse_many(stack_designs([to_si(drive) for drive in drives]), need)
    cables = tuple(cable.name for cable in drives[0].cables)
    return Sweep(loaded.drive.name, dict(zip(names, columns, strict=True)), figures, cables)


def _paired(names: Sequence[str], arrays: Sequence[Column]) -> list[Column]:
    n = max((len(array) for array in arrays), default=0)
    for name, array in zip(names, arrays, strict=True):
        if array.ndim != 1 or len(array) not in (1, n):
            raise MbcdmError(
                f"{name}: values of shape {array.shape} beside others of length {n}; give each field one value, or as "
                "many as the longest, or grid=True for all combinations"
            )
    return [np.broadcast_to(array, (n,)) for array in arrays]


def _combined(arrays: Sequence[Column]) -> list[Column]:
    return [mesh.ravel() for mesh in np.meshgrid(*arrays, indexing="ij")] if arrays else []


def _column(name: str, values: Column) -> dict[str, Column]:
    """A column in the unit that people read, which its name then ends with."""
    stem, _, unit = name.rpartition("_")
    if unit == "rad":
        degrees = any(word in stem for word in _IN_DEGREES)
        return {f"{stem}_deg": np.degrees(values)} if degrees else {f"{stem}_mrad": values * 1e3}
    return {f"{stem}_mm": values * 1e3} if unit == "m" else {name: values}


def _or_none(value: Any) -> Any:
    return None if isinstance(value, float) and not math.isfinite(value) else value
