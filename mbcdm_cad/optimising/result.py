"""The result of a search: the front with a short design file for each point, as text, table, data and page."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from math import isfinite
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from mbcdm_cad.checks.comparison import CheckResult, failed
from mbcdm_cad.checks.comparison import figures as check_figures
from mbcdm_cad.checks.run import Budget, run_all
from mbcdm_cad.design.drive import Drive
from mbcdm_cad.design.loader import LoadedDesign
from mbcdm_cad.layouts.check_design import checks_of
from mbcdm_cad.layouts.loader import layout_of, load_text
from mbcdm_cad.optimising.evaluate import FIGURES, Facts, figure, unit_of
from mbcdm_cad.optimising.search import INTERRUPTED, ROUNDS, Searched, TriedPoint, counted
from mbcdm_cad.optimising.wishes import Keep, Wishes
from mbcdm_cad.report.page.template import page_environment
from mbcdm_cad.report.table import ReportTable, TextReport, designs_shown, filled
from mbcdm_cad.routes import Floats
from mbcdm_cad.solving.question import Question, difference, patched

if TYPE_CHECKING:
    import pandas


# Points of a cable and of a circle, about: a page of a hundred designs stays below 2 MB.
_LINE, _CIRCLE = 90, 48


def sketch(drive: Drive) -> dict[str, Any]:
    """Lines by kind, each a list of points (x, y, z) in mm, drum centred: ``cables``, ``bodies``."""
    layout = layout_of(drive)
    paths = layout.cable_paths(0.0)
    return {
        "cables": [_points(path.sample(max(path.length_mm / _LINE, 0.5))) for path in paths],
        "bodies": [_points(circle) for circle in _circles(drive)],
    }


def _circles(drive: Drive) -> list[Floats]:
    """One circle for each wrap of a cable, about the body's axis."""
    routes = layout_of(drive).loads.si.routes
    turn = np.linspace(0.0, 2.0 * np.pi, _CIRCLE + 1)[:, None]
    found = []
    for cable in routes.cables:
        for wrap in cable.wraps:
            body = routes.body(wrap.body)
            axis, first = np.array(body.axis), np.array(body.reference)
            middle = np.array(body.point_m) + wrap.height_m * axis
            around = np.cos(turn) * first + np.sin(turn) * np.cross(axis, first)
            found.append((middle + wrap.radius_m * around) * 1e3)
    return found


def _points(line: Floats) -> list[list[float]]:
    rounded: list[list[float]] = np.asarray(line).round(1).tolist()
    return rounded


# A check binds where its margin is below this share of its limit.
BINDS = 0.02


@dataclass(frozen=True)
class FrontPoint:
    """One design of the front: its ``name``, file content ``text``, ``figures``, ``patch`` from the file given.

    ``checks``: all of its checks, without advice; ``sketch``: it in space, see
    :func:`mbcdm_cad.optimising.result.sketch`.
    """

    name: str
    layout: str
    text: str
    patch: str
    figures: Mapping[str, float]
    checks: tuple[CheckResult, ...]
    sketch: Mapping[str, Any] = field(default_factory=dict)

    @property
    def binding(self) -> tuple[str, ...]:
        """The checks with a limit that are within :data:`BINDS` of it, the nearest first."""
        shares = [
            (check.margin / (abs(check.limit) or 1.0), check.id)
            for check in self.checks
            if check.margin is not None and check.limit is not None and check.status == "pass"
        ]
        return tuple(name for share, name in sorted(shares) if 0.0 <= round(share, 9) < BINDS)

    def to_dict(self) -> dict[str, Any]:
        """Plain data."""
        return {
            "name": self.name,
            "layout": self.layout,
            "figures": dict(self.figures),
            "binding": list(self.binding),
            "patch": self.patch,
        }


@dataclass(frozen=True)
class BesideDesign:
    """A design beside which the front is shown: its ``name``, ``figures``, and the checks that it fails."""

    name: str
    figures: Mapping[str, float]
    failing: tuple[str, ...] = ()


