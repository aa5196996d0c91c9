"""When a change happened: the times at which it explains the run nearly as well, from the likelihood of each.

The prediction depends on the time only through the samples between two times, so its slope says nothing. The sum of
squares is compared instead with the noise that is left, white and coloured.
"""

from __future__ import annotations

import numpy as np

from mbcdm_cad.loop.effect import Effect
from mbcdm_cad.loop.search.evidence import noise_left
from mbcdm_cad.loop.search.fit import Fit, Fitter

# Half the square of a normal deviate beyond which 5 % lie: the fall of the log-likelihood at the ends of an interval.
LOG_FALL = 1.92
# First step away from the fitted time, its growth, and the bisections that find the end.
FIRST_S, GROWTH, HALVINGS = 0.02, 1.5, 12


def time_interval_s(fitter: Fitter, fit: Fit, effect: Effect) -> tuple[float, float]:
    """The earliest and the latest time of a change, 95 %, s from the beginning of its run."""
    k = fit.effects.index(effect)
    at = next(i for i, p in enumerate(effect.parameters) if p.role == "place")
    parameter, best = effect.parameters[at], float(fit.values[k][at])
    noise = noise_left(fitter, fit)
    memory = 1.0 + 2.0 * noise.memory_s / min(p.step_s for p in fitter.runs)
    square = noise.white_rad**2 + memory * noise.coloured_rad**2
    used = fitter.used
    least = float(np.sum(fit.residual[used] ** 2))

    def likely(time: float) -> bool:
        values = [v.copy() for v in fit.values]
        values[k][at] = time
        moved = fitter.centred_on(used, fitter.output - fitter.predict(fit.effects, values, fit.offsets))
        return float(np.sum(moved**2)) - least < 2.0 * LOG_FALL * square

    def end(towards: float) -> float:
        inside, step = best, FIRST_S
        while abs(towards - inside) > 0.0:
            outside = inside + np.sign(towards - inside) * min(step, abs(towards - inside))
            if not likely(float(outside)):
                break
            inside, step = float(outside), step * GROWTH
        else:
            return towards
        for _ in range(HALVINGS):
            middle = 0.5 * (inside + float(outside))
            inside, outside = (middle, outside) if likely(middle) else (inside, middle)
        return float(outside)

    # Between two samples nothing tells one time from another.
    step = max(p.step_s for p in fitter.runs)
    return max(parameter.low, end(parameter.low) - step), min(parameter.high, end(parameter.high) + step)
