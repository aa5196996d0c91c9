"""The search by evidence as a judge of a run, beside the loop's own: what it finds, as a result file has it.

    python -m benchmarks.judge --rival --workers 2          # the part of the table that continuous integration judges
    python -m benchmarks.judge --rival --only "rig one"

It is not used by the package. It decides by marginal likelihood (:mod:`mbcdm_cad.loop.search.marginal`) where the loop has
rules, is judged by the same runs, and is to replace the loop's selection, exchange and verdict when no class of
benchmarks/judge.jsonl is worse. What is known to be missing:

- A late input with a friction: both are found, and withdrawn beside an unknown.
- An error that goes with the square of the speed: plain curves have to be candidates without a name.
- CPU time, most of it in the screening.
- Odds saturate at 0 or 1 and are not calibrated.
- Several runs, own values of runs that differ, tables by hand and frequency responses are not covered.

Two rules stay that no evidence can say: an effect below the least size is not named, since a microradian of everything
is in every run, and a name is withdrawn beside an unknown a quarter as large, which may contain it.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
from threadpoolctl import threadpool_limits

from mbcdm_cad.design.drive import Drive
from mbcdm_cad.layouts.registry import layout_of
from mbcdm_cad.loop.effect import Effect
from mbcdm_cad.loop.effects import friction, library
from mbcdm_cad.loop.prepare.prepared import prepare_all
from mbcdm_cad.loop.search.account import as_named, errors
from mbcdm_cad.loop.search.by_evidence import LEAST_FALL, LOG_ODDS, Search
from mbcdm_cad.loop.search.fit import Fit, Fitter
from mbcdm_cad.loop.search.verdict import BLAME_SHARE
from mbcdm_cad.measurement.run import Run
from mbcdm_cad.measurement.vet import arranged


def close_by_evidence(drive: Drive, run: Run) -> dict[str, Any]:
    """What the search finds in a log of a motion: the fields of a result file that are judged, and the ``probability``
    of each name."""
    d = layout_of(drive).si
    ratio = float(np.mean(d.total_ratio))
    with threadpool_limits(1, "blas"):
        prepared = prepare_all([arranged(run, drive)], ratio)[0][0]
        fitter = Fitter(d, ratio, [prepared], drive.as_built)
        wound = friction.NAME, friction.WOUND
        search = Search(fitter, [e for e in library(d, prepared) if (e.name, e.form) != wound], fitter.fit())
        return _result(search)


def _result(search: Search) -> dict[str, Any]:
    """Search, withdraw what is too small or may be a part of the unknown, tell the rest."""
    fit, sets = search.found()
    least_rad = LEAST_FALL * search.floor_rad
    kept = fit
    while True:
        certain, unknown_rad = search.of(kept).unknown_odds > LOG_ODDS, search.unknown_rad(kept)
        falls = {e: _fall_rad(search, kept, e) for e in kept.effects}
        least = {e: max(least_rad, unknown_rad / BLAME_SHARE if certain else 0.0) for e in falls}
        small = min(falls, key=lambda e: falls[e] / least[e], default=None)
        if small is None or falls[small] >= least[small]:
            break
        kept = search.without(kept, small)
    unknown_rad = search.unknown_rad(kept)
    effects: list[dict[str, Any]] = []
    one_of: list[list[dict[str, Any]]] = []
    for one in sets:
        if one.effect not in kept.effects:
            continue
        first = _named(search, fit, one.effect, one.probability, one.forms)
        others = [_named(search, other, other.effects[-1], share) for other, share in one.alike]
        if others:
            one_of.append([first, *others])
        else:
            effects.append(first)
    unknown = unknown_rad > least_rad and search.of(kept).unknown_odds > LOG_ODDS
    words = ("partly_explained", "explained") if effects or one_of else ("unknown", "none")
    return {
        "verdict": words[0] if unknown else words[1],
        "effects": effects,
        "one_of": one_of,
        "unknown": {"rms_rad": unknown_rad} if unknown else None,
        "error": errors(search.fitter, search.bare, fit, search.floor_rad).to_json(),
    }


def _fall_rad(search: Search, fit: Fit, effect: Effect) -> float:
    """By how much an effect lowers the error, rad RMS: the root of the fall of the mean square."""
    less = search.without(fit, effect)
    return float(np.sqrt(max(0.0, np.mean(less.residual[search.used] ** 2 - fit.residual[search.used] ** 2))))


def _named(search: Search, fit: Fit, effect: Effect, probability: float, forms: tuple[str, ...] = ()) -> dict[str, Any]:
    """An effect of a fit with the mean and the 95 % intervals of its posterior, all nuisances integrated out; places
    keep their fit."""
    evidence, own = search.of(fit), fit.columns_of(effect)
    sizes = [p.role == "size" for p in effect.parameters]
    values = np.where(sizes, evidence.mean[own], fit.values_of(effect))
    found = as_named(effect, values, evidence.covariance[own, own], _fall_rad(search, fit, effect), "")
    return replace(found, equivalent=forms).to_json() | {"probability": probability}
