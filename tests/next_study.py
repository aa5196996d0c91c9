"""How often the run that ``mbcdm loop --next`` proposes settles a set of effects, on simulated benches.

    python tests/next_study.py --cases ratio_encoder,creep --seeds 41000:41010 --store out/next-study.jsonl
    python tests/next_study.py --store out/next-study.jsonl --table docs/next-run.md

Each case is a run of a bench of tests/bench_study.py. Where the loop ends in a set with the true effect in it, it
proposes the next run, the same bench makes it (the same servos, sensors and physics, other noise), and the loop judges
both together. What happened in the first run stays: a cable that slipped has slipped, a rope that settles goes on
settling.
"""

from __future__ import annotations

import argparse
import json
import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

ROOT = Path(__file__).resolve().parents[1]
sys.path[:0] = [str(ROOT / "tests" / "support"), str(ROOT)]

from bench_data import Simulated, drum_angle, stream, through_files  # noqa: E402
from bench_effects import Effect  # noqa: E402
from bench_motion import RATE_HZ, Bench, stray, warming_air  # noqa: E402
from bench_real import Truth, logged, simulate_real, tracked, truth_of  # noqa: E402
from bench_score import interval, outcome_of, said_of, same  # noqa: E402
from scipy.ndimage import uniform_filter1d  # noqa: E402

from mbcdm_cad.layouts.loader import load_design  # noqa: E402
from mbcdm_cad.loop.search.engine import close_loop  # noqa: E402
from mbcdm_cad.planning.next_run import USELESS, next_run  # noqa: E402
from mbcdm_cad.rig.quasistatic.experiment import Experiment  # noqa: E402
from tests.support.many import add_workers, run_many  # noqa: E402

DRIVE = load_design(ROOT / "params" / "mbcdm.yaml").drive
PAGE = """# Does the proposed run settle a set?

Made by `{command}`:
{runs} runs of those cases of the [study of benches](loop-benches.md) that often end in a set. {sets} of them ended in a
set with the true effect in it. For each, `loop --next` proposed a run, the same simulated bench made it (same servos,
sensors and physics, other noise), and the loop judged both runs together. A rope that settles goes on settling in the
second run, a cable that slipped has slipped. *Settled rightly*: the true effect is named. Where the expected
probability of a wrong choice is {useless:g} or more, the command proposes no run and says what would separate the
effects.

{table}

{by_set}
"""
# Below this expected probability of a wrong choice the proposal promises to settle the set.
PROMISED = 0.05
# A load follows its command over this time, s; between the runs the bench stands for so long.
LOAD_S, PAUSE_S = 0.2, 120.0


def made(truth: Truth, experiment: Experiment, case: str, seed: int) -> Simulated:
    """The proposed run on the bench of ``truth``."""
    key = f"next/{case}"
    rng = stream(key, seed, "motion")
    time = np.arange(round(experiment.duration_s * RATE_HZ)) / RATE_HZ
    drum = experiment.motion.drum_rad(time)
    load = experiment.load.torque_Nm(time, drum, experiment.motion.period_s)
    load = uniform_filter1d(load, round(LOAD_S * RATE_HZ), mode="nearest")
    names = DRIVE.input_names
    inputs = np.array([truth.ratio * drum + stray(time, rng) for _ in names])
    bench = Bench(time, inputs, load, np.gradient(drum, time), warming_air(time, rng))
    bench = tracked(bench, truth.ratio, truth.traits, stream(key, seed, "tracking"))
    later = tuple(_later(effect, truth.bench.time_s[-1] + PAUSE_S) for effect in truth.effects)
    angle = drum_angle(truth.chain, names, bench, later, stream(key, seed, "wander"))
    run = Simulated(truth.plan, bench, angle, {}, later, truth.columns)
    return logged(run, truth.traits, truth.ratio, stream(key, seed, "sensors"))


def _later(effect: Effect, after_s: float) -> Effect:
    """The effect in a run that begins ``after_s`` after the first one began."""
    if "at_s" in effect.size:  # it has happened
        return replace(effect, size={**effect.size, "at_s": -after_s})
    if effect.kind == "settling":  # log(1 + (t + T) / t0) is log(1 + t / (t0 + T)) and a constant
        return replace(effect, size={**effect.size, "time_s": effect.size["time_s"] + after_s})
    return effect


