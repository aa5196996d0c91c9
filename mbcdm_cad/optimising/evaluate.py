"""Evaluate one point: size it, check it without advice, and take its figures from the file that would state it."""

from __future__ import annotations

import warnings
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from mbcdm_cad.checks.comparison import Check
from mbcdm_cad.design.fieldpath import leaves
from mbcdm_cad.design.loader import Resolved
from mbcdm_cad.errors import InputError, MbcdmError
from mbcdm_cad.layouts.base import NoFigureError
from mbcdm_cad.layouts.check_design import checks_of
from mbcdm_cad.model.block_rows import many_meshes
from mbcdm_cad.optimising.figures import BY_ELEMENTS, FIGURES, Facts, figure
from mbcdm_cad.optimising.spread import percentile_of
from mbcdm_cad.optimising.wishes import Keep
from mbcdm_cad.solving.question import Point, Question, stated
from mbcdm_cad.solving.trials import LAST, missed, must_hold

# Figures without a limit, which fail only where the model has no answer.
NOTED = frozenset({"wrap_slip_test", "wrap_slip_peak"})
# Checks that take as long as all quick ones together and seldom miss.
LONG = frozenset({"life", "path_length", "pair_mismatch", "transmission_error", "backdrive", "take_up"})
BOX = frozenset(f"envelope_{axis}" for axis in "xyz")
# The checks run in stages, and keeps with them, by what they take: those of a stage only if a design passes all before.
ELEMENTS, SLOWER, QUICK = range(3)
_SLOWER = LAST | NOTED | LONG | BOX
# What a miss in a stage adds, so that a design that passes more stages is always nearer to a pass.
STAGE = 200.0
# Violation of a point that gives no drive.
NO_DRIVE = 1000.0
# Between the name of an aim and the reason why a design cannot be compared with others.
NO_FIGURE = ": no figure, "
# Beginning of the reason of a point that shows a fault of this program.
FAULT = "fault of the program: "


@dataclass(frozen=True)
class Evaluated:
    """One evaluated point, plain data.

    ``failing``: the checks and keeps that it misses, and the aims of which it has no figure, each with its share of
    ``violation``; ``refused``: why it is no drive; ``figures`` and ``fields`` (of its file, by dotted name) of a design
    that passes.
    """

    failing: tuple[tuple[str, float], ...] = ()
    refused: str = ""
    figures: Mapping[str, float] = field(default_factory=dict)
    fields: Mapping[str, Any] = field(default_factory=dict)

    @property
    def passes(self) -> bool:
        """Whether it is a drive that passes every check and keeps every figure."""
        return not self.failing and not self.refused

    @property
    def violation(self) -> float:
        """Zero for a design that passes, and the larger the further it is from that."""
        if self.refused:
            return NO_DRIVE
        reached = max((_stage(name) for name, _ in self.failing), default=ELEMENTS)
        return STAGE * reached + sum(miss for _, miss in self.failing)


def _stage(name: str) -> int:
    """The stage of a check, of a keep as text, or of an aim without a figure."""
    figure, _, limit = name.partition(":")
    if figure in BY_ELEMENTS or percentile_of(figure) is not None:
        return ELEMENTS
    return SLOWER if limit or figure in _SLOWER else QUICK


def evaluate(question: Question, point: Point, keeps: Sequence[Keep], names: Sequence[str]) -> Evaluated:
    """Evaluate a point; ``names`` are the figures wanted beside those of :data:`FIGURES`.

    The file that states the point decides: where a rule changes because a value is stated, that design counts.
    """
    with np.errstate(all="ignore"), warnings.catch_warnings(), many_meshes():
        warnings.simplefilter("ignore", RuntimeWarning)
        try:
            data, moved = question.trial(point)
            found = question.resolve(data, moved)
            facts = facts_of(found)
            failing = _missed_early(facts, keeps, names)
            if failing:
                return Evaluated(failing)
            if moved:
                data = stated(data, moved, found)
                as_stated = question.resolve(data, {})
                if as_stated.design != found.design:
                    facts = facts_of(as_stated)
                    failing = _missed_early(facts, keeps, names)
            failing = failing or _missed(facts, keeps, names, ELEMENTS)
            if failing:
                return Evaluated(failing)
            return _figures(facts, data, names, keeps)
        except InputError as error:
            return Evaluated(refused=str(error.problems[0].what))
        except (MbcdmError, NoFigureError) as error:
            return Evaluated(refused=str(error))
        except Exception as error:  # a search of hours must not end at one point; the result counts them
            return Evaluated(refused=f"{FAULT}{type(error).__name__}: {error}")


_Missed = tuple[tuple[str, float], ...]


def _missed_early(facts: Facts, keeps: Sequence[Keep], names: Sequence[str]) -> _Missed:
    return _missed(facts, keeps, names, QUICK) or _missed(facts, keeps, names, SLOWER)


def _missed(facts: Facts, keeps: Sequence[Keep], names: Sequence[str], stage: int) -> _Missed:
    """The checks of a stage that fail and are not waived; if there are none, its keeps that are missed.

    A design without a figure of an aim cannot be compared with others: that counts as a keep that is missed.
    """
    drive = facts.drive
    asked = [
        check
        for check in facts.checks.values()
        if _stage(check.id) == stage and must_hold(check) and drive.waiver(check.id) is None
    ]
    misses = [(check.id, missed(check, drive.layout)) for check in asked]
    own = [keep for keep in keeps if _stage(str(keep)) == stage]
    aims = [name for name in names if _stage(name + NO_FIGURE) == stage]
    if not any(miss for _, miss in misses):
        misses = [(str(keep), _short(keep, figure(facts, keep.figure))) for keep in own]
        lacking = [name for name in aims if not np.isfinite(figure(facts, name))]
        misses += [(name + NO_FIGURE + facts.reasons.get(name, "the file has no such number"), 1.0) for name in lacking]
    return tuple((name, float(f"{miss:.9g}")) for name, miss in misses if miss)


def _short(keep: Keep, value: float) -> float:
    """What a keep adds to the violation, below 1; zero if it is kept."""
    margin = keep.margin(value) if np.isfinite(value) else float("-inf")
    share = max(-margin, 0.0) / (abs(keep.limit) or 1.0)
    return share / (1.0 + share) if np.isfinite(share) else 1.0


def facts_of(found: Resolved) -> Facts:
    """What the figures of a design follow from."""
    drive = found.drive
    checks: dict[str, Check] = {check.id: check for check in checks_of(drive)}
    return Facts(drive, checks, found.sizing.data if found.sizing is not None else found.design.model_dump())


def _figures(facts: Facts, data: Mapping[str, Any], names: Sequence[str], keeps: Sequence[Keep]) -> Evaluated:
    figures = {name: figure(facts, name) for name in dict.fromkeys([*FIGURES, *names, *(k.figure for k in keeps)])}
    known = {name: value for name, value in figures.items() if np.isfinite(value)}
    return Evaluated((), "", known, dict(leaves(data)))
