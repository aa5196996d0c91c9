"""What the loop found, and the result file made of it."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from mbcdm_cad.identification.readable import readable
from mbcdm_cad.measurement.run import Floats

if TYPE_CHECKING:
    from mbcdm_cad.identification.unknown import Unknown

VERDICTS = ("none", "explained", "partly_explained", "unknown", "not_testable")


@dataclass(frozen=True)
class Value:
    """A figure with its 95 % interval."""

    value: float
    low: float
    high: float

    def to_json(self) -> dict[str, Any]:
        """As the result file has it."""
        return {"value": self.value, "ci95": [self.low, self.high]}


@dataclass(frozen=True)
class Named:
    """An effect that was named: figures by name (SI, the unit in the name), what it means in metal, what else is alike.

    ``fitted`` are the values that the effect's own parameters took, ``form`` which form they belong to.
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

    @property
    def words(self) -> str:
        """Name, stage and cables."""
        return " ".join(filter(None, [self.name, self.stage or "", " ".join(self.cables)]))

    def to_json(self) -> dict[str, Any]:
        """As the result file has it."""
        found: dict[str, Any] = {"name": self.name}
        if self.stage:
            found["stage"] = self.stage
        if self.cables:
            found["cables"] = list(self.cables)
        found |= {
            "form": self.form,
            "parameters": {name: value.to_json() for name, value in self.parameters.items()},
            "physical": dict(self.physical),
            "equivalent": [[words] for words in self.equivalent],
            "where_to_look": self.where_to_look,
            "separate_by": self.separate_by,
            "explains_rms_rad": self.fall_rad,
        }
        return found


@dataclass(frozen=True)
class Evidence:
    """One line of the table of candidates: what it is, held-out RMS with it, and what became of it."""

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
class LoopResult:
    """The loop's answer; ``one_of`` holds sets of which the data cannot tell which."""

    verdict: str
    effects: tuple[Named, ...]
    one_of: tuple[tuple[Named, ...], ...]
    unknown: Unknown | None
    errors: Errors
    evidence: tuple[Evidence, ...]
    small: tuple[Evidence, ...]
    not_testable: tuple[str, ...]
    next_steps: tuple[str, ...]
    chain_orders: dict[str, float]
    traces: tuple[Traces, ...] = field(repr=False, default=())

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
        }

    @property
    def sentence(self) -> str:
        """The finding in one sentence."""
        e = self.errors
        _, (before, after, floor) = readable("_rad", [e.before.value, e.after.value, e.floor_rad])
        sizes = f"held-out error {before} RMS before, {after} after"
        words = [self._described(named) for named in self.effects]
        words += ["one of " + " or ".join(named.words for named in group) for group in self.one_of]
        if self.verdict == "none":
            return f"The declared model explains the run: held-out error {before} RMS, noise floor {floor}."
        if self.verdict == "not_testable":
            return "Nothing can be said from this run: " + "; ".join(self.not_testable) + "."
        if self.verdict == "unknown":
            assert self.unknown is not None
            return f"The model lacks something that none of the known effects explains: {self.unknown.sentence()}."
        tail = f"; something unknown is left: {self.unknown.sentence()}" if self.unknown else ""
        return f"The model lacks {' and '.join(words)}; {sizes}{tail}."

    def _described(self, named: Named) -> str:
        figures = []
        for name, value in named.parameters.items():
            word, (middle, low, high) = readable(name, [value.value, value.low, value.high])
            figures.append(f"{word} {middle} ({low.split(' ')[0]} to {high})")
        return f"{named.words} [{named.form}: {', '.join(figures)}]"
