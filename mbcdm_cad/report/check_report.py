"""The results of all checks and of a build: counted, as text, JSON and table, with each check's chance as built.

The values that were found (modulus, preload, friction) are normal with their intervals and correlations. The margin of
each check is taken as straight over one standard deviation to either side of each value. Source: derived; the test
draws the values at random instead.

The command line prints it, the Python API returns it.
"""

from __future__ import annotations

import textwrap
from collections import Counter, defaultdict
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, field, replace
from math import erf, sqrt
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from mbcdm_cad.checks.comparison import CheckResult, failed, figures
from mbcdm_cad.checks.motors import speed
from mbcdm_cad.design.blocks import AsBuilt, AsBuiltValue
from mbcdm_cad.design.drive import Drive
from mbcdm_cad.design.resolve import CHANGE_VALUES, HALF_95, with_as_built
from mbcdm_cad.design.sized import LIGHTEST
from mbcdm_cad.errors import MbcdmError, did_you_mean
from mbcdm_cad.layouts.base import Layout, NoFigureError
from mbcdm_cad.layouts.check_design import advised_checks, checks_of
from mbcdm_cad.layouts.registry import layout_of
from mbcdm_cad.model.si import ModelError
from mbcdm_cad.report.table import ReportTable, TextReport, preformatted, speed_shown
from mbcdm_cad.routes import Floats

if TYPE_CHECKING:
    import pandas

    from mbcdm_cad.design.loader import LoadedDesign


# Probabilities beyond these are told as certain, and only counted.
UNSURE = (0.001, 0.999)


@dataclass(frozen=True)
class Chance:
    """The probability that one check passes."""

    check: str
    title: str
    probability: float


def chances_of(drive: Drive, found: Sequence[AsBuilt]) -> tuple[Chance, ...]:
    """Probabilities of all checks; empty where no value with an interval was found. ``drive`` is as built already."""
    known = [(k, entry) for k, entry in enumerate(found) if _deviation(entry) > 0.0]
    if not known:
        return ()
    middle = _margins(drive)
    slopes: dict[str, list[float]] = {name: [] for name in middle}
    for _, entry in known:
        step = _deviation(entry) / (1.0 + _share(entry).value)
        up, down = (_margins(_moved(drive, entry, sign * step)) for sign in (1.0, -1.0))
        for name in slopes:
            slopes[name].append(0.5 * (up.get(name, np.nan) - down.get(name, np.nan)))
    correlation = _correlations(known)
    chances = []
    for check in checks_of(drive):
        slope = np.array(slopes.get(check.id, [np.nan]))
        if check.id not in middle or not np.isfinite(slope).all():
            continue
        deviation = float(np.sqrt(max(0.0, slope @ correlation @ slope)))
        margin = middle[check.id]
        # The normal distribution by its error function: SciPy would make every check of a design slow to start.
        passes = float(margin >= 0.0) if deviation == 0.0 else 0.5 * (1.0 + erf(margin / deviation / sqrt(2.0)))
        chances.append(Chance(check.id, check.title, passes))
    return tuple(chances)


def chance_lines(chances: Sequence[Chance]) -> Iterator[str]:
    """For a terminal: the checks that neither pass nor fail for certain, and how many do."""
    if not chances:
        return
    low, high = UNSURE
    unsure = [one for one in chances if low < one.probability < high]
    passing, failing = (sum(one.probability >= high for one in chances), sum(one.probability <= low for one in chances))
    yield (
        f"as built, within what the loop knows: {passing} checks pass and {failing} fail with a probability over "
        f"{high:.1%}" + ("; of the others:" if unsure else "")
    )
    for one in sorted(unsure, key=lambda one: one.probability):
        yield f"  {one.check} passes with {one.probability:.1%} ({one.title})"


def _margins(drive: Drive) -> dict[str, float]:
    """The margin of each check that has a figure and a limit."""
    found = {}
    with np.errstate(all="ignore"):
        for check in checks_of(drive):
            try:
                compared = check.measure(layout_of(drive))
            except (NoFigureError, ModelError):
                continue
            if compared.sense and np.isfinite(compared.actual) and np.isfinite(compared.limit):
                found[check.id] = float(compared.margin)
    return found


