"""Many designs sized from a file of requirements: columns of fields and figures.

The rules are those of one design. Where the configuration's rules work on columns (:mod:`mbcdm_cad.sizing.bulk`), they
go as far as no frame is needed: values that depend on drum and frame (setback of the inputs, sector, walls) are left
out. Other configurations are sized one by one, with all fields.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, fields
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from mbcdm_cad.layouts.changes import sized_many
from mbcdm_cad.model.bulk import BulkFigures, analyse_many, merged
from mbcdm_cad.model.capability import Requirements, requirements
from mbcdm_cad.model.si import to_si
from mbcdm_cad.report.design_columns import DesignColumns, Values, figure_columns, varied_columns
from mbcdm_cad.sizing.bulk import Alike, gathered

if TYPE_CHECKING:
    from mbcdm_cad.design.loaded import LoadedDesign

# Wraps on passed bodies depend on the inputs' setback, which depends on the frame.
_NEEDS_FRAME = "passed_wrap_deg"


@dataclass(frozen=True, eq=False)
class SizedDesigns(DesignColumns):
    """Sized fields and figures of the cables of n designs.

    Columns are the varied fields, the sized ones by their dotted names (radii by step, ``...drum_radii_mm[1]``; parts
    by their catalogue names) and the figures as in :class:`~mbcdm_cad.report.sweep.Sweep`. ``refused`` gives for a
    design the reason why no rule can fill one of its fields; its other columns are NaN or None.
    """

    name: str
    varied: Mapping[str, Values]
    sized: Mapping[str, Values]
    refused: Values
    figures: BulkFigures | None
    cable_names: tuple[str, ...]

    @cached_property
    def columns(self) -> dict[str, Values]:
        """All columns by name, each (n,)."""
        figures = {} if self.figures is None else figure_columns(self.figures, self.cable_names)
        shown = {name: column for name, column in figures.items() if not name.startswith(_NEEDS_FRAME)}
        return {**self.varied, **self.sized, "refused": self.refused, **shown}

    def __len__(self) -> int:
        """Number of designs."""
        return len(self.refused)

    def summary(self) -> str:
        """How many designs there are, and how many of them the rules fill."""
        return f"{self.name}: {len(self)} designs, {sum(not why for why in self.refused)} sized"


def size_designs(loaded: LoadedDesign, ranges: Mapping[str, Any], *, grid: bool = False) -> SizedDesigns:
    """Size the designs that ``ranges`` describe, as in :func:`mbcdm_cad.report.sweep.sweep`.

    Values are validated one by one; checks are not evaluated, and rules between fields only where designs are sized one
    by one. Errors: ``InputError`` for a value that the file could not hold, ``MbcdmError`` for arrays of different
    lengths.
    """
    varied = varied_columns(ranges, grid=grid)
    n = len(next(iter(varied.values())))
    many = sized_many(loaded, varied)
    sized: dict[str, Values] = {}
    for field in many.fields:
        if field not in varied:
            sized |= _by_step(field, gathered(many.groups, field, n))
    refused = np.full(n, "", dtype=object)
    for group in many.groups:
        refused[group.rows] = group.refused
    parts = [
        (group.rows.tolist(), _figures(group, many.drive_of(group, loaded.drive)))
        for group in many.groups
        if not group.refused
    ]
    cables = tuple(cable.name for cable in loaded.drive.cables)
    return SizedDesigns(loaded.drive.name, varied, sized, refused, merged(parts, n) if parts else None, cables)


def _figures(group: Alike, drive: Any) -> BulkFigures:
    """Figures of a group; its drive holds columns, or numbers if it is one design."""
    n, need = len(group.rows), requirements(drive)
    wide = Requirements(*(np.broadcast_to(np.asarray(getattr(need, f.name), float), (n,)) for f in fields(need)))
    return analyse_many(to_si(drive).spread(n), wide)


def _by_step(field: str, values: Values) -> dict[str, Values]:
    """Columns of a field; none for lists of blocks, such as cables, which are the same for all designs."""
    if values.ndim == 2:
        return {f"{field}[{k + 1}]": values[:, k] for k in range(values.shape[1])}
    return {} if isinstance(values[0], list) else {field: values}