def judged(task: tuple[str, int]) -> dict[str, Any]:
    """The first run, the proposed one, and what the loop says of both."""
    case, seed = task
    truth = truth_of(DRIVE, case, seed)
    entries = [effect.as_truth() for effect in truth.effects]
    first = through_files(simulate_real(DRIVE, case, seed), DRIVE.input_names)
    found = close_loop(DRIVE, [first])
    row: dict[str, Any] = {"case": case, "seed": seed, "first": said_of(found.to_json()), "settled": None}
    if outcome_of(found.to_json(), entries) != "set":
        return row
    following = next_run(DRIVE, [first], found)
    assert following is not None
    row |= {
        "members": " or ".join(sorted(one.words for one in following.members)),
        "proposed": following.experiment.about,
        "wrong_before": following.wrong_before,
        "wrong_after": following.wrong_after,
        "settled": False,
    }
    if not following.useful:
        return row
    second = through_files(made(truth, following.experiment, case, seed), DRIVE.input_names)
    members = [{"name": one.name, "stage": one.stage, "cables": one.cables} for one in following.members]
    asked = next((entry for entry in entries if any(same(one, entry) for one in members)), None)
    result = close_loop(DRIVE, [first, second]).to_json()
    return row | {
        "asked": None if asked is None else asked["name"],
        "both": said_of(result),
        "outcome": outcome_of(result, entries),
        "settled": asked is not None and any(same(one, asked) for one in result["effects"]),
    }


def table(rows: list[dict[str, Any]]) -> str:
    """Settled sets by what the proposal expected, as Markdown."""
    lines = [
        "| the proposal expects | sets | settled rightly | share | 95 % | wrong name or wrong set |",
        "| --- | --- | --- | --- | --- | --- |",
    ]
    tests = (
        ("a wrong choice in less than 5 %", lambda r: r["wrong_after"] < PROMISED),
        ("in 5 to 20 %", lambda r: PROMISED <= r["wrong_after"] < USELESS),
        ("all that are proposed", lambda r: r["wrong_after"] < USELESS),
    )
    for words, chosen in tests:
        some = [r for r in rows if chosen(r)]
        right = sum(r["settled"] for r in some)
        wrong = sum(r["outcome"] in ("wrong", "wrong set") for r in some)
        if some:
            low, high = interval(right, len(some))
            share = f"{right / len(some):.0%} | {low:.0%} to {high:.0%}"
            lines.append(f"| {words} | {len(some)} | {right} | {share} | {wrong} |")
    return "\n".join(lines)


def by_set(rows: list[dict[str, Any]]) -> str:
    """Settled sets by their members, as Markdown."""
    groups: dict[str, list[dict[str, Any]]] = {}
    for row in rows:
        groups.setdefault(row["members"], []).append(row)
    lines = ["| set | sets | a run is proposed | settled rightly |", "| --- | --- | --- | --- |"]
    for members, some in sorted(groups.items(), key=lambda pair: -len(pair[1])):
        useful = sum(r["wrong_after"] < USELESS for r in some)
        lines.append(f"| {members} | {len(some)} | {useful} | {sum(r['settled'] for r in some)} |")
    useful = sum(r["wrong_after"] < USELESS for r in rows)
    lines.append(f"| **all** | {len(rows)} | {useful} | {sum(r['settled'] for r in rows)} |")
    return "\n".join(lines)


def page(rows: list[dict[str, Any]]) -> str:
    """The page of docs/."""
    cases = ",".join(sorted({r["case"] for r in rows}))
    seeds = [r["seed"] for r in rows]
    sets = [r for r in rows if r["settled"] is not None]
    return PAGE.format(
        command=f"python tests/next_study.py --cases {cases} --seeds {min(seeds)}:{max(seeds) + 1}",
        runs=len(rows),
        sets=len(sets),
        useless=USELESS,
        table=table(sets),
        by_set=by_set(sets),
    )


def main() -> None:
    """Parse and do."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--cases", default="", help="cases of tests/support/bench_real.py, separated by commas")
    parser.add_argument("--seeds", default="0:0", help="first and last, as 41000:41010; the last is not made")
    parser.add_argument("--store", type=Path, default=ROOT / "out" / "next-study.jsonl")
    add_workers(parser)
    parser.add_argument("--table", type=Path, help="Markdown page to write")
    options = parser.parse_args()
    rows = [json.loads(line) for line in options.store.read_text().splitlines()] if options.store.exists() else []
    done = {(r["case"], r["seed"]) for r in rows}
    first, last = (int(word) for word in options.seeds.split(":"))
    cases = [case for case in options.cases.split(",") if case]
    wanted = [(case, seed) for seed in range(first, last) for case in cases if (case, seed) not in done]
    options.store.parent.mkdir(parents=True, exist_ok=True)
    with options.store.open("a") as kept:
        for row in run_many(judged, wanted, options):
            rows.append(row)
            kept.write(json.dumps(row) + "\n")
            kept.flush()
            print(json.dumps(row), flush=True)
    if options.table:
        options.table.write_text(page(rows), encoding="utf-8")
    print(table([r for r in rows if r["settled"] is not None]))


if __name__ == "__main__":
    main()
