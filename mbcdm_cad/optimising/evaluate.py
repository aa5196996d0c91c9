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
from mbcdm_cad.optimising.figures import FIGURES, Facts, figure
from mbcdm_cad.optimising.wishes import Keep
from mbcdm_cad.solving.question import Point, Question, stated
from mbcdm_cad.solving.trials import LAST, missed, must_hold

# Checks that solve finite elements: they run only on a design that passes all others.
WINDUP = "frame_windup"
ELEMENTS = frozenset({"drum_stress", WINDUP, "stiffness"})
# Figures without a limit, which fail only where the model has no answer.
NOTED = frozenset({"wrap_slip_test", "wrap_slip_peak"})
LATE = LAST | ELEMENTS | NOTED
# What a design that fails an early check adds, so that one that fails only late checks is always nearer to a pass.
EARLY = 4.0 * len(LATE)
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
        early = EARLY if any(name not in LATE and ":" not in name for name, _ in self.failing) else 0.0
        return early + sum(miss for _, miss in self.failing)


def evaluate(question: Question, point: Point, keeps: Sequence[Keep], names: Sequence[str]) -> Evaluated:
    """Evaluate a point; ``names`` are the figures wanted beside those of :data:`FIGURES`.

    The file that states the point decides: where a rule changes because a value is stated, that design counts. A design
    that fails a check without finite elements is judged with the walls with which its rules begin.
    """
    with np.errstate(all="ignore"), warnings.catch_warnings(), many_meshes():
        warnings.simplefilter("ignore", RuntimeWarning)
        try:
            data, moved = question.trial(point)
            found = question.resolve(data, moved, first=True)
            failing = _failing(found, early=True)
            if not failing and _bends_too_much(question, found):
                found = question.resolve(data, moved)
                failing = _failing(found, early=True)
            if failing:
                return Evaluated(failing)
            if moved:
                data = stated(data, moved, found)
                as_stated = question.resolve(data, {})
                if as_stated.design != found.design:
                    failing = _failing(as_stated, early=True)
                    found = as_stated
            failing = failing or _failing(found, early=False)
            if failing:
                return Evaluated(failing)
            return _kept(found, data, keeps, names)
        except InputError as error:
            return Evaluated(refused=str(error.problems[0].what))
        except (MbcdmError, NoFigureError) as error:
            return Evaluated(refused=str(error))
        except Exception as error:  # a search of hours must not end at one point; the result counts them
            return Evaluated(refused=f"{FAULT}{type(error).__name__}: {error}")


def _failing(found: Resolved, *, early: bool) -> tuple[tuple[str, float], ...]:
    """The checks that fail and are not waived, of those that run early or late."""
    drive = found.drive
    asked = [
        check
        for check in checks_of(drive)
        if (check.id not in LATE) == early and must_hold(check) and drive.waiver(check.id) is None
    ]
    misses = [(check.id, missed(check, drive.layout)) for check in asked]
    return tuple((name, float(f"{miss:.9g}")) for name, miss in misses if miss)


def _bends_too_much(question: Question, found: Resolved) -> bool:
    """Whether the sizing rules may stiffen a design that they have only begun."""
    drive = found.drive
    sizing = question.file.sizing
    return (
        sizing is not None
        and sizing.has_first
        and any(missed(check, drive.layout) for check in checks_of(drive) if check.id == WINDUP)
    )


def facts_of(found: Resolved) -> Facts:
    """What the figures of a design follow from."""
    drive = found.drive
    checks: dict[str, Check] = {check.id: check for check in checks_of(drive)}
    return Facts(drive, checks, found.sizing.data if found.sizing is not None else found.design.model_dump())


def _kept(found: Resolved, data: Mapping[str, Any], keeps: Sequence[Keep], names: Sequence[str]) -> Evaluated:
    facts = facts_of(found)
    figures = {name: figure(facts, name) for name in dict.fromkeys([*FIGURES, *names, *(k.figure for k in keeps)])}
    short = []
    for keep in keeps:
        value = figures[keep.figure]
        margin = keep.margin(value) if np.isfinite(value) else float("-inf")
        if margin < 0.0:
            share = -margin / (abs(keep.limit) or 1.0)
            short.append((str(keep), float(f"{share / (1.0 + share) if np.isfinite(share) else 1.0:.9g}")))
    known = {name: value for name, value in figures.items() if np.isfinite(value)}
    missing = [name for name in names if name not in known]
    if missing and not short:
        reason = facts.reasons.get(missing[0], "this design has no such figure")
        return Evaluated(refused=f"{missing[0]}: {reason}")
    return Evaluated(tuple(short), "", known, dict(leaves(data)))
