"""All results of the checks on one design: counted, as text for a terminal, as JSON, as a table.

The command line prints it, the Python API returns it.
"""

from __future__ import annotations

import textwrap
from collections import Counter, defaultdict
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, field
from typing import TYPE_CHECKING, Any, Literal

from mbcdm_cad.checks.comparison import CheckResult, failed, figures
from mbcdm_cad.checks.motors import speed
from mbcdm_cad.design.sized import LIGHTEST
from mbcdm_cad.errors import MbcdmError, did_you_mean
from mbcdm_cad.layouts.base import Layout, NoFigureError
from mbcdm_cad.layouts.check_design import advised_checks
from mbcdm_cad.model.si import ModelError
from mbcdm_cad.report.as_built_chances import Chance, chance_lines, chances_of
from mbcdm_cad.report.table import ReportTable, speed_shown

if TYPE_CHECKING:
    import pandas

    from mbcdm_cad.design.loaded import LoadedDesign

Shown = Literal["findings", "failed", "all"]
WORDS = ("pass", "warn", "fail", "waived")
_COLOURS = {"pass": "32", "warn": "33", "fail": "31", "waived": "33"}
# Passing checks first and failing ones last, next to the summary, so that they stay visible on the terminal.
_ORDER = ("pass", "warn", "waived", "fail")
_INDENT = " " * 7
# Width in characters for figure and limit of a passing check; few need more.
_FIGURES = 28
# What the rules choose together where a file leaves the ratio open.
_TRAIN = ("drive.motor", "drive.gearhead")


@dataclass(frozen=True)
class CheckReport:
    """Results of every check on the design ``name``, in the order of docs/checks.md."""

    name: str
    design_sha256: str
    results: tuple[CheckResult, ...]
    # Result of applying the remedies together, in words; empty if nothing fails.
    advice: str = ""
    # Probability of each check on a drive as built; empty where no value was found on it.
    chances: tuple[Chance, ...] = ()
    # Ratio, motor and gearhead of the lightest drive, by field; empty where the file states the ratio.
    chosen: Mapping[str, Any] = field(default_factory=dict)
    # Speed of that drive where the file asks for none: the lightest is a slow one.
    chosen_speed: str = ""

    @property
    def passed(self) -> bool:
        """Whether no check fails; warnings and waived failures do not count."""
        return not self.failed

    @property
    def failed(self) -> tuple[CheckResult, ...]:
        """Results that fail and are not waived."""
        return failed(self.results)

    @property
    def warnings(self) -> tuple[CheckResult, ...]:
        """Results that warn."""
        return tuple(result for result in self.results if result.status == "warn")

    @property
    def counts(self) -> dict[str, int]:
        """Number of results by status; waived ones are counted as waived, not as passed."""
        found = Counter(_word(result) for result in self.results)
        return {word: found[word] for word in WORDS}

    def __iter__(self) -> Iterator[CheckResult]:
        """All results, in order."""
        return iter(self.results)

    def __len__(self) -> int:
        """Number of checks."""
        return len(self.results)

    def __getitem__(self, check_id: str) -> CheckResult:
        """The result of one check. Raises ``MbcdmError`` for an id that no check has."""
        for result in self.results:
            if result.id == check_id:
                return result
        remedy = did_you_mean(check_id, (result.id for result in self.results))
        raise MbcdmError(f"{check_id}: no such check; {remedy}")

    def text(self, *, width: int | None = None, colour: bool = False, show: Shown = "findings") -> str:
        """What ``mbcdm check`` prints: warnings, then failures with their remedies, and a summary line.

        ``show`` "failed" leaves the warnings out, "all" also lists passing checks. No line is longer than ``width``.
        """
        words = {"findings": _ORDER[1:], "failed": _ORDER[3:], "all": _ORDER}[show]
        listed = [result for word in words for result in self.results if _word(result) == word]
        alike: dict[tuple[str, str], list[CheckResult]] = defaultdict(list)
        for result in failed(listed):
            if result.actual is None:
                alike[result.message, result.remedy].append(result)
        grouped = [each for each in alike.values() if len(each) > 1]
        alone = [result for result in listed if not any(result in each for each in grouped)]
        lines = [line for result in alone for line in _lines(result, _Columns.of(self.results, width), colour)]
        lines += [line for each in grouped for line in _together(each, width, colour)]
        lines += _wrapped(self.advice, _INDENT, _INDENT, width)
        lines += [line for text in chance_lines(self.chances) for line in _wrapped(text, "", _INDENT, width)]
        told = ", ".join(f"{name} {value}" for name, value in self.chosen.items())
        told = f"chosen for the lightest drive: {told}{self.chosen_speed}" if told else ""
        lines += _wrapped(told, "", _INDENT, width)
        return "\n".join([*lines, *_wrapped(self._summary(), "", "", width)])

    def _summary(self) -> str:
        counted = ", ".join(f"{n} {word}" for word, n in self.counts.items())
        return f"{self.name}: {counted}, of {len(self)} checks"

    def __str__(self) -> str:
        """As :meth:`text`."""
        return self.text()

    def _repr_html_(self) -> str:
        """For notebooks: the summary, then the checks that do not simply pass."""
        found = [result for word in _ORDER[1:] for result in self.results if _word(result) == word]
        rows = tuple((_word(r), r.id, figures(r), r.message, r.remedy) for r in found)
        counted = ", ".join(f"{n} {word}" for word, n in self.counts.items())
        return (
            f"<p>{self.name}: {counted}</p>"
            + ReportTable(("status", "check", "figure", "found", "remedy"), rows).html()
        )

    def to_dict(self) -> dict[str, Any]:
        """All fields of all results, with a summary, ready for JSON."""
        return {
            "design": self.name,
            "design_sha256": self.design_sha256,
            "summary": self.counts,
            "advice": self.advice,
            "checks": [asdict(result) for result in self.results],
            "as_built": {one.check: one.probability for one in self.chances},
            **({"chosen": dict(self.chosen)} if self.chosen else {}),
        }

    def to_pandas(self) -> pandas.DataFrame:
        """One row a check. Raises ``MbcdmError`` where pandas is not installed."""
        rows = [asdict(result) for result in self.results]
        columns = tuple(CheckResult.__dataclass_fields__)
        return ReportTable(columns, tuple(tuple(row[name] for name in columns) for row in rows)).pandas()


