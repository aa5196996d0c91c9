"""Parameters as value and sigma: backlash and torque with an interval, by Monte Carlo and by linear theory beside."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from mbcdm_cad.model.bulk import BulkFigures, Requirements, analyse_many
from mbcdm_cad.model.errors import ModelError
from mbcdm_cad.model.si import DriveSI, Floats

# What may carry a sigma, and which field of the drive or of the requirements it changes.
PARAMETERS = (
    "preload_N", "friction_coefficient", "modulus_Pa", "centre_distance_m", "load_Nm", "input_rating_Nm",
)  # fmt: skip
STEP_SIGMA = 0.1


@dataclass(frozen=True)
class Interval:
    """A figure, its 95 % interval by Monte Carlo, and the standard deviation by Monte Carlo and by linear theory."""

    value: float
    low: float
    high: float
    sigma: float
    linear_sigma: float


def figures_of(bulk: BulkFigures) -> dict[str, Floats]:
    """The figures that carry an interval, each (n,): rad and N m."""
    return {
        "turn_rad": np.abs(bulk.turn_rad[0]),
        "reversal_swing_rad": bulk.reversal_swing_rad,
        "peak_torque_plus_Nm": bulk.peak_torque_Nm[0],
        "peak_torque_minus_Nm": bulk.peak_torque_Nm[1],
    }


def intervals(
    d: DriveSI, need: Requirements, sigma: Mapping[str, float], draws: int = 20_000, seed: int = 0
) -> dict[str, Interval]:
    """Intervals of backlash and torque for one design whose parameters are normal with standard deviations ``sigma``.

    Keys of ``sigma`` are among ``PARAMETERS``, in their SI units; each preload is drawn on its own. Draws that make no
    drive (no free span, friction not above zero) are left out. Errors: ``ModelError`` for an unknown name, a negative
    sigma, or if more than 1 % of the draws make no drive.
    """
    for name, size in sigma.items():
        if name not in PARAMETERS:
            raise ModelError(f"sigma of {name!r}: no such parameter; use one of {', '.join(PARAMETERS)}")
        if not size >= 0.0:
            raise ModelError(f"sigma of {name}: {size:g} is below 0")
    rng = np.random.default_rng(seed)
    shape = {name: (d.n_cables, draws) if name == "preload_N" else (draws,) for name in sigma}
    drawn = analyse_many(*_shifted(d, need, {k: sigma[k] * rng.standard_normal(shape[k]) for k in sigma}, draws))
    lost = 1.0 - float(np.mean(drawn.valid))
    if lost > 0.01:
        raise ModelError(
            f"{lost:.0%} of the draws have no free span or no friction; the sigmas are too wide for a normal law"
        )
    # Columns: the middle, then each parameter (each preload) a little up and a little down.
    steps = [(k, j) for k in sigma for j in (range(d.n_cables) if k == "preload_N" else (0,))]
    shift = {k: np.zeros((d.n_cables, 1 + 2 * len(steps)) if k == "preload_N" else 1 + 2 * len(steps)) for k in sigma}
    for at, (name, j) in enumerate(steps):
        row = shift[name][j] if name == "preload_N" else shift[name]
        row[1 + 2 * at], row[2 + 2 * at] = STEP_SIGMA * sigma[name], -STEP_SIGMA * sigma[name]
    around = figures_of(analyse_many(*_shifted(d, need, shift, 1 + 2 * len(steps))))
    found = {}
    for name, values in figures_of(drawn).items():
        values = values[drawn.valid]
        low, high = np.quantile(values, [0.025, 0.975])
        slopes = (around[name][1::2] - around[name][2::2]) / (2 * STEP_SIGMA)
        found[name] = Interval(
            float(around[name][0]), float(low), float(high), float(values.std()), float(np.sqrt((slopes**2).sum()))
        )
    return found


def _shifted(d: DriveSI, need: Requirements, shift: Mapping[str, Any], n: int) -> tuple[DriveSI, Requirements]:
    fields, asked = {}, {}
    for name, change in shift.items():
        if hasattr(need, name):
            asked[name] = np.asarray(getattr(need, name)) + change
        else:
            base = getattr(d, name)
            fields[name] = (base[:, None] if name == "preload_N" else base) + change
    return d.spread(n).with_(**fields), Requirements(**(vars(need) | asked))
