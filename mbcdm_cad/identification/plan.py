"""Predict the finding of a planned run: the smallest size of each effect that is named, and its rivals.

The same Jacobians as in the loop, on the planned motion and load. An effect is named if it lowers the error of held-out
half sweeps by ``LEAST_FALL`` of the noise and is supported by all sweeps and sectors; two effects are separated if the
part of one that the other cannot imitate is above the noise. Linear in the sizes, so valid for small effects.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.stats import f as f_distribution
from scipy.stats import norm

from mbcdm_cad.design.drive import Drive
from mbcdm_cad.identification.effect import Effect
from mbcdm_cad.identification.effects import library
from mbcdm_cad.identification.evidence import ALPHA
from mbcdm_cad.identification.exchange import ALIKE_SHARE
from mbcdm_cad.identification.fit import Fit, Fitter
from mbcdm_cad.identification.noise import Noise, noise_of
from mbcdm_cad.identification.prepared import SECTORS, Prepared, prepare
from mbcdm_cad.identification.result import readable
from mbcdm_cad.identification.select import LEAST_FALL
from mbcdm_cad.measurement.run import Run
from mbcdm_cad.measurement.vet import arranged
from mbcdm_cad.model.errors import ModelError
from mbcdm_cad.model.si import to_si
from mbcdm_cad.routes import Floats

POWER = 0.9
# t^2 (1 - rho) from which a wrong choice between two effects is less likely than 1 %.
TOLD_STRENGTH = 10.9
# Orders of ripple that are planned, cycles a turn of the output.
ORDERS = (20.0, 200.0)
# A rival is listed if the effect can be confused with it up to so many times its smallest named size; worst first.
MOST_RIVALS = 4
ANY_SIZE = 1e3
# An effect that would have to be so many times its typical size, or beyond its bound, is never seen in the run.
NEVER = 1e4


@dataclass(frozen=True)
class Rival:
    """Another effect that fits as well up to ``from_size`` (in the unit of the effect's own size; None: at any
    size)."""

    label: str
    from_size: float | None


@dataclass(frozen=True)
class Foreseen:
    """One effect: the smallest size that is named with the plan's power; None if the run cannot show it."""

    label: str
    parameter: str
    smallest: float | None
    rivals: tuple[Rival, ...]


@dataclass(frozen=True, eq=False)
class _Tried:
    """One effect at one place: the derivatives by its sizes on all used samples (n, k), without what offsets explain,
    and an orthonormal basis of them."""

    effect: Effect
    label: str
    columns: Floats
    basis: Floats


@dataclass(frozen=True)
class RunPlan:
    """What a planned run can find, with the noise that was assumed."""

    noise: Noise
    effects: tuple[Foreseen, ...]
    power: float = POWER

    def to_json(self) -> dict[str, Any]:
        """For a file."""
        return {"power": self.power, "noise": self.noise.to_json(), "effects": [asdict(one) for one in self.effects]}

    def text(self) -> str:
        """For the terminal."""
        width = max(len(one.label) for one in self.effects)
        lines = [
            f"noise floor {1e6 * self.noise.total_rad:.3g} urad ({self.noise.source})",
            "",
            f"{'effect':<{width}}  {f'named from (power {self.power:g})':<34}  not told from, below",
        ]
        for one in self.effects:
            rivals = "; ".join(f"{rival.label}: {_words(one.parameter, rival.from_size)}" for rival in one.rivals)
            size = "this run cannot show it" if one.smallest is None else _words(one.parameter, one.smallest)
            lines.append(f"{one.label:<{width}}  {size:<34}  {rivals}".rstrip())
        return "\n".join(lines)


def _words(parameter: str, size: float | None) -> str:
    if size is None:
        return "at any size"
    word, shown = readable(parameter, [size])
    return f"{word} {shown[0]}"


def noise_from(drive: Drive, run: Run) -> Noise:
    """The noise of a measured run, for planning other runs."""
    fitter = planned_fitter(drive, run)
    return noise_of(fitter.base, [fitter.fit().residual])


def plan_of(drive: Drive, run: Run, noise: Noise | None = None, power: float = POWER) -> RunPlan:
    """What ``run``, measured or only planned, can find on ``drive``. ``noise`` is that of a pilot run.

    ``power`` is the probability with which an effect of the smallest size is to be named.
    """
    fitter = planned_fitter(drive, run)
    bare = fitter.fit()
    noise = noise or noise_of(fitter.base, [bare.residual])
    p = fitter.runs[0]
    offered = [effect for effect in library(fitter.d, p) if not effect.inside]
    tried = [found for effect in offered for found in _columns(fitter, bare, effect)]
    least = [_least(one.columns, noise, p, len(tried), power) for one in tried]
    foreseen = []
    for one, (strength, unit) in zip(tried, least, strict=True):
        parameter = next(p for p in one.effect.parameters if p.role == "size")
        size = strength * noise.total_rad / unit if unit > 0.0 else np.inf
        if size > min(parameter.high, NEVER * parameter.size):
            foreseen.append(Foreseen(one.label, parameter.name, None, ()))
            continue
        rivals = []
        for other, (_, shown) in zip(tried, least, strict=True):
            if other.effect.key == one.effect.key or shown <= 0.0:
                continue
            wanted = _apart(one.basis, other.basis, noise, p)
            if wanted > strength:
                from_size = None if wanted > ANY_SIZE * strength else wanted / strength * size
                rivals.append((wanted, Rival(other.label, from_size)))
        rivals.sort(key=lambda rival: -rival[0])
        worst = tuple(rival for _, rival in rivals[:MOST_RIVALS])
        foreseen.append(Foreseen(one.label, _size_name(one.effect), size, worst))
    return RunPlan(noise, tuple(foreseen), power)


