"""What torque sensor and computed parts may be wrong by is no effect: names that this explains are withdrawn.

A gain wrong by half a per cent looks like a stiffness wrong by half a per cent, a slow amplifier like a drag. So each
named effect of the load is compared with gain, zero and lag of the sensor within its class, together: where they
explain the run as well, the effect is not named, and the sensor's errors stay in the fit. The give of the structure
and the losses that the design states are treated alike, within their standard deviations.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from mbcdm_cad.loop.effect import Effect
from mbcdm_cad.loop.effects.load_sensor import within_class, within_prior
from mbcdm_cad.loop.readable import readable
from mbcdm_cad.loop.search.exchange import Exchanges, Group
from mbcdm_cad.loop.search.fit import Fit
from mbcdm_cad.measurement.run import TorqueClass
from mbcdm_cad.routes import Floats

# An effect that does more than this many times what the class can do is none of the sensor.
REACH = 2.0
SENSORS = ("load_gain", "load_zero", "load_hysteresis", "load_lag")
PARTS = ("structure", "losses")


@dataclass(frozen=True)
class WithinClass:
    """Errors of the torque sensor in the fit: name and size of each, with the class that allows them."""

    sizes: tuple[tuple[str, float], ...]
    torque_class: TorqueClass

    @property
    def sentence(self) -> str:
        """For people."""
        own, others = (
            [" ".join((word, *shown)) for word, shown in (readable(*one) for one in group)] for group in self._groups()
        )
        sentences = []
        if others:
            sentences.append(
                f"errors of the {self.torque_class.what} within its class ({self.torque_class.words}): "
                f"{', '.join(others)}"
            )
        if own:
            sentences.append(f"figures of the design within their uncertainty: {', '.join(own)}")
        return " and ".join(sentences)

    def _groups(self) -> Iterator[list[tuple[str, list[float]]]]:
        """Sizes of the parts' figures, and of the sensor's errors."""
        for parts in (True, False):
            yield [(name, [size]) for name, size in self.sizes if name.startswith(PARTS) is parts]


class ClassOfSensor(Exchanges):
    """The comparison of effects of the load with the class of the torque sensor."""

    within: WithinClass | None = None

    def beyond_class(self, fit: Fit, groups: tuple[Group, ...]) -> tuple[Fit, tuple[Group, ...]]:
        """The fit and the effects that the torque sensor does not explain."""
        own = [*within_class(self.fitter.runs), *within_prior(self.fitter.runs)]
        if not own:
            return fit, groups
        groups = tuple(g for g in groups if not _is_within(g.effect, fit, own))
        reach = self._reach(fit, own)
        for group in sorted(groups, key=lambda g: self.fall_rad(fit, g.effect)):
            if not group.effect.generic or self.fall_rad(fit, group.effect) > REACH * reach:
                continue
            rest = [e for e in fit.effects if e is not group.effect]
            new = [e for e in own if not any(_same(e, other) for other in rest)]
            # The figure of the parts begins where the effect that it replaces ended: from zero it may end at a bound.
            size = float(fit.values_of(group.effect)[0])
            starts = (
                [float(np.clip(size, e.parameters[0].low, e.parameters[0].high)) if _same(e, group.effect) else 0.0]
                for e in new
            )
            values: list[Floats | list[float]] = [*map(fit.values_of, rest), *starts]
            trial = self.fitter.tried((*rest, *new), values, fit.offsets)
            if trial is None or not (trial.square <= fit.square or self.alike(trial, fit, self._against(trial))):
                continue
            self.search.give_back("within the class of the torque sensor", group.effect, fit)
            fit, groups = trial, tuple(g for g in groups if g is not group)
        sizes = tuple(
            (size_name(e), float(fit.values_of(e)[0]))
            for e in fit.effects
            if e.name in (*SENSORS, *PARTS) and all(e is not g.effect for g in groups)
        )
        if sizes:
            self.within = WithinClass(sizes, self.fitter.runs[0].run.sensors.torque_class)
        return fit, groups

    def _against(self, fit: Fit) -> float:
        """Logarithm of the odds against a gain of this size, where its standard deviation is known, and none."""
        sigma = self.fitter.runs[0].run.sensors.torque_class.gain_sigma
        found = [float(v[0]) for e, v in zip(fit.effects, fit.values, strict=True) if e.name == "load_gain"]
        return 0.5 * sum((one / sigma) ** 2 for one in found) if sigma else 0.0

    def fall_rad(self, fit: Fit, effect: Effect) -> float:
        """How much the held-out error falls with an effect of a fit of the search, RMS in quadrature."""
        less = self.search.without(fit, effect)
        return float(np.sqrt(max(0.0, self.search.held_rms(less) ** 2 - self.search.held_rms(fit) ** 2)))

    def _reach(self, fit: Fit, own: list[Effect]) -> float:
        """What the class can change, rad RMS."""
        f = self.fitter
        before = f.output - fit.residual
        changes = []
        for effect in own:
            most = np.array([effect.parameters[0].high])
            after = f.predict((*fit.effects, effect), (*fit.values, most), fit.offsets)
            changes.append(float(np.std(f.centred_on(f.used, after - before))))
        return float(np.sum(changes))


# Effects that move the reading as the figure of the parts does.
_LIKE = {"structure": "stiffness_error", "losses": "friction"}


def _same(own: Effect, other: Effect) -> bool:
    """Whether an effect already has the place of an error of the sensor or of a figure of the parts."""
    return other.name == own.name or (
        other.name == _LIKE.get(own.name) and other.parameters[0].name == own.parameters[0].name
    )


def size_name(effect: Effect) -> str:
    """Name of its figure, with the unit."""
    name = effect.parameters[0].name
    return f"{effect.name}_{name}" if effect.name in PARTS else f"{effect.name[5:]}_{name.rsplit('_', 1)[-1]}"


def _is_within(effect: Effect, fit: Fit, own: list[Effect]) -> bool:
    """Whether an effect is an error of the torque sensor no larger than its class."""
    bound = next((e.parameters[0].high for e in own if e.name == effect.name), 0.0)
    return abs(float(fit.values_of(effect)[0])) <= bound
