"""How often the run that ``mbcdm loop --next`` proposes settles a set of effects, on simulated benches.

    python -m benchmarks.studies.next_run --cases ratio_encoder,creep --first-seed 41000 --runs 20 --rows out/next.jsonl

Each case is a run of a bench of tests/support/bench_real.py. Where the loop ends in a set with the true effect in it,
it proposes the next run, the same bench makes it (the same servos, sensors and physics, other noise), and the loop
judges both together. What happened in the first run stays: a cable that slipped has slipped, a rope that settles goes
on settling. Settled rightly: the true effect is named.
"""

from dataclasses import dataclass, replace
from itertools import count, islice

import numpy as np
from scipy.ndimage import uniform_filter1d

from benchmarks.study import ROOT, Row, Study, parser
from mbcdm_cad.layouts.loader import load_design
from mbcdm_cad.loop.result import LoopResult
from mbcdm_cad.loop.search.engine import close_loop
from mbcdm_cad.measurement.run import Run
from mbcdm_cad.planning.best_run import USELESS, NextRun, next_run
from mbcdm_cad.rig.experiment import Experiment
from tests.support.bench_data import Simulated, drum_angle, stream, through_files
from tests.support.bench_effects import Effect
from tests.support.bench_motion import RATE_HZ, Bench, stray, warming_air
from tests.support.bench_real import Truth, logged, simulate_real, tracked, truth_of
from tests.support.bench_score import interval, outcome_of, said_of, same

DRIVE = load_design(ROOT / "params" / "mbcdm.yaml").drive
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


@dataclass(frozen=True)
class Proposed:
    """The first run of a bench, what the loop says of it, and the next run; None where there is no set to settle, or
    no run is proposed."""

    first: Run
    found: LoopResult
    truth: list[Row]
    following: NextRun | None
    second: Run | None


def proposed(case: str, seed: int) -> Proposed:
    """The first run and the one that the loop proposes after it."""
    truth = truth_of(DRIVE, case, seed)
    entries = [effect.as_truth() for effect in truth.effects]
    first = through_files(simulate_real(DRIVE, case, seed), DRIVE.input_names)
    found = close_loop(DRIVE, [first])
    settles = outcome_of(found.to_json(), entries) == "set"
    following = next_run(DRIVE, [first], found) if settles else None
    if following is None or not following.useful:
        return Proposed(first, found, entries, following, None)
    second = through_files(made(truth, following.experiment, case, seed), DRIVE.input_names)
    return Proposed(first, found, entries, following, second)


def judged(task: tuple[str, int]) -> Row:
    """The first run, the proposed one, and what the loop says of both."""
    one = proposed(*task)
    row: Row = {"first": said_of(one.found.to_json()), "settled": None}
    if one.following is None:
        return row
    row |= {
        "members": " or ".join(sorted(member.words for member in one.following.members)),
        "proposed": one.following.experiment.about,
        "wrong_after": one.following.wrong_after,
        "settled": False,
    }
    if one.second is None:
        return row
    members = [{"name": m.name, "stage": m.stage, "cables": m.cables} for m in one.following.members]
    asked = [entry for entry in one.truth if any(same(member, entry) for member in members)][:1]
    result = close_loop(DRIVE, [one.first, one.second]).to_json()
    settled = any(same(said, entry) for said in result["effects"] for entry in asked)
    return row | {"both": said_of(result), "outcome": outcome_of(result, one.truth), "settled": settled}


def table(rows: list[Row]) -> str:
    """Settled sets by what the proposal expected, as Markdown."""
    rows = [row for row in rows if row["settled"] is not None]
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
    return "\n".join([*lines, "", by_set(rows)])


def by_set(rows: list[Row]) -> str:
    """Settled sets by their members, as Markdown."""
    groups: dict[str, list[Row]] = {}
    for row in rows:
        groups.setdefault(row["members"], []).append(row)
    lines = ["| set | sets | a run is proposed | settled rightly |", "| --- | --- | --- | --- |"]
    for members, some in sorted(groups.items(), key=lambda pair: -len(pair[1])):
        useful = sum(r["wrong_after"] < USELESS for r in some)
        lines.append(f"| {members} | {len(some)} | {useful} | {sum(r['settled'] for r in some)} |")
    useful = sum(r["wrong_after"] < USELESS for r in rows)
    lines.append(f"| **all** | {len(rows)} | {useful} | {sum(r['settled'] for r in rows)} |")
    return "\n".join(lines)


def main() -> None:
    """Parse and do."""
    options = parser(__doc__)
    options.add_argument("--cases", default="", help="cases of tests/support/bench_real.py, separated by commas")
    given = options.parse_args()
    tasks = ((case, seed) for seed in count(given.first_seed) for case in given.cases.split(",") if case)
    Study(judged, table).run(islice(tasks, given.runs), given)


if __name__ == "__main__":
    main()