@dataclass(frozen=True)
class Optimum(TextReport):
    """The front of a search, best first in its first aim; ``starts``: the files as given, those that pass.

    ``beside``: other designs to compare it with.

    ``folder`` has the files of :func:`mbcdm_cad.jobs.outputs.optimise`; ``finished`` is False for a search that was
    interrupted or ran out of time, and that can go on.
    """

    wishes: Wishes
    folder: Path
    points: tuple[FrontPoint, ...]
    starts: tuple[TriedPoint, ...]
    searched: Searched
    beside: tuple[BesideDesign, ...] = ()

    @property
    def finished(self) -> bool:
        """Whether the search came to its end."""
        return self.searched.finished

    @property
    def interrupted(self) -> bool:
        """Whether the keyboard interrupted it."""
        return self.searched.stopped == INTERRUPTED

    def __len__(self) -> int:
        """Number of designs on the front."""
        return len(self.points)

    def __getitem__(self, k: int) -> FrontPoint:
        """A design of the front, from 0."""
        return self.points[k]

    @property
    def shown(self) -> tuple[str, ...]:
        """The figures of the tables: aims, keeps, then mass and torque."""
        names = [aim.figure for aim in self.wishes.aims] + [keep.figure for keep in self.wishes.keeps]
        return tuple(dict.fromkeys([*names, "mass_g", "torque_Nm"]))

    @cached_property
    def table(self) -> ReportTable:
        """One row a design, figures of :attr:`shown`."""
        layouts = len({p.layout for p in self.points}) > 1
        heads = ("design", *(("layout",) if layouts else ()), *self.shown)
        rows = tuple(
            (p.name, *((p.layout,) if layouts else ()), *(p.figures.get(name) for name in self.shown))
            for p in self.points
        )
        return ReportTable(heads, rows)

    def binding(self) -> dict[str, list[str]]:
        """The checks that bind on the front, with the names of the designs where they do, the most first."""
        found: dict[str, list[str]] = {}
        for point in self.points:
            for name in point.binding:
                found.setdefault(name, []).append(point.name)
        return dict(sorted(found.items(), key=lambda item: (-len(item[1]), item[0])))

    def text(self, width: int | None = None) -> str:
        """What ``mbcdm optimise`` prints."""
        return "\n".join(self._lines(width))

    def _lines(self, width: int | None) -> Iterator[str]:
        s = self.searched
        yield from filled(
            f"{designs_shown(len(s.tried))} evaluated, {s.passing} pass every check"
            + (" and keep what was asked" if self.wishes.keeps else "")
            + f"; ended: {s.stopped}",
            width,
        )
        if s.grown is not None and not s.finished:
            yield from filled(f"the front's hypervolume grew by {s.grown:.2%} in the last {ROUNDS} generations", width)
        if not self.points:
            yield from filled(
                "no design passes; checks that failed most: "
                + (", ".join(f"{name} ({count})" for name, count in list(s.failing.items())[:8]) or "none"),
                width,
            )
            for reason, count in list(s.refused.items())[:3]:
                yield from filled(f"no drive, {count} times: {reason}", width)
        else:
            aims = ", ".join(map(str, self.wishes.aims))
            yield f"Front of {aims}: {designs_shown(len(self.points))} in {self.folder}/front"
            yield from self.table.text(width, "  ")
            for other in self.beside:
                shown = (f"{name} {other.figures[name]:.4g}" for name in self.shown if name in other.figures)
                fails = f" (fails {', '.join(other.failing)})" if other.failing else ""
                yield from filled(f"  beside it {other.name}{fails}: {', '.join(shown)}", width)
            yield from self._binding_lines(width)
        for reason, count in s.left_out.items():
            yield from filled(f"{designs_shown(count)} left out for an aim that they do not have: {reason}", width)
        if s.faults:
            yield from filled(f"{len(s.faults)} points ended in a fault, the first: {s.faults[0]}", width)

    def _binding_lines(self, width: int | None) -> Iterator[str]:
        found, count = self.binding(), len(self.points)
        everywhere = [name for name, where in found.items() if len(where) == count]
        some = [f"{name} ({_listed(where)})" for name, where in found.items() if len(where) < count]
        near = f"within {BINDS:.0%} of their limits"
        if everywhere:
            yield from filled(f"  {near} at every design: {', '.join(everywhere)}", width)
        if some:
            yield from filled(f"  {near} at some: {', '.join(some[:12])}" + (", ..." if len(some) > 12 else ""), width)
        warned = counted(check.id for point in self.points for check in point.checks if check.status == "warn")
        if warned:
            told = ", ".join(f"{name} ({number} of {count})" for name, number in warned.items())
            yield from filled(f"  warnings, which a search does not avoid unless --keep says so: {told}", width)
            if avoided := " ".join(f'--keep "{keep}"' for keep in self._avoiding()):
                yield from filled(f"  to avoid them: {avoided}", width)

    def _avoiding(self) -> list[Keep]:
        """The limits that keep the figures of warnings within theirs, as the first design that warns has them."""
        warned = {check.id: check for point in self.points[::-1] for check in point.checks if check.status == "warn"}
        return [
            Keep(name, 1 if check.limit > check.actual else -1, check.limit)
            for name, check in warned.items()
            if check.limit is not None and check.actual is not None
        ]

    def to_dict(self) -> dict[str, Any]:
        """Everything, ready for JSON; this is ``optimum.json``."""
        s = self.searched
        return {
            "aims": [str(aim) for aim in self.wishes.aims],
            "keeps": [str(keep) for keep in self.wishes.keeps],
            "evaluated": len(s.tried),
            "passing": s.passing,
            "stopped": s.stopped,
            "finished": s.finished,
            "grown": None if s.grown is None else float(f"{s.grown:.9g}"),
            "front": [point.to_dict() for point in self.points],
            "starts": [dict(start.result.figures) for start in self.starts],
            "beside": [{"name": o.name, "figures": dict(o.figures), "failing": list(o.failing)} for o in self.beside],
            "binding": self.binding(),
            "failing": dict(s.failing),
            "left_out": dict(s.left_out),
            "hypervolume": [{"evaluated": count, "volume": float(f"{volume:.9g}")} for count, volume in s.curve],
            "faults": list(s.faults),
        }

    def to_pandas(self) -> pandas.DataFrame:
        """One row a design, all figures. Raises ``MbcdmError`` without pandas."""
        return self.all_figures().pandas()

    def all_figures(self) -> ReportTable:
        """One row a design, every figure that it has."""
        names = tuple(dict.fromkeys(name for point in self.points for name in point.figures))
        rows = tuple((p.name, p.layout, *(p.figures.get(name) for name in names)) for p in self.points)
        return ReportTable(("design", "layout", *names), rows)


