"""Tables of the confusion study, in markdown."""

from __future__ import annotations

from collections import Counter, defaultdict
from collections.abc import Iterable

import numpy as np
from bench_score import OUTCOMES, Score

# What the project aims at, by group: (what, outcomes that count, share, at least or at most).
AIMS: tuple[tuple[str, tuple[str, ...], tuple[str, ...], str, float], ...] = (
    ("a name or set in a run without an effect", ("null",), ("wrong", "wrong set"), "<=", 0.02),
    ("the same with a small repeatable texture", ("texture",), ("wrong", "wrong set"), "<=", 0.05),
    ("single effect that can be separated, named exactly", ("single",), ("exact",), ">=", 0.95),
    ("single effect for which a set is acceptable, named exactly", ("fair",), ("exact",), ">=", 0.85),
    ("the same, named exactly or in a set", ("fair",), ("exact", "set"), ">=", 0.95),
    ("pair named exactly", ("pair",), ("exact",), ">=", 0.90),
    ("wrong name, all runs with effects of the library", ("single", "fair", "alike", "pair"), ("wrong",), "<=", 0.02),
    ("cause outside the library for which an effect of the library is named", ("outside",), ("wrong",), "<=", 0.05),
)


def aims_table(scores: list[Score]) -> str:
    """Each aim with count, share and whether it is met."""
    rows = ["| aim | limit | found | runs | met |", "| --- | --- | --- | --- | --- |"]
    for what, groups, outcomes, sense, limit in AIMS:
        runs = [s for s in scores if s.group in groups]
        if runs:
            share = sum(s.outcome in outcomes for s in runs) / len(runs)
            rows.append(_aim(what, sense, limit, share, len(runs)))
    sets = [s for s in scores if s.outcome in ("set", "wrong set") and s.group in ("single", "fair", "alike", "pair")]
    if sets:
        share = _share(s.outcome == "set" for s in sets)
        rows.append(_aim("sets that contain the true effect", ">=", 0.95, share, len(sets)))
    judged = [s for s in scores if s.knowing_rad and s.after_rad and s.outcome == "exact"]
    if judged:
        ratio = np.array([s.after_rad / s.knowing_rad for s in judged if s.after_rad and s.knowing_rad])
        what = f"held-out error at most 1.05 of that with the truth known (median {np.median(ratio):.3f}, exact runs)"
        rows.append(_aim(what, ">=", 0.95, float(np.mean(ratio <= 1.05)), len(ratio)))
    values = [v for s in scores for v in s.values if s.outcome == "exact"]
    if values:
        near = _share(abs(found - true) <= 0.03 * abs(true) for _, true, found, _, _ in values)
        rows.append(_aim("value within 3 % of the truth", ">=", 0.95, near, len(values)))
    covered = [low <= true <= high for _, true, _, low, high in values if low is not None and high is not None]
    if covered:
        share = _share(covered)
        met = "yes" if 0.85 <= share <= 0.99 else "no"
        what = "95 % intervals that contain the true value"
        rows.append(f"| {what} | 85 to 99 % | {share:.1%} | {len(covered)} | {met} |")
    return "\n".join(rows)


def _share(hits: Iterable[bool]) -> float:
    return float(np.mean([bool(hit) for hit in hits]))


def _aim(what: str, sense: str, limit: float, share: float, count: int) -> str:
    met = share >= limit if sense == ">=" else share <= limit
    words = "at least" if sense == ">=" else "at most"
    return f"| {what} | {words} {limit:.0%} | {share:.1%} | {count} | {'yes' if met else 'no'} |"


def outcome_table(scores: list[Score]) -> str:
    """One row a case, one column an outcome."""
    used = [o for o in OUTCOMES if any(s.outcome == o for s in scores)]
    head = "| case | aim | runs | " + " | ".join(used) + " | error after / knowing | median s |"
    rows = [head, "| --- " * (len(used) + 5) + "|"]
    for case, runs in _by_case(scores).items():
        counts = Counter(s.outcome for s in runs)
        ratio = [s.after_rad / s.knowing_rad for s in runs if s.after_rad and s.knowing_rad]
        cells = [case, runs[0].group, str(len(runs)), *(str(counts[o] or "") for o in used)]
        cells.append(f"{np.median(ratio):.3f}" if ratio else "")
        cells.append(f"{np.median([s.seconds for s in runs]):.1f}")
        rows.append("| " + " | ".join(cells) + " |")
    return "\n".join(rows)


def matrix(scores: list[Score]) -> str:
    """What was said of each case, most frequent first, with counts."""
    rows = ["| case | finding (runs) |", "| --- | --- |"]
    for case, runs in _by_case(scores).items():
        said = Counter(s.said for s in runs).most_common()
        text = "; ".join(f"{what} ({count})" for what, count in said[:8]).replace("|", "or")
        more = "" if len(said) <= 8 else f"; {len(said) - 8} others"
        rows.append(f"| {case} | {text}{more} |")
    return "\n".join(rows)


def value_table(scores: list[Score]) -> str:
    """Relative error and coverage of each reported size."""
    sizes: dict[str, list[tuple[float, float, float | None, float | None]]] = defaultdict(list)
    for score in scores:
        for what, *rest in score.values:
            sizes[what].append(tuple(rest))  # type: ignore[arg-type]
    rows = ["| size | values | median error | 95 % of errors below | intervals that contain it |", "| --- " * 5 + "|"]
    for what, values in sorted(sizes.items()):
        error = [abs(found - true) / abs(true) for true, found, _, _ in values]
        held = [low <= true <= high for true, _, low, high in values if low is not None and high is not None]
        covered = f"{_share(held):.0%}" if held else "none given"
        rows.append(f"| {what} | {len(values)} | {np.median(error):.2%} | {np.quantile(error, 0.95):.2%} | {covered} |")
    return "\n".join(rows)


def _by_case(scores: list[Score]) -> dict[str, list[Score]]:
    cases: dict[str, list[Score]] = {}
    for score in scores:
        cases.setdefault(score.case, []).append(score)
    return cases
