"""Many designs that differ in some fields, analysed at once: columns of figures in readable units."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from mbcdm_cad.layouts.changes import changed_drives
from mbcdm_cad.model.bulk import BulkFigures, analyse_many, merged, stack_designs
from mbcdm_cad.model.capability import Requirements, requirements
from mbcdm_cad.model.si import DriveSI, to_si
from mbcdm_cad.report.design_columns import DesignColumns, Values, figure_columns, varied_columns

if TYPE_CHECKING:
    from mbcdm_cad.design.loaded import LoadedDesign


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
        return f"{self.name}: {len(self)} designs, {int(np.sum(self.figures.valid))} with a free span"


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
    asked = [requirements(drive) for drive in drives]
    designs, groups = [to_si(drive) for drive in drives], list[tuple[list[int], BulkFigures]]()
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