def _listed(names: Sequence[str]) -> str:
    return ", ".join(names[:4]) + (f" and {len(names) - 4} more" if len(names) > 4 else "")


def optimum_of(
    questions: Sequence[Question], searched: Searched, folder: Path, stem: str, beside: Iterable[LoadedDesign] = ()
) -> Optimum:
    """The front of a search with its design files, named ``stem`` and a number, read and checked from their texts."""
    rows = sorted(searched.front, key=lambda row: (*searched.aims(row).tolist(), row))
    digits = max(2, len(str(len(rows))))
    points = []
    for number, row in enumerate(rows, start=1):
        one = searched.tried[row]
        name = f"{stem[: 60 - digits]}-{number:0{digits}d}"
        points.append(_front_point(questions[one.question], one, name))
    # The first point of each file has all its fields by their rules, and its ranges at their middles.
    firsts = {one.question: one for one in reversed(searched.tried)}
    starts = tuple(firsts[k] for k in sorted(firsts) if firsts[k].result.passes)
    others = tuple(_beside(one, searched.wishes) for one in beside)
    return Optimum(searched.wishes, folder, tuple(points), starts, searched, others)


def _beside(loaded: LoadedDesign, wishes: Wishes) -> BesideDesign:
    facts = Facts(loaded.drive, loaded.design.model_dump())
    names = dict.fromkeys([*FIGURES, *(a.figure for a in wishes.aims), *(k.figure for k in wishes.keeps)])
    figures = {name: figure(facts, name) for name in names}
    return BesideDesign(
        loaded.drive.name,
        {name: value for name, value in figures.items() if isfinite(value)},
        tuple(check.id for check in failed(checked(loaded))),
    )


def _front_point(question: Question, one: TriedPoint, name: str) -> FrontPoint:
    wanted = {**one.result.fields, "name": name}
    path = f"{name}.yaml"
    text = patched(question.text, str(question.path), wanted)
    loaded = load_text(text, path)
    return FrontPoint(
        name,
        loaded.drive.configuration,
        text,
        difference(question.text, text, question.path.name),
        one.result.figures,
        checked(loaded),
        sketch(loaded.drive),
    )


def checked(loaded: LoadedDesign) -> tuple[CheckResult, ...]:
    """All checks of a design without trying remedies."""
    return run_all(checks_of(loaded.drive), layout_of(loaded.drive), Budget(0))


# Where the page's template lies.
_PACKAGE = ("mbcdm_cad.optimising", "assets")


def optimum_page(found: Optimum) -> bytes:
    """The page as UTF-8; needs no other file. Raises nothing for a search without a passing design."""
    values = {n: {one.figures.get(n) for one in found.points} for n in dict.fromkeys([*found.shown, *FIGURES])}
    least = 1 if len(found.points) == 1 else 2
    names = [n for n, own in values.items() if n in found.shown or (len(own) >= least and own != {None})]
    data = {
        "aims": [{"figure": aim.figure, "sense": aim.sense} for aim in found.wishes.aims],
        "names": names,
        "units": {name: unit_of(name) for name in names},
        "points": [_point(point) for point in found.points],
        "starts": _marked(found),
        "curve": [list(step) for step in found.searched.curve],
    }
    template = page_environment(_PACKAGE).get_template("optimum.html.j2")
    return template.render(found=found, data=data, binding=found.binding(), meanings=FIGURES).encode()


def _marked(found: Optimum) -> list[dict[str, Any]]:
    """The designs that are no part of the front: its files as given, and those beside it."""
    several = len(found.starts) > 1
    given = [
        {"name": f"File {k} as given" if several else "File as given", "figures": dict(start.result.figures)}
        for k, start in enumerate(found.starts, start=1)
    ]
    return given + [
        {
            "name": f"{one.name} (fails {len(one.failing)} of its checks)" if one.failing else one.name,
            "figures": dict(one.figures),
            "beside": True,
        }
        for one in found.beside
    ]


def _point(point: FrontPoint) -> dict[str, Any]:
    return {
        "name": point.name,
        "layout": point.layout,
        "figures": dict(point.figures),
        "patch": point.patch,
        "binding": list(point.binding),
        "sketch": dict(point.sketch),
        "checks": [[c.id, c.title, c.status, check_figures(c)] for c in point.checks],
    }
