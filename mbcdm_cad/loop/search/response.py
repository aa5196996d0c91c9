"""The loop on frequency responses: the first mode behind the inputs, its stiffness over amplitude, delays of the bench.

Suspects are figures of the chain behind the inputs (:mod:`mbcdm_cad.loop.prepare.behind_inputs`) and of the bench, and
a second mode. They are found as those of a table by hand (:mod:`mbcdm_cad.loop.search.selection`), with averages of
lines as readings. What sensors, law and structure may be wrong by is in every fit, with its class as prior.
"""

from collections.abc import Iterator, Sequence
from copy import copy
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq, least_squares

from mbcdm_cad.design.drive import Drive
from mbcdm_cad.layouts.registry import layout_of
from mbcdm_cad.loop.prepare import behind_inputs
from mbcdm_cad.loop.prepare.samples import ONE_OF
from mbcdm_cad.loop.readable import INTERVAL, Value, readable
from mbcdm_cad.loop.result import BodePicture, Errors, LoopResult, Named, Noise, TorsionalMode, verdict_of
from mbcdm_cad.loop.search.account import errors_of, next_steps
from mbcdm_cad.loop.search.evidence import TRIED, NoiseModel, NoiseOfUnknownSize, Weighed, Whitened
from mbcdm_cad.loop.search.few_readings import LeftOver
from mbcdm_cad.loop.search.fit import DIFFERENCE
from mbcdm_cad.loop.search.moves import Moves
from mbcdm_cad.loop.search.problem import hats_over
from mbcdm_cad.measurement.response import FrequencyResponse, response_of
from mbcdm_cad.measurement.run import Run
from mbcdm_cad.model.si import DriveSI
from mbcdm_cad.routes import Complex, Floats

# Standard deviations as shares: of the slip, by the friction of the wraps; of all compliance, by lumped inertias and
# the law (the rig's modes are up to 1.8 % off the model's, twice that in compliance); of radii and encoders.
SLIP_SHARE, LAW_SHARE, SCALE_SHARE = 0.1, 0.015, 0.001
# What the rig's chirps leave: of a response averaged over neighbouring lines, and of the slip by the linear law.
ESTIMATE_SHARE, LINEAR_SHARE = 0.005, 0.05
# Places and sizes at which the fit of a second mode begins; it lies this far from the first.
PLACES, SHARES, APART = 40, (0.03, 0.15, 0.5), 1.15
# Knots over the logarithm of the frequency of what an unknown cause may do, as a share of the response.
KNOTS = (6, 18)
# What may be wrong within its figures of what suspects are too.
TOLERANCES = ("structure", "inertia")
# Standard deviation of what is always free and nobody knows, over its typical size.
OPEN = 10.0

Mask = NDArray[np.bool_]


@dataclass(frozen=True, eq=False)
class Suspect:
    """What may be wrong, by the figures ``shapes`` (name: typical size and bounds), of which the first is reported as
    ``figure``; all are 0 where nothing is. ``grid``: values at which a fit may begin.

    ``words``: physics, where to look, what separates it, plain; as of :class:`mbcdm_cad.loop.result.Named`.
    """

    name: str
    form: str
    figure: str
    words: tuple[str, str, str, str]
    shapes: dict[str, tuple[float, float, float]]
    grid: tuple[dict[str, float], ...]

    @property
    def parameter(self) -> str:
        """Name of its first figure in the model."""
        return next(iter(self.shapes))

    @property
    def last(self) -> bool:
        """Whether it is a shape rather than a cause."""
        return False

    @property
    def key(self) -> str:
        """Forms with the same key have the same name."""
        return self.name

    @property
    def label(self) -> str:
        """Name and form."""
        return f"{self.name} ({self.form})"


