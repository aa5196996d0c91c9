"""Columns of figures of many designs, in readable units, with their output as text, plain data and data frames."""

from __future__ import annotations

import math
from abc import abstractmethod
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, fields
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from mbcdm_cad.errors import MbcdmError, did_you_mean
from mbcdm_cad.layouts.changes import changed_drives
from mbcdm_cad.layouts.registry import layout_of
from mbcdm_cad.model.bulk import BulkFigures, analyse_many, merged, stack_designs
from mbcdm_cad.model.capability import Requirements, requirements
from mbcdm_cad.model.si import DriveSI
from mbcdm_cad.report.table import ReportTable, TextReport, data_frame, designs_shown

if TYPE_CHECKING:
    import pandas

    from mbcdm_cad.design.loader import LoadedDesign

Values = NDArray[Any]
# Figures with a row for a load that opposes positive rotation, and one for the other direction.
_BOTH_WAYS = ("turn_rad", "peak_torque_Nm")
# Angles that are shown in degrees; the others, of backlash, in mrad.
_IN_DEGREES = ("wrap", "fleet_angle")


class DesignColumns(TextReport):
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


@dataclass(frozen=True, eq=False)
class Sweep(DesignColumns):
    """Figures of n designs: ``varied`` fields by name, ``figures`` in SI, ``cable_names`` of their rows.

    Iterating and indexing goes over columns: the varied fields, then the figures in mm, N, N m, deg and, of backlash,
    mrad. A design that has no free span has ``valid`` False and NaN in its figures. ``reversal_swing_mrad`` is the
    backlash that a bench measures when the load changes sign; ``cable_backlash_mrad[NAME]`` is Eq. (14) of one cable.
    """

    name: str
    varied: Mapping[str, Values]
    figures: BulkFigures
    cable_names: tuple[str, ...]

    @cached_property
    def columns(self) -> dict[str, Values]:
        """All columns by name, each (n,)."""
        return {**self.varied, **figure_columns(self.figures, self.cable_names)}

    def __len__(self) -> int:
        """Number of designs."""
        return len(self.figures.valid)

    def summary(self) -> str:
        """How many designs there are, and how many have a free span."""
        return f"{self.name}: {designs_shown(len(self))}, {int(np.sum(self.figures.valid))} with a free span"


def sweep(loaded: LoadedDesign, ranges: Mapping[str, Any], *, grid: bool = False) -> Sweep:
    """Analyse the designs that ``ranges`` describe: for each field an array of values, one a design, or one for all.

    ``grid`` makes all combinations of the values instead, the last field varying fastest. Fields are named and
    validated as in :func:`mbcdm_cad.layouts.changes.with_changes`; what the file leaves out is sized again for
    each design, which takes 10 to 60 ms each. Errors: ``InputError`` for a value that the file could not hold,
    ``MbcdmError`` for arrays of different lengths or none.
    """
    varied = varied_columns(ranges, grid=grid)
    rows = [dict(zip(varied, row, strict=True)) for row in zip(*varied.values(), strict=True)]
    drives = list(changed_drives(loaded, rows))
    asked = [requirements(layout_of(drive)) for drive in drives]
    designs, groups = [layout_of(drive).si for drive in drives], list[tuple[list[int], BulkFigures]]()
    for members in _routed_alike(designs):
        need = Requirements(*(np.array([getattr(asked[k], f.name) for k in members]) for f in fields(Requirements)))
        groups.append((members, analyse_many(stack_designs([designs[k] for k in members]), need)))
    cables = tuple(cable.name for cable in drives[0].cables)
    return Sweep(loaded.drive.name, varied, merged(groups, len(rows)), cables)


def _routed_alike(designs: Sequence[DriveSI]) -> list[list[int]]:
    """Indices of the designs in groups with the same routes; sizing rules may choose other arrangements for some."""
    groups: list[list[int]] = []
    for k, design in enumerate(designs):
        own = next((group for group in groups if designs[group[0]].geometry == design.geometry), None)
        if own is None:
            groups.append([k])
        else:
            own.append(k)
    return groups
