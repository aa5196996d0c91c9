"""Sums over cells: one pass over the samples, after which every test needs only the cells.

A cell is the part of one sweep that lies in one sector of angle. For columns X and a residual y it keeps the Gram
matrix [1 X y]^T [1 X y] of its samples.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mbcdm_cad.measurement.run import Floats

# Samples multiplied at one time: what keeps the copy small however long the run.
BLOCK = 65_536


@dataclass(frozen=True, eq=False)
class Cells:
    """Grams (cells, k + 2, k + 2) of [1, X, y], y last, and the sweep and sector number of each cell."""

    gram: Floats
    sweep: NDArray[np.int64]
    sector: NDArray[np.int64]

    @property
    def total(self) -> Floats:
        """Gram of all samples."""
        return np.asarray(self.gram.sum(axis=0))


def cell_grams(columns: Floats, y: Floats, sweep: NDArray[np.int64], sector: NDArray[np.int64]) -> Cells:
    """Grams of ``columns`` (n, k) and ``y`` (n,) over the cells given by ``sweep`` and ``sector``, each (n,)."""
    _, sweep_number = np.unique(sweep, return_inverse=True)
    sectors, sector_number = np.unique(sector, return_inverse=True)
    cell = sweep_number * sectors.size + sector_number
    wide = columns.shape[1] + 2
    gram = np.zeros((int(cell.max()) + 1, wide, wide))
    for start in range(0, y.size, BLOCK):
        part = slice(start, start + BLOCK)
        order = np.argsort(cell[part], kind="stable")
        here = cell[part][order]
        table = np.column_stack([np.ones(here.size), columns[part], y[part]])[order]
        edges = np.flatnonzero(np.diff(here)) + 1
        for rows in np.split(np.arange(here.size), edges):
            some = table[rows[0] : rows[-1] + 1]
            gram[here[rows[0]]] += some.T @ some
    filled = np.flatnonzero(gram[:, 0, 0] > 0.0)
    return Cells(gram[filled], filled // sectors.size, filled % sectors.size)