_LEVELS = "runs of a third and three times the amplitude: slip of the wraps goes with it"
_TORQUE = "log the torque between drum and what it turns, or repeat with another known inertia at the output"
_LATE = "an output sensor of known latency; both sensors on one shaft"
# Suspects of the bench, and the name of a mode of which no design says where it should be.
BENCH, MODE, SECOND = ("delay", "lag", "gain"), "torsional_mode", "second_mode"
# Those that no design file holds.
NOT_DESIGNED = ("lag", "behind", "inertia")
# By name, form, parameter and figure: the words.
_SUSPECTS = {
    ("delay", "late sensor", "delay", "delay_s"): (
        "the bench, not the drive: the output is read later than the input, a phase in proportion to frequency",
        "filter of the output encoder, time stamps of the logger",
        _LATE,
        "the bench reads the output {delay_s} later than the input",
    ),
    ("delay", "low-pass of the output", "lag", "lag_s"): (
        "a filter of first order lags and weakens the output: it is of the bench and not of the drive",
        "filter of the output encoder",
        _LATE,
        "the bench filters the output with a time constant of {lag_s}",
    ),
    ("ratio_error", "pitch radius or encoder scale", "gain", "share"): (
        "output over input differs from the declared ratio at all frequencies",
        "counts per turn and units of the encoders; pitch radii",
        "a full turn of each encoder against a reference",
        "the ratio of output to inputs is {share} {way_share} than declared",
    ),
    (MODE, "inputs held", "mode", "natural_frequency_Hz"): (
        "behind the inputs the output swings on what gives between; at the frequency given where nothing slips",
        "stiffness and inertia, against the design",
        "give the design file: it says what the mode should be",
        "for small motion the output swings at {natural_frequency_Hz}",
    ),
    ("stiffness_error", "modulus of the rope", "modulus", "share"): (
        "E A of the rope or its free length differs: stiffness and slip scale",
        "a pull test of the rope after bedding in",
        _TORQUE,
        "the rope's stiffness is {share} {way_share} than the design file says",
    ),
    ("stiffness_error", "compliance in series", "series", "compliance_rad_Nm"): (
        "drum, shafts, bearings or frame give more than computed, or less if below zero",
        "screws of hub and frame, bearings, shafts",
        f"{_TORQUE}; {_LEVELS}",
        "the compliance of the drive's structure is {compliance_rad_Nm} {way_compliance_rad_Nm} than computed",
    ),
    ("stiffness_error", "compliance behind the output encoder", "behind", "compliance_rad_Nm"): (
        "hub, coupling or payload gives behind the encoder",
        "hub clamp and coupling, between the output encoder and what it turns",
        _TORQUE,
        "between the output encoder and what it turns something gives {compliance_rad_Nm}",
    ),
    ("payload_inertia", "all that the output turns", "inertia", "share"): (
        "what the output turns is heavier or lighter than declared",
        "weigh the payload and swing it as a pendulum; inertia_plate and loads.payload",
        _TORQUE,
        "what the output turns has an inertia {share} {way_share} than declared",
    ),
    ("preload_error", "all cables", "preload", "share"): (
        "the tension set at all tensioners differs, or the friction of the wraps: slip goes with 1/(mu T)",
        "tension of each cable by plucking or a gauge",
        _LEVELS,
        "the tension of all cables is {share} {way_share} than the design file says",
    ),
}


# What a second mode may be: form, physics, where to look, plain; by what swings.
_SECOND = {
    "arm": (
        "arm or frame",
        "a part of what the output turns, or the frame that carries the drive, swings on its own: at {own} the output "
        "stands still, and a second mode is beside it; no cause of the drive",
        "the payload's arm and its coupling; the frame, its feet and what it stands on",
        "the output has a second mode at {natural_frequency_Hz}, in payload or frame",
    ),
    "front": (
        "mass in front of the drum",
        "a mass between the inputs' encoders and the drum swings on its own, at {own} with both held",
        "encoders on the motors: the pulley on its gearhead; guide pulleys and shafts in front of the drum",
        "the output has a second mode at {natural_frequency_Hz}, in front of the drum",
    ),
}


def suspects(d: DriveSI | None, held: behind_inputs.BehindInputs, highest_Hz: float) -> tuple[Suspect, ...]:
    """Everything that a frequency response can show of a drive."""
    turn = 0.45 / highest_Hz
    shares = np.concatenate([-np.geomspace(0.7, 0.01, 16), np.geomspace(0.01, 3.0, 20)])
    stiff = float(held.cables_rad_Nm[0]) + held.before_drum
    gives = (2.0 * np.pi * highest_Hz * np.geomspace(0.03, 1.0, 96)) ** -2.0
    # Grid, typical size and bounds of each parameter.
    shapes = {
        "delay": (np.linspace(-8.0 * turn, 8.0 * turn, 97), 1e-4, -np.inf, np.inf),
        "lag": (np.geomspace(0.02 * turn, 4.0 * turn, 24), 1e-4, 0.0, np.inf),
        "gain": (np.array([-0.1, -0.01, 0.01, 0.1]), 1e-3, -0.5, 0.5),
        "mode": (gives, float(gives[48]), 0.0, np.inf),
        "modulus": (shares, 0.01, -0.8, 4.0),
        "series": (stiff * shares, 0.01 * stiff, -0.95 * stiff, np.inf),
        "behind": (stiff * np.geomspace(0.01, 2.0, 20), 0.01 * stiff, 0.0, np.inf),
        "inertia": (shares, 0.01, -0.9, 9.0),
        "preload": (shares, 0.01, -0.6, 9.0),
    }
    offered = (*BENCH, "mode") if d is None else tuple(name for name in shapes if name != "mode")
    found = []
    for (name, form, parameter, figure), words in _SUSPECTS.items():
        if parameter in offered:
            grid, size, low, high = shapes[parameter]
            starts = tuple({parameter: float(at)} for at in (0.0, *grid))
            found.append(Suspect(name, form, figure, words, {parameter: (size, low, high)}, starts))
    return tuple(found)