def check_design(loaded: LoadedDesign) -> CheckReport:
    """Run every check. Raises ``InputError`` for a waiver that names no check, and for nothing else."""
    results, together = advised_checks(loaded)
    advice = together.words(loaded.path.name) if together else ""
    chances = chances_of(loaded.drive, loaded.design.as_built)
    chosen = _chosen(loaded)
    told = _speed(loaded.drive.layout) if chosen and loaded.drive.loads.speed_deg_s is None else ""
    return CheckReport(loaded.drive.name, loaded.sha256, results, advice, chances, chosen, told)


def _speed(layout: Layout) -> str:
    """Speed of the drum under load as words, with the field that asks for another; empty without a figure."""
    try:
        found = speed(layout)
    except (NoFigureError, ModelError):
        return ""
    return f"; {found.subject} {speed_shown(found.actual)} deg/s (loads.speed_deg_s asks for more)"


def _chosen(loaded: LoadedDesign) -> dict[str, Any]:
    """Ratio, motor and gearhead that the rules chose together, by field."""
    by_rule = {value.field: value.value for value in loaded.sized}
    ratios = [value.field for value in loaded.sized if value.driver == LIGHTEST]
    return {name: by_rule[name] for name in (*ratios, *_TRAIN) if ratios and name in by_rule}


def _word(result: CheckResult) -> str:
    return "waived" if result.waived_reason else result.status


@dataclass(frozen=True)
class _Columns:
    """Widths that the lines of a report share. Titles of passing checks are left out if they do not all fit."""

    width: int | None
    id: int
    titles: bool

    @classmethod
    def of(cls, results: Sequence[CheckResult], width: int | None) -> _Columns:
        id_width = max((len(result.id) for result in results), default=0)
        longest = max((len(result.title) for result in results), default=0)
        needed = len(_INDENT) + id_width + _FIGURES + 2 + longest
        return cls(width, id_width, width is None or needed <= width)


def _lines(r: CheckResult, columns: _Columns, colour: bool) -> Iterator[str]:
    """Lines of one check: id and figures; if it does not simply pass, message and remedy below."""
    word, width = _word(r), columns.width
    if word == "pass":
        text = f"{r.id:<{columns.id}} {figures(r):<{_FIGURES}} {r.title if columns.titles else ''}".rstrip()
        first, *more = _wrapped(text, _INDENT, _INDENT, width)
    else:
        first, *more = _wrapped(f"{r.id}: {r.title}", _INDENT, _INDENT, width)
        more += _wrapped(r.message, _INDENT, _INDENT, width)
        note = f"waived: {r.waived_reason}" if r.waived_reason else f"-> {r.remedy}" if r.remedy else ""
        more += _wrapped(note, _INDENT, _INDENT + "   ", width)
    yield _mark(word, colour) + first[len(_INDENT) - 1 :]
    yield from more


def _together(failing: Sequence[CheckResult], width: int | None, colour: bool) -> Iterator[str]:
    """Lines of checks whose figures do not exist for one common reason: the reason once, then which they are."""
    first, *more = _wrapped(f"{len(failing)} checks, for one reason", _INDENT, _INDENT, width)
    yield _mark("fail", colour) + first[len(_INDENT) - 1 :]
    yield from (*more, *_wrapped(failing[0].message, _INDENT, _INDENT, width))
    yield from _wrapped(f"-> {failing[0].remedy}", _INDENT, _INDENT + "   ", width)
    yield from _wrapped(", ".join(result.id for result in failing), _INDENT, _INDENT, width)


def _mark(word: str, colour: bool) -> str:
    return f"\x1b[{_COLOURS[word]}m{word:<6}\x1b[0m" if colour else f"{word:<6}"


def _wrapped(text: str, first: str, rest: str, width: int | None) -> list[str]:
    """Lines of at most ``width`` characters; runs of spaces, which line columns up, are kept."""
    if width is None or len(first) + len(text) <= width:
        return [first + text] if text else []
    return textwrap.wrap(
        text,
        max(width, 40),
        initial_indent=first,
        subsequent_indent=rest,
        break_on_hyphens=False,
        break_long_words=False,
    )
