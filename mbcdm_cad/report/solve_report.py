"""The result of a search for a passing design: as text with the patch of the file, as JSON, as the changed file.

The command line prints it, the Python API returns it.
"""

import shlex
from collections.abc import Callable
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from mbcdm_cad.design.describe import flow
from mbcdm_cad.report.table import TextReport, designs_shown, rendered
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
        found, name, codes = self.solution, str(self.path), {"+": "32", "-": "31", "@": "36"} if colour else {}
        patch = self.patch.splitlines() if found.changes else []
        return rendered(
            "solve.txt.j2",
            filters={"word": _word, "setting": _setting},
            name=name,
            conflict=self.conflict,
            tried=designs_shown(found.trials),
            changes=found.changes,
            patch=[f"\x1b[{codes[x[:1]]}m{x}\x1b[0m" if x[:1] in codes else x for x in patch],
            ranges=found.question.ranges,  # who leaves a range open often wants the best within it
            quoted=shlex.quote(name),
        ).removesuffix("\n")

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
