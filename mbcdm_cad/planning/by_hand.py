"""What readings by hand, or a chirp, could find: the smallest size of each effect, by the tests of the loop on them.

The slopes are those at size zero, so valid for small effects. The F test on the readings that are not held back must
find the effect with the plan's power, and the readings held back must show it as the loop asks.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.optimize import brentq
from scipy.stats import chi2, ncf, norm
from scipy.stats import f as f_distribution

from mbcdm_cad.design.drive import Drive
from mbcdm_cad.loop.effect import Effect
from mbcdm_cad.loop.search.evidence import LOG_ODDS
from mbcdm_cad.loop.search.few import PLAY, FewReadings, prepared_by_hand
from mbcdm_cad.loop.search.few_words import CHANCE
from mbcdm_cad.loop.search.response import ResponseLoop, Suspect
from mbcdm_cad.loop.search.select import LEAST_FALL
from mbcdm_cad.measurement.run import Run
from mbcdm_cad.measurement.vet import arranged
from mbcdm_cad.model.si import to_si
from mbcdm_cad.routes import Floats

# Noncentrality beyond which nothing is looked for.
MOST_STRENGTH = 1e6


class PlannedReadings:
    """Readings by hand that are planned, or were made, on a drive."""

    def __init__(self, drive: Drive, run: Run) -> None:
        d = to_si(drive)
        ratio = float(np.mean(d.total_ratio))
        self.few = FewReadings(d, ratio, [prepared_by_hand(arranged(run, drive), ratio)], drive.as_built)
        self.effects = [e for e in self.few.library if not e.unmeasured]

    def slopes(self, effect: Effect) -> Floats | None:
        """Derivatives of the prediction by the sizes of an effect, on all samples (n, k); None if nothing shows."""
        if self.few.loses_track or (effect.name == PLAY and self.few.hides_play):
            return None
        f, sizes = self.few.fitter, [p.role == "size" for p in effect.parameters]
        for start in f.guesses(effect, self.few.bare.residual):
            values = np.where(sizes, 0.0, start)
            slopes = f.fit((effect,), (values,), iterations=0).jacobian[:, sizes]
            if np.all(np.linalg.norm(f.centred_on(f.train, slopes), axis=0) > 0.0):
                return slopes
        return None

    def smallest(self, effect: Effect, slopes: Floats, floor_rad: float, power: float) -> float:
        """The smallest size that is named with this power, whatever its phase; infinite if the readings are too few."""
        f = self.few.fitter
        n, test = int(f.train.sum()), int(f.test.sum())
        extra = len(effect.parameters)
        freedom = n - extra - 1
        if freedom < 1 or not test:
            return np.inf
        limit = float(f_distribution.isf(CHANCE / len(self.few.library), extra, freedom))

        def lacks(strength: float) -> float:
            return float(ncf.sf(limit, extra, freedom, strength)) - power

        if lacks(MOST_STRENGTH) < 0.0:
            return np.inf
        strength = float(brentq(lacks, 1e-6, MOST_STRENGTH))
        _, lengths, phases = np.linalg.svd(f.centred_on(f.train, slopes), full_matrices=False)
        found = np.sqrt(strength) / lengths[-1]
        sure = float(norm.isf(1.0 - power)) / np.sqrt(test)
        held = float(np.sqrt(np.mean((f.centred(slopes, f.train)[f.test] @ phases[-1]) ** 2)))
        shown = (sure + np.sqrt(sure**2 + LEAST_FALL**2)) / held if held else np.inf
        return floor_rad * float(max(found, shown))

    def apart(self, one: Floats, other: Floats, floor_rad: float, power: float) -> float:
        """The size from which an effect of slopes ``one`` is told from another with the loop's odds."""
        f = self.few.fitter
        mine, its = (f.centred_on(f.used, columns) for columns in (one, other))
        basis = np.linalg.qr(its)[0]
        _, lengths, phases = np.linalg.svd(mine, full_matrices=False)
        left = mine @ phases[-1]
        left = left - basis @ (basis.T @ left)
        needed = np.sqrt(2.0 * LOG_ODDS) + float(norm.isf(1.0 - power))
        length = float(np.linalg.norm(left))
        return needed * floor_rad / length if length > 1e-9 * float(lengths[-1]) else np.inf


def sizes_by_hand(
    planned: PlannedReadings, floor_rad: float, power: float
) -> Sequence[tuple[Effect, float, list[tuple[Effect, float]]]]:
    """Each effect with its smallest size, and the size from which each other one is told from it, largest first."""
    slopes = {e: s for e in planned.effects if (s := planned.slopes(e)) is not None}
    found = list[tuple[Effect, float, list[tuple[Effect, float]]]]()
    for effect in planned.effects:
        if effect not in slopes:
            found.append((effect, np.inf, []))
            continue
        least = planned.smallest(effect, slopes[effect], floor_rad, power)
        rivals = [
            (other, planned.apart(slopes[effect], its, floor_rad, power))
            for other, its in slopes.items()
            if other.key != effect.key
        ]
        found.append((effect, least, sorted(rivals, key=lambda rival: -rival[1])))
    return found


def sizes_of_response(loop: ResponseLoop, power: float) -> Sequence[tuple[Suspect, float, list[tuple[str, float]]]]:
    """Each suspect of a frequency response with its smallest size, and the size from which it is told from each other
    one and from what the design's structure and the declared inertia may be wrong by, largest first."""
    free, columns = loop.slopes()
    basis, sure = np.linalg.qr(free)[0], float(norm.isf(1.0 - power))
    left = {name: column - basis @ (basis.T @ column) for name, column in columns.items()}
    # The F test has the averages that are not held back, the odds have all.
    found = (float(np.sqrt(chi2.isf(CHANCE / len(loop.suspects), 1))) + sure) / float(np.sqrt(np.mean(~loop.test)))
    apart, scale = np.sqrt(2.0 * LOG_ODDS) + sure, float(np.sqrt(loop.together))
    result = []
    for one in loop.suspects:
        mine = left[one.parameter]
        # Named by the F test, and by the error that is held back; beyond what the law, the slip and the sensors may do.
        bare = max(found * scale, LEAST_FALL * float(np.sqrt(mine.size))) / float(np.linalg.norm(mine) + 1e-300)
        least = max(_beside(mine, left[name], bare, 2.0 * sigma) for name, sigma in loop.prior.items())
        rivals = []
        for name, (_, _, most) in loop.tolerances.items():
            if name == one.parameter:
                least += most
            else:
                rivals.append((f"{name} within its figures", _beside(mine, left[name], bare, most)))
        for other in loop.suspects:
            if other.name != one.name:
                alone = _without(mine, left[other.parameter])
                rivals.append((other.label, apart * scale / float(np.linalg.norm(alone) + 1e-300)))
        result.append((one, least, sorted(rivals, key=lambda rival: -rival[1])))
    return result


def _without(mine: Floats, its: Floats) -> Floats:
    """What another slope leaves of one."""
    return np.asarray(mine - its * float(its @ mine) / (float(its @ its) + 1e-300))


def _beside(mine: Floats, its: Floats, bare: float, most: float) -> float:
    """The size beside a figure that may be wrong by ``most``, or by anything that the response itself shows; ``bare``
    that without it."""
    square, alone = float(mine @ mine) + 1e-300, float(np.linalg.norm(_without(mine, its))) + 1e-300
    return min(bare + most * abs(float(its @ mine)) / square, bare * float(np.sqrt(square)) / alone)
