"""Half sweeps of a run, and the moving mean that smooths its signals."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import uniform_filter1d

from mbcdm_cad.routes import Floats
from mbcdm_cad.storage.compiled import compiled

# A reversal counts if the output has moved back by this share of its travel.
REVERSAL_SHARE = 0.1
# Window over which a speed is computed, s.
SPEED_WINDOW_S = 0.1


@compiled
def _turns(output: Floats, reach: float, out: NDArray[np.int64]) -> int:
    """Fill ``out`` with the samples at which the output turns; their number."""
    found, rising = 0, 0
    low = high = output[0]
    low_at = high_at = 0
    for k in range(output.size):
        value = output[k]
        if rising >= 0 and value > high:
            high, high_at = value, k
        if rising <= 0 and value < low:
            low, low_at = value, k
        if rising >= 0 and high - value > reach:
            out[found] = high_at
            found += 1
            rising, low, low_at = -1, value, k
        elif rising <= 0 and value - low > reach:
            out[found] = low_at
            found += 1
            rising, high, high_at = 1, value, k
    return found


def half_sweeps(output_rad: Floats) -> NDArray[np.int64]:
    """Number of the half sweep at each sample, from 0; shape (n,). A turn counts after a tenth of the travel."""
    out, reach = np.empty(output_rad.size + 1, dtype=np.int64), REVERSAL_SHARE * float(np.ptp(output_rad))
    turns = out[: _turns(np.ascontiguousarray(output_rad), reach, out)]
    # There is no reversal before the first motion.
    if turns.size and abs(output_rad[turns[0]] - output_rad[0]) <= reach:
        turns = turns[1:]
    return np.asarray(np.searchsorted(turns, np.arange(output_rad.size), side="right"), dtype=np.int64)


def smoothed(values: Floats, window_s: float, step_s: float) -> Floats:
    """Two passes of a centred moving mean: a triangle ``window_s`` wide; the ends are held."""
    width = 2 * round(window_s / (4.0 * step_s)) + 1
    if width == 1:
        return values
    once = uniform_filter1d(values, width, axis=-1, mode="nearest")
    return np.asarray(uniform_filter1d(once, width, axis=-1, mode="nearest"))


def smoothed_at(values: Floats, time_s: Floats, window_s: float, step_s: float) -> Floats:
    """As ``smoothed``, for a moving signal whose samples are not evenly spaced in time.

    A mean belongs to the mean time of its samples. Where a logger jitters, loses samples or ends, that is not the time
    of the middle sample; the slope takes the mean there.
    """
    mean, at = smoothed(values, window_s, step_s), smoothed(time_s, window_s, step_s)
    return np.asarray(mean + np.gradient(mean, at, axis=-1) * (time_s - at))
