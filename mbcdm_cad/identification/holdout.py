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


def held_sweeps(sweep: NDArray[np.int64], output_rad: Floats, load_Nm: Floats | None) -> NDArray[np.int64]:
    """Numbers of the half sweeps to hold back; ``sweep`` (n,) numbers them, ascending, below 0 those that are not used.

    The half sweeps are put in order of direction, then of load level (up and down in turn, so that neighbours are
    alike), then of time; every fourth along that order is taken, so that each direction and, with enough of them, each
    level has its share. At least one, never all.
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
    return np.sort(numbers[order][min(ONE_OF // 2, numbers.size - 1) :: ONE_OF])


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
