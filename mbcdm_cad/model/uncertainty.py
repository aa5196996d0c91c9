"""Intervals of backlash and torque for parameters with a sigma, by Monte Carlo and by linear theory."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from mbcdm_cad.model.bulk import BulkFigures, Requirements, analyse_many
from mbcdm_cad.model.errors import ModelError
from mbcdm_cad.model.si import DriveSI
from mbcdm_cad.routes import Floats

# Parameters that may have a sigma besides the geometry's lengths, and the field of the drive or requirements of each.
PARAMETERS = ("friction_coefficient", "modulus_Pa", "area_m2", "load_Nm", "input_rating_Nm")
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
    """The figures of the whole drive that carry an interval, each (n,): rad and N m."""
    return {
        "turn_rad": np.abs(bulk.turn_rad[0]),
        "reversal_swing_rad": bulk.reversal_swing_rad,
        "peak_torque_plus_Nm": bulk.peak_torque_Nm[0],
        "peak_torque_minus_Nm": bulk.peak_torque_Nm[1],
    }


def by_cable(d: DriveSI) -> tuple[str, ...]:
    """Names of the parameters that are drawn for each cable independently."""
    return ("preload_N", *d.geometry.per_cable)


def parameters(d: DriveSI) -> tuple[str, ...]:
    """Names of all parameters of this drive that may have a sigma."""
    return (*by_cable(d), *PARAMETERS, *(v.name for v in d.geometry.varied))


def _all_figures(bulk: BulkFigures, cables: tuple[str, ...]) -> dict[str, Floats]:
    each = {f"backlash_{name}_rad": row for name, row in zip(cables, bulk.cable_backlash_rad, strict=True)}
    return each | figures_of(bulk)


def intervals(
    d: DriveSI, need: Requirements, sigma: Mapping[str, Any], draws: int = 20_000, seed: int = 0
) -> dict[str, Interval]:
    """Intervals of backlash and torque for one design whose parameters are normal with standard deviations ``sigma``.

    Keys of ``sigma`` are among :func:`parameters`, in their SI units; those :func:`by_cable` take one value or one
    for each cable, and are drawn for each cable independently. Impossible draws (no free span, friction not above zero)
    are left out. Raises ``ModelError`` for an unknown name, a negative sigma, or if over 1 % of the draws are
    impossible.
    """
    sizes: dict[str, Floats] = {}
    known, own = parameters(d), by_cable(d)
    for name, given in sigma.items():
        if name not in known:
            raise ModelError(f"sigma of {name!r}: no such parameter; use one of {', '.join(known)}")
        # One row a cable where each is drawn on its own, else one row.
        sizes[name] = np.array(np.broadcast_to(given, (d.n_cables if name in own else 1,)), dtype=float)
        if not np.all(sizes[name] >= 0.0):
            raise ModelError(f"sigma of {name}: {np.min(sizes[name]):g} is below 0")
    rng = np.random.default_rng(seed)
    random = {k: size[:, None] * rng.standard_normal((size.size, draws)) for k, size in sizes.items()}
    drawn = analyse_many(*_shifted(d, need, random, draws))
    lost = 1.0 - float(np.mean(drawn.valid))
    if lost > 0.01:
        raise ModelError(
            f"{lost:.0%} of the draws have no free span or no friction (limit 1 %): the sigmas are too wide for a "
            "normal law; lower those of centre distance, radii or friction"
        )
    # Columns: nominal, then each parameter (of each cable) a small step up and a small step down.
    steps = [(k, row) for k, size in sizes.items() for row in range(size.size)]
    shift = {k: np.zeros((size.size, 1 + 2 * len(steps))) for k, size in sizes.items()}
    for at, (name, row) in enumerate(steps):
        step = STEP_SIGMA * sizes[name][row]
        shift[name][row, 1 + 2 * at], shift[name][row, 2 + 2 * at] = step, -step
    around = _all_figures(analyse_many(*_shifted(d, need, shift, 1 + 2 * len(steps))), d.cable_names)
    found = {}
    for name, values in _all_figures(drawn, d.cable_names).items():
        values = values[drawn.valid]
        low, high = np.quantile(values, [0.025, 0.975])
        slopes = (around[name][1::2] - around[name][2::2]) / (2 * STEP_SIGMA)
        found[name] = Interval(
            float(around[name][0]), float(low), float(high), float(values.std()), float(np.sqrt((slopes**2).sum()))
        )
    return found


def _shifted(d: DriveSI, need: Requirements, shift: Mapping[str, Floats], n: int) -> tuple[DriveSI, Requirements]:
    fields, asked = {}, {}
    own = by_cable(d)
    for name, change in shift.items():
        if name in own:
            fields[name] = d.value(name)[:, None] + change
        elif hasattr(need, name):
            asked[name] = np.asarray(getattr(need, name)) + change[0]
        else:
            fields[name] = d.value(name) + change[0]
    return d.spread(n).with_(**fields), Requirements(**(vars(need) | asked))
