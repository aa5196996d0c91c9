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

from mbcdm_cad.design.drive import Drive
from mbcdm_cad.identification.colour import along, coloured
from mbcdm_cad.identification.effect import Effect
from mbcdm_cad.identification.effects import library
from mbcdm_cad.identification.exchange import ALIKE_SHARE
from mbcdm_cad.identification.fit import Fit, Fitter
from mbcdm_cad.identification.noise import Noise, noise_of
from mbcdm_cad.identification.power import shown, smallest
from mbcdm_cad.identification.prepared import prepare
from mbcdm_cad.identification.result import readable
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
# What an offset may explain, and how an effect that strains the cables shows, hang on the size, and the size on both:
# it is found in so many rounds at most, to within this share.
ROUNDS, SETTLED = 6, 0.01
# Sizes of the two signs that differ by less than this share are given as one.
SAME_SIZE = 0.03
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
    """One effect: the smallest size that is named with the plan's power, whatever its sign and phase; None if the run
    cannot show it.

    ``if_positive`` and ``if_negative``: that size for one sign, where they differ and the run can show it.
    """

    label: str
    parameter: str
    smallest: float | None
    rivals: tuple[Rival, ...]
    if_positive: float | None = None
    if_negative: float | None = None


@dataclass(frozen=True, eq=False)
class _Tried:
    """One effect at the place ``at``: the derivatives by its sizes (n, k), plain, and on the used samples without what
    offsets explain, an orthonormal basis of the latter, the number of independent samples that the noise leaves along
    them, and the RMS that one unit of the size causes at the worst phase."""

    effect: Effect
    label: str
    at: Floats
    plain: Floats
    columns: Floats
    basis: Floats
    counted: float
    unit: float

    @property
    def sizes(self) -> list[int]:
        """Indices of the parameters that are sizes."""
        return _sizes(self.effect)


@dataclass(frozen=True)
class _Sizes:
    """Sizes from which an effect is named, of either sign; infinite where the run cannot show it."""

    positive: float
    negative: float

    @property
    def either(self) -> float | None:
        """The size that is enough whatever the sign, of the signs that can be shown; None if there is none."""
        return max((size for size in (self.positive, self.negative) if np.isfinite(size)), default=None)

    @property
    def signed(self) -> tuple[float | None, float | None]:
        """Each, None where it is infinite; both None where the sign makes next to no difference."""
        if self.positive == self.negative or abs(self.positive / self.negative - 1.0) < SAME_SIZE:
            return None, None
        positive, negative = (size if np.isfinite(size) else None for size in (self.positive, self.negative))
        return positive, negative


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
            size = "this run cannot show it" if one.smallest is None else _size_words(one)
            lines.append(f"{one.label:<{width}}  {size:<34}  {rivals}".rstrip())
        return "\n".join(lines)


def _size_words(one: Foreseen) -> str:
    if one.if_positive is None and one.if_negative is None:
        return _words(one.parameter, one.smallest)
    signed = [("+", one.if_positive), ("-", one.if_negative)]
    word = _words(one.parameter, one.smallest).rsplit(" ", 2)[0]
    return f"{word} " + " or ".join(
        sign + _words(one.parameter, size).removeprefix(f"{word} ") for sign, size in signed if size is not None
    )


def _words(parameter: str, size: float | None) -> str:
    if size is None:
        return "at any size"
    word, shown = readable(parameter, [size])
    return f"{word} {shown[0]}"


def noise_from(drive: Drive, run: Run) -> Noise:
    """The noise of a measured run, for planning other runs."""
    fitter = planned_fitter(drive, run)
    return _noise_in(fitter, fitter.fit())


def _noise_in(fitter: Fitter, bare: Fit) -> Noise:
    """The floor as the loop has it, and its colour."""
    return coloured(noise_of(fitter.base, [bare.residual]), fitter.base[0], bare.residual)


def plan_of(drive: Drive, run: Run, noise: Noise | None = None, power: float = POWER) -> RunPlan:
    """What ``run``, measured or only planned, can find on ``drive``. ``noise`` is that of a pilot run.

    ``power`` is the probability with which an effect of the smallest size is to be named.
    """
    fitter = planned_fitter(drive, run)
    bare = fitter.fit()
    noise = noise or _noise_in(fitter, bare)
    p = fitter.runs[0]
    offered = [effect for effect in library(fitter.d, p) if not effect.inside]
    tried = [found for effect in offered for found in _columns(fitter, bare, effect, noise)]
    foreseen = []
    for one in tried:
        parameter = one.effect.parameters[one.sizes[0]]
        sizes = _smallest(fitter, bare, one, noise, len(tried), power)
        size = sizes.either
        if size is None:
            foreseen.append(Foreseen(one.label, parameter.name, None, ()))
            continue
        strength = size * one.unit / noise.total_rad
        rivals = []
        for other in tried:
            if other.effect.key == one.effect.key or other.unit <= 0.0:
                continue
            wanted = _apart(one, other)
            if wanted > strength:
                from_size = None if wanted > ANY_SIZE * strength else wanted / strength * size
                rivals.append((wanted, Rival(other.label, from_size)))
        rivals.sort(key=lambda rival: -rival[0])
        worst = tuple(rival for _, rival in rivals[:MOST_RIVALS])
        foreseen.append(Foreseen(one.label, _size_name(one.effect), size, worst, *sizes.signed))
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