def planned_fitter(drive: Drive, run: Run) -> Fitter:
    """The fitter of one run, measured or planned."""
    d = to_si(drive)
    ratio = float(np.mean(d.total_ratio))
    return Fitter(d, ratio, [prepare(arranged(run, drive), ratio)[0]], drive.as_built)


def _size_name(effect: Effect) -> str:
    """Name of the first size; the amplitude of a wave has the same unit."""
    name = next(p.name for p in effect.parameters if p.role == "size")
    return name.replace("cosine_", "amplitude_")


def _columns(fitter: Fitter, bare: Fit, effect: Effect) -> list[_Tried]:
    """The effect at each place that is planned."""
    places: Sequence[Sequence[float]] = [[0.0] * len(effect.parameters)]
    labels = [effect.label]
    if effect.order_index is not None:
        places = [[0.0] * effect.order_index + [order] for order in ORDERS]
        labels = [f"{effect.name} of order {order:g}" for order in ORDERS]
    elif any(p.role == "place" for p in effect.parameters):
        guesses = effect.first_guesses(fitter.base[0], bare.residual)
        places = [guesses[len(guesses) // 2]]
    used = fitter.used
    known = fitter.centred(bare.jacobian, used)[used]
    basis = np.linalg.qr(known)[0] if known.shape[1] else np.zeros((int(used.sum()), 0))
    without = fitter.output - bare.residual  # a constant apart, which ``centred`` removes
    sizes = [k for k, parameter in enumerate(effect.parameters) if parameter.role == "size"]
    found = []
    for place, label in zip(places, labels, strict=True):
        at = np.array(place, dtype=float)
        try:
            before = fitter.predict([effect], [at], bare.offsets) if at[sizes].any() else without
            rows = []
            for k in sizes:
                moved = at.copy()
                moved[k] += effect.parameters[k].size
                rows.append((fitter.predict([effect], [moved], bare.offsets) - before) / effect.parameters[k].size)
        except ModelError:
            continue
        columns = fitter.centred(np.stack(rows, axis=1), used)[used]
        columns = np.asarray(columns - basis @ (basis.T @ columns))
        found.append(_Tried(effect, label, columns, np.linalg.qr(columns)[0]))
    return found


def counting(noise: Noise, step_s: float) -> float:
    """Share of samples ``step_s`` apart that count as independent, since coloured noise is correlated."""
    square = noise.white_rad**2 + noise.coloured_rad**2 * max(1.0, 2.0 * noise.memory_s / step_s)
    return noise.total_rad**2 / max(square, noise.total_rad**2)


def _least(columns: Floats, noise: Noise, p: Prepared, candidates: int, power: float) -> tuple[float, float]:
    """RMS over the floor that is named with ``power``, and RMS that one unit of the size causes at its worst phase.

    The half sweeps held back must show the effect, and the others must support it. Where the load differs from sweep to
    sweep, either may show less of it than all do.
    """
    share = counting(noise, p.step_s)
    test = p.test[p.used]
    held, trained = max(4.0, share * float(test.sum())), max(4.0, share * float((~test).sum()))
    sure = float(norm.ppf(power))
    # The fall of the held-out mean square, reduced by the error of a fit to noise, must be LEAST_FALL of the floor's.
    chance = sure / np.sqrt(held)
    by_size = chance + np.sqrt(chance**2 + LEAST_FALL**2)
    freedom, k = SECTORS - 1, columns.shape[1]
    critical = k * float(f_distribution.isf(ALPHA / candidates, k, max(freedom - k + 1, 1)))
    by_test = (np.sqrt(critical) + sure) / np.sqrt(trained)

    def of_unit(chosen: NDArray[np.bool_]) -> float:
        part = columns[chosen]
        return float(np.linalg.svd(part, compute_uv=False)[-1]) / np.sqrt(part.shape[0]) if len(part) >= k else 0.0

    unit, shown, supporting = of_unit(np.ones_like(test)), of_unit(test), of_unit(~test)
    if min(shown, supporting) <= 0.0:
        return np.inf, 0.0
    return float(max(by_size * unit / shown, by_test * unit / supporting)), unit


def _apart(one: Floats, other: Floats, noise: Noise, p: Prepared) -> float:
    """RMS over the floor from which an effect is separated from another; both are bases of their columns."""
    alike = min(1.0, float(np.linalg.svd(one.T @ other, compute_uv=False)[0]))
    n = one.shape[0] * counting(noise, p.step_s)
    left = max(1.0 - alike, 1e-12)
    return float(max(np.sqrt(TOLD_STRENGTH / left / n), ALIKE_SHARE / np.sqrt(max(1.0 - alike**2, 1e-12))))
