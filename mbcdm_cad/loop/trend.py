"""How the figures of a drive change from date to date, and the day on which one reaches its limit.

The values of the runs come from one fit with all that they share (:mod:`mbcdm_cad.loop.search.own`). Three courses are
fitted to them by generalised least squares: the same throughout, evenly with time, settling (with the logarithm of the
time). Beside the covariance of the fit each run may scatter, as after a re-tensioning. The course with the least BIC is
taken (G. Schwarz, Annals of Statistics 6 (1978)); its odds against no change are those of the two BIC.
"""

import datetime
import io
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from math import log
from typing import Any

import numpy as np

from mbcdm_cad.design.blocks import AsBuilt, AsBuiltValue
from mbcdm_cad.design.drive import Drive
from mbcdm_cad.design.resolve import with_as_built
from mbcdm_cad.layouts.base import NoFigureError
from mbcdm_cad.layouts.check_design import checks_of
from mbcdm_cad.layouts.registry import layout_of
from mbcdm_cad.loop.judge import LoopReport, Study
from mbcdm_cad.loop.readable import Value, readable
from mbcdm_cad.loop.result import CLEAR_ODDS, Differing, odds_words
from mbcdm_cad.loop.search.own import FIELDS
from mbcdm_cad.model.si import ModelError
from mbcdm_cad.report.table import TextReport
from mbcdm_cad.routes import Floats

DAY_S = 86400.0
# Runs without which no course is fitted.
FEWEST_RUNS = 4
# Scatters of the runs that are tried, over the standard deviation of the values about their mean.
SCATTERS = (0.0, 0.01, 0.02, 0.05, 0.1, 0.2, 0.35, 0.5, 0.7, 1.0, 1.4)
# Draws for the interval of a day, and how far ahead it is looked for, in times of the study's length.
DRAWS, AHEAD = 4000, 20.0
# Halvings that find the limit of a design within its bounds.
HALVINGS = 24
COURSES: dict[str, Callable[[Floats], Floats]] = {
    "evenly with time": lambda days: days,
    "settling, with the logarithm of the time in days": np.log1p,
}


MENDED = "if it was put right between the runs, give those since then in a study of their own"


@dataclass(frozen=True)
class Limit:
    """The value at which a figure reaches a limit, and what says so."""

    value: float
    words: str


@dataclass(frozen=True, eq=False)
class Trend:
    """The course of one figure: ``values`` with 95 % intervals at ``dates``, its course in words, and the day at a
    limit with the earliest and the latest day, 95 %; a day beyond the look ahead is None. ``changed``: that the runs
    certainly differ, in words."""

    name: str
    figure: str
    dates: tuple[datetime.datetime, ...]
    runs: tuple[str, ...]
    values: tuple[Value, ...]
    course: str
    log_odds: float
    slope_a_day: Value | None
    line: Floats = field(repr=False)
    limit: Limit | None = None
    day: datetime.datetime | None = None
    earliest: datetime.datetime | None = None
    latest: datetime.datetime | None = None
    changed: str = ""

    @property
    def sentence(self) -> str:
        """What it did, in one sentence."""
        if self.changed and self.log_odds <= log(CLEAR_ODDS):
            said = f"{self.name} {self.changed}, but on no course over the dates: {MENDED}"
            return said + self._reached
        said = odds_words(self.log_odds, f"{self.name} changes {self.course}", f"{self.name} does not change with time")
        if self.slope_a_day is not None and self.log_odds > 0.0:
            word, (middle, low, high) = readable(self.figure, self.slope_a_day.three)
            over = "day" if "evenly" in self.course else "e-fold of the days"
            said += f": {word} by {middle} a {over} (95 %: {low} to {high})"
        return said + self._reached

    @property
    def _reached(self) -> str:
        if self.limit is None:
            return ""
        _, (limit,) = readable(self.figure, [self.limit.value])
        if self.log_odds <= log(CLEAR_ODDS):
            return f"; limit {limit} ({self.limit.words}), no day is given since the trend is not certain"
        if self.day is None:
            return f"; limit {limit} ({self.limit.words}) is not reached within {AHEAD:g} times the time of the study"
        latest = "no latest day" if self.latest is None else f"{self.latest:%Y-%m-%d}"
        earliest = "-" if self.earliest is None else f"{self.earliest:%Y-%m-%d}"
        return f"; limit {limit} ({self.limit.words}) reached on {self.day:%Y-%m-%d} (95 %: {earliest} to {latest})"

    def lines(self) -> list[str]:
        """The table for a terminal."""
        word = readable(self.figure, [1.0])[0]
        wide = max(len(run) for run in self.runs)
        lines = [f"{'date':<17}{'run':<{wide}}  {word} (95 %)"]
        for date, run, value in zip(self.dates, self.runs, self.values, strict=True):
            _, (middle, low, high) = readable(self.figure, value.three)
            lines.append(f"{date:%Y-%m-%d %H:%M} {run:<{wide}}  {middle} ({low} to {high})")
        return lines

    def to_json(self) -> dict[str, Any]:
        """As plain data."""
        return {
            "name": self.name,
            "figure": self.figure,
            "runs": [
                {"run": run, "date": date.isoformat(), **value.to_json()}
                for run, date, value in zip(self.runs, self.dates, self.values, strict=True)
            ],
            "course": self.course,
            "log_odds": self.log_odds,
            "slope_a_day": self.slope_a_day.to_json() if self.slope_a_day else None,
            "limit": {"value": self.limit.value, "from": self.limit.words} if self.limit else None,
            "day": [date.isoformat() if date else None for date in (self.day, self.earliest, self.latest)],
            "sentence": self.sentence,
        }


