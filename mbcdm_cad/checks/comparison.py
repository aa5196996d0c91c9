"""Comparison of a figure with its limit, the check that makes it, and the result of a check."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from math import inf, isfinite
from types import ModuleType
from typing import Any, Literal, NamedTuple

from mbcdm_cad.checks.design_variables import Adjustment

# Tolerance for rounding errors, so that a gap that equals its limit exactly passes.
TOLERANCE = 1e-9


# A figure below this is the rounding error of an exact zero, and one below this share of its limit as well.
NOTHING, SHARE_OF_NOTHING = 1e-11, 1e-6


def shown(value: float) -> str:
    """Four significant digits; 0 for a value that differs from it only by rounding."""
    return "0" if abs(value) < NOTHING else f"{value:.4g}"


class Comparison(NamedTuple):
    """``actual`` of ``subject`` against ``limit``: at least (``sense`` +1), at most (-1), or no limit (0)."""

    subject: str
    actual: float
    limit: float
    unit: str
    sense: int
    note: str = ""

    @property
    def margin(self) -> float:
        """Distance from the limit in ``unit``, positive inside; minus infinity if the figure is not finite."""
        if not isfinite(self.actual):
            return -inf
        return self.sense * (self.actual - self.limit)

    @property
    def shown(self) -> Comparison:
        """The same with 0 in place of a figure that differs from it only by rounding."""
        nothing = 0.0 < abs(self.actual) < SHARE_OF_NOTHING * abs(self.limit)
        return self._replace(actual=0.0) if nothing else self

    @property
    def holds(self) -> bool:
        """Whether the limit is kept, apart from rounding errors."""
        return self.margin >= -TOLERANCE


def at_least(subject: str, actual: float, limit: float, unit: str, note: str = "") -> Comparison:
    """``actual`` must not fall below ``limit``."""
    return Comparison(subject, float(actual), float(limit), unit, 1, note)


def at_most(subject: str, actual: float, limit: float, unit: str, note: str = "") -> Comparison:
    """``actual`` must not exceed ``limit``."""
    return Comparison(subject, float(actual), float(limit), unit, -1, note)


def noted(subject: str, actual: float, unit: str, note: str = "") -> Comparison:
    """A figure for information, without a limit."""
    return Comparison(subject, float(actual), 0.0, unit, 0, note)


def worst(findings: Iterable[Comparison]) -> Comparison:
    """The finding nearest to, or furthest beyond, its limit; all in one unit."""
    return min(findings, key=lambda finding: finding.margin)


class Check(NamedTuple):
    """One check. ``measure`` may raise :class:`~mbcdm_cad.layouts.base.NoFigureError`.

    ``severity``: status if the limit is not kept. ``adjust``: design variables that may correct it, tried in this
    order. ``advice``: other changes that help. ``measure`` and ``advice`` get the design under test of the
    configuration that the check belongs to, a :class:`~mbcdm_cad.layouts.base.Layout`.
    ``applies``: the drives of the configuration that the check is run on, None for all.
    """

    id: str
    title: str
    source: str
    measure: Callable[[Any], Comparison]
    severity: str = "fail"
    adjust: tuple[Adjustment, ...] = ()
    advice: str | Callable[[Any], str] = ""
    applies: Callable[[Any], bool] | None = None

    def asked_of(self, drive: Any) -> bool:
        """Whether the check applies to this drive of its configuration."""
        return self.applies is None or self.applies(drive)


class Family(NamedTuple):
    """Checks that are run and shown together; ``text`` says what they compare."""

    text: str
    checks: tuple[Check, ...]


def families(*found: Family | ModuleType) -> tuple[Family, ...]:
    """Families in their order; a module is one by the first line of its docstring and its ``CHECKS``."""
    return tuple(
        one if isinstance(one, Family) else Family((one.__doc__ or "").strip().split("\n")[0], one.CHECKS)
        for one in found
    )


Status = Literal["pass", "warn", "fail"]


@dataclass(frozen=True)
class CheckResult:
    """Outcome of one check; plain data, no number is ever infinite or NaN.

    ``margin`` is in ``unit`` and positive inside the limit; ``actual``, ``limit`` and ``margin`` are None if they do
    not exist. ``message`` states figure and limit, ``remedy`` the change that would make the check pass (empty if it
    passes). A waived failure has status "pass" and its ``waived_reason``.
    """

    id: str
    title: str
    status: Status
    actual: float | None
    limit: float | None
    unit: str
    margin: float | None
    message: str
    remedy: str
    source: str
    waived_reason: str | None = None


def figures(r: CheckResult) -> str:
    """``actual >= limit unit``, with the sign that the limit has."""
    if r.actual is None:
        return "not evaluated"
    if r.limit is None or r.margin is None:
        return f"{shown(r.actual)} {r.unit}"
    least = (r.actual - r.limit) * r.margin > 0 or (r.margin == 0.0 and r.status == "pass")
    return f"{shown(r.actual)} {'>=' if least else '<='} {shown(r.limit)} {r.unit}"


def failed(results: Sequence[CheckResult]) -> tuple[CheckResult, ...]:
    """Results that fail and are not waived."""
    return tuple(result for result in results if result.status == "fail")
