"""Choose the half sweeps that are held back, by load, direction and time alone, before any residual is computed.

Taking every fourth half sweep by number is not enough: where loads are stepped periodically, all half sweeps held back
could have the same load, and an effect of the load could not be judged on them.
"""

from __future__ import annotations

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
    return numbers[held]


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


def held_words(held: NDArray[np.int64], sweep: NDArray[np.int64], load_Nm: Floats | None) -> str:
    """Text for results: numbers, counted from the first half sweep that is used, and their mean loads."""
    numbers = ", ".join(str(one + 1) for one in held[:8]) + (", ..." if held.size > 8 else "")
    words = f"half sweeps {numbers}"
    if load_Nm is not None and held.size:
        means = _means(held, sweep, load_Nm)
        words += f" (mean loads {min(means):.2g} to {max(means):.2g} N m)"
    return words
