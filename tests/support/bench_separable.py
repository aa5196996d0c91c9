"""Whether an effect of a run is large enough to be named, and whether the run can tell it from every other effect.

    judged = separability(truth_of(drive, "pulley_guide", 4), drive.input_names)

Both follow from the truth alone: the true signals, the true noise and the chain of bench_chain.py. Nothing of the
project's model or loop is used, so that which runs count is fixed before the loop sees them.

*Change*: the output with all effects minus the output without the one in question. What the zeros of the encoders and
the refitted sizes of the other effects of the run can take up is projected out.

*Large enough*: the mean square of the change is above (0.45 floor)^2 with a probability of 0.95 on a quarter of the
samples, as many as are held back; the floor is that of the true noise.

*Separable*: each rival, an effect of the vocabulary with another name, is fitted to the change by least squares,
together with the zeros and the other effects. With d what it leaves, and C the covariance of the true noise with its
memory, the wrong one of the two fits better with a probability of Phi(-d.d / (2 sqrt(d.C.d))). A run is separable if
this is below 1 % for every rival. Rivals act in proportion to their size at first; those that come nearest are
simulated again with the sizes that fit best, within the bounds that a bench can have: what strains the cables is not
proportional to its size, and small differences from it are what tells the runout of one input from that of the other.

Every eighth sample of the true signals is used: the cables follow the path of the inputs, not its pace.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from bench_data import drum_angle
from bench_effects import ALL, Effect
from bench_motion import RATE_HZ, Bench
from bench_real import DECLARED_FLOOR_RAD, Traits, Truth
from bench_score import same
from scipy.optimize import least_squares
from scipy.signal import lfilter
from scipy.stats import norm

EVERY = 8
PIECE_RAD = 8e-3
# The steps of the encoders make an error that is white up to about this rate.
STEPS_HZ = 200.0
LEAST_GAIN, POWER, CONFUSION, HELD_SHARE = 0.45, 0.95, 0.01, 0.25
# Rivals that are simulated again, with so many steps of their sizes at most.
AGAIN, ROUNDS = 3, 20
# Factor by which a rival that cannot be simulated counts as worse than none.
FAR = 100.0
# Effects with one size whose bounds are known.
BOUNDS = {
    "preload": ("share", -0.8, 4.0),
    "mu": ("share", -0.8, 4.0),
    "modulus": ("share", -0.8, 4.0),
    "bearing": ("torque_Nm", 0.0, np.inf),
    "viscous": ("drag_Nm_s", 0.0, np.inf),
    "input_play": ("play_rad", 0.0, np.inf),
    "shaft_compliance": ("compliance_rad_Nm", 0.0, np.inf),
    "output_play": ("play_rad", 0.0, np.inf),
}


@dataclass(frozen=True)
class Separability:
    """Of the worst effect of a run: RMS of its change (rad), whether it is large enough, its nearest rival, and the
    probability of taking one for the other."""

    gain_rad: float
    large: bool
    rival: str
    confusion: float

    @property
    def separable(self) -> bool:
        """Whether the run can tell every effect of it from all others."""
        return self.confusion < CONFUSION


@dataclass(frozen=True)
class Rival:
    """One effect of the vocabulary: one column for each of ``parts`` (effects simulated with the chain), or columns
    that are known without it, as several choices (an order, a time) of which the best counts."""

    label: dict[str, object]
    parts: tuple[Effect, ...] = ()
    choices: tuple[np.ndarray, ...] = ()


def separability(truth: Truth, input_names: tuple[str, ...]) -> Separability:
    """Of the effects of a run that the vocabulary has; a run has at least one."""
    view = _View(truth, input_names)
    known = [effect for effect in truth.effects if effect.in_vocabulary]
    found = [view.judged(effect) for effect in known]
    worst = max(found, key=lambda one: one.confusion)
    least = min(found, key=lambda one: one.gain_rad)
    return Separability(least.gain_rad, all(one.large for one in found), worst.rival, worst.confusion)


class _View:
    """One run seen with every eighth sample, after the first turning point."""

    def __init__(self, truth: Truth, input_names: tuple[str, ...]) -> None:
        whole, self.truth, self.names = truth.bench, truth, input_names
        self.bench = Bench(
            whole.time_s[::EVERY],
            whole.input_rad[:, ::EVERY],
            whole.load_Nm[::EVERY],
            whole.speed_rad_s[::EVERY],
            whole.air_degC[::EVERY],
        )
        self.used = self.bench.time_s > 0.25 / truth.plan.frequency_hz
        self.full = self.drum(truth.effects)
        self.zeros = self._zeros()
        self.rivals = self._rivals()
        self.columns = [
            [np.stack([self.drum((*truth.effects, part)) - self.full for part in one.parts], axis=1)]
            if one.parts
            else list(one.choices)
            for one in self.rivals
        ]

    def drum(self, effects: Sequence[Effect]) -> np.ndarray:
        """Output of the run with some effects, rad."""
        return drum_angle(
            self.truth.chain, self.names, self.bench, tuple(effects), np.random.default_rng(0), piece_rad=PIECE_RAD
        )

    def _zeros(self) -> np.ndarray:
        """What a shift of the zero of each encoder changes."""
        columns = [np.ones(self.full.size)]
        for index in range(len(self.names) - 1):
            moved = self.bench.input_rad.copy()
            moved[index] += 1e-4
            moved[index + 1] -= 1e-4
            shifted = replace(self.bench, input_rad=moved)
            rng = np.random.default_rng(0)
            drum = drum_angle(self.truth.chain, self.names, shifted, self.truth.effects, rng, piece_rad=PIECE_RAD)
            columns.append(drum - self.full)
        return np.stack(columns, axis=1)

    def _rivals(self) -> list[Rival]:
        """The vocabulary on this bench, each effect with a small size of its own."""
        waves = (0.0, 0.5 * np.pi)
        found = [
            Rival(
                {"name": "once_per_rev", "stage": stage},
                tuple(
                    Effect("once_per_rev", "pulley", {"eccentricity_m": 3e-6, "phase_rad": phase}, stage=stage)
                    for phase in waves
                ),
            )
            for stage in ("guide", *(f"input_{name}" for name in self.names))
        ]
        for stage, kind in (("drum", "output_encoder"), *((f"input_{name}", "input_encoder") for name in self.names)):
            size = 1e-4 if stage == "drum" else 5e-4
            parts = [Effect("once_per_rev", kind, {"amplitude_rad": size, "phase_rad": w}, stage=stage) for w in waves]
            found.append(Rival({"name": "once_per_rev", "stage": stage}, tuple(parts)))

        def one(name: str, kind: str, size: dict[str, float], cables: tuple[int, ...] = (), stage: str = "") -> None:
            effect = Effect(name, kind, size, cables=cables, stage=stage or None)
            found.append(Rival(effect.as_truth(), (effect,)))

        one("ratio_error", "output_scale", {"share": 1e-4})
        one("stiffness_error", "modulus", {"share": 0.02})
        one("stiffness_error", "shaft_compliance", {"compliance_rad_Nm": 1e-5})
        for cables in (ALL, *((j,) for j in ALL)):
            one("preload_error", "preload", {"share": 0.02}, cables)
        one("cable_friction", "mu", {"share": 0.02})
        one("friction", "bearing", {"torque_Nm": 0.02})
        one("delay", "latency", {"delay_s": 1e-4})
        one("delay", "viscous", {"drag_Nm_s": 0.1})
        one("lash", "output_play", {"play_rad": 2e-5})
        for name in self.names:
            one("lash", "input_play", {"play_rad": 2e-4}, stage=f"input_{name}")
        one("winding_history", "transport", {})
        found += self._plain()
        return found

    def _plain(self) -> list[Rival]:
        """Effects whose columns are functions of angle or time."""
        t, angle = self.bench.time_s, self.full
        travel = float(np.ptp(angle))
        orders = np.arange(2.0, 80.0, 0.5 * np.pi / travel)
        # A wave of the order of a shaft is that shaft's, not a ripple.
        shafts = (self.truth.ratio, float(np.mean(self.truth.chain.r_drum / self.truth.chain.r_guide)))
        orders = orders[np.all([np.abs(orders - n) > np.pi / travel for n in shafts], axis=0)]
        rest = [Rival({"name": "bow"}, choices=(np.stack([angle**2, angle**3], axis=1),))]
        waves = tuple(np.stack([np.cos(n * angle), np.sin(n * angle)], axis=1) for n in orders)
        rest.append(Rival({"name": "ripple"}, choices=waves))
        drifts = [1.0 - np.exp(-t / T) for T in np.geomspace(5.0, 2.0 * t[-1], 12)]
        if self.truth.temperature:
            drifts = [self.bench.air_degC]
        rest.append(Rival({"name": "thermal_drift"}, choices=tuple(d[:, None] for d in drifts)))
        creeps = tuple(np.log1p(t / t0)[:, None] for t0 in np.geomspace(0.5, 50.0, 8))
        rest.append(Rival({"name": "creep"}, choices=creeps))
        steps = tuple((t > at)[:, None].astype(float) for at in np.linspace(0.05, 0.95, 46) * t[-1])
        rest.append(Rival({"name": "slip_step"}, choices=steps))
        return rest

    def judged(self, effect: Effect) -> Separability:
        """One effect of the run against all others."""
        others = [one for one in self.truth.effects if one is not effect]
        rest = self.drum(others)
        change = self.full - rest
        basis = self._basis([self.zeros, *(self._own(other) for other in others)])
        plain = self._without(basis, change)
        gain, large = self._large(plain)
        ranked = []
        for rival, choices in zip(self.rivals, self.columns, strict=True):
            if same(rival.label, effect) or any(same(rival.label, other) for other in others):
                continue
            left = min((self._left(basis, change, columns)[0] for columns in choices), key=lambda d: float(d @ d))
            ranked.append((self._confusion(left), rival))
        ranked.sort(key=lambda pair: -pair[0])
        for rival in [r for _, r in ranked if r.parts and r.parts[0].size][:AGAIN]:
            left = self._refitted(basis, change, rest, others, rival)
            ranked = [(c, r) for c, r in ranked if r is not rival] + [(self._confusion(left), rival)]
        worst, rival = max(ranked, key=lambda pair: pair[0])
        words = " ".join(str(rival.label.get(key)) for key in ("name", "stage") if rival.label.get(key))
        return Separability(gain, large, words, worst)

    def _own(self, effect: Effect) -> np.ndarray:
        """Columns of an effect of the run whose size is refitted."""
        for rival, choices in zip(self.rivals, self.columns, strict=True):
            if rival.parts and same(rival.label, effect) and rival.parts[0].kind == effect.kind:
                return choices[0]
        if effect.kind == "division":
            order = effect.size["cycles_per_output_rev"]
            return np.stack([np.cos(order * self.full), np.sin(order * self.full)], axis=1)
        return (self.full - self.drum([one for one in self.truth.effects if one is not effect]))[:, None]

    def _refitted(
        self, basis: np.ndarray, change: np.ndarray, rest: np.ndarray, others: Sequence[Effect], rival: Rival
    ) -> np.ndarray:
        """What a rival leaves of the change with its best sizes, within their bounds.

        A rival need not act in proportion to its size: the slip from cable friction grows with its square, and runout
        moves the load between the cables.
        """
        parts = [(part, *BOUNDS.get(part.kind, (next(iter(part.size)), -np.inf, np.inf))) for part in rival.parts]
        unit = np.array([abs(part.size[key]) for part, key, _, _ in parts])
        low, high = (np.array([bound[k] for bound in parts]) / unit for k in (2, 3))
        slack = FAR * self._without(basis, change)

        def left(factors: np.ndarray) -> np.ndarray:
            made = [
                replace(part, size={**part.size, key: float(factor * size)})
                for (part, key, _, _), factor, size in zip(parts, factors, unit, strict=True)
            ]
            try:
                return self._without(basis, change - (self.drum((*others, *made)) - rest))
            except ValueError:  # sizes at which the cables go slack
                return slack

        columns = np.stack([self.drum((*others, part)) - rest for part in rival.parts], axis=1)
        begin = np.clip(self._left(basis, change, columns)[1], 0.99 * low, 0.99 * high)
        while left(begin) is slack:
            begin = 0.5 * begin
        found = least_squares(left, begin, bounds=(low, high), diff_step=0.01, xtol=1e-3, max_nfev=ROUNDS)
        return np.asarray(found.fun)

    def _basis(self, columns: Sequence[np.ndarray]) -> np.ndarray:
        table = np.hstack(list(columns))[self.used]
        table = table / (np.linalg.norm(table, axis=0) + 1e-30)
        return np.linalg.qr(table)[0]

    def _without(self, basis: np.ndarray, values: np.ndarray) -> np.ndarray:
        """``values`` (n,) or (n, k) on the samples in use, less what the columns of ``basis`` explain."""
        chosen = values[self.used]
        return chosen - basis @ (basis.T @ chosen)

    def _left(self, basis: np.ndarray, change: np.ndarray, columns: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """What least squares on ``columns`` leaves of the change, and the factors of the columns."""
        y, table = self._without(basis, change), self._without(basis, columns)
        size = np.linalg.norm(table, axis=0) + 1e-30
        factors = np.linalg.lstsq(table / size, y, rcond=1e-6)[0] / size
        return y - table @ factors, factors

    def _confusion(self, left: np.ndarray) -> float:
        """Probability that the wrong one of two fits is the better one; ``left`` (n,) is their difference, rad."""
        square, deviation = self._sums(left)
        return float(norm.sf(square / (2.0 * deviation))) if deviation > 0.0 else 0.5

    def _large(self, change: np.ndarray) -> tuple[float, bool]:
        """RMS of a change, rad, and whether it would be named with the power asked for."""
        square, deviation = self._sums(change)
        count = change.size * self._logged
        mean = square / count
        error = 2.0 * deviation / count / np.sqrt(HELD_SHARE)
        least = (LEAST_GAIN * self.truth.traits.floor_rad) ** 2
        return float(np.sqrt(mean)), bool(mean - norm.isf(1.0 - POWER) * error >= least)

    @property
    def _logged(self) -> float:
        """Samples of the logger for one of this view."""
        return self.truth.traits.rate_hz * EVERY / RATE_HZ

    def _sums(self, values: np.ndarray) -> tuple[float, float]:
        """Sum of squares over the samples of the logger, and the deviation of the sum of values times noise."""
        traits, k = self.truth.traits, self._logged
        return k * float(values @ values), float(np.sqrt(noise_along(values, traits, k)))


def noise_along(values: np.ndarray, traits: Traits, logged: float) -> float:
    """Variance of the sum of ``values`` times the noise of a bench; ``logged`` samples of the logger for each value."""
    step_s = EVERY / RATE_HZ
    square = float(values @ values)
    steps = min(traits.rate_hz, STEPS_HZ) * step_s
    white = square * (logged * traits.white_rad**2 + logged**2 / steps * DECLARED_FLOOR_RAD**2)
    keep = float(np.exp(-step_s / traits.memory_s))
    before = lfilter([0.0, keep], [1.0, -keep], values)
    coloured = (square + 2.0 * float(values @ before)) * (logged * traits.coloured_rad) ** 2
    ramp = np.linspace(-0.5, 0.5, values.size)
    drift = (logged * traits.drift_rad * float(values @ ramp)) ** 2
    return white + coloured + drift