def second_modes(low_Hz: float, high_Hz: float, first_Hz: float) -> Iterator[Suspect]:
    """What may swing on its own within these frequencies, away from the first mode."""
    grid = [at for at in np.geomspace(low_Hz, high_Hz, PLACES) if abs(np.log(at / first_Hz)) > np.log(APART)]
    for what, (form, physics, look, plain) in _SECOND.items():
        names = [f"{what}_{figure}" for figure in ("Hz", "share", "damping")]
        starts = tuple(dict(zip(names, (float(at), share, 0.02), strict=True)) for share in SHARES for at in grid)
        shapes = ((0.1 * first_Hz, low_Hz, high_Hz), (0.1, 0.0, 0.95), (0.05, 0.0, 0.5))
        words = physics, look, "repeat without the payload, and with the frame clamped", plain
        yield Suspect(SECOND, form, "natural_frequency_Hz", words, dict(zip(names, shapes, strict=True)), starts)


@dataclass(frozen=True, eq=False)
class ResponseFit:
    """Figures that fit the responses; ``weighted`` (n,): what is left of all averages over its noise.

    ``covariance`` of the figures ``free``, and ``slopes`` (2 n, k): derivatives of what is left by them.
    """

    effects: tuple[Suspect, ...]
    values: dict[str, float]
    weighted: Complex
    covariance: Floats
    slopes: Floats
    free: tuple[str, ...]

    def half(self, parameter: str) -> float:
        """Half width of the interval of a figure that was free, by the scatter that is left."""
        at = self.free.index(parameter)
        return INTERVAL * float(np.sqrt(self.covariance[at, at]))


def _sigmas(seen: FrequencyResponse, held: behind_inputs.BehindInputs, v: behind_inputs.Values) -> list[Floats]:
    """Noise of each quotient: its scatter, what averaging leaves, and what the linear law of the slip leaves."""
    inertia, gain = held.payload_kg_m2 + held.drum_kg_m2, np.abs(seen.output.value)
    torque = behind_inputs.carried_Nm(seen, inertia)
    slip = np.interp(torque, held.torque_Nm, held.cables_rad_Nm) - held.cables_rad_Nm[0]
    slip = LINEAR_SHARE * (slip + v.get("softening", 0.0) * torque)
    # By how much the quotients change with the compliance.
    slopes = ((gain * 2.0 * np.pi * seen.frequency_Hz) ** 2 * inertia, 1.0)
    if seen.over_torque:
        slopes = ((gain / (held.cables_rad_Nm[0] + held.before_drum + held.behind_drum)) ** 2, 1.0)
    pairs = zip(seen.quotients, slopes, strict=False)
    return [np.sqrt(q.sigma**2 + (ESTIMATE_SHARE * np.abs(q.value)) ** 2 + (slope * slip) ** 2) for q, slope in pairs]


