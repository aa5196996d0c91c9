"""On what the noise hangs: its size over load, speed, place and time. The noise of a sensor is the same everywhere.

The residual's mean square over cells of sweep and sector is compared, as its logarithm, with the mean of each quantity
there. A quantity counts if the noise is twice as large at one end as at the other, and if whole sweeps agree on it
(slope over its error, clustered by sweep). A drive that changes in mid-run has noise that hangs on load and time; time
stamps that jitter have noise that hangs on the speed.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mbcdm_cad.loop.prepare.prepared import Prepared
from mbcdm_cad.loop.readable import readable
from mbcdm_cad.routes import Floats

# Least ratio of the noise between the two ends, and least slope over its error.
LEAST_RATIO, LEAST_ERRORS = 2.0, 5.0
# Sweeps and samples of a cell that are needed to say anything.
FEWEST_SWEEPS, FEWEST_SAMPLES = 6, 8
# Ends of a quantity, as shares of the cells.
ENDS = (0.1, 0.9)
CAUSES = {
    "load": "the stiffness or the tension of the drive changes during the run, or the torque sensor lags",
    "speed": "time stamps that jitter, or a delay that changes",
    "time": "something of the drive or the bench changes during the run",
}


@dataclass(frozen=True)
class Scatter:
    """Noise that hangs on a quantity: its RMS where that is small and where it is large, rad."""

    quantity: str
    low_rad: float
    high_rad: float

    @property
    def words(self) -> str:
        """For people."""
        _, (low, high) = readable("_rad", [self.low_rad, self.high_rad])
        ends = {"time": ("at first", "in the end")}.get(self.quantity, (f"at small {self.quantity}", "at large"))
        return (
            f"what does not repeat hangs on the {self.quantity}: {low} RMS {ends[0]}, {high} {ends[1]}; no noise of an "
            f"encoder does: {CAUSES[self.quantity]}"
        )


def hangs_on(p: Prepared, residual: Floats) -> Scatter | None:
    """The quantity on which the noise of a run hangs most surely; None if it is the same everywhere.

    ``residual`` (rad, (n,)) is what all effects leave.
    """
    use = p.used
    sweeps, sweep = np.unique(p.sweep[use], return_inverse=True)
    if sweeps.size < FEWEST_SWEEPS:
        return None
    cell = sweep * (int(p.sector.max()) + 1) + p.sector[use]
    _, cell = np.unique(cell, return_inverse=True)
    count = np.bincount(cell)
    full = count >= FEWEST_SAMPLES
    if full.sum() < FEWEST_SWEEPS:
        return None
    square = np.bincount(cell, (residual[use] - residual[use].mean()) ** 2) / count
    of_sweep = np.zeros(count.size, dtype=np.int64)
    of_sweep[cell] = sweep
    quantities: dict[str, Floats] = {"speed": np.abs(p.speed_rad_s), "time": p.time_s}
    if p.load_Nm is not None and p.load_Nm.any():
        quantities["load"] = np.abs(p.load_Nm)
    found: list[tuple[float, Scatter]] = []
    for name, values in quantities.items():
        at = (np.bincount(cell, values[use]) / count)[full]
        low, high = np.quantile(at, ENDS)
        log_square, groups = np.log(square[full] + 1e-300), of_sweep[full]
        x = at - at.mean()
        if not x.any() or high <= low:
            continue
        slope = float(x @ log_square / (x @ x))
        rest = x * (log_square - log_square.mean() - slope * x)
        error = float(np.sqrt(np.sum(np.bincount(groups, rest) ** 2))) / float(x @ x)
        ratio = float(np.exp(0.5 * slope * (high - low)))
        if error > 0.0 and abs(slope) / error >= LEAST_ERRORS and max(ratio, 1.0 / ratio) >= LEAST_RATIO:
            middle = float(log_square.mean())
            ends = (np.exp(0.5 * (middle + slope * (end - at.mean()))) for end in (low, high))
            found.append((abs(slope) / error, Scatter(name, *(float(end) for end in ends))))
    return max(found, key=lambda one: one[0])[1] if found else None
