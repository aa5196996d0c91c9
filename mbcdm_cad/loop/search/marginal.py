"""Marginal likelihood (evidence) of a linear-Gaussian model at a nonlinear fit, for few readings.

The density of the readings with all coefficients integrated out over their priors: it falls with each coefficient that
the readings did not need (Occam factor). D. J. C. MacKay, Neural Computation 4 (1992) 415-447.
"""

from __future__ import annotations

import numpy as np

from mbcdm_cad.routes import Floats

# Steps of the noise over which it is integrated.
NOISES = 40


def log_evidence(rest: Floats, columns: Floats, lost: int, floor: float, most: float, known: int) -> float:
    """Logarithm of the evidence of readings, without what is common to all models of them.

    ``rest`` (n,): the readings without what has no prior; ``columns`` (n, k): what one standard deviation of each prior
    does. The noise is white, the logarithm of its RMS uniform up to ``most``; ``known`` degrees of freedom of repeated
    readings found it to be ``floor``, 0 where these say nothing of it; ``lost``: degrees of freedom that means took.
    """
    axes, sizes, _ = np.linalg.svd(columns, full_matrices=False)
    along = axes.T @ rest
    beyond, freedom = max(float(rest @ rest - along @ along), 0.0), rest.size - lost
    variances = np.geomspace(0.5 * floor, max(most, 2.0 * floor), NOISES)[:, None] ** 2
    spread = np.log1p(sizes**2 / variances).sum(axis=1) + freedom * np.log(variances[:, 0])
    spread = spread + known * (np.log(variances[:, 0]) + floor**2 / variances[:, 0]) if known else spread
    squares = (along**2 / (sizes**2 + variances)).sum(axis=1) + beyond / variances[:, 0]
    return float(np.logaddexp.reduce(-0.5 * (spread + squares)))
