"""Choose samples of a run: half sweeps that are held back, and those that are used where a run is too long.

Choose the half sweeps that are held back, by load, direction and time alone, before any residual is computed.

Taking every fourth half sweep by number is not enough: where loads are stepped periodically, all half sweeps held back
could have the same load, and an effect of the load could not be judged on them.

Choose samples of a run that is too long to use all of them.

A part of the samples of a half sweep is enough, but the turning points of motion and load must be among them. This
limits the thinning; beyond it whole stretches are left out. The friction depends on extremes from long before a
stretch, so the turning points of the part that is left out are simulated before the next stretch.
"""

import math
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from mbcdm_cad.routes import Floats

# One half sweep of so many is held back.
ONE_OF = 4
# Loads closer than this share of their range count as one level.
LEVEL_SHARE = 0.1
# Bins of the load in which held half sweeps are compared with all. They are exchanged while this share of their samples
# is in bins in which it should not be, and if an exchange lowers the share by so much at least.
LOAD_BINS = 8
# Parts of a run of which the first and the last have a half sweep that is held back; a difference beyond any of levels.
THIRDS, FAR = 3, 1e3
UNLIKE, LEAST_GAIN = 0.2, 0.02


def held_sweeps(sweep: NDArray[np.int64], output_rad: Floats, load_Nm: Floats | None) -> NDArray[np.int64]:
    """Numbers of the half sweeps to hold back; ``sweep`` (n,) numbers them, ascending, below 0 those that are not used.

    The half sweeps are put in order of direction, then of load level (up and down in turn, so that neighbours are
    alike), then of time; every fourth along that order is taken, so that each direction and, with enough of them, each
    level has its share. Half sweeps are then exchanged as long as their loads differ much from those of the run. At
    least one, never all.
    """
    numbers = np.unique(sweep[sweep >= 0])
    if numbers.size < 2:
        return numbers[:0]
    first, last = np.searchsorted(sweep, numbers), np.searchsorted(sweep, numbers, side="right") - 1
    direction = np.sign(output_rad[last] - output_rad[first])
    level = np.zeros(numbers.size)
    if load_Nm is not None:
        mean = _means(numbers, sweep, load_Nm)
        level = np.round(mean / (LEVEL_SHARE * np.ptp(load_Nm))) if np.ptp(load_Nm) > 0.0 else level
    level = np.where(direction > 0.0, level, -level)
    order = np.lexsort((numbers, level, direction))
    held = np.zeros(numbers.size, dtype=np.bool_)
    held[order[min(ONE_OF // 2, numbers.size - 1) :: ONE_OF]] = True
    if load_Nm is not None and np.ptp(load_Nm) > 0.0:
        held = _representative(held, _counts(numbers, sweep, load_Nm, direction > 0.0))
    return numbers[_throughout(held, direction, level)]


def _throughout(held: NDArray[np.bool_], direction: Floats, level: Floats) -> NDArray[np.bool_]:
    """``held`` with one half sweep in the first and in the last third of the run, if there are two: a drive may change.

    The one that is given up is of the same direction, and of the nearest level of the load.
    """
    third = held.size // THIRDS
    held = held.copy()
    for part in (slice(0, third), slice(held.size - third, held.size)):
        if held[part].any() or held.sum() < 2 or third < 2:
            continue
        inside = np.flatnonzero(held)
        others = np.arange(held.size)[part]
        apart = np.abs(level[inside, None] - level[others]) + FAR * (direction[inside, None] != direction[others])
        # Of equal ones, the held half sweep nearest in time gives way, so that the other end keeps its own.
        apart = apart + np.abs(inside[:, None] - others) / held.size**2
        i, j = np.unravel_index(int(np.argmin(apart)), apart.shape)
        held[inside[i]], held[others[j]] = False, True
    return held


def _counts(numbers: NDArray[np.int64], sweep: NDArray[np.int64], load_Nm: Floats, up: NDArray[np.bool_]) -> Floats:
    """Samples of each half sweep in each bin of the load; the two directions have bins of their own; (m, 2 bins)."""
    used = np.isin(sweep, numbers)
    k = np.searchsorted(numbers, sweep[used])
    load = load_Nm[used]
    span = float(np.ptp(load)) or 1.0
    place = np.minimum((load - load.min()) / span * LOAD_BINS, LOAD_BINS - 1).astype(np.int64) + LOAD_BINS * up[k]
    table = np.bincount(k * 2 * LOAD_BINS + place, minlength=numbers.size * 2 * LOAD_BINS)
    return table.reshape(numbers.size, 2 * LOAD_BINS).astype(float)


def _representative(held: NDArray[np.bool_], counts: Floats) -> NDArray[np.bool_]:
    """``held`` after the exchanges that bring the loads of the held half sweeps near to those of all, one at a time.

    Where the load changes within a half sweep, its mean does not tell which loads it has.
    """
    whole = counts.sum(axis=0) / counts.sum()

    def distance(sums: Floats) -> Floats:
        """Share of the samples that would have to change their bin, for sums (..., bins)."""
        return np.asarray(0.5 * np.abs(sums / sums.sum(axis=-1, keepdims=True) - whole).sum(axis=-1))

    held = held.copy()
    now = counts[held].sum(axis=0)
    while distance(now) > UNLIKE:
        inside, outside = np.flatnonzero(held), np.flatnonzero(~held)
        after = distance(now - counts[inside, None] + counts[None, outside])
        i, j = np.unravel_index(int(np.argmin(after)), after.shape)
        if after[i, j] > distance(now) - LEAST_GAIN:
            break
        held[inside[i]], held[outside[j]] = False, True
        now = counts[held].sum(axis=0)
    return held


def _means(numbers: NDArray[np.int64], sweep: NDArray[np.int64], values: Floats) -> Floats:
    """Mean of ``values`` over each of the half sweeps; ``sweep`` ascends."""
    sums = np.concatenate([[0.0], np.cumsum(values)])
    first, last = np.searchsorted(sweep, numbers), np.searchsorted(sweep, numbers, side="right")
    return np.asarray((sums[last] - sums[first]) / (last - first))


def held_words(held: NDArray[np.int64], sweep: NDArray[np.int64], load_Nm: Floats | None, few: bool) -> str:
    """Text for results: numbers of the half sweeps in the run, from 1, and their mean loads.

    ``sweep`` counts from the second half sweep of the run; with too ``few`` it counts eighths of the time.
    """
    if not held.size:
        return "none"
    numbers = ", ".join(str(one + (1 if few else 2)) for one in held[:8]) + (", ..." if held.size > 8 else "")
    words = f"eighths {numbers} of the time" if few else f"half sweep{'s' * (held.size > 1)} {numbers}"
    if load_Nm is not None and load_Nm.any():
        means = _means(held, sweep, load_Nm)
        words += f" (mean loads {min(means):.2g} to {max(means):.2g} N m)"
    return words


# Samples that the search uses, and the most of a half sweep that it keeps. Half as many are enough for fast lines;
# more half sweeps say more than more samples of each.
SEARCH_SAMPLES = 20_000
SEARCH_IN_SWEEP = 1250
SEARCH_STRETCHES = 4
# Runs up to which each has all these samples.
FULL_RUNS = 3
# The same for the figures and the errors; the friction must not change noticeably within this time.
WHOLE_SAMPLES = 250_000
WHOLE_IN_SWEEP = 200
WHOLE_STEP_S = 0.04
WHOLE_STRETCHES = 16
# A stretch has at least so many half sweeps, of which the first is discarded.
LEAST_SWEEPS = 5
# Half sweeps before a stretch whose turning points are simulated.
LEAD_SWEEPS = 200
# The last of these half sweeps are simulated in steps, since effects of the angle have extremes between the ends.
STEPPED_SWEEPS = 12
LEAD_STEPS = 32
# Number of last samples of a stretch, which smoothing would mix with the samples after it.
TAIL = 32


@dataclass(frozen=True, eq=False)
class Cut:
    """Samples of a run: ``index`` (n,), every ``stride``-th within stretches that begin at positions ``starts``.

    ``lead`` (n,) marks the few samples that are simulated before a stretch begins, ``unknown`` (n,) these and all
    others that are simulated but not judged: the first half sweep of each stretch, whose friction history is only
    roughly known.
    """

    index: NDArray[np.int64]
    stride: int
    starts: NDArray[np.int64]
    lead: NDArray[np.bool_]
    unknown: NDArray[np.bool_]


def search_cut(sweep: NDArray[np.int64], load_Nm: Floats | None, runs: int = 1) -> Cut | None:
    """The samples that the search uses; None if that is the whole run. ``sweep`` (n,): half sweeps, ascending.

    Of many ``runs``, each has its share of the samples of a few.
    """
    share = min(1.0, FULL_RUNS / runs)
    most, in_sweep = int(share * SEARCH_SAMPLES), share * SEARCH_IN_SWEEP
    if sweep.size <= most * 1.25:
        return None
    return _cut(sweep, load_Nm, math.ceil(_in_sweep(sweep) / in_sweep), most, SEARCH_STRETCHES)


def whole_cut(sweep: NDArray[np.int64], load_Nm: Floats | None, step_s: float) -> Cut:
    """The samples for the figures: the whole run, thinned, or stretches of a very long run."""
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
    # The first stretch begins with the run, the last ends with it; all others begin at a reversal of the drive.
    begins = _with_extremes(np.linspace(0, n - length, count).astype(np.int64), length, turns, load_Nm)
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


def _with_extremes(
    begins: NDArray[np.int64], length: int, turns: NDArray[np.int64], load_Nm: Floats | None
) -> NDArray[np.int64]:
    """``begins`` after a stretch was moved to each extreme of the load that no stretch has: play may be crossed only
    there.

    The first and the last stretch stay. The half sweep of the extreme is the second of its stretch, because the first
    is discarded.
    """
    if load_Nm is None:
        return begins
    found, free = begins.copy(), list(range(1, begins.size - 1))
    for extreme in (int(load_Nm.argmin()), int(load_Nm.argmax())):
        if not free or np.any((found <= extreme) & (extreme < found + length)):
            continue
        nearest = min(free, key=lambda k: abs(int(found[k]) - extreme))
        free.remove(nearest)
        before = turns[turns <= extreme]
        found[nearest] = before[-2] if before.size > 1 else max(0, extreme - length // 2)
    return np.sort(found)


def _turning_points(sweep: NDArray[np.int64], load_Nm: Floats | None, begin: int, end: int) -> NDArray[np.int64]:
    """Samples between two stretches: reversals, extremes of the load in each half sweep, and a few more."""
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
