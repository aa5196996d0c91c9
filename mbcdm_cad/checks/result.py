"""The result of a check: one record for the terminal, the JSON and the report."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

from mbcdm_cad.checks.comparison import shown

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
