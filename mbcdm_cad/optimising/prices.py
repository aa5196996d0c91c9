"""What each requirement of a design costs: one at a time is moved a little, and the design is solved again."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any

from mbcdm_cad.design.yamltree import leaves
from mbcdm_cad.errors import MbcdmError
from mbcdm_cad.optimising import Effort
from mbcdm_cad.optimising.evaluate import Evaluated, evaluate, refuse_unknown
from mbcdm_cad.parallel.forks import crew
from mbcdm_cad.report.table import ReportTable, TextReport
from mbcdm_cad.solving.question import ASIDE, Fixed, Question
from mbcdm_cad.solving.repair import repair
from mbcdm_cad.solving.trials import Trials

# A requirement is moved by this share both ways; trials to make the moved design pass.
STEP, TRIALS = 0.05, 24


@dataclass(frozen=True)
class Price:
    """One requirement moved from ``before`` to ``after``; ``figures`` then, empty if no passing design was found."""

    field: str
    before: float
    after: float
    figures: dict[str, float]


@dataclass(frozen=True)
class Prices(TextReport):
    """The figures of a design, and what they become when one requirement is moved."""

    figures: dict[str, float]
    prices: tuple[Price, ...]

    def table(self) -> ReportTable:
        """One row a requirement: the change of each figure for one unit of it, moved down and up."""
        rows: list[tuple[Any, ...]] = []
        for down, up in zip(self.prices[::2], self.prices[1::2], strict=True):
            cells: list[str] = []
            for name, value in self.figures.items():
                for price in (down, up):
                    moved = price.figures.get(name)
                    step = price.after - price.before
                    change = 0.0 if moved is None else (moved - value) / step
                    shown = f"{change:+.3g}" if abs(change) > 1e-9 else "0"
                    cells.append("none passes" if moved is None else shown)
            rows.append((down.field, down.before, *cells))
        heads = [f"{name} per unit, {way}" for name in self.figures for way in (f"-{STEP:.0%}", f"+{STEP:.0%}")]
        return ReportTable(("requirement", "value", *heads), tuple(rows))

    def text(self, width: int | None = None) -> str:
        """The table."""
        return "\n".join(self.table().text(width))

    def to_dict(self) -> dict[str, Any]:
        """Plain data."""
        return {
            "figures": self.figures,
            "prices": [
                {"field": p.field, "before": p.before, "after": p.after, "figures": p.figures} for p in self.prices
            ],
        }


def prices_of(question: Question, names: Sequence[str], effort: Effort, told: Callable[[str], None]) -> Prices:
    """The prices of all requirements of a design; ``names`` are the figures.

    Raises ``MbcdmError`` for a design that does not pass, and for a name that is no figure.
    """
    refuse_unknown(names, [question])
    now = evaluate(question, {}, (), names)
    if not now.passes:
        failing = now.refused or ", ".join(name for name, _ in now.failing)
        raise MbcdmError(f"{question.path}: does not pass ({failing}), so that nothing has a price; see mbcdm check")
    asked = [
        (field, value, float(f"{value * share:.6g}"))
        for field, value in requirements(question)
        for share in (1.0 - STEP, 1.0 + STEP)
    ]
    moved = []
    with crew(_Move(question, tuple(names)), effort.workers, effort.scheduler) as workers:
        results = workers.results([(field, after) for field, _, after in asked])
        for (field, before, after), found in zip(asked, results, strict=True):
            told(f"price of {field}")
            moved.append(Price(field, before, after, {name: found.figures[name] for name in names if found.passes}))
    return Prices({name: now.figures[name] for name in names}, tuple(moved))


def requirements(question: Question) -> Iterator[tuple[str, float]]:
    """The numbers of the file that ask for something, with their values."""
    for field, value in leaves(question.data):
        if field.split(".")[0] in ASIDE or isinstance(value, bool) or not isinstance(value, int | float) or not value:
            continue
        yield field, float(value)


@dataclass(frozen=True)
class _Move:
    """The design with one requirement moved: by its rules, or by few changes of what the file leaves open.

    Plain data, so that it can be sent to another machine.
    """

    question: Question
    names: tuple[str, ...]

    def __call__(self, moved: tuple[str, float]) -> Evaluated:
        field, value = moved
        asked = self.question.relaxed({field: Fixed(value)})
        found = evaluate(asked, {}, (), self.names)
        if found.passes or found.refused:
            return found
        return evaluate(asked, repair(Trials(asked, 1), {}, TRIALS), (), self.names)
