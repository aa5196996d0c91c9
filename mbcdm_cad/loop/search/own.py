"""Values that runs have for themselves: where their fits begin, their figures, and whether they changed, with odds."""

from collections.abc import Sequence

import numpy as np
from scipy.linalg import helmert

from mbcdm_cad.errors import MbcdmError, did_you_mean
from mbcdm_cad.loop.effect import Effect
from mbcdm_cad.loop.prepare.prepared import Prepared
from mbcdm_cad.loop.result import Differing, OwnValue
from mbcdm_cad.loop.search.account import interval
from mbcdm_cad.loop.search.fit import Fit, Fitter
from mbcdm_cad.model.si import DriveSI
from mbcdm_cad.routes import Floats

# Fields of the design that an effect changes, by the effect's name and form.
FIELDS = {
    "rope.preload_N": ("preload_error", "all cables"),
    "rope.modulus_GPa": ("stiffness_error", "modulus of the rope"),
    "rope.friction_coefficient": ("cable_friction", "rope on pulley"),
}
# Before the data, a change is normal with this many times the effect's typical small size: 10 % of a share.
LIKELY_SIZES = 5.0


def own_effects(names: Sequence[str], offered: Sequence[Effect], run: str) -> list[list[Effect]]:
    """The effects of ``names``, each in its forms: fields of the design, or effects with stage. Raises MbcdmError."""
    found = []
    for name in names:
        key = FIELDS.get(name)
        same = [e for e in offered if ((e.name, e.form) == key if key else _called(e) == name)]
        same = [e for e in same if all(p.role != "order" for p in e.parameters) and not e.once and e.base is None]
        if not same:
            known = [*(f for f, key in FIELDS.items() if any((e.name, e.form) == key for e in offered))]
            known += sorted({_called(e) for e in offered if not e.once and e.base is None and e.order_index is None})
            raise MbcdmError(f"{run}: nothing called {name!r} can differ in this run; {did_you_mean(name, known)}")
        found.append(same)
    return found


def in_best_forms(
    d: DriveSI | None, ratio: float, runs: Sequence[Prepared], forms: Sequence[Sequence[Sequence[Effect]]]
) -> list[list[Effect]]:
    """For each run its own effects: of a design in the first form, else in that which leaves least of the runs that
    have it, each fitted alone."""
    if d is not None:
        return [[same[0] for same in one] for one in forms]

    def left(run: Prepared, effect: Effect) -> float:
        alone = Fitter(d, ratio, [run], (), [[effect]])
        return alone.fit(offsets=begun(alone)).square

    best: dict[tuple[str, ...], str] = {}
    for every in {tuple(e.label for e in same): same for one in forms for same in one if len(same) > 1}:
        sums = dict.fromkeys(every, 0.0)
        for run, one in zip(runs, forms, strict=True):
            for same in (same for same in one if tuple(e.label for e in same) == every):
                for effect in same:
                    sums[effect.label] += left(run, effect)
        best[every] = min(every, key=sums.__getitem__)
    return [
        [next(e for e in same if e.label == best.get(tuple(e.label for e in same), e.label)) for same in one]
        for one in forms
    ]


def _called(effect: Effect) -> str:
    return " ".join(filter(None, (effect.name, effect.stage)))


def begun(fitter: Fitter) -> Floats:
    """Offsets and own values from which the joint fit begins: the best of each run alone, from all of its starts."""
    row = np.zeros(fitter.free.size)
    for k, (run, own) in enumerate(zip(fitter.runs, fitter.own, strict=True)):
        if not own:
            continue
        alone = Fitter(fitter.d, fitter.ratio, [run], fitter.known, [own])
        best = alone.fit()
        at = alone.apart
        for effect in own:
            for guess in alone.guesses(effect, alone.fit().residual if effect.starts else best.residual):
                values = best.offsets.copy()
                values[at : at + len(guess)] = guess
                found = alone.tried((), (), values)
                best = found if found is not None and found.square < best.square else best
            at += len(effect.parameters)
        row[fitter.rows[k]] = best.offsets
    return row


def differing(fitter: Fitter, whole: Fit, covariance: Floats, names: Sequence[Sequence[str]]) -> tuple[Differing, ...]:
    """What each run has for itself, by name. ``whole`` is the fit with the ``covariance`` of its values and offsets;
    ``names`` are those of the effects of each run."""
    if not any(names):
        return ()
    column = np.cumsum(fitter.free) - 1 + whole.width
    found = []
    for name in dict.fromkeys(name for one in names for name in one):
        values, places = [], []
        for k, one in enumerate(names):
            if name not in one:
                continue
            effects = fitter.own[k]
            at = fitter.rows[k].start + fitter.apart
            at += sum(len(e.parameters) for e in effects[: one.index(name)])
            effect = effects[one.index(name)]
            part = slice(at, at + len(effect.parameters))
            columns = column[part]
            block = covariance[np.ix_(columns, columns)]
            figures = {f.name: interval(f, whole.offsets[part], block, effect) for f in effect.reported()}
            run = fitter.runs[k].run
            values.append(OwnValue(k, run.source or f"run {k + 1}", whole.offsets[part], figures))
            places.append(np.arange(part.start, part.stop))
        rows = np.concatenate(places)
        joint = covariance[np.ix_(column[rows], column[rows])]
        likely = np.concatenate([[LIKELY_SIZES * p.size for p in effect.parameters]] * len(values))
        every = len(values) == len(names)
        odds = log_odds_of_change(np.concatenate([v.values for v in values]), joint, likely, len(values), every)
        found.append(Differing(name, effect.form, tuple(values), joint, odds, every))
    return tuple(found)


def log_odds_of_change(values: Floats, covariance: Floats, likely: Floats, runs: int, among_themselves: bool) -> float:
    """Logarithm of the odds that the values of ``runs`` runs, (runs * k,), are not all the same; even before the data.

    The same: all equal, at any value, or, unless ``among_themselves``, all zero, which is what the other runs have. Not
    the same: each moved by a normal deviate of the standard deviation ``likely``.
    """
    if among_themselves:  # what they have in common says nothing
        contrasts = np.kron(helmert(runs), np.eye(values.size // runs))
        values, likely = contrasts @ values, likely[: contrasts.shape[0]]
        covariance = contrasts @ covariance @ contrasts.T

    def log_likelihood(spread: Floats) -> float:
        scaled = spread / np.outer(likely, likely)
        return -0.5 * float(
            values / likely @ np.linalg.solve(scaled, values / likely) + np.linalg.slogdet(scaled).logabsdet
        )

    return log_likelihood(covariance + np.diag(likely**2)) - log_likelihood(covariance)
