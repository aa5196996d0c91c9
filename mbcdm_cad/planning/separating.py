"""Find the run that separates the members of a set, before it is made.

Each member is put into the planned run with the size that was found, and each other member is fitted to its change by
one linear step. The part that cannot be imitated is compared with the noise: the probability to choose the wrong one is
Phi(-|d| / (2 sigma)) for a difference d (see ``clusters``).
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.stats import norm

from mbcdm_cad.design.drive import Drive
from mbcdm_cad.loop.effect import Effect
from mbcdm_cad.loop.effects import library
from mbcdm_cad.loop.prepare.noise import Noise
from mbcdm_cad.loop.result import Named
from mbcdm_cad.loop.search.exchange import ALIKE_SHARE
from mbcdm_cad.loop.search.fit import Fit, Fitter
from mbcdm_cad.measurement.run import Run
from mbcdm_cad.model.si import ModelError
from mbcdm_cad.planning.colour import along
from mbcdm_cad.planning.planned import planned_fitter, without_offsets
from mbcdm_cad.routes import Floats


def wrong_choice(drive: Drive, run: Run, members: Sequence[Named], noise: Noise, step_s: float) -> float:
    """Probability of a wrong choice between the two of ``members`` that ``run`` separates worst, 0 to 0.5.

    ``step_s`` is the time between samples of the run to be made; ``run`` may have fewer samples. The result is also 0.5
    where the run does not show one of them at all, or cannot be simulated with it.
    """
    fitter = planned_fitter(drive, run)
    bare = fitter.fit()
    offered = library(fitter.d, fitter.runs[0])
    found = [_changes(fitter, bare, effect, one, noise) for one in members if (effect := _effect_of(one, offered))]
    if len(found) < len(members) or any(one is None for one in found):
        return 0.5
    worst = 0.0
    for k, one in enumerate(found):
        for j, other in enumerate(found):
            if j != k and one is not None and other is not None:
                worst = max(worst, _mistaken(one[0], other[1], noise, (fitter.runs[0].step_s, step_s)))
    return worst


def _effect_of(named: Named, offered: Sequence[Effect]) -> Effect | None:
    """The effect of the library that was named; None where the run does not allow it."""
    key = named.name, named.stage, named.cables
    return next((effect for effect in offered if effect.key == key and effect.form == named.form), None)


def _changes(fitter: Fitter, bare: Fit, effect: Effect, named: Named, noise: Noise) -> tuple[Floats, Floats] | None:
    """Change by the effect at the size that was found, (n,), and its derivatives there (n, k), without offsets."""
    at = np.array([named.fitted[parameter.name] for parameter in effect.parameters])
    try:
        there = fitter.predict([effect], [at], bare.offsets)
        rows = [there - fitter.predict([effect], [0.0 * at], bare.offsets)]
        for k, parameter in enumerate(effect.parameters):
            moved = at.copy()
            moved[k] += 0.1 * parameter.size
            rows.append((fitter.predict([effect], [moved], bare.offsets) - there) / (0.1 * parameter.size))
    except ModelError:
        return None
    columns = without_offsets(fitter, bare, np.stack(rows, axis=1), noise)
    return columns[:, 0], columns[:, 1:]


def _mistaken(change: Floats, slopes: Floats, noise: Noise, steps_s: tuple[float, float]) -> float:
    """Probability to confuse an effect with these ``slopes`` with one that makes this ``change``.

    ``steps_s``: time between these samples, and between those of the run to be made.
    """
    size = np.linalg.norm(slopes, axis=0)
    kept = slopes[:, size > 0.0] / size[size > 0.0]
    left = change - kept @ np.linalg.lstsq(kept, change, rcond=1e-8)[0] if kept.shape[1] else change
    rms = float(np.sqrt(np.mean(left**2)))
    # So small a difference may be an error of the model: the loop treats it as none.
    if rms < ALIKE_SHARE * noise.total_rad:
        return 0.5
    return float(norm.sf(0.5 * rms * np.sqrt(left.size / along(left, noise, *steps_s)) / noise.total_rad))