@dataclass(frozen=True, eq=False)
class TrendReport(TextReport):
    """All trends of a study, and the loop's finding on what the runs share."""

    loop: LoopReport
    trends: tuple[Trend, ...]

    def text(self) -> str:
        """For a terminal: a sentence and a table for each figure, then what the runs share."""
        parts = [line for trend in self.trends for line in (trend.sentence, *trend.lines(), "")]
        return "\n".join([*parts, f"all runs together: {self.loop.result.sentence}"])

    def to_dict(self) -> dict[str, Any]:
        """Ready for JSON."""
        return {"trends": [trend.to_json() for trend in self.trends], "loop": self.loop.to_dict()}

    def picture(self) -> bytes:
        """Values with intervals over the dates, the course, the limit and the day at which it is reached, as a PNG."""
        from matplotlib.backends.backend_agg import FigureCanvasAgg
        from matplotlib.figure import Figure

        figure = Figure(figsize=(9, 3.2 * len(self.trends)), layout="constrained")
        FigureCanvasAgg(figure)
        for axes, trend in zip(figure.subplots(len(self.trends), squeeze=False)[:, 0], self.trends, strict=True):
            middle = np.array([value.value for value in trend.values])
            ends = np.abs(np.array([[v.value - v.low, v.high - v.value] for v in trend.values]).T)
            dates: Any = list(trend.dates)
            axes.errorbar(dates, middle, yerr=ends, fmt="o", ms=4, capsize=2, color="#0072B2", label="of each run")
            axes.plot(dates, trend.line, color="#D55E00", label=trend.course)
            if trend.limit is not None:
                axes.axhline(trend.limit.value, color="#000000", ls="--", lw=0.8, label=f"limit: {trend.limit.words}")
            axes.set(ylabel=trend.figure, title=trend.name)
            axes.legend(fontsize=8, frameon=False)
            axes.grid(alpha=0.3)
        target = io.BytesIO()
        figure.savefig(target, format="png", dpi=100, metadata={"Software": None})
        return target.getvalue()


def refuse_no_trend(study: Study) -> None:
    """Raise an error where dates or runs are too few, or nothing differs in every run: before anything is computed."""
    count = len(study.files)
    if count < FEWEST_RUNS:
        raise study.problem(("runs",), "too few runs for a trend", f"{count}", remedy=f"give {FEWEST_RUNS} or more")
    if study.dates is None:
        raise study.problem(("runs", 0), "no date", remedy="add date: 2026-03-01 to every run")
    if not set.intersection(*map(set, study.differs)):
        raise study.problem((), "nothing differs in every run", remedy="add differs: [rope.preload_N] at the top")
    for name in study.content.limits:
        where = ("limits", name)
        if FIELDS.get(name, ("",))[0] == "stiffness_error":
            remedy = "leave it out: a modulus is told as a share of the design's, and the design's checks apply"
            raise study.problem(where, "a limit that no figure has", remedy=remedy)
        if any(name not in one for one in study.differs):
            raise study.problem(where, "a limit of what does not differ in every run", remedy="add it to differs")


