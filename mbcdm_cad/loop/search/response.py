"""The loop on frequency responses: the first mode behind the inputs, its stiffness over amplitude, delays of the bench.

Output over inputs does not depend on motors, gearheads and position loops, as far as the inputs' encoders see them: its
poles are the modes with the inputs held. Behind them the cables, whose wraps slip the more the higher the torque, and
the parts turn drum and payload. The cables' law is linearised at the torque that each frequency carries. A slip that
goes with the square of the torque (Masing) has the part 1 - 4i/(3 pi) of its compliance in the first harmonic, so that
softening and hysteresis are one figure.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from copy import copy
from dataclasses import dataclass, replace
from math import exp, log
from typing import Any

import numpy as np
from scipy.optimize import least_squares
from scipy.stats import f as f_distribution

from mbcdm_cad.design.drive import Drive
from mbcdm_cad.layouts.base import NoFigureError
from mbcdm_cad.layouts.lumped import compliance_of
from mbcdm_cad.layouts.structure import sigma_urad_Nm
from mbcdm_cad.loop.prepare.noise import Noise
from mbcdm_cad.loop.readable import Value, readable
from mbcdm_cad.loop.result import BodePicture, Errors, Evidence, LoopResult, Named, TorsionalMode
from mbcdm_cad.loop.search.account import INTERVAL, next_steps
from mbcdm_cad.loop.search.few import MOST_EFFECTS, ODDS
from mbcdm_cad.loop.search.few_words import CHANCE, LeftOver
from mbcdm_cad.loop.search.select import LEAST_FALL
from mbcdm_cad.measurement.response import FrequencyResponse, response_of
from mbcdm_cad.measurement.run import Run
from mbcdm_cad.model.backlash import drum_backlash
from mbcdm_cad.model.si import DriveSI, to_si
from mbcdm_cad.routes import Complex, Floats

# Part of the slip's compliance out of phase with the torque.
HYSTERESIS = 4.0 / (3.0 * np.pi)
# Standard deviations as shares: of the slip, by the linear law at one amplitude and the friction of the wraps; of all
# compliance, by lumped inertias and the law (the rig's modes are up to 1.5 % above the model's).
SLIP_SHARE, LAW_SHARE = 0.1, 0.015
# Standard deviation of radii and scales of the encoders.
SCALE_SHARE = 0.001
# Accuracy of a response that is averaged over neighbouring lines, as a share; and of the linear law, as a share of the
# slip: the rig's chirps leave so much.
ESTIMATE_SHARE, LINEAR_SHARE = 0.005, 0.05
# Amplitudes at which the cables' law is computed, and the least of them as a share of the largest.
AMPLITUDES, LEAST_AMPLITUDE, MOST_AMPLITUDE = 32, 1e-3, 2.5
# Sizes from which a fit begins, the best of the grid.
TRIED = 2
# Step of a difference quotient, of the typical size.
SLOPE = 1e-2
# Steps in which amplitude and frequency of a mode settle.
SETTLED = 12
# A mode lies in the band if its frequency is this far inside.
INSIDE = 1.05


@dataclass(frozen=True, eq=False)
class BehindInputs:
    """A drive behind its inputs: compliances in rad/(N m) and inertias in kg m2 at the output.

    ``cables_rad_Nm`` over the amplitude of the torque ``torque_Nm``; ``before_drum`` and ``behind_drum`` of the parts,
    ``seen`` what the encoder sees of the latter; ``sigma_rad_Nm`` of the parts together.
    """

    torque_Nm: Floats
    cables_rad_Nm: Floats
    before_drum: float = 0.0
    behind_drum: float = 0.0
    seen: float = 0.0
    sigma_rad_Nm: float = 0.0
    drum_kg_m2: float = 0.0
    payload_kg_m2: float = 1.0

    def at(self, amplitude_Nm: float) -> BehindInputs:
        """The same with the cables linear as they are at this amplitude, without their hysteresis."""
        cables = float(np.interp(amplitude_Nm, self.torque_Nm, self.cables_rad_Nm))
        return replace(self, torque_Nm=np.zeros(1), cables_rad_Nm=np.full(1, cables))


# Of a drive of which only the ratio is known: rigid, with a payload of 1.
RIGID_DRIVE = BehindInputs(np.zeros(1), np.zeros(1))


def behind_inputs(drive: Drive, run: Run, most_rad_s2: float) -> BehindInputs:
    """The design behind the inputs of a run whose output accelerates by ``most_rad_s2`` at most."""
    d, layout = to_si(drive), drive.layout
    bodies, routes = layout.inertias_kg_m2, layout.routed.routes
    drum = bodies[routes.drum.name] + sum(bodies[b.name] * b.turns_per_drum**2 for b in routes.passed)
    payload = drive.loads.carried.about_axis_kg_m2 + run.plate.inertia_kg_m2
    torque = np.geomspace(LEAST_AMPLITUDE, MOST_AMPLITUDE, AMPLITUDES) * most_rad_s2 * (drum + payload)
    cables = drum_backlash(d, torque).reversal_swing_rad / (2.0 * torque)
    held = BehindInputs(torque, cables, drum_kg_m2=drum, payload_kg_m2=payload)
    if run.counted is None or not run.counted.structure:
        return held
    try:
        structure = layout.structure
    except NoFigureError:
        return held
    if structure is None:
        return held
    chain, give = structure.chain, compliance_of(drive)
    motors = structure.motor_encoders or any(run.motor_side) or run.counted.inputs_at == "motors"
    before = chain.before_drum + (chain.before_inputs if motors else 0.0)
    inside = give.land_to_encoder - chain.before_drum - (chain.before_inputs if structure.motor_encoders else 0.0)
    seen = chain.in_drum if run.counted.output_at == "payload" else float(np.clip(inside, 0.0, chain.in_drum))
    sigma = 1e-6 * sigma_urad_Nm(structure.at_payload)
    return replace(held, before_drum=before, behind_drum=chain.in_drum, seen=seen, sigma_rad_Nm=sigma)


@dataclass(frozen=True, eq=False)
class Suspect:
    """What may be wrong, by one ``figure`` that is 0 where nothing is; ``grid`` are the sizes at which a fit may begin.

    ``words``: physics, where to look, what separates it, plain; as of :class:`mbcdm_cad.loop.result.Named`.
    """

    name: str
    form: str
    parameter: str
    figure: str
    words: tuple[str, str, str, str]
    grid: Floats
    size: float
    low: float
    high: float

    @property
    def label(self) -> str:
        """Name and form."""
        return f"{self.name} ({self.form})"


_LEVELS = "runs of a third and three times the amplitude: slip of the wraps goes with it"
_TORQUE = "log the torque between drum and what it turns, or repeat with another known inertia at the output"
_LATE = "an output sensor of known latency; both sensors on one shaft"
# Suspects of the bench, and the name of a mode of which no design says where it should be.
BENCH, MODE = ("delay", "lag", "gain"), "torsional_mode"
# Those that no design file holds.
NOT_DESIGNED = ("lag", "behind", "inertia")
# Name, form, parameter and figure; then the words.
_SUSPECTS = (
    ("delay", "late sensor", "delay", "delay_s"),
    (
        "the bench, not the drive: the output is read later than the input, a phase in proportion to frequency",
        "filter of the output encoder, time stamps of the logger",
        _LATE,
        "the bench reads the output {delay_s} later than the input",
    ),
    ("delay", "low-pass of the output", "lag", "lag_s"),
    (
        "a filter of first order lags and weakens the output: it is of the bench and not of the drive",
        "filter of the output encoder",
        _LATE,
        "the bench filters the output with a time constant of {lag_s}",
    ),
    ("ratio_error", "pitch radius or encoder scale", "gain", "share"),
    (
        "output over input differs from the declared ratio at all frequencies",
        "counts per turn and units of the encoders; pitch radii",
        "a full turn of each encoder against a reference",
        "the ratio of output to inputs is {share} {way_share} than declared",
    ),
    (MODE, "inputs held", "mode", "natural_frequency_Hz"),
    (
        "behind the inputs the output swings on what gives between",
        "stiffness and inertia, against the design",
        "give the design file: it says what the mode should be",
        "the output swings at {natural_frequency_Hz}",
    ),
    ("stiffness_error", "modulus of the rope", "modulus", "share"),
    (
        "E A of the rope or its free length differs: stiffness and slip scale",
        "a pull test of the rope after bedding in",
        _TORQUE,
        "the rope's stiffness is {share} {way_share} than the design file says",
    ),
    ("stiffness_error", "compliance in series", "series", "compliance_rad_Nm"),
    (
        "drum, shafts, bearings or frame give more than computed, or less if below zero",
        "screws of hub and frame, bearings, shafts",
        f"{_TORQUE}; {_LEVELS}",
        "the structure of the drive gives {compliance_rad_Nm} {way_compliance_rad_Nm} than computed",
    ),
    ("stiffness_error", "compliance behind the output encoder", "behind", "compliance_rad_Nm"),
    (
        "hub, coupling or payload gives behind the encoder",
        "hub clamp and coupling, between the output encoder and what it turns",
        _TORQUE,
        "between the output encoder and what it turns something gives {compliance_rad_Nm}",
    ),
    ("payload_inertia", "all that the output turns", "inertia", "share"),
    (
        "what the output turns is heavier or lighter than declared",
        "weigh the payload and swing it as a pendulum; inertia_plate and loads.payload",
        _TORQUE,
        "what the output turns has an inertia {share} {way_share} than declared",
    ),
    ("preload_error", "all cables", "preload", "share"),
    (
        "the tension set at all tensioners differs, or the friction of the wraps: slip goes with 1/(mu T)",
        "tension of each cable by plucking or a gauge",
        _LEVELS,
        "the tension of all cables is {share} {way_share} than the design file says",
    ),
)


def suspects(d: DriveSI | None, held: BehindInputs, highest_Hz: float) -> tuple[Suspect, ...]:
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
    rows = zip(_SUSPECTS[::2], _SUSPECTS[1::2], strict=True)
    return tuple(Suspect(*row, words, *shapes[row[2]]) for row, words in rows if row[2] in offered)


Values = Mapping[str, float]


def predicted(held: BehindInputs, v: Values, seen: FrequencyResponse) -> tuple[Complex, Complex]:
    """Output over inputs, and twist over torque in rad/(N m), with figures ``v`` of suspects and nuisances."""

    def of(name: str) -> float:
        return v.get(name, 0.0)

    s = 2j * np.pi * seen.frequency_Hz
    payload, drum = held.payload_kg_m2 * (1.0 + of("inertia")), held.drum_kg_m2
    torque = (payload + drum) * seen.acceleration_rad_s2
    before, behind, inside = _gives(held, v, torque, np.asarray(s.imag, dtype=float))
    hub = 1.0 / (1.0 + behind * payload * s**2)
    land = 1.0 / (1.0 + before * (drum + payload * hub) * s**2)
    read = land * (1.0 - inside * payload * hub * s**2)
    read = read * (1.0 + of("gain") + of("scale")) * np.exp(-s * of("delay")) / (1.0 + s * of("lag"))
    carried = payload * s**2 * hub * land * np.exp(-s * of("load_lag")) * (1.0 + of("load_gain"))
    return read, (1.0 - read) / carried


def _gives(held: BehindInputs, v: Values, torque_Nm: Floats, rate_rad_s: Floats) -> tuple[Complex, Complex, Complex]:
    """Complex compliance up to the drum, behind it, and of the latter in front of the encoder.

    Of the loss factor one part hangs on no frequency, one is in proportion to it.
    """

    def of(name: str) -> float:
        return v.get(name, 0.0)

    lossy, sticking = 1.0 / (1.0 + 1j * (of("loss") + of("viscous_s") * rate_rad_s)), held.cables_rad_Nm[0]
    slip = np.interp(torque_Nm / (1.0 + of("preload")), held.torque_Nm, held.cables_rad_Nm) - sticking
    slip = slip * (1.0 + of("slip")) + of("softening") * torque_Nm
    cables = sticking * lossy + slip * (1.0 - 1j * HYSTERESIS)
    before = cables / (1.0 + of("modulus")) + (held.before_drum + of("series") + of("structure") + of("mode")) * lossy
    before = before * (1.0 + of("law"))
    behind = (held.behind_drum + of("behind")) * lossy
    return before, np.asarray(behind), np.asarray(held.seen * lossy)


def first_mode(held: BehindInputs, v: Values, torque_Nm: float) -> tuple[float, float]:
    """Frequency in Hz and damping ratio of the lowest mode with the inputs held, at an amplitude of the torque."""
    payload, drum = held.payload_kg_m2 * (1.0 + v.get("inertia", 0.0)), held.drum_kg_m2
    rate = 0.0
    for _ in range(3):  # what is viscous hangs on the frequency
        gives = _gives(held, v, np.array([torque_Nm]), np.array([rate]))
        before, behind, _ = (complex(one[0]) for one in gives)
        # (1 - behind payload x) (1 - before drum x) = before payload x, x the square of the angular frequency
        roots = np.roots([behind * payload * before * drum, -(behind * payload + before * (drum + payload)), 1.0])
        square = min(roots, key=abs) if roots.size else 1e18 + 0j
        rate = float(np.sqrt(max(square.real, 1e-9)))
    return rate / (2.0 * np.pi), float(0.5 * square.imag / rate**2)


@dataclass(frozen=True, eq=False)
class ResponseFit:
    """Figures that fit the responses; ``weighted`` (n,): what is left of all averages over its noise."""

    suspects: tuple[Suspect, ...]
    values: dict[str, float]
    weighted: Complex
    covariance: Floats
    square: float
    width: int

    def with_last(self, suspect: Suspect) -> ResponseFit:
        """The same with one of its suspects named last."""
        at = self.suspects.index(suspect)
        order = [k for k in range(len(self.suspects)) if k != at] + [at]
        places = order + list(range(len(order), self.width))
        covariance = self.covariance[np.ix_(places, places)]
        return replace(self, suspects=tuple(self.suspects[k] for k in order), covariance=covariance)

    def sigma(self, parameter: str) -> float:
        """Standard deviation of the figure of one of the suspects, by the scatter that is left."""
        at = [one.parameter for one in self.suspects].index(parameter)
        return float(np.sqrt(self.covariance[at, at]))


def _both(output: Any, twist: Any) -> Any:
    """Rows of a run: those of the output, and of the twist where there is one."""
    return output if twist is None else np.concatenate([output, twist])


def _sigma(seen: FrequencyResponse, held: BehindInputs, v: Values) -> Floats:
    """Noise of output over inputs: its scatter, what averaging leaves, and what the linear law of the slip leaves."""
    size, rate = np.abs(seen.output.value), 2.0 * np.pi * seen.frequency_Hz
    slip = _slip(seen, held) + v.get("softening", 0.0) * seen.acceleration_rad_s2
    slip = LINEAR_SHARE * slip * size**2 * rate**2 * (held.payload_kg_m2 + held.drum_kg_m2)
    return np.asarray(np.sqrt(seen.output.sigma**2 + (ESTIMATE_SHARE * size) ** 2 + slip**2))


def _twist_sigma(seen: FrequencyResponse, held: BehindInputs) -> Floats:
    assert seen.twist is not None
    size = ESTIMATE_SHARE * np.abs(seen.twist.value)
    return np.asarray(np.sqrt(seen.twist.sigma**2 + size**2 + (LINEAR_SHARE * _slip(seen, held)) ** 2))


def _slip(seen: FrequencyResponse, held: BehindInputs) -> Floats:
    """Compliance by slip at each frequency, rad/(N m)."""
    torque = (held.payload_kg_m2 + held.drum_kg_m2) * seen.acceleration_rad_s2
    return np.asarray(np.interp(torque, held.torque_Nm, held.cables_rad_Nm) - held.cables_rad_Nm[0])


class ResponseLoop:
    """The loop on frequency responses of one drive."""

    def __init__(self, drive: Drive | None, ratio: float, runs: Sequence[Run]) -> None:
        self.runs, self.d = tuple(runs), None if drive is None else to_si(drive)
        self.seen = [response_of(run, ratio) for run in runs]
        if drive is None:  # nothing says what the torque turns
            self.seen = [replace(one, twist=None) for one in self.seen]
        self.held = [
            RIGID_DRIVE if drive is None else behind_inputs(drive, run, float(one.acceleration_rad_s2.max()))
            for run, one in zip(runs, self.seen, strict=True)
        ]
        self.highest_Hz = max(float(one.frequency_Hz[-1]) for one in self.seen)
        self.suspects = suspects(self.d, self.held[0], self.highest_Hz)
        known = () if drive is None else drive.as_built
        # What an earlier loop found is declared.
        self.declared = {
            one.parameter: value.value
            for entry in known
            for one in self.suspects
            if (one.name, one.form) == (entry.name, entry.form)
            for value in entry.values
        }
        slips = ("slip",) if any(np.ptp(held.cables_rad_Nm) > 0.0 for held in self.held) else ()
        sensor = runs[0].sensors.torque_class
        # Standard deviations of what is not known better; none is off by more than two.
        self.prior = (
            {"scale": SCALE_SHARE} | dict.fromkeys(slips, SLIP_SHARE) | ({} if drive is None else {"law": LAW_SHARE})
        )
        if any(one.twist is not None for one in self.seen):
            self.prior |= {"load_gain": 0.5 * sensor.share + 1e-6, "load_lag": 0.5 * sensor.lag_s + 1e-6}
        self.nuisances = {"loss": (0.02, 0.0, 1.0), "viscous_s": (1e-4, 0.0, 0.1)} | {
            k: (s, -2.0 * s, 2.0 * s) for k, s in self.prior.items()
        }
        if drive is None:  # slip of wraps that nothing is known of
            give = (2.0 * np.pi * self.highest_Hz) ** -2.0
            most = max(float(one.acceleration_rad_s2.max()) for one in self.seen)
            self.nuisances["softening"] = (0.1 * give / most, 0.0, np.inf)
        self.measured = np.concatenate([_both(one.output.value, one.twist and one.twist.value) for one in self.seen])
        third = [np.arange(one.frequency_Hz.size) % 3 == 1 for one in self.seen]
        self.test = np.concatenate([_both(t, one.twist and t) for t, one in zip(third, self.seen, strict=True)])
        # Amplitude of the inputs for which errors are stated: the usual one.
        self.input_rad = float(np.median(np.concatenate([one.input_rad for one in self.seen])))
        self._weigh({})

    def _weigh(self, v: Values) -> None:
        """Set the noise of all averages; of a drive without a design with the slip that a fit ``v`` found."""
        pairs = list(zip(self.seen, self.held, strict=True))
        outputs = [_sigma(one, held, v) for one, held in pairs]
        both = [_both(o, one.twist and _twist_sigma(one, held)) for o, (one, held) in zip(outputs, pairs, strict=True)]
        self.sigma = np.concatenate(both)
        scatter = np.concatenate([_both(one.output.sigma, one.twist and one.twist.sigma) for one in self.seen])
        peak = [np.abs(one.output.value) for one in self.seen]
        # What averaging and the linear law leave goes together over the width of the peak: there averages count as one.
        together = max(int(np.sum(gain > np.sqrt(0.5) * gain.max())) for gain in peak)
        self.together = 1.0 + (together - 1.0) * float(np.mean(1.0 - (scatter / self.sigma) ** 2))
        self.floor_rad = self.input_rad * float(np.sqrt(1.0 / np.mean(np.concatenate(outputs) ** -2.0)))
        self.bare = self.fit(())

    @property
    def noise(self) -> Noise:
        """The noise floor."""
        n = sum(one.frequency_Hz.size for one in self.seen)
        source = f"scatter of the response in {n} averages, and what averaging and the linear law leave"
        return Noise(self.floor_rad, self.floor_rad, 0.0, 0.0, 0.0, source)

    # Fits.

    def weighted(self, v: Values) -> Complex:
        """What figures leave of all averages, over its noise, (n,)."""
        rows = []
        for held, seen in zip(self.held, self.seen, strict=True):
            output, twist = predicted(held, v, seen)
            rows.append(_both(output, seen.twist and twist))
        return np.asarray((self.measured - np.concatenate(rows)) / self.sigma)

    def _residual(self, v: Values, mask: np.ndarray) -> Floats:
        left = self.weighted(v)[mask]
        priors = [v.get(name, 0.0) / sigma for name, sigma in self.prior.items()]
        return np.concatenate([left.real, left.imag, priors])

    def fit(
        self,
        chosen: Sequence[Suspect],
        start: Values | None = None,
        mask: np.ndarray | None = None,
        more: Mapping[str, tuple[float, float, float]] | None = None,
    ) -> ResponseFit:
        """The fit of some suspects beside the nuisances, on the averages that are not held back or of ``mask``.
        ``more``: further figures, with size and bounds."""
        mask = ~self.test if mask is None else mask
        more = more or {}
        names = [*(one.parameter for one in chosen), *self.nuisances, *more]
        shapes = [(one.size, one.low, one.high) for one in chosen]
        shapes += [*self.nuisances.values(), *more.values()]
        begin = {**self.declared, **dict.fromkeys(self.nuisances, 0.0), "loss": 0.02, **(start or {})}
        size, low, high = (np.array([shape[k] for shape in shapes]) for k in range(3))
        x0 = np.clip([begin.get(name, 0.0) for name in names], low + 1e-9 * size, high - 1e-9 * size)

        def figures(x: Floats) -> dict[str, float]:
            return {**begin, **dict(zip(names, x.tolist(), strict=True))}

        found = least_squares(
            lambda x: self._residual(figures(x), mask),
            x0,
            x_scale=size,
            bounds=(low, high),
            max_nfev=40,
            ftol=1e-4,
            xtol=1e-4,
        )
        freedom = max(found.fun.size - len(names), 1)
        square = 2.0 * found.cost / freedom
        covariance = np.linalg.pinv(found.jac.T @ found.jac) * max(1.0, square) * self.together
        values = figures(found.x)
        return ResponseFit(tuple(chosen), values, self.weighted(values), covariance, 2.0 * found.cost, len(names))

    def best(self, fit: ResponseFit, suspect: Suspect, mask: np.ndarray | None = None) -> ResponseFit:
        """The best fit with one suspect more, over its starts."""
        used = ~self.test if mask is None else mask
        grid = [{**fit.values, suspect.parameter: float(size)} for size in (0.0, *suspect.grid)]
        cost = [float(np.sum(self._residual(v, used) ** 2)) for v in grid]
        trials = [self.fit((*fit.suspects, suspect), grid[k], mask) for k in np.argsort(cost)[:TRIED]]
        return min(trials, key=lambda one: one.square)

    def _held(self, fit: ResponseFit) -> float:
        """Error of what is held back, rad RMS for inputs of the usual amplitude."""
        return self._rms(fit.weighted[self.test])

    def _rms(self, weighted: Complex) -> float:
        return self.floor_rad * float(np.sqrt(0.5 * np.mean(np.abs(weighted) ** 2)))

    def _supported(self, less: ResponseFit, more: ResponseFit) -> bool:
        """Whether what is held back and the rest support the last suspect of ``more``."""
        clear = self._held(less) ** 2 - self._held(more) ** 2 >= (LEAST_FALL * self.floor_rad) ** 2
        freedom = 2 * int((~self.test).sum()) - more.width
        scatter = max(more.square / freedom, 1.0) * self.together
        chance = float(f_distribution.sf((less.square - more.square) / scatter, 1, freedom))
        last = more.suspects[-1].parameter
        bounded = abs(more.values[last] - self.declared.get(last, 0.0)) > INTERVAL * more.sigma(last)
        return clear and bounded and chance < CHANCE / len(self.suspects)

    def _odds(self, worse: ResponseFit, better: ResponseFit) -> float:
        """Odds of one fit against another of the same averages, each with its number of figures counted."""
        n = 2 * self.measured.size
        variance = max(better.square / max(n - better.width, 1), 1.0) * self.together
        extra = worse.width - better.width
        return exp(min(0.5 * ((worse.square - better.square) / variance + extra * log(n)), 700.0))

    def slopes(self) -> tuple[Floats, dict[str, Floats]]:
        """Derivatives of all averages over their noise at the declared figures: by what is always free, (n, k), and by
        each suspect and each figure that is known within bounds, (n,)."""
        at, base = self.bare.values, self.weighted(self.bare.values)
        sizes = {one.parameter: one.size for one in self.suspects}
        sizes |= {name: size for name, (size, *_) in (self.nuisances | self.priors()).items()}

        def slope(name: str) -> Floats:
            moved = {**at, name: at.get(name, 0.0) + SLOPE * sizes[name]}
            change = (self.weighted(moved) - base) / (SLOPE * sizes[name])
            return np.concatenate([change.real, change.imag])

        free = [name for name in self.nuisances if name not in self.prior]
        return np.stack([slope(name) for name in free], axis=1), {k: slope(k) for k in sizes if k not in free}

    # Selection.

    def _selected(self) -> tuple[ResponseFit, list[Evidence], list[Evidence]]:
        """The fit with what the responses support; what was accepted, and what was too small."""
        now, steps, small = self.bare, list[Evidence](), list[Evidence]()
        while len(now.suspects) < MOST_EFFECTS + 1:
            free = [one for one in self.suspects if self._may_join(one, now.suspects)]
            trials = sorted((self.best(now, one) for one in free), key=lambda t: t.square)
            following = next((t for t in trials if self._supported(now, t)), None)
            small = [
                Evidence(t.suspects[-1].label, self._held(t), self._fall(now, t), "too small to name")
                for t in trials[:5]
            ]
            if following is None:
                break
            label = following.suspects[-1].label
            steps.append(Evidence(label, self._held(following), self._fall(now, following), "accepted"))
            now = following
        while len(now.suspects) > 1:
            less = {one: self._without(now, one) for one in now.suspects}
            needless = [fit for one, fit in less.items() if not self._supported(fit, now.with_last(one))]
            if not needless:
                break
            now = min(needless, key=lambda one: one.square)
        return now, steps, small

    @staticmethod
    def _may_join(suspect: Suspect, chosen: Sequence[Suspect]) -> bool:
        """Whether a suspect is none of those chosen, nor another form of one of the bench's."""
        return all(one is not suspect and (one.name, suspect.name) != ("delay", "delay") for one in chosen)

    def _fall(self, less: ResponseFit, more: ResponseFit) -> float:
        return float(np.sqrt(max(0.0, self._held(less) ** 2 - self._held(more) ** 2)))

    def _without(self, fit: ResponseFit, suspect: Suspect, mask: np.ndarray | None = None) -> ResponseFit:
        start = {**fit.values, suspect.parameter: self.declared.get(suspect.parameter, 0.0)}
        return self.fit([one for one in fit.suspects if one is not suspect], start, mask)

    def priors(self) -> dict[str, tuple[float, float, float]]:
        """Size and bounds of what the design's structure and the declared inertia may be wrong by."""
        if self.d is None:
            return {}
        sizes = {"structure": max(held.sigma_rad_Nm for held in self.held), "inertia": self.runs[0].plate.inertia_share}
        return {name: (size, -2.0 * size, 2.0 * size) for name, size in sizes.items() if size > 0.0}

    def _allowed(self, fit: ResponseFit) -> tuple[ResponseFit, str]:
        """``fit``, or one without suspects of the drive where its figures may be wrong by as much; words for that."""
        bench, more = [one for one in fit.suspects if one.parameter in BENCH], self.priors()
        if len(bench) == len(fit.suspects) or not more:
            return fit, ""
        start = {one.parameter: fit.values[one.parameter] for one in bench}
        allowed = self.fit(bench, start, None, more)
        if self._odds(allowed, fit) >= ODDS:
            return fit, ""
        names = {"structure": ("compliance_rad_Nm", "of the structure"), "inertia": ("share", "of the inertia")}
        words = [f"{readable(names[k][0], [allowed.values[k]])[1][0]} {names[k][1]}" for k in more]
        return allowed, f"an error of {' and '.join(words)}, within what is known of them"

    # Result.

    def result(self) -> LoopResult:
        """Select, compare with alternatives, judge."""
        fit, steps, small = self._selected()
        if self.d is None:
            self._weigh(fit.values)
            fit, steps, small = self._selected()
        fit, within = self._allowed(fit)
        if within:
            steps, small = [], []
        whole = self.fit(
            fit.suspects, fit.values, np.ones(self.test.size, dtype=bool), self.priors() if within else None
        )
        named, sets = list[Named](), list[tuple[Named, ...]]()
        for one in whole.suspects:
            first = self._named(one, whole, self._fall(self._without(fit, one), fit))
            forms, others = self._alike(whole, one)
            first = replace(first, equivalent=forms)
            if others:
                sets.append((first, *others))
            else:
                named.append(first)
        found = self._errors(fit)
        left = None if found.near_floor else self._left(whole)
        if named or sets:
            verdict = "explained" if left is None else "partly_explained"
        else:
            verdict = "none" if left is None else "unknown"
        return LoopResult(
            verdict,
            tuple(named),
            tuple(sets),
            left,
            found,
            tuple(steps),
            tuple(small),
            self._not_testable(),
            next_steps(named, sets, None),
            {},
            noise=self.noise,
            within_class=within,
            pictures=self._pictures(whole),
            modes=tuple(mode for k in range(len(self.runs)) if (mode := self._mode(k, whole)) is not None),
        )

    def _alike(self, whole: ResponseFit, one: Suspect) -> tuple[tuple[str, ...], list[Named]]:
        """Other forms of a suspect, and other suspects in its place, that fit nearly as well."""
        every = np.ones(self.test.size, dtype=bool)
        rest = self._without(whole, one, every)
        forms, others = list[str](), list[Named]()
        for other in self.suspects:
            if other is one or not self._may_join(other, rest.suspects):
                continue
            trial = self.best(rest, other, every)
            if self._odds(trial, whole) >= ODDS:
                continue
            if other.name == one.name:
                forms.append(other.form)
            else:
                others.append(self._named(other, trial, 0.0))
        return tuple(forms), others

    def _named(self, one: Suspect, fit: ResponseFit, fall_rad: float) -> Named:
        value, half = fit.values[one.parameter], INTERVAL * fit.sigma(one.parameter)
        figures = {one.figure: Value(value, value - half, value + half)}
        if one.name == MODE:
            low, middle, high = (
                float(np.sqrt(1.0 / max(v, 1e-30)) / (2.0 * np.pi)) for v in (value + half, value, value - half)
            )
            figures = {one.figure: Value(middle, low, high)}
        cables = self.d.cable_names if self.d is not None and one.name == "preload_error" else ()
        fitted = {} if one.parameter in NOT_DESIGNED else {one.figure: value}
        physics, look, separate, plain = one.words
        return Named(
            one.name, one.form, None, cables, figures, {}, (), look, separate, physics, fall_rad, fitted, plain=plain
        )

    def _errors(self, fit: ResponseFit) -> Errors:
        before, after = (self._interval(one.weighted[self.test]) for one in (self.bare, fit))
        first, last = (self.floor_rad * float(np.abs(one.weighted[self.test]).max()) for one in (self.bare, fit))
        could, did = before.value**2 - self.floor_rad**2, before.value**2 - after.value**2
        share = float(np.clip(did / could, 0.0, 1.0)) if could > 0.0 else 1.0
        _, (size,) = readable("_rad", [self.input_rad])
        held = f"every third average; errors of the output for inputs of {size} at all frequencies, by their certainty"
        return Errors(before, after, first, last, self.floor_rad, share, held)

    def _interval(self, weighted: Complex) -> Value:
        squares = 0.5 * np.abs(weighted) ** 2
        half = INTERVAL * float(np.std(squares)) / np.sqrt(squares.size)
        ends = (float(squares.mean()), max(0.0, float(squares.mean()) - half), float(squares.mean()) + half)
        return Value(*(self.floor_rad * float(np.sqrt(end)) for end in ends))

    def _left(self, whole: ResponseFit) -> LeftOver:
        """What is left of all averages, and at which frequencies the most."""
        at = np.concatenate([_both(one.frequency_Hz, one.twist and one.frequency_Hz) for one in self.seen])
        squares = np.abs(whole.weighted) ** 2
        order = np.argsort(at)
        share = np.cumsum(squares[order]) / squares.sum()
        low, high = (float(at[order][np.searchsorted(share, end)]) for end in (0.25, 0.75))
        peak = self.floor_rad * float(np.sqrt(squares.max()))
        words = f"half of it between {low:.3g} and {high:.3g} Hz"
        return LeftOver(self._rms(whole.weighted), peak, self.floor_rad, (), (), 0.0, (), words)

    def _not_testable(self) -> tuple[str, ...]:
        words = ["friction, play, ripple and all that goes with angle or lasts: a response is for small fast motion"]
        if self.d is None:
            return (*words, "only the ratio is known: whether the mode is where it should be")
        modes = [first_mode(held, self.declared, 0.0)[0] for held in self.held]
        if min(modes) * INSIDE > self.highest_Hz:
            words.append(
                f"the first mode of the design, {min(modes):.4g} Hz, is not within {self.highest_Hz:.4g} Hz: log "
                "faster, or let the output turn more inertia"
            )
        if all(one.twist is None for one in self.seen):
            words.append("no torque: which of stiffness and inertia differs, if all runs have one inertia")
        return tuple(words)

    def _mode(self, k: int, whole: ResponseFit) -> TorsionalMode | None:
        """The mode of one run, fitted for itself as linear; None where it is not in the band."""
        held, seen = self.held[k], self.seen[k]
        inertia = held.payload_kg_m2 * (1.0 + whole.values.get("inertia", 0.0)) + held.drum_kg_m2
        amplitude = 0.0
        for _ in range(SETTLED):
            frequency = first_mode(held, whole.values, amplitude)[0]
            now = inertia * float(np.interp(frequency, seen.frequency_Hz, seen.acceleration_rad_s2))
            amplitude += 0.5 * (now - amplitude)
        if not seen.frequency_Hz[0] * INSIDE < frequency < seen.frequency_Hz[-1] / INSIDE:
            return None
        alone = copy(self)
        alone.seen, alone.held, alone.prior = [replace(seen, twist=None)], [held.at(amplitude)], {}
        alone.nuisances = {"loss": self.nuisances["loss"]}
        alone.sigma = _sigma(seen, held, whole.values)

        def linear(response: Complex) -> tuple[Value, Value]:
            """The mode of a response as one of a linear drive."""
            alone.measured = response
            free = [one for one in self.suspects if one.parameter in ("delay", "gain")]
            free += [one for one in self.suspects if one.parameter in ("mode", "inertia")]
            size = free[-1].parameter
            fit = alone.fit(free, {**whole.values, "loss": 0.1, "softening": 0.0}, np.ones(response.size, dtype=bool))
            found, damping = first_mode(alone.held[0], fit.values, amplitude)
            stretch = fit.values[size] + (0.0 if self.d is None else 1.0)
            half = 0.5 * INTERVAL * fit.sigma(size) / stretch * found
            spread = 0.5 * INTERVAL * float(np.sqrt(fit.covariance[-1, -1]))
            low = max(damping - spread, 0.0)
            return Value(found, found - half, found + half), Value(damping, low, damping + spread)

        found, damping = linear(seen.output.value)
        mode = TorsionalMode(self.runs[k].source, found, damping, None, None, None)
        if self.d is None:
            return mode
        declared = linear(predicted(held, self.declared, seen)[0])
        return replace(mode, torque_Nm=amplitude, declared_Hz=declared[0].value, declared_damping=declared[1].value)

    def _pictures(self, whole: ResponseFit) -> tuple[BodePicture, ...]:
        found = []
        # The design has no figure for the damping besides that of the wraps.
        declared = {**self.declared, "loss": whole.values["loss"]}
        for run, seen, held in zip(self.runs, self.seen, self.held, strict=True):
            before, after = (predicted(held, v, seen)[0] for v in (declared, whole.values))
            found.append(
                BodePicture(run.source, seen.frequency_Hz, seen.output.value, seen.output.coherence, before, after)
            )
        return tuple(found)
