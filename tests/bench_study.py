"""How often the loop is right on benches as they are: noisier than declared, servos unlike, loggers that jitter.

    python tests/bench_study.py --only null --seeds 3 --jobs 2 --store out/bench-study.jsonl
    python tests/bench_study.py --table docs/loop-benches.md --store out/bench-study.jsonl --judged-only

Runs are made by tests/support/bench_real.py. A run counts as large enough when what its effects change at the output is
at least ``--least`` of the bench's true noise (RMS), which is worked out from the truth before the loop sees the run.
"""

from __future__ import annotations

import argparse
import json
import multiprocessing
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT / "tests" / "support"))

from bench_data import write_run  # noqa: E402
from bench_real import REAL_CASES, gain_rad, simulate_real  # noqa: E402
from bench_score import label, outcome_of, said_of, values_of  # noqa: E402
from scipy.stats import beta  # noqa: E402

from mbcdm_cad.configurations.loader import load_design  # noqa: E402

DESIGN = ROOT / "params" / "mbcdm.yaml"


def judge(task: tuple[str, int]) -> dict[str, Any]:
    """Make the run, give it to the loop, compare."""
    from mbcdm_cad.identification.engine import close_loop
    from mbcdm_cad.measurement.reading import load_measurement

    case, seed = task
    drive = load_design(DESIGN).drive
    run, traits = simulate_real(drive, case, seed)
    row: dict[str, Any] = {
        "case": case,
        "seed": seed,
        "group": REAL_CASES[case].group,
        "load": run.plan.load,
        "rate_hz": traits.rate_hz,
        "true": " + ".join(label(effect) for effect in run.effects) or "none",
        "true_floor": traits.floor_rad,
        "gain": gain_rad(drive, case, seed) if run.effects else 0.0,
        "samples": int(run.bench.time_s.size),
    }
    with tempfile.TemporaryDirectory() as name:
        write_run(Path(name), "run", run, drive.input_names)
        measured = load_measurement(Path(name) / "run.yaml")
    start = time.perf_counter()
    try:
        result = close_loop(drive, [measured]).to_json()
    except Exception as fault:  # a study of hundreds of runs goes on and reports the fault
        return row | {"outcome": "error", "said": f"{type(fault).__name__}: {fault}", "seconds": 0.0}
    error = result["error"]
    return row | {
        "outcome": outcome_of(result, run.effects),
        "said": said_of(result),
        "verdict": result["verdict"],
        "before": error["before_rad"],
        "after": error["after_rad"],
        "floor": error["floor_rad"],
        "values": values_of(result, run.effects),
        "seconds": time.perf_counter() - start,
    }


def interval(right: int, of: int) -> tuple[float, float]:
    """95 % interval of a share (Clopper and Pearson)."""
    low = float(beta.ppf(0.025, right, of - right + 1)) if right else 0.0
    high = float(beta.ppf(0.975, right + 1, of - right)) if right < of else 1.0
    return low, high


def summary(rows: list[dict[str, Any]], least: float) -> str:
    """Shares by group, as Markdown."""

    def of(group: tuple[str, ...], large: bool | None = None) -> list[dict[str, Any]]:
        chosen = [r for r in rows if r["group"] in group]
        return [r for r in chosen if large is None or (r["gain"] >= least * r["true_floor"]) == large]

    lines = ["| what | aim | right | of | share | 95 % |", "| --- | --- | --- | --- | --- | --- |"]

    def line(what: str, aim: str, chosen: list[dict[str, Any]], good: tuple[str, ...]) -> None:
        right = sum(r["outcome"] in good for r in chosen)
        if chosen:
            low, high = interval(right, len(chosen))
            share = f"{right / len(chosen):.0%} | {low:.0%} to {high:.0%}"
            lines.append(f"| {what} | {aim} | {right} | {len(chosen)} | {share} |")

    inside = ("single", "fair", "pair", "three")
    line("effect-free: no name", "98 %", of(("null", "texture")), ("none", "not_testable", "unknown"))
    line("effect-free: verdict none", "-", of(("null", "texture")), ("none", "not_testable"))
    line("single, large enough: exactly named", "95 %", of(("single", "fair"), True), ("exact",))
    line("single, large enough: named or in a set", "-", of(("single", "fair"), True), ("exact", "set"))
    line("pair, large enough: named or in a set", "90 %", of(("pair",), True), ("exact", "set"))
    line("three, large enough: named or in a set", "-", of(("three",), True), ("exact", "set"))
    not_wrong = ("exact", "set", "partial", "none", "unknown", "wrong set")
    line("any effect: no wrong name", "98 %", of(inside), not_wrong)
    line("small effect: no wrong name", "98 %", of(inside, False), not_wrong)
    line("outside the vocabulary: not blamed on a name", "95 %", of(("outside",)), ("none", "unknown", "exact"))
    covered = [low <= true <= high for r in rows for _, true, _, low, high in r.get("values", []) if low is not None]
    if covered:
        low, high = interval(sum(covered), len(covered))
        lines.append(
            f"| 95 % intervals that hold the truth | 85 to 99 % | {sum(covered)} | {len(covered)} | "
            f"{sum(covered) / len(covered):.0%} | {low:.0%} to {high:.0%} |"
        )
    return "\n".join(lines)


def main() -> None:
    """Parse and do."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--only", default="", help="cases, groups or beginnings of names, separated by commas")
    parser.add_argument("--seeds", type=int, default=1)
    parser.add_argument("--first-seed", type=int, default=0)
    parser.add_argument("--jobs", type=int, default=1)
    parser.add_argument("--least", type=float, default=0.6)
    parser.add_argument("--store", type=Path, default=ROOT / "out" / "bench-study.jsonl")
    parser.add_argument("--judged-only", action="store_true")
    options = parser.parse_args()
    words = [word for word in options.only.split(",") if word]
    cases = [n for n, c in REAL_CASES.items() if not words or c.group in words or any(n.startswith(w) for w in words)]
    options.store.parent.mkdir(parents=True, exist_ok=True)
    rows = [json.loads(line) for line in options.store.read_text().splitlines()] if options.store.exists() else []
    done = {(r["case"], r["seed"]) for r in rows}
    seeds = range(options.first_seed, options.first_seed + options.seeds)
    tasks = [(case, seed) for seed in seeds for case in cases if (case, seed) not in done]
    if not options.judged_only:
        with options.store.open("a") as kept, multiprocessing.get_context("spawn").Pool(options.jobs) as pool:
            for row in pool.imap_unordered(judge, tasks):
                rows.append(row)
                kept.write(json.dumps(row) + "\n")
                kept.flush()
                print(
                    f"{row['case']:28s} {row['seed']:3d} {row['load']:8s} {row['rate_hz']:5.0f} Hz {row['outcome']:9s} "
                    f"{row['seconds']:5.1f} s gain {1e6 * row['gain']:6.1f} floor {1e6 * row['true_floor']:5.1f} "
                    f"({1e6 * row.get('floor', 0.0):5.1f}) before {1e6 * row.get('before', 0.0):6.1f} after "
                    f"{1e6 * row.get('after', 0.0):6.1f} true: {row['true']}; said: {row['said']}",
                    flush=True,
                )
    print(summary(rows, options.least))


if __name__ == "__main__":
    main()