def without_offsets(fitter: Fitter, bare: Fit, columns: Floats, noise: Noise, size: float = 0.0) -> Floats:
    """Changes of the prediction (n, k) on all used samples, as the loop sees them: less their mean over the training
    samples, and less what the offsets between the input encoders explain there of so many times the columns.

    An offset is known before the run: it is within its limit, as likely here as there, of a variance of a third of the
    limit squared. Where that moves the prediction by less than the noise, it explains nothing; and never more than its
    limit does.
    """
    train, used, p = fitter.train, fitter.used, fitter.runs[0]
    columns = fitter.centred(columns, train)
    known = fitter.centred(bare.jacobian, train)
    if known.shape[1]:
        own, limit = known[train], fitter.limit[fitter.free]
        noises = [along(row, noise, p.step_s) * noise.total_rad**2 for row in own.T]
        drawn = np.diag(3.0 * np.array(noises) / limit**2)
        offsets = np.linalg.solve(own.T @ own + drawn, own.T @ columns[train])
        wanted = np.maximum(size * np.linalg.norm(offsets, axis=1), 1e-30 * limit)
        columns = columns - known @ (offsets * np.minimum(1.0, limit / wanted)[:, None])
    return np.asarray(columns[used])


def _changed(fitter: Fitter, bare: Fit, effect: Effect, at: Floats) -> Floats:
    """Change of the prediction by the effect, but for a constant."""
    return np.asarray(fitter.predict([effect], [at], bare.offsets) - (fitter.output - bare.residual))


def _columns(fitter: Fitter, bare: Fit, effect: Effect, noise: Noise) -> list[_Tried]:
    """The effect at each place that is planned."""
    places: Sequence[Sequence[float]] = [[0.0] * len(effect.parameters)]
    labels = [effect.label]
    if effect.order_index is not None:
        places = [[0.0] * effect.order_index + [order] for order in ORDERS]
        labels = [f"{effect.name} of order {order:g}" for order in ORDERS]
    elif any(p.role == "place" for p in effect.parameters):
        guesses = effect.first_guesses(fitter.base[0], bare.residual)
        places = [guesses[len(guesses) // 2]]
    sizes = _sizes(effect)
    found = []
    for place, label in zip(places, labels, strict=True):
        at = np.array(place, dtype=float)
        try:
            before = _changed(fitter, bare, effect, at) if at[sizes].any() else 0.0
            rows = []
            for k in sizes:
                moved = at.copy()
                moved[k] += effect.parameters[k].size
                rows.append((_changed(fitter, bare, effect, moved) - before) / effect.parameters[k].size)
        except ModelError:
            continue
        plain = np.stack(rows, axis=1)
        columns = without_offsets(fitter, bare, plain, noise)
        spread = max(along(column, noise, fitter.runs[0].step_s) for column in columns.T)
        unit = float(np.linalg.svd(columns, compute_uv=False)[-1]) / np.sqrt(columns.shape[0])
        basis = np.linalg.qr(columns)[0]
        found.append(_Tried(effect, label, at, plain, columns, basis, columns.shape[0] / spread, unit))
    return found


def _sizes(effect: Effect) -> list[int]:
    return [k for k, parameter in enumerate(effect.parameters) if parameter.role == "size"]


def _smallest(fitter: Fitter, bare: Fit, one: _Tried, noise: Noise, candidates: int, power: float) -> _Sizes:
    """The sizes of either sign that are named with this power.

    An effect of one size that strains the cables is taken at that size and not by its derivative: a low preload shows
    more than a high one.
    """
    p, parameter = fitter.runs[0], one.effect.parameters[one.sizes[0]]
    straight = smallest(shown(one.columns, noise, p, candidates), power)
    # A play at an input has no slope: it is taken as it shows at its usual size.
    bent = len(one.sizes) == 1 and fitter.kind(one.effect) == 0 and not one.effect.saturates

    def of_sign(sign: float) -> float:
        limit = min(parameter.high if sign > 0.0 else -parameter.low, NEVER * parameter.size)
        size, at, columns = straight, min(straight, limit), one.plain
        for _ in range(ROUNDS):
            if bent:
                moved = one.at.copy()
                moved[one.sizes[0]] += sign * at
                try:
                    columns = _changed(fitter, bare, one.effect, moved)[:, None] / (sign * at)
                except ModelError:  # a cable is slack at this size
                    at *= 0.5
                    continue
            way = shown(without_offsets(fitter, bare, columns, noise, at), noise, p, candidates)
            size = smallest(way, power)
            if abs(size / at - 1.0) < SETTLED:
                break
            at = min(size, limit)
        return size if size <= limit else np.inf

    if not np.isfinite(straight):
        return _Sizes(np.inf, np.inf)
    positive = of_sign(1.0)
    return _Sizes(positive, of_sign(-1.0) if bent and parameter.low < 0.0 else positive)


def _apart(one: _Tried, other: _Tried) -> float:
    """RMS over the floor from which an effect is separated from another."""
    alike = min(1.0, float(np.linalg.svd(one.basis.T @ other.basis, compute_uv=False)[0]))
    left = max(1.0 - alike, 1e-12)
    return float(max(np.sqrt(TOLD_STRENGTH / left / one.counted), ALIKE_SHARE / np.sqrt(max(1.0 - alike**2, 1e-12))))
