"""Choose samples of a run that is too long to use all of them.

Every so many samples of a half sweep are enough; the turning points of motion and load must be among them, so thinning
has a limit, beyond which whole stretches are left out. The friction remembers extremes from long before a stretch: of
what is left out, the turning points lead in to the next one.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from mbcdm_cad.routes import Floats

# Samples that the search works on, and samples of a half sweep that are kept for it: fast lines need them.
SEARCH_SAMPLES = 20_000
SEARCH_IN_SWEEP = 1250
SEARCH_STRETCHES = 4
# The same for the figures and the errors; between samples nothing may happen to the friction in this time.
WHOLE_SAMPLES = 250_000
WHOLE_IN_SWEEP = 200
WHOLE_STEP_S = 0.04
WHOLE_STRETCHES = 16
# A stretch has so many half sweeps at least: its first is discarded.
LEAST_SWEEPS = 5
# Half sweeps before a stretch whose turning points lead in to it.
LEAD_SWEEPS = 200
# The last of them are gone through in steps, since what turns with the angle has extremes of its own.
STEPPED_SWEEPS = 12
LEAD_STEPS = 32
# Last samples of a stretch, which smoothing would mix with what comes after.
TAIL = 32


@dataclass(frozen=True, eq=False)
class Cut:
    """Samples of a run: ``index`` (n,), every ``stride``-th within stretches that begin at positions ``starts``.

    ``lead`` (n,) marks the few samples that only lead in to a stretch, ``unknown`` (n,) those and all others that are
    to be simulated and not judged: the first half sweep of each stretch, whose friction history is only roughly known.
    """

    index: NDArray[np.int64]
    stride: int
    starts: NDArray[np.int64]
    lead: NDArray[np.bool_]
    unknown: NDArray[np.bool_]


def search_cut(sweep: NDArray[np.int64], load_Nm: Floats | None) -> Cut | None:
    """What the search works on; None if that is the whole run. ``sweep`` (n,) numbers the half sweeps, ascending."""
    if sweep.size <= SEARCH_SAMPLES * 1.25:
        return None
    return _cut(sweep, load_Nm, max(1, _in_sweep(sweep) // SEARCH_IN_SWEEP), SEARCH_SAMPLES, SEARCH_STRETCHES)


def whole_cut(sweep: NDArray[np.int64], load_Nm: Floats | None, step_s: float) -> Cut:
    """What the figures are taken from: all, thinned, and of a very long run stretches."""
    most = max(1, int(WHOLE_STEP_S / step_s), _in_sweep(sweep) // WHOLE_IN_SWEEP)
    return _cut(sweep, load_Nm, min(-(-sweep.size // WHOLE_SAMPLES), most), WHOLE_SAMPLES, WHOLE_STRETCHES)


def _in_sweep(sweep: NDArray[np.int64]) -> int:
    return int(np.median(np.bincount(sweep - sweep[0])))


def _cut(sweep: NDArray[np.int64], load_Nm: Floats | None, stride: int, most: int, stretches: int) -> Cut:
    n = sweep.size
    if n <= 1.25 * most * stride:
        index = np.arange(0, n, stride)
        none = np.zeros(index.size, dtype=np.bool_)
        return Cut(index, stride, np.zeros(1, dtype=np.int64), none, none)
    turns = np.flatnonzero(np.diff(sweep)) + 1
    count = int(np.clip(most * stride / (LEAST_SWEEPS * n / (turns.size + 1)), 1, stretches))
    length = most * stride // count
    # The first begins with the run, the last ends with it; all others begin where the drive turns.
    begins = np.linspace(0, n - length, count).astype(np.int64)
    if turns.size:
        begins[1:] = turns[np.minimum(np.searchsorted(turns, begins[1:]), turns.size - 1)]
    pieces, leads, unknown, end = [], [], [], 0
    for begin, following in pairwise([*begins.tolist(), n]):
        before = _turning_points(sweep, load_Nm, end, begin)
        end = min(begin + length, following)
        piece = np.arange(begin, end, stride)
        first = np.zeros(piece.size, dtype=np.bool_) if begin == 0 else sweep[piece] == sweep[begin]
        first[-TAIL:] = True
        pieces += [before, piece]
        leads += [np.ones(before.size, dtype=np.bool_), np.zeros(piece.size, dtype=np.bool_)]
        unknown += [np.ones(before.size, dtype=np.bool_), first]
    starts = np.cumsum([0, *(piece.size for piece in pieces[:-1])])[1::2]
    return Cut(np.concatenate(pieces), stride, starts, np.concatenate(leads), np.concatenate(unknown))


def _turning_points(sweep: NDArray[np.int64], load_Nm: Floats | None, begin: int, end: int) -> NDArray[np.int64]:
    """Samples between two stretches where the drive turns or a half sweep's load is at its ends, and a few besides."""
    if load_Nm is None or end <= begin:
        return np.empty(0, dtype=np.int64)
    turns = begin + 1 + np.flatnonzero(np.diff(sweep[begin:end]))
    found: list[NDArray[np.int64]] = []
    for first, last in pairwise([*turns[-LEAD_SWEEPS:].tolist(), end]):
        part = load_Nm[first:last]
        found.append(np.array([first, first + int(part.argmin()), first + int(part.argmax())]))
    near = int(turns[-STEPPED_SWEEPS:].min(initial=end))
    found.append(np.arange(near, end, max(1, (end - near) // (STEPPED_SWEEPS * LEAD_STEPS))))
    return np.unique(np.concatenate(found))
