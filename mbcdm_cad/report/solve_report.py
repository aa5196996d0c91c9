"""The result of a search for a passing design: as text with the patch of the file, as JSON, as the changed file.

The command line prints it, the Python API returns it.
"""

import shlex
from collections.abc import Callable, Iterator
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from mbcdm_cad.design.describe import flow
from mbcdm_cad.report.table import TextReport, designs_shown
from mbcdm_cad.solving.conflict import Conflict, Give
from mbcdm_cad.solving.question import Out, Question, Times, difference, patched
from mbcdm_cad.solving.solve import Change, Solution, solve
from mbcdm_cad.storage.folders import write_whole


@dataclass(frozen=True)
class SolveReport(TextReport):
    """``solution`` of the search for the file ``path``; ``design_text``: the file that passes, None if there is none.

    ``design_text`` has all comments of the file; only the changed fields differ.
    """

    path: Path
    solution: Solution
    design_text: str | None

    @property
    def passed(self) -> bool:
        """Whether a design was found that passes every check."""
        return self.design_text is not None

    @property
    def changes(self) -> tuple[Change, ...]:
        """The changed fields; empty if the file passes as it is, or if nothing passes."""
        return self.solution.changes

    @property
    def conflict(self) -> Conflict | None:
        """The requirements that exclude each other; None if a design was found."""
        return self.solution.conflict

    @property
    def patch(self) -> str:
        """The change of the file as a unified diff; empty if there is none."""
        before = self.solution.question.text
        return "" if self.design_text is None else difference(before, self.design_text, str(self.path))

    def save(self, path: str | Path) -> None:
        """Write the file that passes; nothing if there is none. Raises ``OSError`` if it cannot be written."""
        if self.design_text is not None:
            write_whole({Path(path): self.design_text.encode()})

    def text(self, *, colour: bool = False) -> str:
        """What ``mbcdm solve`` prints: the changes and the patch, or the requirements that exclude each other."""
        return "\n".join(self._lines(colour))

    def _lines(self, colour: bool) -> Iterator[str]:
        found, name = self.solution, str(self.path)
        if self.design_text is None:
            assert found.conflict is not None, "without a design there is a conflict"
            yield from _conflict_lines(found.conflict, name, found.trials)
            return
        if not found.changes:
            yield f"{name}: passes every check as it is"
            return
        count = len(found.changes)
        tried = designs_shown(found.trials)
        yield f"{name}: {count} change{'s' * (count > 1)} and it passes every check ({tried} tried)"
        for change in found.changes:
            yield f"  {change.field}: {_word(change.before)} -> {_word(change.after)}  ({change.note})"
        yield ""
        for line in self.patch.splitlines():
            code = {"+": "32", "-": "31", "@": "36"}.get(line[:1]) if colour else None
            yield f"\x1b[{code}m{line}\x1b[0m" if code else line
        if found.question.ranges:
            # Who leaves a range open often wants the best within it.
            yield ""
            yield f"This is the nearest design; the best one finds: mbcdm optimise {shlex.quote(name)} --aim mass_g:min"

    def to_dict(self) -> dict[str, Any]:
        """What ``mbcdm solve --json`` prints."""
        conflict = self.conflict
        return {
            "design": str(self.path),
            "passes": self.passed,
            "trials": self.solution.trials,
            "changes": [asdict(change) for change in self.changes],
            "patch": self.patch if self.passed else None,
            "conflict": conflict
            and {
                "exclude": list(conflict.exclude),
                "proved": conflict.proved,
                "first": [_give_json(way) for way in conflict.first],
                "either": [_give_json(way) for way in conflict.either],
                "not_tried": list(conflict.not_tried),
                "nearest": [{"check": check, "message": message} for check, message in conflict.nearest],
            },
        }


def solve_design(
    question: Question, told: Callable[[str, int], None] | None = None, jobs: int | None = None
) -> SolveReport:
    """Search for the design nearest to the question's file that passes every check; see :func:`solve`."""
    found = solve(question, told, jobs)
    text = None if found.data is None else patched(question.text, str(question.path), found.data)
    return SolveReport(question.path, found, text)


def _conflict_lines(conflict: Conflict, name: str, trials: int) -> Iterator[str]:
    yield f"{name}: no design was found that passes every check ({designs_shown(trials)} tried)"
    if conflict.first:
        yield "These requirements were relaxed first, one after the other:"
        yield from (f"  {_give(way)}" for way in conflict.first)
    if conflict.exclude:
        many = "these" if len(conflict.exclude) > 1 else "this"
        missed = f"no design was found that meets {many} together with the rest of the file"
        sure = "these exclude each other" if conflict.proved else missed
        yield f"{'Then ' if conflict.first else ''}{sure}: {', '.join(conflict.exclude)}"
        yield "To relax one of them is enough; each of these was tried and passes:"
        yield from (f"  {_give(way)}" for way in conflict.either)
    else:
        yield "No requirement was found that gives a passing design when it alone is relaxed."
    if conflict.not_tried:
        yield f"The search ended after {designs_shown(trials)}; not relaxed yet: {', '.join(conflict.not_tried)}"
    yield "Checks that fail on the design that came nearest:"
    yield from (f"  {check}: {message}" for check, message in conflict.nearest)


def _give(way: Give) -> str:
    moved = ", ".join(f"{field} {_setting(value)}" for field, value in way.moves.items())
    with_it = f"  (then also changed: {moved})" if moved else ""
    if way.after is None:
        return f"{way.field}: {_word(way.before)} -> left out; its rule then gives the value{with_it}"
    return f"{way.field}: {_word(way.before)} -> {_word(way.after)}{with_it}"


def _setting(value: Any) -> str:
    if isinstance(value, Times):
        return f"times {value.factor:g}"
    return "left out" if isinstance(value, Out) else _word(value)


def _word(value: Any) -> str:
    if value is None:
        return "left out"
    return value if isinstance(value, str) else flow(value)


def _give_json(way: Give) -> dict[str, Any]:
    moves = {field: _setting(value) for field, value in way.moves.items()}
    return {"field": way.field, "before": way.before, "after": way.after, "moves": moves}
