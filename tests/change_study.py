"""How often a change during the run is found, and how often one is named where nothing changed.

    python tests/change_study.py --rounds 5 --first-seed 60000 --store out/change-study.jsonl
    python tests/change_study.py --rounds 0 --store out/change-study.jsonl --table docs/loop-changes.md

Runs are those of tests/support/bench_change.py: benches of other code, noisier than declared, whose effect begins in
mid-run. In each round every case is made once, and as many runs without a change: effect-free ones, and ones whose
effect is there from the start.
"""

from __future__ import annotations

import argparse
import json
import sys
from functools import cache
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT / "tests" / "support"))
sys.path.insert(0, str(ROOT))

from bench_change import CHANGES, TRANSITION_S, simulate_change  # noqa: E402
from bench_data import through_files  # noqa: E402
from bench_real import simulate_real  # noqa: E402
from scipy.stats import binomtest  # noqa: E402

from mbcdm_cad.design.drive import Drive  # noqa: E402
from mbcdm_cad.layouts.loader import load_design  # noqa: E402
from tests.support.many import add_workers, run_many  # noqa: E402

UNCHANGED = ("null_brake", "null_steps", "null_hand", "null_motor", "thermal", "creep", "stiffness_modulus", "friction")
CHANGED = tuple(f"{case} changes" for case in CHANGES)
# What a change of one figure may be taken for in a set: to second order only mu T_pre counts.
ALIKE = {"preload_error": "cable_friction", "cable_friction": "preload_error"}


@cache
def _drive() -> Drive:
    return load_design(ROOT / "params" / "mbcdm.yaml").drive


def judge(asked: tuple[str, int]) -> dict[str, Any]:
    """Make the run of a case and a seed, give it to the loop, compare."""
    from mbcdm_cad.loop.search.engine import close_loop

    (case, seed), drive = asked, _drive()
    name, changes = case.removesuffix(" changes"), case.endswith(" changes")
    simulated, at_s = simulate_change(drive, name, seed) if changes else (simulate_real(drive, name, seed), None)
    result = close_loop(drive, [through_files(simulated, drive.input_names)])
    sets = [[one] for one in result.effects] + [list(group) for group in result.one_of]
    true = {CHANGES[name]} if changes else set()
    found = [group for group in sets if any(one.name == "change" and one.stage in true for one in group)]
    members = [one for group in found for one in group if one.stage in true]
    at = members[0].parameters.get("at_s") if members else None
    wrong = [one.words for group in sets if group not in found for one in group if changes or one.name == "change"]
    wrong += [one.words for g in found for one in g if one.stage not in true | {ALIKE.get(t) for t in true}]
    said = [" or ".join(one.words for one in group) for group in sets]
    inside = None if at is None or at_s is None else bool(at.low <= at_s <= at.high)
    off_s = None if at is None or at_s is None else abs(at.value - at_s)
    outcome = "named" if any(len(g) == 1 for g in found) else "set" if found else "missed"
    return {
        "case": case,
        "seed": seed,
        "outcome": outcome if changes else "none",
        "wrong": wrong,
        "said": said,
        "verdict": result.verdict,
        "inside": inside,
        "off_s": off_s,
    }


def table(rows: list[dict[str, Any]]) -> str:
    """The page."""
    changed, still = ([r for r in rows if r["case"].endswith(" changes") == c] for c in (True, False))

    def share(name: str, good: int, of: int) -> str:
        if not of:
            return f"| {name} | - | 0 | - | - |"
        ends = binomtest(good, of).proportion_ci()
        return f"| {name} | {good} | {of} | {good / of:.1%} | {ends.low:.1%} to {ends.high:.1%} |"

    timed = [r for r in changed if r["inside"] is not None]
    lines = [
        "# Changes during a run: how often they are found\n",
        "Written by `python tests/change_study.py --rounds 0 --store STORE --table docs/loop-changes.md`; the module "
        "says how the runs are made.\nBenches of other code than the loop's, noise 1 to 8 times what is declared.\n",
        "| count | good | runs | share | 95 % interval |",
        "| --- | --- | --- | --- | --- |",
        share("change named, or in a set", sum(r["outcome"] != "missed" for r in changed), len(changed)),
        share("change named outright", sum(r["outcome"] == "named" for r in changed), len(changed)),
        share("no wrong name beside or in place of the change", sum(not r["wrong"] for r in changed), len(changed)),
        share(
            "time inside its 95 % interval, or within the 0.05 s that the change takes",
            sum(r["inside"] or r["off_s"] <= TRANSITION_S for r in timed),
            len(timed),
        ),
        share("runs without a change: no change named", sum(not r["wrong"] for r in still), len(still)),
        "",
        "| case | runs | named | set | missed | wrong | said (runs) |",
        "| --- | --- | --- | --- | --- | --- | --- |",
    ]
    for case in (*CHANGED, *UNCHANGED):
        mine = [r for r in rows if r["case"] == case]
        counts = {word: sum(r["outcome"] == word for r in mine) for word in ("named", "set", "missed")}
        said: dict[str, int] = {}
        for r in mine:
            words = " + ".join(r["said"]) or r["verdict"]
            said[words] = said.get(words, 0) + 1
        told = "; ".join(f"{words} ({n})" for words, n in sorted(said.items(), key=lambda item: -item[1]))
        lines.append(
            f"| {case} | {len(mine)} | {counts['named']} | {counts['set']} | {counts['missed']} | "
            f"{sum(bool(r['wrong']) for r in mine)} | {told} |"
        )
    return "\n".join(lines) + "\n"


def main() -> None:
    """Parse and do."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--rounds", type=int, default=1)
    parser.add_argument("--first-seed", type=int, default=0)
    parser.add_argument("--store", type=Path, default=ROOT / "out" / "change-study.jsonl")
    parser.add_argument("--table", type=Path, help="Markdown page to write")
    add_workers(parser)
    options = parser.parse_args()
    options.store.parent.mkdir(parents=True, exist_ok=True)
    rows = [json.loads(line) for line in options.store.read_text().splitlines()] if options.store.exists() else []
    done = {(r["case"], r["seed"]) for r in rows}
    seeds = range(options.first_seed, options.first_seed + options.rounds)
    asked = [(case, seed) for seed in seeds for case in (*CHANGED, *UNCHANGED) if (case, seed) not in done]
    for row in run_many(judge, asked, options):
        rows.append(row)
        with options.store.open("a") as file:
            file.write(json.dumps(row) + "\n")
        print(row["case"], row["seed"], row["outcome"], row["said"], row["wrong"], flush=True)
    if options.table is not None:
        options.table.write_text(table(rows), "utf-8")


if __name__ == "__main__":
    main()
