"""Comparison of a figure with its limit, the check that makes it, and the result of a check."""

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial, wraps
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
    def shown(self) -> "Comparison":
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


# What a measure yields: comparisons, or (subject, actual, least) with or without a note, in the unit of its check.
Findings = Iterator[Comparison | tuple[str, float, float] | tuple[str, float, float, str]]


@dataclass(frozen=True)
class Check:
    """One check, which compares the design that it is called with; :func:`check` makes it.

    ``measure`` may raise :class:`~mbcdm_cad.layouts.base.NoFigureError`.
    ``severity``: status if the limit is not kept. ``adjust``: design variables that may correct it, tried in this
    order. ``advice``: other changes that help. ``measure`` and ``advice`` get the design under test of the
    configuration that the check belongs to, a :class:`~mbcdm_cad.layouts.base.Layout`.
    ``applies``: the drives of the configuration that the check is run on, None for all; ``warns``: those of them for
    which it only warns, None for none beside ``severity``.
    """

    id: str
    title: str
    source: str
    measure: Callable[[Any], Comparison]
    severity: str = "fail"
    adjust: tuple[Adjustment, ...] = ()
    advice: str | Callable[[Any], str] = ""
    applies: Callable[[Any], bool] | None = None
    warns: Callable[[Any], bool] | None = None

    def __call__(self, design: Any) -> Comparison:
        """The comparison that decides on this design."""
        return self.measure(design)

    def asked_of(self, drive: Any) -> bool:
        """Whether the check applies to this drive of its configuration."""
        return self.applies is None or self.applies(drive)

    def severity_on(self, drive: Any) -> str:
        """Status of this drive if the limit is not kept."""
        return "warn" if self.warns is not None and self.warns(drive) else self.severity

    def but(self, **changes: Any) -> "Check":
        """The same check with other fields."""
        return replace(self, **changes)


Maker = Callable[[Callable[[Any], Comparison | Findings]], Check]


def check(
    title: str,
    source: str,
    *adjust: Adjustment,
    advice: str | Callable[[Any], str] = "",
    advice_on: Callable[[Any, Comparison], str] | None = None,
    warn: bool | Callable[[Any], bool] = False,
    applies: Callable[[Any], bool] | None = None,
    unit: str = "mm",
    none: Comparison | None = None,
) -> Maker:
    """Make a check, whose id is the function's name, of a function that gives one comparison or yields several.

    The worst counts; ``none``: what stands where nothing is found. ``advice_on``: advice that reads what is found.
    ``warn``: whether it only warns, of all drives or of which.
    """

    def made(measure: Callable[[Any], Comparison | Findings]) -> Check:
        @wraps(measure)
        def compared(design: Any) -> Comparison:
            found = measure(design)
            if isinstance(found, Comparison):
                return found
            each = [f if isinstance(f, Comparison) else at_least(*f[:3], unit, *f[3:]) for f in found]
            return none if none is not None and not each else worst(each)

        severity, warns = ("fail", warn) if callable(warn) else ("warn" if warn else "fail", None)
        told = advice if advice_on is None else lambda design: advice_on(design, compared(design))
        return Check(measure.__name__, title, source, compared, severity, adjust, told, applies, warns)

    return made


def check_for(applies: Callable[[Any], bool]) -> Callable[..., Maker]:
    """As :func:`check`, of the drives for which ``applies`` holds."""
    return partial(check, applies=applies)


class Family(NamedTuple):
    """Checks that are run and shown together; ``text`` says what they compare.

    One without checks is a heading: it has the checks that follow it in its module.
    """

    text: str
    checks: tuple[Check, ...] = ()


def families(*found: Family | ModuleType) -> tuple[Family, ...]:
    """Families in their order; a module gives its ``FAMILIES``, or those of the checks that are written in it."""
    return tuple(
        family
        for one in found
        for family in ((one,) if isinstance(one, Family) else getattr(one, "FAMILIES", None) or _own(one))
    )


def _own(module: ModuleType) -> Iterator[Family]:
    """The checks of a module in its order, under its headings, or under the first line of its docstring."""
    text, checks = (module.__doc__ or "").strip().split("\n")[0], dict[str, list[Check]]()
    for one in getattr(module, "CHECKS", vars(module).values()):
        if isinstance(one, Family):
            text = one.text
        elif isinstance(one, Check) and (hasattr(module, "CHECKS") or one.measure.__module__ == module.__name__):
            checks.setdefault(text, []).append(one)
    return (Family(text, tuple(own)) for text, own in checks.items())


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
