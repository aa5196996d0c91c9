"""The time from which on a quantity counts in a residual that it did not count in before: a change during the run."""

from __future__ import annotations

import numpy as np

from mbcdm_cad.routes import Floats

# Times that are tried, first over the whole run without its ends, then around the best.
COARSE_TIMES, FINE_TIMES, EDGE_SHARE = 60, 60, 0.04


def time_of_change(time_s: Floats, shape: Floats, residual: Floats) -> float:
    """The time after which ``shape`` (n,) explains the residual best, beside a constant and ``shape`` throughout."""
    low, high = (float(np.quantile(time_s, q)) for q in (EDGE_SHARE, 1.0 - EDGE_SHARE))
    apart = (high - low) / COARSE_TIMES
    size = float(np.std(shape)) or 1.0
    sums = _Sums(time_s, shape / size, residual)
    at = sums.best(np.linspace(low, high, COARSE_TIMES))
    return sums.best(np.linspace(max(low, at - apart), min(high, at + apart), FINE_TIMES))


class _Sums:
    """Running sums, from which the fit for each time follows at once."""

    def __init__(self, time_s: Floats, shape: Floats, residual: Floats) -> None:
        self.time_s = time_s
        rows = np.stack([shape, shape**2, residual * shape])
        self.running = np.concatenate([np.zeros((3, 1)), np.cumsum(rows, axis=1)], axis=1)
        self.residual = float(residual.sum())

    def best(self, times: Floats) -> float:
        """The time that explains most."""
        whole = self.running[:, -1]
        c, cc, rc = whole[:, None] - self.running[:, np.searchsorted(self.time_s, times)]
        n, one = float(self.time_s.size), np.ones_like(c)
        gram = np.array([[n * one, whole[0] * one, c], [whole[0] * one, whole[1] * one, cc], [c, cc, cc]]).transpose(
            2, 0, 1
        )
        side = np.stack([self.residual * one, whole[2] * one, rc], axis=1)
        solved = (np.linalg.pinv(gram, rcond=1e-10, hermitian=True) @ side[..., None])[..., 0]
        return float(times[int(np.argmax(np.sum(side * solved, axis=1)))])
