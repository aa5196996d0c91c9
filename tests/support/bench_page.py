"""The page of docs/ about the bench study: each aim with its 95 % interval, and what was said by class of bench."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Sequence
from textwrap import fill
from typing import Any

import numpy as np
from scipy.stats import beta

Row = dict[str, Any]
INSIDE = ("single", "fair", "pair", "three")
FREE = ("null", "texture")
RIGHT = ("exact", "set")
# From this heading on the page is written by hand and kept.
BY_HAND = "## What falls short"


def interval(right: int, of: int) -> tuple[float, float]:
    """95 % interval of a share (Clopper and Pearson)."""
    low = float(beta.ppf(0.025, right, of - right + 1)) if right else 0.0
    high = float(beta.ppf(0.975, right + 1, of - right)) if right < of else 1.0
    return low, high


SHARES_HEAD = ("| what | aim | right | of | share | 95 % |", "| --- | --- | --- | --- | --- | --- |")


def share_row(what: str, aim: str, hits: Sequence[bool]) -> list[str]:
    """A row below ``SHARES_HEAD``; none of no runs."""
    if not hits:
        return []
    low, high = interval(sum(hits), len(hits))
    return [f"| {what} | {aim} | {sum(hits)} | {len(hits)} | {sum(hits) / len(hits):.1%} | {low:.1%} to {high:.1%} |"]


def counted(row: Row) -> bool:
    """Whether every effect of a run is large enough and can be told from all others, by the truth."""
    return bool(row["large"] and row["separable"])


def summary(rows: Sequence[Row]) -> str:
    """Each aim with its count, share and interval, as Markdown."""
    lines = list(SHARES_HEAD)

    def share(what: str, aim: str, hits: Sequence[bool]) -> None:
        lines.extend(share_row(what, aim, hits))

    def line(what: str, aim: str, chosen: Sequence[Row], good: tuple[str, ...]) -> None:
        share(what, aim, [r["outcome"] in good for r in chosen])

    def of(*groups: str, told: Callable[[Row], bool] = lambda row: True) -> list[Row]:
        return [r for r in rows if r["group"] in groups and told(r)]

    line("effect-free: no name", "98 %", of(*FREE), ("none", "not_testable", "unknown"))
    line("effect-free: verdict `none`", "-", of(*FREE), ("none", "not_testable"))
    for name, groups, aim in (
        ("single", ("single", "fair"), "95 %"),
        ("pair", ("pair",), "90 %"),
        ("three", ("three",), "-"),
    ):
        line(f"{name}, counted: exactly named", aim, of(*groups, told=counted), ("exact",))
        line(f"{name}, counted: named or in a set", "-", of(*groups, told=counted), RIGHT)
        alike = of(*groups, told=lambda r: r["large"] and not r["separable"])
        line(f"{name}, large but not separable: named or in a set", "-", alike, RIGHT)
    not_wrong = ("exact", "set", "partial", "none", "unknown", "not_testable", "wrong set")
    line("any effect: no wrong name", "98 %", of(*INSIDE), not_wrong)
    line("threes: no wrong name", "98 %", of("three"), not_wrong)
    line("small effect: no wrong name", "98 %", of(*INSIDE, told=lambda r: not r["large"]), not_wrong)
    line("cause outside the vocabulary: no name", "95 %", of("outside"), ("none", "unknown"))
    sets = of(*INSIDE, told=lambda r: "{" in r["said"] and r["outcome"] != "wrong")
    line("sets that hold the truth", "95 %", sets, ("exact", "set", "partial"))
    large = of(*INSIDE, told=lambda r: r["large"] and r.get("knowing"))
    near = [r["after"] <= 1.05 * r["knowing"] for r in large]
    share("large effect: held-out error at most 1.05 of knowing the truth", "all", near)
    named = [r["after"] <= 1.05 * r["knowing"] for r in large if r["outcome"] in RIGHT]
    share("the same, where the finding is right", "all", named)
    covered = [
        low <= true <= high for r in rows for _, true, _, low, high in r.get("values", []) if None not in (low, high)
    ]
    share("95 % intervals that hold the truth", "85 to 99 %", covered)
    return "\n".join(lines)


CLASSES: dict[str, Callable[[Row], str]] = {
    "load": lambda r: str(r["load"]),
    "samples a second": lambda r: (
        "50 and 100" if r["rate_hz"] < 150 else "200" if r["rate_hz"] < 300 else "500 to 2000"
    ),
    "noise, times declared": lambda r: "1 to 1.5" if r["noise"] < 1.5 else "1.5 to 3" if r["noise"] < 3 else "3 to 8",
    "half travel, rad": lambda r: f"{r['half_travel_rad']:g}",
    "motion": lambda r: str(r["wave"]),
    "gaps in the log": lambda r: "with gaps" if r["gaps"] else "without gaps",
}


def by_class(rows: Sequence[Row]) -> str:
    """What was said of the runs of each class of benches: effect-free runs, and runs with large effects."""
    said = ("exact", "set", "partial", "missed", "wrong set", "wrong")
    head = ["class", "", "effect-free: none", "unknown", "a name", "with effects", *said]
    lines = ["| " + " | ".join(head) + " |", "| --- " * len(head) + "|"]
    for name, kind in CLASSES.items():
        for value in sorted({kind(r) for r in rows}):
            mine = [r for r in rows if kind(r) == value]
            free = Counter(r["outcome"] for r in mine if r["group"] in FREE)
            effects = [r["outcome"] for r in mine if r["group"] in INSIDE and r["large"]]
            found = Counter("missed" if o in ("none", "unknown", "not_testable", "error") else o for o in effects)
            none, unknown = free["none"] + free["not_testable"], free["unknown"]
            cells = [none, unknown, sum(free.values()) - none - unknown, len(effects), *(found[o] for o in said)]
            lines.append(f"| {name} | {value} | " + " | ".join(str(c or "") for c in cells) + " |")
    return "\n".join(lines)


def findings(rows: Sequence[Row]) -> str:
    """What was said of each case, most frequent first."""
    lines = ["| case | runs | counted | finding (runs) |", "| --- | --- | --- | --- |"]
    for case in dict.fromkeys(r["case"] for r in rows):
        mine = [r for r in rows if r["case"] == case]
        said = Counter(r["said"].replace(" | ", " or ") for r in mine).most_common()
        words = "; ".join(f"{what} ({count})" for what, count in said)
        told = str(sum(counted(r) for r in mine)) if mine[0]["group"] in INSIDE else ""
        lines.append(f"| {case} | {len(mine)} | {told} | {words} |")
    return "\n".join(lines)


def failures(rows: Sequence[Row]) -> str:
    """Runs in which something is named that is not there, or counted effects are not all named outright."""
    lines = ["| case | seed | true | finding | nearest rival |", "| --- | --- | --- | --- | --- |"]
    for r in sorted(rows, key=lambda r: (r["case"], r["seed"])):
        missed = r["group"] in INSIDE and counted(r) and r["outcome"] != "exact"
        if missed or r["outcome"] in ("wrong", "wrong set", "error"):
            said, rival = r["said"].replace(" | ", " or "), r.get("rival") or ""
            lines.append(f"| {r['case']} | {r['seed']} | {r['true']} | {said} | {rival} |")
    return "\n".join(lines)


def page(rows: Sequence[Row], command: str, before: str = "") -> str:
    """The whole page; ``before`` is the page as it is, of which the part written by hand is kept."""
    groups = Counter(
        "effect-free" if r["group"] in FREE else {"fair": "single"}.get(r["group"], r["group"]) for r in rows
    )
    made = ", ".join(f"{groups[name]} {words}" for name, words in GROUPS.items() if groups[name])
    ratio = [r["after"] / r["knowing"] for r in rows if r.get("knowing") and r["outcome"] in RIGHT]
    parts = [
        "# How often the loop is right on simulated benches with realistic noise",
        fill(
            f"Made by `{command}`: {len(rows)} runs ({made}). None of these seeds was used while the loop was "
            "developed, and all runs were judged by one version of the loop.",
            120,
        ),
        ABOUT,
        "## Comparison with the aims",
        summary(rows),
        fill(
            f"Held-out error over that of knowing the truth where the finding is right: median "
            f"{np.median(ratio):.3f}, "
            f"95 % below {np.quantile(ratio, 0.95):.3f}.",
            120,
        )
        if ratio
        else "",
        "## By class of bench",
        "Missed: verdict `none` or `unknown`. Runs with effects: only those with large effects.",
        by_class(rows),
        "## Findings",
        findings(rows),
        "## Runs that went wrong",
        "Counted runs in which not every effect is named outright, and runs with a name or a set that is wrong.",
        failures(rows),
    ]
    kept = before[before.index(BY_HAND) :] if BY_HAND in before else ""
    return "\n\n".join(part for part in [*parts, kept.rstrip()] if part) + "\n"


GROUPS = {
    "effect-free": "without an effect",
    "single": "with one effect",
    "pair": "with two",
    "three": "with three",
    "outside": "with a cause that the loop's library does not have",
}
ABOUT = """This study runs the [loop](loop.md) on simulated benches and compares its finding with the truth. Each bench
draws at random:

- its noise: 1 to 8 times the noise of its declared encoder steps, white and correlated in time, and a slow drift;
- its servos: tracking errors of 5 to 40 urad at the drum, 0.1 to 3 Hz, with a lag under load;
- its logger: 50 to 2000 samples a second, with jitter and gaps;
- its load: brake, several levels, bias, steps, pendulum, spring, by hand, or a motor.

The cables are chains of pieces with Coulomb friction, not the model's equations. The measurement file declares only the
steps of the encoders.

Which runs are counted follows from the truth and the true noise alone (`tests/support/bench_separable.py`), before the
loop sees them. An effect is *large* if it lowers the held-out error by 0.45 of the floor or more with a probability
of 0.95. It is *separable* if the probability of taking another effect of the library for it is below 1 %. A run is
*counted* if all its effects are large and separable. The others are listed apart.

Exact: all effects are named, and nothing else. Set: each effect that is not named is a member of a set of effects that
the data cannot separate. Partial: the names are right, but an effect is missing. Wrong: a named effect is not present.
Wrong set: no member of a set is present."""