def _share(entry: AsBuilt) -> AsBuiltValue:
    return next(value for value in entry.values if value.name == "share")


def _deviation(entry: AsBuilt) -> float:
    """Standard deviation of the share that an entry changes a value of the design by; 0 for other entries."""
    if entry.form not in CHANGE_VALUES.get(entry.name, ()):
        return 0.0
    share = _share(entry)
    return 0.0 if share.low is None or share.high is None else (share.high - share.low) / (2.0 * HALF_95)


def _moved(drive: Drive, entry: AsBuilt, share: float) -> Drive:
    """The drive with the value of an entry changed by a further share."""
    return with_as_built(drive, (replace(entry, values=(AsBuiltValue(name="share", value=share),)),))


def _correlations(known: Sequence[tuple[int, AsBuilt]]) -> Floats:
    """Correlations of the shares of the entries, given by their number in the file."""
    found = np.eye(len(known))
    at = {number: k for k, (number, _) in enumerate(known)}
    for k, (_, entry) in enumerate(known):
        for one in entry.correlated:
            if one.own == one.other == "share" and one.entry in at:
                found[k, at[one.entry]] = found[at[one.entry], k] = one.correlation
    return found


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
class CheckReport(TextReport):
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

    def html(self) -> str:
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
    told = _speed(layout_of(loaded.drive)) if chosen and loaded.drive.loads.speed_deg_s is None else ""
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


@dataclass(frozen=True)
class BuildReport(TextReport):
    """Outcome of a build: ``folder`` is None where it was refused, ``data`` is report.json where parts were drawn.

    ``made`` names the parts that had to be drawn; ``unchanged``: the folder already contained everything.
    ``cache_problem``: why the cache could not be used, in one sentence; else empty.
    """

    name: str
    folder: Path | None
    checks: CheckReport
    data: dict[str, Any] | None
    made: tuple[str, ...]
    unchanged: bool = False
    cache_problem: str = ""

    @property
    def passed(self) -> bool:
        """Whether it was built and no check fails, of the design or of what was built."""
        return self.folder is not None and self.checks.passed

    def text(self) -> str:
        """What ``mbcdm build`` prints."""
        if self.folder is None or self.data is None:
            failed = ", ".join(check.id for check in self.checks.failed)
            return f"{self.name}: not built, {len(self.checks.failed)} check(s) fail: {failed}"
        mass, box, run = (self.data[key] for key in ("mass", "envelope", "interference"))
        counts = self.checks.counts
        some = f": {', '.join(self.made)}" if 0 < len(self.made) < 6 else ""
        drawn = "nothing changed" if self.unchanged else f"{len(self.made)} made{some}"
        size = " x ".join(f"{v:.2f}" for v in box["size_mm"])
        heavy = "" if mass["target_g"] is None else f" (target {mass['target_g']:g} +- {mass['tolerance_g']:g})"
        asked = "" if box["target_mm"] is None else f" (target {' x '.join(f'{v:g}' for v in box['target_mm'])})"
        lines = [
            f"{self.folder}: {drawn}",
            f"  mass {mass['mass_g']:.1f} g +- {mass['sigma_g']:.1f}{heavy}",
            f"  box X x Z x Y {size} mm{asked}",
            f"  interference: {len(run['clashes'])} clashes at {len(run['poses_deg'])} poses",
            f"  checks: {counts['fail']} fail, {counts['warn']} warn, of {len(self.checks)}; see report.md",
        ]
        if self.data["forced"]:
            lines.insert(1, f"  FORCED although these fail: {', '.join(self.data['failed_checks'])}")
        return "\n".join(lines)

    def html(self) -> str:
        """For notebooks: the text, then the checks that do not simply pass."""
        return preformatted(self.text()) + self.checks.html()

    def to_dict(self) -> dict[str, Any]:
        """The content of report.json, ready for JSON; for a refused build only the results of the checks."""
        return self.data if self.data is not None else {"checks": self.checks.to_dict()["checks"]}