class ResponseLoop(Moves[ResponseFit]):
    """The loop on frequency responses of one drive."""

    def __init__(self, drive: Drive | None, ratio: float, runs: Sequence[Run]) -> None:
        self.runs, self.drive, self.d = tuple(runs), drive, None if drive is None else layout_of(drive).si
        self.seen = [response_of(run, ratio) for run in runs]
        if drive is None:  # nothing says what the torque turns
            self.seen = [replace(one, twist=None) for one in self.seen]
        most = [float(one.acceleration_rad_s2.max()) for one in self.seen]
        pairs = zip(runs, most, strict=True)
        self.held = [
            behind_inputs.RIGID_DRIVE if drive is None else behind_inputs.behind_inputs(drive, *pair) for pair in pairs
        ]
        # Of a table without an amplitude nothing says how much the wraps slip.
        self.held = [held if one.levelled else held.at(0.0) for held, one in zip(self.held, self.seen, strict=True)]
        levelled, by_torque = (
            all(row) for row in zip(*((one.levelled, one.over_torque) for one in self.seen), strict=True)
        )
        self.highest_Hz = max(float(one.frequency_Hz[-1]) for one in self.seen)
        self.library = suspects(self.d, self.held[0], self.highest_Hz)
        if by_torque:  # nothing is over the inputs
            self.library = tuple(one for one in self.library if one.parameter != "gain")
        # What an earlier loop found is declared.
        self.declared = {
            one.parameter: value.value
            for entry in (() if drive is None else drive.as_built)
            for one in self.library
            if (one.name, one.form) == (entry.name, entry.form)
            for value in entry.values
        }
        # Standard deviations of what is not known better; none is off by more than two.
        self.prior = {"scale": SCALE_SHARE}
        if any(np.ptp(held.cables_rad_Nm) > 0.0 for held in self.held):
            self.prior["slip"] = SLIP_SHARE
        if drive is not None:
            self.prior["law"] = LAW_SHARE
        if any(one.twist is not None or one.over_torque for one in self.seen):
            classes = [run.sensors.torque_class for run in runs]
            self.prior["load_gain"] = 0.5 * max(one.share for one in classes) + 1e-6
            self.prior["load_lag"] = 0.5 * max(one.lag_s for one in classes) + 1e-6
        if drive is not None:
            self.prior["structure"] = max(held.sigma_rad_Nm for held in self.held)
            self.prior["inertia"] = max(run.plate.inertia_share for run in runs)
        # Size and bounds of what is always free.
        self.nuisances = {"loss": (0.02, 0.0, 1.0), "viscous_s": (1e-4, 0.0, 0.1)}
        if drive is None:  # slip of wraps that nothing is known of
            self.nuisances["softening"] = (0.1 * (2.0 * np.pi * self.highest_Hz) ** -2.0 / max(most), 0.0, np.inf)
        elif not levelled:
            held = self.held[0]
            size = 0.1 * float(held.cables_rad_Nm[0]) / (max(most) * (held.payload_kg_m2 + held.drum_kg_m2))
            self.nuisances["softening"] = (size, 0.0, np.inf)
        self.prior = {name: sigma for name, sigma in self.prior.items() if sigma > 0.0}
        # None of these is off by more than two standard deviations.
        self.nuisances |= {name: (sigma, -2.0 * sigma, 2.0 * sigma) for name, sigma in self.prior.items()}
        quotients = [one for seen in self.seen for one in seen.quotients]
        self.measured = np.concatenate([one.value for one in quotients])
        self.scatter = np.concatenate([one.sigma for one in quotients])
        self.test: Mask = np.concatenate([np.arange(one.value.size) % ONE_OF == 1 for one in quotients])
        self.every: Mask = np.ones(self.test.size, dtype=bool)
        # Amplitude of the inputs, and of a torque, for which errors are stated: the usual one.
        levels = {
            one.over_torque: [other.input_rad for other in self.seen if other.over_torque == one.over_torque]
            for one in self.seen
        }
        self.amplitude = {over: float(np.median(np.concatenate(rows))) for over, rows in levels.items()}
        self.names = len({one.name for one in self.library}) + 1
        self._weigh({})
        first = behind_inputs.first_mode(self.held[0], self.bare.values, 0.0)[0]
        if drive is None:  # nothing says where the first mode is
            mode = next(one for one in self.library if one.name == MODE)
            first = behind_inputs.first_mode(self.held[0], self.best(self.bare, mode).values, 0.0)[0]
        low = min(float(one.frequency_Hz[0]) for one in self.seen)
        self.library += tuple(second_modes(low, self.highest_Hz, first))

    def _weigh(self, v: behind_inputs.Values) -> None:
        """Set the noise of all averages; of a drive without a design with the slip that a fit ``v`` found."""
        sigmas = [_sigmas(seen, held, v) for seen, held in zip(self.seen, self.held, strict=True)]
        self.sigma = np.concatenate([row for rows in sigmas for row in rows])
        # What averaging and the linear law leave goes together over the width of the peak: there averages count as one.
        gains = [np.abs(one.output.value) for one in self.seen]
        together = max(int(np.sum(gain > np.sqrt(0.5) * gain.max())) for gain in gains)
        self.together = 1.0 + (together - 1.0) * float(np.mean(1.0 - (self.scatter / self.sigma) ** 2))
        pairs = zip(sigmas, self.seen, strict=True)
        outputs = np.concatenate([rows[0] * self.amplitude[seen.over_torque] for rows, seen in pairs])
        self._floor_rad = 1.0 / float(np.sqrt(np.mean(outputs**-2.0)))
        self.bare, self.before = self.fit(()), self.fit((), known=TOLERANCES)
        self.rescaled(self.scales)

    def rescaled(self, scales: Floats) -> None:
        """Take other scales of an unknown cause, and forget what was found under others."""
        self.scales, self._known = scales, dict[ResponseFit, Weighed]()
        self.forget()
        noise = NoiseModel(float(np.sqrt(self.together)))
        none = np.zeros((2 * self.measured.size, 0)), np.zeros((2, 0))
        self.white = NoiseOfUnknownSize(noise, *none, self._curves(), self.names, noise.white_rad, scales)

    def _curves(self) -> tuple[Floats, ...]:
        """What an unknown cause may do: a smooth share of the response over the logarithm of the frequency."""
        at = np.log(np.concatenate([one.frequency_Hz for one in self.seen for _ in one.quotients]))
        found = []
        for knots in KNOTS:
            hats = np.stack(hats_over(at, knots), axis=1) * (self.measured / self.sigma)[:, None]
            both = np.hstack([hats, 1j * hats])
            rows = np.vstack([both.real, both.imag])
            found.append(rows / np.sqrt(np.mean(rows**2) * rows.shape[1]))
        return tuple(found)

    @property
    def floor_rad(self) -> float:
        """The noise floor, rad RMS."""
        return self._floor_rad

    @property
    def noise(self) -> Noise:
        """The noise floor."""
        n = sum(one.frequency_Hz.size for one in self.seen)
        source = f"scatter of the response in {n} averages, and what averaging and the linear law leave"
        return Noise(self.floor_rad, self.floor_rad, 0.0, 0.0, 0.0, source)

    # Fits.

    def weighted(self, v: behind_inputs.Values) -> Complex:
        """What figures leave of all averages, over its noise, (n,)."""
        pairs = zip(self.held, self.seen, strict=True)
        rows = [row for held, seen in pairs for row in behind_inputs.predicted(held, v, seen)[: len(seen.quotients)]]
        return np.asarray((self.measured - np.concatenate(rows)) / self.sigma)

    def _residual(self, v: behind_inputs.Values, mask: Mask) -> Floats:
        left = self.weighted(v)[mask]
        return np.concatenate([left.real, left.imag])

    def fit(
        self,
        chosen: Sequence[Suspect],
        start: behind_inputs.Values | None = None,
        mask: Mask | None = None,
        known: Sequence[str] = (),
    ) -> ResponseFit:
        """The fit of some suspects beside the nuisances, but those ``known``, on all averages or those of ``mask``."""
        used = self.every if mask is None else mask
        free = {name: shape for name, shape in self.nuisances.items() if name not in known}
        free |= {name: shape for one in chosen for name, shape in one.shapes.items()}
        begin = {**self.declared, **dict.fromkeys(self.nuisances, 0.0), "loss": 0.02, **(start or {})}
        size, low, high = np.array(list(free.values())).T
        x0 = np.clip([begin.get(name, 0.0) for name in free], low + 1e-9 * size, high - 1e-9 * size)
        own = {name for one in chosen for name in one.shapes}
        priors = [name for name in free if name in self.prior and name not in own]

        def figures(x: Floats) -> dict[str, float]:
            return {**begin, **dict(zip(free, x.tolist(), strict=True))}

        def residual(x: Floats) -> Floats:
            v = figures(x)
            return np.append(self._residual(v, used), [v[name] / self.prior[name] for name in priors])

        most = 40 + 40 * any(one.name == SECOND for one in chosen)
        found = least_squares(residual, x0, x_scale=size, bounds=(low, high), max_nfev=most, ftol=1e-4, xtol=1e-4)
        n = 2 * int(used.sum())
        scatter = max(1.0, float(np.sum(found.fun[:n] ** 2)) / max(n - len(free), 1))
        scaled = found.jac * size  # else what has large figures, as a frequency, would count as known
        scaled[:n] /= np.sqrt(scatter * self.together)
        covariance = np.linalg.pinv(scaled.T @ scaled) * np.outer(size, size)
        values = figures(found.x)
        return ResponseFit(tuple(chosen), values, self.weighted(values), covariance, found.jac[:n], tuple(free))

    def best(self, fit: ResponseFit, cause: Suspect) -> ResponseFit:
        """The likeliest fit with one suspect more, over its starts."""
        cost = [float(np.sum(self._residual({**fit.values, **start}, self.every) ** 2)) for start in cause.grid]
        starts = np.argsort(cost)[:TRIED]
        if cause.name == SECOND:  # one share too many may draw all starts to a wrong place
            n = len(cause.grid) // len(SHARES)
            starts = n * np.arange(len(SHARES)) + np.reshape(cost, (len(SHARES), n)).argmin(axis=1)
        trials = [self.fit((*fit.effects, cause), {**fit.values, **cause.grid[k]}) for k in starts]
        return max(trials, key=self.log_of)

    def planned(self) -> tuple[Whitened, dict[Suspect, Floats]]:
        """For a plan: noise and nuisances at the declared figures, and derivatives of all averages over their noise by
        each suspect, (2 n,)."""
        at, base, found = self.bare.values, self.weighted(self.bare.values), {}
        for one in self.library:
            size = one.shapes[one.parameter][0]
            if one.name != SECOND:
                change = base - self.weighted({**at, one.parameter: at.get(one.parameter, 0.0) + DIFFERENCE * size})
                found[one] = np.concatenate([change.real, change.imag]) / (DIFFERENCE * size)
        sizes = np.array([self.prior.get(name, OPEN * self.nuisances[name][0]) for name in self.bare.free])
        bounds = np.full((2, sizes.size), np.inf) * np.array([[-1.0], [1.0]])
        return Whitened(self.white.noise, -self.bare.slopes * sizes, bounds, self._curves(), self.names), found

    # Moves.

    def _rms(self, weighted: Complex) -> float:
        """Error in rad RMS for inputs of the usual amplitude."""
        return self.floor_rad * float(np.sqrt(0.5 * np.mean(np.abs(weighted) ** 2)))

    def rms(self, fit: ResponseFit) -> float:
        """Error of all averages."""
        return self._rms(fit.weighted)

    def of(self, fit: ResponseFit) -> Weighed:
        """Evidence of a fit, linear about it."""
        if fit not in self._known:
            slopes, weighted = -fit.slopes, np.concatenate([fit.weighted.real, fit.weighted.imag])
            whole = self._rms(self.before.weighted) / self.floor_rad
            shapes = {name: shape for one in fit.effects for name, shape in one.shapes.items()}
            at = np.array([fit.values[name] for name in fit.free])
            rms = np.sqrt(np.mean(slopes**2, axis=0))
            sd, bounds = [], []
            for k, name in enumerate(fit.free):
                size, low, high = shapes.get(name) or self.nuisances[name]
                sd.append(self.prior.get(name, OPEN * size))
                if name in shapes:
                    sd[-1] = whole / max(float(rms[k]), 1e-300)
                if name.startswith(tuple(_SECOND)):
                    sd[-1] = (high - low) / np.sqrt(12.0)
                bounds.append((low, high))
            columns = np.column_stack([slopes, weighted + slopes @ at])
            self._known[fit] = self.white.evidence_of(columns, np.array(sd), np.array(bounds).T)
        return self._known[fit]

    def without(self, fit: ResponseFit, cause: Suspect) -> ResponseFit:
        """The fit without one of its suspects."""
        start = {**fit.values, **{name: self.declared.get(name, 0.0) for name in cause.shapes}}
        rest = [one for one in fit.effects if one is not cause]
        if not rest:
            return self.bare
        key = frozenset(rest)
        if key not in self._without:
            self._without[key] = self.fit(rest, start)
        return self._without[key]

    def trials(self, now: ResponseFit) -> list[ResponseFit]:
        """Fits with one suspect more: others, and one of the forms of a delay and of a second mode."""
        taken = {one.name for one in now.effects if one.name in ("delay", SECOND)}
        if self.d is None and not any(one.name == MODE for one in now.effects):
            taken.add(SECOND)  # without its first mode the drive is rigid, and the second would take its place
        offered = [one for one in self.library if one not in now.effects and one.name not in taken]
        return [fit for one in offered if self._possible(fit := self.best(now, one), one)]

    def _possible(self, fit: ResponseFit, cause: Suspect) -> bool:
        """Whether a figure is more than its interval; and whether a second mode lies within the band."""
        name = cause.parameter
        at, half = fit.values[name], fit.half(name)
        if cause.name != SECOND:
            return abs(at - self.declared.get(name, 0.0)) > half
        (_, low, high), what = cause.shapes[name], name.removesuffix("_Hz")
        within = low < at < high and low < self._peak_Hz(what, fit.values) < high and half < at
        # In front of the drum a share of 0 is no absence.
        return within and (what == "front" or fit.values["arm_share"] > fit.half("arm_share"))

    # Result.

    def result(self) -> LoopResult:
        """Select, compare with alternatives, judge."""
        whole = self.found()
        if self.d is None:
            self._weigh(whole.values)
            whole = self.found()
        whole, _ = self.withdrawn(whole)
        named, sets = self.told(whole)
        fit = self.fit(whole.effects, whole.values, ~self.test)
        found = self._errors(fit)
        left = self._left(whole) if self.unexplained(whole) else None
        modes = [self._mode(k, whole) for k in range(len(self.runs))]
        return LoopResult(
            verdict_of([*named, *sets], left),
            tuple(named),
            tuple(sets),
            left,
            found,
            *self.candidates(whole),
            self._not_testable(),
            next_steps(named, sets, left),
            {},
            noise=self.noise,
            within_class=self._within_class(whole),
            pictures=self._pictures(whole),
            modes=tuple(mode for mode in modes if mode is not None),
        )

    def _within_class(self, fit: ResponseFit) -> str:
        """By what structure and declared inertia are wrong within their figures, where that is told from nothing."""
        units = {"structure": "compliance_rad_Nm", "inertia": "share"}
        own = {name for one in fit.effects for name in one.shapes}
        told = [name for name in units if name in self.prior and name not in own]
        told = [name for name in told if abs(fit.values[name]) > self.prior[name]]
        words = [f"{readable(units[name], [fit.values[name]])[1][0]} of the {name}" for name in told]
        return f"an error of {' and '.join(words)}, within what is known of them" if words else ""

    def _peak_Hz(self, what: str, v: behind_inputs.Values) -> float:
        """Where a second mode raises the response the most."""
        near = v[f"{what}_Hz"] * np.geomspace(0.5, 2.0, 2000)
        level = np.interp(near, self.seen[0].frequency_Hz, self.seen[0].acceleration_rad_s2)
        fine = replace(self.seen[0], frequency_Hz=near, acceleration_rad_s2=level, twist=None, over_torque=False)
        beside, without = (
            behind_inputs.predicted(self.held[0], {**v, **more}, fine)[0] for more in ({}, {f"{what}_Hz": 0.0})
        )
        return float(near[np.argmax(np.abs(beside / without))])

    def _second_named(self, one: Suspect, fit: ResponseFit, fall_rad: float) -> Named:
        """A second mode: its frequency, where the peak of the fitted response is, and what it may be."""
        what = one.parameter.removesuffix("_Hz")
        own, half = fit.values[one.parameter], fit.half(one.parameter)
        peak = self._peak_Hz(what, fit.values)
        figures = {"natural_frequency_Hz": Value(peak, *(peak * (1.0 + sign * half / own) for sign in (-1.0, 1.0)))}
        if what == "arm":
            share, spread = fit.values["arm_share"], fit.half("arm_share")
            figures["share"] = Value(share, share - spread, share + spread)
        physics, look, separate, plain = one.words
        physics = physics.format(own=f"{own:.4g} Hz")
        if self.drive is not None:
            modes = behind_inputs.own_modes_Hz(self.held[0], self.drive)
            same = [f"{one:.4g}" for one in modes if abs(np.log(one / peak)) < np.log(APART)]
            shown = ", ".join(same or [f"{one:.4g}" for one in modes])
            physics += (
                f"; the design has a mode near it, {shown} Hz"
                if same
                else f"; the design has no mode near it, but {shown} Hz"
            )
        return Named(SECOND, one.form, None, (), figures, {}, (), look, separate, physics, fall_rad, {}, plain=plain)

    def named(self, one: Suspect, fit: ResponseFit, fall_rad: float) -> Named:
        if one.name == SECOND:
            return self._second_named(one, fit, fall_rad)
        value, half = fit.values[one.parameter], fit.half(one.parameter)
        ends = np.array([value, value - half, value + half])
        if one.name == MODE:
            ends = np.maximum(ends[[0, 2, 1]], 1e-30) ** -0.5 / (2.0 * np.pi)
        cables = self.d.cable_names if self.d is not None and one.name == "preload_error" else ()
        figures, fitted = {one.figure: Value(*ends.tolist())}, {one.figure: value}
        physics, look, separate, plain = one.words
        if one.parameter in NOT_DESIGNED:
            fitted = {}
        return Named(
            one.name, one.form, None, cables, figures, {}, (), look, separate, physics, fall_rad, fitted, plain=plain
        )

    def _errors(self, fit: ResponseFit) -> Errors:
        rows = [one.weighted[self.test] for one in (self.before, fit)]
        first, last = (self.floor_rad * float(np.abs(row).max()) for row in rows)
        sizes = {over: readable("_Nm" if over else "_rad", [size])[1][0] for over, size in self.amplitude.items()}
        of = " and ".join(f"{'torques' if over else 'inputs'} of {size}" for over, size in sizes.items())
        held = f"every fourth average; errors of the output for {of} at all frequencies, by their certainty"
        return errors_of(self._interval(rows[0]), self._interval(rows[1]), first, last, self.floor_rad, held)

    def _interval(self, weighted: Complex) -> Value:
        squares = 0.5 * np.abs(weighted) ** 2
        middle, half = float(squares.mean()), INTERVAL * float(np.std(squares)) / np.sqrt(squares.size)
        ends = (middle, max(0.0, middle - half), middle + half)
        return Value(*(self.floor_rad * float(np.sqrt(end)) for end in ends))

    def _left(self, whole: ResponseFit) -> LeftOver:
        """What is left of all averages, and at which frequencies the most."""
        at = np.concatenate([one.frequency_Hz for one in self.seen for _ in one.quotients])
        order, squares = np.argsort(at), np.abs(whole.weighted) ** 2
        share = np.cumsum(squares[order]) / squares.sum()
        low, high = (float(at[order][np.searchsorted(share, end)]) for end in (0.25, 0.75))
        peak = self.floor_rad * float(np.sqrt(squares.max()))
        words = f"half of it between {low:.3g} and {high:.3g} Hz"
        return LeftOver(self._rms(whole.weighted), peak, self.floor_rad, (), (), 0.0, (), hangs_on=words)

    def _not_testable(self) -> tuple[str, ...]:
        words = ["friction, play, ripple and all that goes with angle or lasts: a response is for small fast motion"]
        if self.d is None:
            return (*words, "only the ratio is known: whether the mode is where it should be")
        lowest = min(behind_inputs.first_mode(held, self.declared, 0.0)[0] for held in self.held)
        if lowest > self.highest_Hz:
            words.append(
                f"the first mode of the design, {lowest:.4g} Hz, is not within {self.highest_Hz:.4g} Hz: log faster, "
                "or let the output turn more inertia"
            )
        if not all(one.levelled for one in self.seen):
            words.append(
                "no amplitude: preload, and slip of the wraps, which is told from a soft rope by its damping alone"
            )
        if all(one.twist is None and not one.over_torque for one in self.seen):
            words.append("no torque: which of stiffness and inertia differs, if all runs have one inertia")
        return tuple(words)

    def _mode(self, k: int, whole: ResponseFit) -> TorsionalMode | None:
        """The mode of one run, fitted for itself as linear; None where it is not in the band."""
        held, seen = self.held[k], self.seen[k]
        inertia = held.payload_kg_m2 * (1.0 + whole.values.get("inertia", 0.0)) + held.drum_kg_m2
        carried = behind_inputs.carried_Nm(seen, inertia)

        def beyond(amplitude: float) -> float:
            return amplitude - float(
                np.interp(behind_inputs.first_mode(held, whole.values, amplitude)[0], seen.frequency_Hz, carried)
            )

        amplitude = float(brentq(beyond, 0.0, float(carried.max())))
        frequency = behind_inputs.first_mode(held, whole.values, amplitude)[0]
        if not seen.frequency_Hz[0] < frequency < seen.frequency_Hz[-1]:
            return None
        alone = copy(self)
        alone.seen, alone.held, alone.prior = [replace(seen, twist=None)], [held.at(amplitude)], {}
        alone.nuisances = {"load_gain": (0.01, -0.9, 9.0)} if seen.over_torque else {}
        alone.nuisances["loss"] = self.nuisances["loss"]
        alone.every = np.ones(seen.frequency_Hz.size, dtype=bool)
        alone.sigma = _sigmas(seen, held, whole.values)[0]
        size = "mode" if self.d is None else "inertia"
        free = [one for one in self.library if one.parameter in ("delay", "gain", size)]

        def linear(response: Complex, values: behind_inputs.Values) -> tuple[Value, Value]:
            """Frequency and damping ratio of a response as that of a linear drive."""
            alone.measured = response
            fit = alone.fit(free, {**values, "loss": 0.1, "softening": 0.0})
            found, damping = behind_inputs.first_mode(alone.held[0], fit.values, amplitude)
            half = 0.5 * fit.half(size) / (fit.values[size] + (0.0 if self.d is None else 1.0)) * found
            spread = 0.5 * fit.half("loss")
            return (
                Value(found, found - half, found + half),
                Value(damping, max(damping - spread, 0.0), damping + spread),
            )

        mode = TorsionalMode(self.runs[k].source, *linear(seen.output.value, whole.values), None, None, None)
        if self.d is None:
            return mode
        # The design has no damping but that of its wraps, and no second mode.
        no_more = {"viscous_s": 0.0} | {f"{what}_Hz": 0.0 for what in _SECOND}
        declared, damping = linear(behind_inputs.predicted(held, self.declared, seen)[0], {**whole.values, **no_more})
        torque = amplitude if seen.levelled else None
        return replace(mode, torque_Nm=torque, declared_Hz=declared.value, declared_damping=damping.value)

    def _pictures(self, whole: ResponseFit) -> tuple[BodePicture, ...]:
        found = []
        # The design has no figure for the damping besides that of the wraps.
        declared = {**self.declared, "loss": whole.values["loss"]}
        for run, seen, held in zip(self.runs, self.seen, self.held, strict=True):
            before, after = (behind_inputs.predicted(held, v, seen)[0] for v in (declared, whole.values))
            output = seen.output
            rows = output.value, output.coherence, before, after
            found.append(BodePicture(run.source, seen.frequency_Hz, *rows, seen.over_torque))
        return tuple(found)