def trends_of(study: Study, report: LoopReport) -> TrendReport:
    """The trend of everything that differs in every run."""
    dates = study.dates
    assert dates is not None, "refused before"
    whole = [one for one in report.result.own if one.every]
    return TrendReport(report, tuple(trend_of(one, dates, study, report.drive) for one in whole))


def trend_of(one: Differing, dates: Sequence[datetime.datetime], study: Study, drive: Drive | None) -> Trend:
    """The course of one figure over the dates, the first fitted value of each run."""
    wide = one.runs[0].values.size
    fitted = np.array([run.values[0] for run in one.runs])
    covariance = one.covariance[::wide, ::wide]
    # In the design's unit if there is one, else the first.
    figure = min(one.runs[0].figures, key=lambda name: name == "share")
    values = tuple(run.figures[figure] for run in one.runs)
    days = np.array([(date - dates[0]).total_seconds() / DAY_S for date in dates])
    course = best_course(days, fitted, covariance)
    # The figure is a straight function of the fitted value: a share of the declared figure, or the value itself.
    scale, shift = np.polyfit(fitted, [v.value for v in values], 1) if np.ptp(fitted) else (1.0, 0.0)
    slope = None
    if course.rising is not None:
        middle, half = scale * course.rising[0], abs(scale) * 1.96 * course.rising[1]
        slope = Value(middle, middle - half, middle + half)
    line = scale * course.at(days) + shift
    towards = 1.0 if course.rising is None or course.rising[0] * scale > 0.0 else -1.0
    limit = _limit(one.name, figure, float(line[-1]), towards, study, drive)
    found: list[datetime.datetime | None] = [None, None, None]
    if limit is not None and course.log_odds > log(CLEAR_ODDS):
        reached = course.days_at((limit.value - shift) / scale, float(days[-1]))
        found = [None if d is None else dates[0] + datetime.timedelta(days=d) for d in reached]
    names = tuple(run.run for run in one.runs)
    return Trend(
        one.name,
        figure,
        tuple(dates),
        names,
        values,
        course.name,
        course.log_odds,
        slope,
        line,
        limit,
        day=found[0],
        earliest=found[1],
        latest=found[2],
        changed=one.changed if one.log_odds > log(CLEAR_ODDS) else "",
    )


@dataclass(frozen=True, eq=False)
class Course:
    """A fitted course: its shape over the days, coefficients and their covariance, log of the odds against none.

    ``rising``: slope and its standard deviation; None for a figure that stays the same.
    """

    name: str
    shape: Callable[[Floats], Floats] | None
    coefficients: Floats
    covariance: Floats
    log_odds: float

    @property
    def rising(self) -> tuple[float, float] | None:
        """Slope and standard deviation."""
        if self.shape is None:
            return None
        return float(self.coefficients[1]), float(np.sqrt(self.covariance[1, 1]))

    def at(self, days: Floats) -> Floats:
        """The course's values."""
        return _columns(self.shape, days) @ self.coefficients

    def days_at(self, value: float, length: float) -> tuple[float | None, float | None, float | None]:
        """The day on which the course reaches a value, earliest and latest, 95 %; None beyond the look ahead."""
        assert self.shape is not None, "a figure that stays the same reaches nothing"
        last = AHEAD * max(length, 1.0)
        grid = np.concatenate([np.linspace(0.0, 2.0 * length, 2000), np.geomspace(2.0 * length + 1e-9, last, 2000)])
        draws = np.random.default_rng(0).multivariate_normal(self.coefficients, self.covariance, DRAWS)
        shape = self.shape(grid)

        def day(coefficients: Floats) -> float:
            beyond = (coefficients[0] + coefficients[1] * shape - value) * np.sign(coefficients[1]) >= 0.0
            return float(grid[int(np.argmax(beyond))]) if beyond.any() else np.inf

        each = np.array([day(one) for one in draws])
        low, high = np.quantile(each, [0.025, 0.975], method="nearest")
        best = day(self.coefficients)
        return tuple(float(d) if np.isfinite(d) else None for d in (best, low, high))  # type: ignore[return-value]


def _columns(shape: Callable[[Floats], Floats] | None, days: Floats) -> Floats:
    return np.column_stack([np.ones_like(days), *([] if shape is None else [shape(days)])])


