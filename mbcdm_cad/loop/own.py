"""What runs that differ on purpose have for themselves, as the result tells it."""

from dataclasses import dataclass, field
from math import exp, log
from typing import Any

from mbcdm_cad.loop.readable import Value, readable
from mbcdm_cad.routes import Floats

# Odds from which a change, or that there was none, is said without reserve.
CLEAR_ODDS, MOST_ODDS = 20.0, 1e6


def odds_words(log_odds: float, yes: str, no: str) -> str:
    """``yes`` or ``no``, whichever the odds speak for, with them."""
    odds = exp(min(abs(log_odds), log(MOST_ODDS)))
    shown = f"over {MOST_ODDS:.0e}".replace("e+0", "e") if abs(log_odds) >= log(MOST_ODDS) else f"{odds:.3g}"
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
                word, (middle, low, high) = readable(name, [value.value, value.low, value.high])
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
