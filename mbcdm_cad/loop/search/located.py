"""Find again the time of an event that happens once, such as a slip.

A fit moves this time only a little, because the prediction hardly depends on a time that is far from the event.
"""

from __future__ import annotations

import numpy as np

from mbcdm_cad.loop.search.fit import Fit, Fitter


def located(fitter: Fitter, fit: Fit) -> Fit | None:
    """A fit of the same effects that starts with each event where the residual without it shows it best.

    ``fitter`` may hold other samples than those of ``fit``. None if the effects cannot be simulated there.
    """
    values = list(fit.values)
    for k, effect in enumerate(fit.effects):
        if not effect.once:
            continue
        rest = [j for j in range(len(values)) if j != k]
        less = fitter.fit([fit.effects[j] for j in rest], [values[j] for j in rest], fit.offsets, fresh=False)
        guess = np.array(effect.first_guesses(fitter.base[0], less.residual[fitter.parts[0]])[0])
        values[k] = np.where(guess != 0.0, guess, values[k])
    return fitter.tried(fit.effects, values, fit.offsets)
