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
# Beginning of the reason of a point that shows a fault of this program.
FAULT = "fault of the program: "


@dataclass(frozen=True)
class Evaluated:
    """One evaluated point, plain data.

    ``failing``: the checks and keeps that it misses, each with its share of ``violation``; ``refused``: why it is no
    drive; ``figures`` and ``fields`` (of its file, by dotted name) of a design that passes.
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
    """The stage of a check, or of a keep as text."""
    figure, _, limit = name.partition(":")
    if figure in BY_ELEMENTS or percentile_of(figure) is not None:
        return ELEMENTS
    return SLOWER if limit or figure in _SLOWER else QUICK


def evaluate(question: Question, point: Point, keeps: Sequence[Keep], names: Sequence[str]) -> Evaluated:
    """Evaluate a point; ``names`` are the figures wanted beside those of :data:`FIGURES`.

    The file that states the point decides: where a rule changes because a value is stated, that design counts. A factor
    is one on what a rule gives with the walls with which the rules begin, and a design that misses anything without
    finite elements is judged with these walls.
    """
    with np.errstate(all="ignore"), warnings.catch_warnings(), many_meshes():
        warnings.simplefilter("ignore", RuntimeWarning)
        try:
            data, moved = question.trial(point)
            found = question.resolve(data, moved, first=True)
            failing = _missed_early(found, keeps)
            if failing:
                return Evaluated(failing)
            if moved or (question.file.sizing is not None and question.file.sizing.has_first):
                data = stated(data, moved, found)
                as_stated = question.resolve(data, {})
                if as_stated.design != found.design:
                    found = as_stated
                    failing = _missed_early(found, keeps)
            failing = failing or _missed(found, keeps, ELEMENTS)
            if failing:
                return Evaluated(failing)
            return _figures(found, data, names, keeps)
        except InputError as error:
            return Evaluated(refused=str(error.problems[0].what))
        except (MbcdmError, NoFigureError) as error:
            return Evaluated(refused=str(error))
        except Exception as error:  # a search of hours must not end at one point; the result counts them
            return Evaluated(refused=f"{FAULT}{type(error).__name__}: {error}")


def _missed_early(found: Resolved, keeps: Sequence[Keep]) -> tuple[tuple[str, float], ...]:
    return _missed(found, keeps, QUICK) or _missed(found, keeps, SLOWER)


def _missed(found: Resolved, keeps: Sequence[Keep], stage: int) -> tuple[tuple[str, float], ...]:
    """The checks of a stage that fail and are not waived; if there are none, its keeps that are missed."""
    drive = found.drive
    asked = [
        check
        for check in checks_of(drive)
        if _stage(check.id) == stage and must_hold(check) and drive.waiver(check.id) is None
    ]
    misses = [(check.id, missed(check, drive.layout)) for check in asked]
    own = [keep for keep in keeps if _stage(str(keep)) == stage]
    if own and not any(miss for _, miss in misses):
        facts = facts_of(found)
        misses = [(str(keep), _short(keep, figure(facts, keep.figure))) for keep in own]
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


def _figures(found: Resolved, data: Mapping[str, Any], names: Sequence[str], keeps: Sequence[Keep]) -> Evaluated:
    facts = facts_of(found)
    figures = {name: figure(facts, name) for name in dict.fromkeys([*FIGURES, *names, *(k.figure for k in keeps)])}
    known = {name: value for name, value in figures.items() if np.isfinite(value)}
    missing = [name for name in names if name not in known]
    if missing:
        reason = facts.reasons.get(missing[0], "this design has no such figure")
        return Evaluated(refused=f"{missing[0]}: {reason}")
    return Evaluated((), "", known, dict(leaves(data)))
