"""Test whether all sweeps and sectors support an effect, or only one of them.

An error at one angle, or in one sweep, can be fitted well by effects that are not present: a few ripples form a bump.
In that case the fit changes when one sector, or one sweep, is left out.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from mbcdm_cad.loop.prepare.lines import line_of
from mbcdm_cad.loop.prepare.noise import Noise, noise_of
from mbcdm_cad.loop.prepare.prepared import SECTORS
from mbcdm_cad.loop.search.clusters import Separation, cluster_estimate, clustered_deviation, separated, separation
from mbcdm_cad.loop.search.fit import Fit, Fitter
from mbcdm_cad.routes import Floats

# Probability of a chance effect, over all candidates that were looked at.
ALPHA = 0.05


def chance(fitter: Fitter, fit: Fit) -> float:
    """Probability that the last effect of ``fit`` was found by chance.

    A Wald test of its sizes with all else fitted too, by leaving out sweeps and sectors; linearised at the fit.
    """
    mask = fitter.train
    columns = fitter.centred_on(mask, fit.jacobian)
    sizes = [value.size for value in fit.values]
    start = sum(sizes[:-1])
    last = fit.effects[-1]
    tested = [start + i for i, parameter in enumerate(last.parameters) if parameter.role == "size"]
    theta = np.zeros(columns.shape[1])
    theta[tested] = [fit.values[-1][i - start] for i in tested]
    y = fit.residual[mask] + columns @ theta
    if not (np.isfinite(columns).all() and np.isfinite(y).all()):
        # A fit at the edge of what can be simulated has slopes that are not finite, and nothing can support it.
        return 1.0
    found = cluster_estimate(columns, y, fitter.sweep[mask], fitter.sector[mask])
    # With so few half sweeps no effect could pass this test; there the rule on the held-out error decides alone.
    return replace(found, freedom=max(found.freedom, SECTORS - 1)).probability(tested)


def noise_left(fitter: Fitter, fit: Fit) -> Noise:
    """The noise in the residual of a fit."""
    return noise_of(fitter.base, [fit.residual[part] for part in fitter.parts])


def separation_of(fitter: Fitter, worse: Fit, better: Fit) -> Separation:
    """How well the data separate two fits."""
    used = fitter.used
    here = better.residual[used]
    return separation(-here, -worse.residual[used], here, fitter.sweep[used], fitter.sector[used])


def log_odds(fitter: Fitter, worse: Fit, better: Fit) -> float:
    """Logarithm of the odds of the better of two fits, both equally likely before."""
    excess = float(np.sum((worse.residual**2 - better.residual**2)[fitter.used]))
    return separation_of(fitter, worse, better).log_odds(excess)


def chance_without_slope(fitter: Fitter, less: Fit, fit: Fit) -> float:
    """Probability that noise makes ``fit`` differ so from ``less``, the fit without one effect.

    For an effect whose size has no slope: a pulley that does not reach the far face of its play fits equally well with
    any larger play. So the change of the prediction is tested, against the noise that the effect leaves: white and
    coloured noise along that change, and what whole sweeps and sectors show if that is more.
    """
    used = fitter.used
    change = (less.residual - fit.residual)[used]
    square = float(change @ change)
    noise = noise_left(fitter, fit)
    samples = 1.0 + 2.0 * noise.memory_s / min(p.step_s for p in fitter.runs)
    along = np.sqrt(square * (noise.white_rad**2 + samples * noise.coloured_rad**2))
    clusters = clustered_deviation(change * fit.residual[used], fitter.sweep[used], fitter.sector[used])
    return separated(square, max(float(along), clusters)).probability


def supported(fitter: Fitter, less: Fit, fit: Fit, candidates: int) -> bool:
    """Whether sweeps and sectors support the last effect of ``fit`` (``less``: without it), one of so many
    candidates."""
    if fit.effects[-1].saturates:
        return chance_without_slope(fitter, less, fit) <= ALPHA / max(candidates, 1)
    order = fit.effects[-1].order_index
    if order is not None and not is_line(fitter, less, float(fit.values[-1][order])):
        return False
    return chance(fitter, fit) <= ALPHA / max(candidates, 1)


def is_line(fitter: Fitter, less: Fit, order: float) -> bool:
    """Whether the residual without the effect has a steady line of this order in every sector."""
    mask = fitter.train
    angle: Floats = np.concatenate([setup.drum_rad for setup in fitter.base])
    return line_of(order, angle[mask], less.residual[mask], fitter.sweep[mask]).is_line
