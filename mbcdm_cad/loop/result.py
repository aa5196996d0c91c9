"""The result of the loop: figures in readable units, the result file, the text for a terminal."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import asdict, dataclass, field
from typing import TYPE_CHECKING, Any

from mbcdm_cad.loop.readable import Value, probability_text, readable, share_text, size_of
from mbcdm_cad.routes import Complex, Floats

if TYPE_CHECKING:
    from mbcdm_cad.loop.correction import Correction
    from mbcdm_cad.loop.prepare.prepared import Prepared, Windows
    from mbcdm_cad.loop.search.unknown import Unknown


# A run is explained if its held-out error is at most this many times the noise floor.
NEAR_FLOOR = 1.25
# If the floor is so many times the declared one, the sensor or its data sheet is doubtful.
FAR_ABOVE = 1.5
# What is not testable without a design, for which no next run is planned either.
ONLY_RATIO = "only the ratio is known: pulleys, preload and ropes"
# Odds below which they are not stated.
LEAST_ODDS = 20.0

# Fields of the result file's first form; the file lists the others as new.
FIRST_FIELDS = ("verdict", "effects", "one_of", "unknown", "error")

# Verdicts, and how a person reads them.
VERDICTS = {
    "none": "Nothing is missing",
    "explained": "Explained",
    "partly_explained": "Partly explained",
    "unknown": "Unknown",
    "not_testable": "Not testable",
}


def verdict_of(found: Sequence[object], left: object | None, testable: bool = True) -> str:
    """The verdict on what was found and what is left; ``testable``: whether what was not found would have been seen."""
    if left is not None:
        return "partly_explained" if found else "unknown"
    return "explained" if found else "none" if testable else "not_testable"


@dataclass(frozen=True)
class Noise:
    """The part of the residual that does not repeat, rad RMS.

    ``total_rad`` is the floor in use; ``white_rad`` and ``coloured_rad`` its parts (quadratic sum), ``memory_s`` the
    correlation time of the coloured part, ``declared_rad`` the noise from the sensors' declared steps alone, 0 where
    they are not given. ``source`` says how it was found.
    """

    total_rad: float
    white_rad: float
    coloured_rad: float
    memory_s: float
    declared_rad: float
    source: str

    @property
    def far_above(self) -> bool:
        """Whether it is far above the noise that the sensors are declared to have."""
        return 0.0 < self.declared_rad * FAR_ABOVE < self.total_rad

    def to_json(self) -> dict[str, float | str]:
        """For the result file."""
        return {"floor_rad" if name == "total_rad" else name: value for name, value in asdict(self).items()}


def doubt_of(noise: Noise, names: str) -> str:
    """A sentence where the noise is far above what the file declares; ``names`` are the runs."""
    return (
        f"{names}: the sensors are noisier than declared: {1e6 * noise.total_rad:.3g} urad RMS do not repeat, where "
        f"the declared steps make {1e6 * noise.declared_rad:.3g} urad (white {1e6 * noise.white_rad:.3g}, coloured "
        f"{1e6 * noise.coloured_rad:.3g} urad"
        + (f" with a memory of {noise.memory_s:.2g} s" if noise.memory_s else "")
        + "); check mounts, cables and supply of the encoders, or declare their angle noise"
    )


def runs_of(prepared: Sequence[Prepared]) -> str:
    """Names of the runs, for a message."""
    return ", ".join(dict.fromkeys(p.run.source or "run" for p in prepared))


@dataclass(frozen=True)
class Named:
    """An effect that was named: figures by name (SI, the unit in the name), its meaning as hardware, equivalent forms.

    ``fitted`` are the fitted values of the effect's parameters, ``form`` the form that they belong to, ``meanings``
    what figures mean on the bench where their names do not say it; ``plain`` as in :class:`Effect`. ``run`` is the data
    of the only run that has it, empty if all have it; ``after`` what a change left behind, as an effect of its own;
    ``correlated``: by the words of an effect that was found with it, and by its own, the correlations of the fitted
    values of both, own values by those of the other; ``half_widths`` of their 95 % intervals, by name; ``probability``
    that it is this effect, where the search states it.
    """

    name: str
    form: str
    stage: str | None
    cables: tuple[str, ...]
    parameters: dict[str, Value]
    physical: dict[str, float]
    equivalent: tuple[str, ...]
    where_to_look: str
    separate_by: str
    physics: str
    fall_rad: float
    fitted: dict[str, float]
    meanings: dict[str, str] = field(default_factory=dict)
    plain: str = ""
    run: str = ""
    correlated: dict[str, Floats] = field(default_factory=dict, repr=False)
    half_widths: dict[str, float] = field(default_factory=dict, repr=False)
    after: Named | None = None
    probability: float | None = None

    @property
    def is_share(self) -> bool:
        """Whether its size is a share of what the drive has."""
        return "share" in self.parameters

    @property
    def words(self) -> str:
        """Name, stage, cables and run."""
        run = f"in {self.run}" if self.run else ""
        return " ".join(filter(None, [self.name, self.stage or "", " ".join(self.cables), run]))

    def to_json(self) -> dict[str, Any]:
        """As the result file has it."""
        where = {"stage": self.stage, "cables": list(self.cables), "run": self.run}
        found = {
            "name": self.name,
            **{key: value for key, value in where.items() if value},
            "form": self.form,
            "parameters": {name: value.to_json() for name, value in self.parameters.items()},
            "physical": dict(self.physical),
            "equivalent": [[words] for words in self.equivalent],
            "where_to_look": self.where_to_look,
            "separate_by": self.separate_by,
            "explains_rms_rad": self.fall_rad,
        }
        return found if self.probability is None else {**found, "probability": self.probability}


def ways_apart(members: Iterable[Named]) -> str:
    """What would separate the members of a set, each way once."""
    return "; or ".join(dict.fromkeys(one.separate_by for one in members))


@dataclass(frozen=True)
class Helpful:
    """An effect that lowers the error but is not named: the unexplained part is too large compared with it, or a
    quantity that was not measured would do the same.

    ``odds``: of the fit with it against that without it.
    """

    named: Named
    odds: float

    @property
    def words(self) -> str:
        """How sure it is."""
        if self.odds < LEAST_ODDS:
            return "odds not known"
        return f"odds {min(self.odds, 9999.0):.0f} to 1"

    def to_json(self) -> dict[str, Any]:
        """As the result file has it."""
        return {**self.named.to_json(), "odds": self.odds}


@dataclass(frozen=True)
class CandidateRow:
    """One line of the table of candidates: its label, the held-out RMS with it, the fall, and the decision."""

    label: str
    held_out_rad: float
    fall_rad: float
    outcome: str


@dataclass(frozen=True)
class Errors:
    """RMS on held-out data before and after, with 95 % intervals; rad."""

    before: Value
    after: Value
    peak_before_rad: float
    peak_after_rad: float
    floor_rad: float
    explained_share: float
    held_out: str

    @property
    def near_floor(self) -> bool:
        """Whether no more than the noise is left: the error is at most NEAR_FLOOR times the floor."""
        return self.after.value <= NEAR_FLOOR * self.floor_rad

    def to_json(self) -> dict[str, Any]:
        """As the result file has it."""
        return {
            "before_rad": self.before.value,
            "before_ci95_rad": [self.before.low, self.before.high],
            "after_rad": self.after.value,
            "after_ci95_rad": [self.after.low, self.after.high],
            "peak_before_rad": self.peak_before_rad,
            "peak_after_rad": self.peak_after_rad,
            "floor_rad": self.floor_rad,
            "explained_share": self.explained_share,
            "held_out": self.held_out,
        }


@dataclass(frozen=True, eq=False)
class Traces:
    """Signals for the report page, thinned, all of the same length; angles and residuals in rad, load in N m."""

    time_s: Floats
    output_rad: Floats
    load_Nm: Floats | None
    residual_before_rad: Floats
    residual_after_rad: Floats
    held: Floats
    used: Floats
    orders: Floats
    amplitude_before_rad: Floats
    amplitude_after_rad: Floats


@dataclass(frozen=True, eq=False)
class ReadingsPicture:
    """Few readings of one run as a picture: ``read_rad`` (n,) at ``at`` (n,), and along ``line_at`` (m,) what the
    declared model and the model with what was found predict, (m,); ``held`` (n,) marks what was held back;
    ``logarithmic``: so is the axis.
    """

    source: str
    title: str
    words: str
    axis: str
    at: Floats
    read_rad: Floats
    held: Floats
    line_at: Floats
    before_rad: Floats
    after_rad: Floats
    logarithmic: bool = False


@dataclass(frozen=True, eq=False)
class BodePicture:
    """A frequency response (n,) of output over inputs, or over a torque on it in rad/(N m), as a Bode plot: as
    measured, and as the declared model and the model with what was found predict it."""

    source: str
    frequency_Hz: Floats
    measured: Complex
    coherence: Floats
    before: Complex
    after: Complex
    over_torque: bool = False


@dataclass(frozen=True)
class TorsionalMode:
    """The first mode with the inputs held, of one run, as that of a linear drive.

    Frequency and damping ratio of the response as measured, with the amplitude of the torque in the cables at the mode;
    and of the response that the design has at the same amplitudes, damped by its wraps alone. None without a design.
    """

    source: str
    frequency_Hz: Value
    damping_share: Value
    torque_Nm: float | None
    declared_Hz: float | None
    declared_damping: float | None

    @property
    def words(self) -> str:
        """In one sentence."""
        f, damping = self.frequency_Hz, self.damping_share
        text = (
            f"mode of {self.source}: {f.value:.4g} Hz ({f.low:.4g} to {f.high:.4g}), damping ratio "
            f"{100.0 * damping.value:.2g} % ({100.0 * damping.low:.2g} to {100.0 * damping.high:.2g} %)"
        )
        if self.declared_Hz is None or self.declared_damping is None:
            return text
        if self.torque_Nm is None:
            return f"{text}; the design has {self.declared_Hz:.4g} Hz where nothing slips"
        return (
            f"{text}, at {self.torque_Nm:.2g} N m in the cables; the design has {self.declared_Hz:.4g} Hz there, and "
            f"{100.0 * self.declared_damping:.2g} % by the slip of its wraps"
        )

    def to_json(self) -> dict[str, Any]:
        """As the result file has it."""
        return asdict(self) | {
            "frequency_Hz": self.frequency_Hz.to_json(),
            "damping_share": self.damping_share.to_json(),
        }


@dataclass(frozen=True, eq=False)
class LoopResult:
    """The result of the loop; ``one_of`` holds sets of effects of which the data cannot say which one is present.

    ``noise`` describes the floor, ``windows`` the smoothing of each run. ``doubts`` are sentences about sensors or
    fitted values that the data make doubtful. ``helpful`` are effects that certainly lower the error and are not named.
    ``within_class`` says by what the torque sensor is wrong within its class; empty if nothing of it is in the fit.
    ``correction`` computes a table for the controller when it is called. ``own``: what runs that differ have each for
    itself; the declared model is then that with these values. ``pictures`` in place of ``traces`` for few readings and
    frequency responses; the latter have ``modes``.
    """

    verdict: str
    effects: tuple[Named, ...]
    one_of: tuple[tuple[Named, ...], ...]
    unknown: Unknown | None
    errors: Errors
    evidence: tuple[CandidateRow, ...]
    small: tuple[CandidateRow, ...]
    not_testable: tuple[str, ...]
    next_steps: tuple[str, ...]
    chain_orders: dict[str, float]
    traces: tuple[Traces, ...] = field(repr=False, default=())
    noise: Noise | None = None
    windows: tuple[Windows, ...] = ()
    doubts: tuple[str, ...] = ()
    helpful: tuple[Helpful, ...] = ()
    within_class: str = ""
    correction: Callable[[], Correction] | None = field(repr=False, default=None)
    own: tuple[Differing, ...] = ()
    pictures: tuple[ReadingsPicture | BodePicture, ...] = field(repr=False, default=())
    modes: tuple[TorsionalMode, ...] = ()

    def to_json(self) -> dict[str, Any]:
        """The result file."""
        return {
            "verdict": self.verdict,
            "sentence": self.sentence,
            "effects": [named.to_json() for named in self.effects],
            "one_of": [[named.to_json() for named in group] for group in self.one_of],
            "unknown": self.unknown.to_json() if self.unknown else None,
            "error": self.errors.to_json(),
            "candidates": [
                {"effect": e.label, "held_out_rad": e.held_out_rad, "fall_rad": e.fall_rad, "outcome": e.outcome}
                for e in (*self.evidence, *self.small)
            ],
            "not_testable": list(self.not_testable),
            "next_steps": list(self.next_steps),
            "noise": self.noise.to_json() if self.noise else None,
            "windows": [asdict(one) for one in self.windows],
            "doubts": list(self.doubts),
            "helpful": [one.to_json() for one in self.helpful],
            "within_class": self.within_class,
            "own": [one.to_json() for one in self.own],
            **({"modes": [mode.to_json() for mode in self.modes]} if self.modes else {}),
        }

    @property
    def sentence(self) -> str:
        """The finding in one sentence."""
        e = self.errors
        _, (before, after, floor) = readable("_rad", [e.before.value, e.after.value, e.floor_rad])
        sizes = f"held-out error {before} RMS before, {after} after"
        words = [self._described(named) for named in self.effects]
        words += ["one of " + " or ".join(named.words for named in group) for group in self.one_of]
        if self.verdict == "none" and self.within_class:
            return f"The declared model explains the run with {self.within_class}; {sizes}, noise floor {floor}."
        if self.verdict == "none":
            return f"The declared model explains the run: held-out error {before} RMS, noise floor {floor}."
        if self.verdict == "not_testable" and self.helpful:
            return f"No torque was measured, and a load explains the error as well as any cause; {sizes}."
        if self.verdict == "not_testable":
            return "This run cannot be used: " + "; ".join(self.not_testable) + "."
        if self.verdict == "unknown":
            assert self.unknown is not None
            parts = " and ".join(f"{one.named.words} ({one.words})" for one in self.helpful)
            helps = f"; the error falls with {parts}, which may only resemble the cause" if parts else ""
            return (
                f"The model lacks something that none of the known effects explains: {self.unknown.sentence()}{helps}."
            )
        tail = f"; with {self.within_class}" if self.within_class else ""
        tail += f"; something unknown is left: {self.unknown.sentence()}" if self.unknown else ""
        return f"The model lacks {' and '.join(words)}; {sizes}{tail}."

    def _described(self, named: Named) -> str:
        figures = []
        for name, value in named.parameters.items():
            word, (middle, low, high) = readable(name, value.three)
            bounded = f"{middle} ({low.split(' ')[0]} to {high})"
            figures.append(f"{word} {bounded if math.isfinite(value.high) else _unbounded(value, low)}")
        return f"{named.words} [{named.form}: {', '.join(figures)}]"


def result_text(result: LoopResult, doubts: Sequence[str] = ()) -> str:
    """The finding in one sentence, the verdict and doubts right below, what to do next, the errors, then the tables.

    Angles are in the unit that suits the error of the declared model.
    """
    e = result.errors
    size, unit = size_of("_rad", [e.before.value])
    lines = [
        result.sentence,
        f"verdict: {VERDICTS[result.verdict]}",
        *doubts,
        *(f"doubt: {words}" for words in result.doubts),
    ]
    for group in (*((one,) for one in result.effects), *result.one_of):
        odds = [f"{one.words} {probability_text(one.probability)}" for one in group if one.probability is not None]
        lines += [f"probability: {', '.join(odds)}"] if odds else []
    lines += [*(f"next: {words}" for words in result.next_steps), ""]
    lines += [
        f"{'error on held-out data':<24}{'RMS':>10}{'95 % from':>12}{'to':>10}{'peak':>10}  {unit}",
        _error_line("declared model", size, e.before.value, e.before.low, e.before.high, e.peak_before_rad),
        _error_line("with what was found", size, e.after.value, e.after.low, e.after.high, e.peak_after_rad),
        f"{'noise floor':<24}{e.floor_rad / size:>10.3g}" + (f"  ({result.noise.source})" if result.noise else ""),
        f"{_explained(e)}; held out: {e.held_out}",
    ]
    lines += ["", *(mode.words for mode in result.modes)] if result.modes else []
    for differing in result.own:
        lines += ["", *differing.lines()]
    for named in result.effects:
        lines += ["", *named_lines(named)]
    for one in result.helpful:
        words = f"lowers the error, {one.words}, and may only resemble the cause:"
        lines += ["", words, *("  " + line for line in named_lines(one.named))]
    for group in result.one_of:
        lines += ["", "one of these; the data cannot show which:"]
        for named in group:
            lines += ["  " + line for line in named_lines(named)]
    candidates = (*result.evidence, *result.small)
    if candidates:
        width = max(len(c.label) for c in candidates)
        lines += ["", f"{'candidate':<{width}}{'held out':>12}{'takes off':>12}  {unit}"]
        # A candidate that was left out has no error on the data held back.
        held = [f"{c.held_out_rad / size:.3g}" for c in result.evidence] + [""] * len(result.small)
        lines += [
            f"{c.label:<{width}}{rms:>12}{f'{c.fall_rad / size:.3g}' if c.fall_rad else '':>12}  {c.outcome}"
            for c, rms in zip(candidates, held, strict=True)
        ]
    lines += [f"smoothing of run {k + 1}: {windows_words(one)}" for k, one in enumerate(result.windows)]
    return "\n".join([*lines, *(f"not testable: {words}" for words in result.not_testable)])


def _explained(e: Errors) -> str:
    """What was found takes off of what lies above the floor, in words."""
    if e.before.value <= e.floor_rad:
        return "explained: nothing lies above the floor"
    return f"explained: {share_text(e.explained_share)} of what lies above the floor"


def _unbounded(value: Value, low: str) -> str:
    """A figure without an upper end; ``low`` is its lower end as text."""
    return "of any size" if value.low <= 0.0 else f"{low} or more"


def named_lines(named: Named) -> list[str]:
    """An effect with its figures, one on each line."""
    lines = [f"{named.words} ({named.form}): {named.physics}"]
    for name, value in named.parameters.items():
        word, (middle, low, high) = readable(name, value.three)
        bounded = f"{middle} (95 %: {low} to {high})"
        lines.append(f"  {word} {bounded if math.isfinite(value.high) else _unbounded(value, low)}")
    for name, figure in named.physical.items():
        if name not in named.parameters:
            word, shown = readable(name, [figure])
            lines.append(f"  {word} {shown[0]}")
    lines += [f"  looks the same: {words}" for words in named.equivalent]
    return [*lines, f"  look at: {named.where_to_look}"]


def windows_words(windows: Windows) -> str:
    """The smoothing of one run, in words."""
    load = f", load {windows.load_s:.2g} s" if windows.load_s else ""
    return f"difference of the inputs {windows.difference_s:.2g} s{load}, speed {windows.speed_s:.2g} s (from the data)"


def _error_line(word: str, size: float, *errors_rad: float) -> str:
    rms, low, high, peak = (error / size for error in errors_rad)
    return f"{word:<24}{rms:>10.3g}{low:>12.3g}{high:>10.3g}{peak:>10.3g}"


# Odds from which a change, or that there was none, is said without reserve.
CLEAR_ODDS, MOST_ODDS = 20.0, 1e6


def odds_words(log_odds: float, yes: str, no: str) -> str:
    """``yes`` or ``no``, whichever the odds speak for, with them."""
    odds = math.exp(min(abs(log_odds), math.log(MOST_ODDS)))
    shown = f"over {MOST_ODDS:.0e}".replace("e+0", "e") if abs(log_odds) >= math.log(MOST_ODDS) else f"{odds:.3g}"
    said = yes if log_odds > 0.0 else no
    return f"{said}, odds {shown} to 1" + ("" if odds >= CLEAR_ODDS else ", which is open")


@dataclass(frozen=True, eq=False)
class OwnValue:
    """The value of one run: its number from 0, its data, the fitted values, and the figures with 95 % intervals."""

    number: int
    run: str
    values: Floats
    figures: dict[str, Value]


@dataclass(frozen=True, eq=False)
class Differing:
    """One figure that differs from run to run: ``name`` as the study calls it.

    ``covariance`` of the fitted values of all its runs, one after the other; ``log_odds`` that they are not the same,
    ``every``: as each other, otherwise as that of the runs that do not differ.
    """

    name: str
    form: str
    runs: tuple[OwnValue, ...]
    covariance: Floats = field(repr=False)
    log_odds: float = 0.0
    every: bool = True

    @property
    def changed(self) -> str:
        """Whether it changed, in words."""
        other = "between the runs" if self.every else "from the other runs"
        return odds_words(self.log_odds, f"changed {other}", f"did not change {other}")

    def lines(self) -> list[str]:
        """For a terminal."""
        lines = [f"{self.name} of each run ({self.form}): {self.changed}"]
        wide = max(len(one.run) for one in self.runs)
        for one in self.runs:
            words = []
            for name, value in one.figures.items():
                word, (middle, low, high) = readable(name, value.three)
                words.append(f"{word} {middle} (95 %: {low} to {high})")
            lines.append(f"  {one.run:<{wide}}  {', '.join(words)}")
        return lines

    def to_json(self) -> dict[str, Any]:
        """As the result file has it."""
        runs = [
            {"run": one.run, "parameters": {name: value.to_json() for name, value in one.figures.items()}}
            for one in self.runs
        ]
        return {"name": self.name, "form": self.form, "runs": runs, "log_odds_changed": self.log_odds}