def best_course(days: Floats, values: Floats, covariance: Floats) -> Course:
    """The course of ``values`` (n,) with their ``covariance``; the odds are against a figure that stays the same."""
    shapes = {"not at all": None, **COURSES}
    fits = {name: _least_squares(_columns(shape, days), values, covariance) for name, shape in shapes.items()}
    moving = min(COURSES, key=lambda name: fits[name][2])
    odds = 0.5 * (fits["not at all"][2] - fits[moving][2])
    name = moving if odds > 0.0 else "not at all"
    return Course(name, shapes[name], fits[name][0], fits[name][1], odds)


def _least_squares(columns: Floats, values: Floats, covariance: Floats) -> tuple[Floats, Floats, float]:
    """Coefficients, covariance and BIC, with the scatter of the runs that makes the values likeliest."""
    best: tuple[Floats, Floats, float] | None = None
    for share in SCATTERS:
        spread = covariance + (share * float(np.std(values))) ** 2 * np.eye(values.size)
        spread = spread + 1e-12 * float(np.trace(spread)) / values.size * np.eye(values.size)
        inverse = np.linalg.inv(spread)
        known = np.linalg.inv(columns.T @ inverse @ columns)
        found = known @ columns.T @ inverse @ values
        rest = values - columns @ found
        minus_two = float(rest @ inverse @ rest) + float(np.linalg.slogdet(spread).logabsdet)
        bic = minus_two + (columns.shape[1] + (share > 0.0)) * log(values.size)
        if best is None or bic < best[2]:
            best = np.asarray(found), np.asarray(known), float(bic)
    assert best is not None
    return best


def _limit(name: str, figure: str, now: float, towards: float, study: Study, drive: Drive | None) -> Limit | None:
    """Where the figure reaches a limit: that of the study file, or that of the first check that fails on the way."""
    if name in study.content.limits:
        return Limit(float(study.content.limits[name]), f"of {study.path.name}")
    if drive is None or name not in FIELDS:
        return None
    return _Design(drive, name).limit(figure, now, towards)


class _Design:
    """The checks of a design with one of its values changed by a share."""

    def __init__(self, drive: Drive, name: str) -> None:
        self.drive, self.key = drive, FIELDS[name]
        self.declared = {
            "preload_error": float(np.mean([cable.preload_N for cable in drive.cables])),
            "cable_friction": drive.friction_coefficient,
            "stiffness_error": 1.0,
        }[self.key[0]]

    def holding(self, share: float) -> dict[str, bool]:
        """Whether each check that may fail holds with the value changed, by title."""
        name, form = self.key
        entry = AsBuilt(name=name, form=form, values=(AsBuiltValue(name="share", value=share),))
        drive = with_as_built(self.drive, (entry,))
        found = {}
        with np.errstate(all="ignore"):
            for check in checks_of(drive):
                if check.severity_on(drive) == "warn":
                    continue
                try:
                    found[f"{check.id} ({check.title})"] = bool(check.measure(layout_of(drive)).holds)
                except (NoFigureError, ModelError):
                    found[f"{check.id} ({check.title})"] = False
        return found

    @cached_property
    def passing(self) -> frozenset[str]:
        """Checks that the declared design passes."""
        return frozenset(name for name, holds in self.holding(0.0).items() if holds)

    def limit(self, figure: str, now: float, towards: float) -> Limit | None:
        """The nearest value beyond ``now`` at which a check of the declared design no longer passes."""
        share = now if figure == "share" else now / self.declared - 1.0
        inside, outside = share, -0.95 if towards < 0.0 else 4.0
        if (outside - inside) * towards <= 0.0 or self._failed(outside) is None:
            return None
        if (first := self._failed(inside)) is not None:
            return Limit(now, f"check {first} does not hold already")
        for _ in range(HALVINGS):
            middle = 0.5 * (inside + outside)
            inside, outside = (middle, outside) if self._failed(middle) is None else (inside, middle)
        broken = self._failed(outside)
        assert broken is not None
        value = outside if figure == "share" else self.declared * (1.0 + outside)
        return Limit(value, f"check {broken}")

    def _failed(self, share: float) -> str | None:
        """The first check that holds for the declared design and not for this one."""
        return next((name for name, holds in self.holding(share).items() if name in self.passing and not holds), None)
