"""How often the loop names the right effect: simulated runs of many cases and seeds, and the loop's findings.

    python tests/confusion.py --seeds 20 --workers 2 --table docs/loop-confusion.md     the whole study
    python tests/confusion.py --only null,pulley_guide --seeds 5                     a few cases
    python tests/confusion.py --make DIR --case NAME --seed N     write one run (CSV, measurement file, truth) and stop
    python tests/confusion.py --list                              names of the cases

Judged runs are kept in --store (out/confusion.jsonl) with the state of the code, so that an interrupted study
continues; --fresh deletes them. For each case the first --twins seeds are run again without the effect: their held-out
error is the one that remains with a perfect model. The first seed of every eighth case also runs through the command
line.
"""

from __future__ import annotations

import argparse
import hashlib
import json
import subprocess
import sys
import tempfile
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
sys.path[:0] = [str(ROOT / "tests" / "support"), str(ROOT)]

from bench_data import CASES, simulate_case, write_case, write_run  # noqa: E402
from bench_score import Score, label, outcome_of, said_of, values_of  # noqa: E402
from bench_tables import aims_table, matrix, outcome_table, value_table  # noqa: E402

from mbcdm_cad.layouts.loader import load_design  # noqa: E402
from tests.support.many import add_workers, run_many  # noqa: E402

DESIGN = ROOT / "params" / "mbcdm.yaml"
STORE = ROOT / "out" / "confusion.jsonl"
COMMAND_LINE_EVERY = 8


def judge(case: str, seed: int, twin: bool = False, command_line: bool = False) -> Score:
    """Make the run, give it to the loop, compare."""
    from mbcdm_cad.loop.search.engine import close_loop
    from mbcdm_cad.measurement.reading import load_measurement

    drive = load_design(DESIGN).drive
    run = simulate_case(drive, case, seed)
    true = " + ".join(label(effect) for effect in run.effects) or "none"
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        write_run(folder, "run", run, drive.input_names)
        start = time.perf_counter()
        try:
            result = close_loop(drive, [load_measurement(folder / "run.yaml")]).to_json()
        except Exception as fault:  # a study of a thousand runs goes on and reports the fault
            return Score(case, seed, CASES[case].group, "error", "error", true, note=f"{type(fault).__name__}: {fault}")
        seconds = time.perf_counter() - start
        outcome = outcome_of(result, run.effects)
        error = result["error"]
        score = Score(case, seed, CASES[case].group, outcome, said_of(result), true, seconds=seconds)
        score.before_rad, score.after_rad, score.floor_rad = (
            _plain(error.get(key)) for key in ("before_rad", "after_rad", "floor_rad")
        )
        score.values = values_of(result, run.effects)
        if command_line:
            score.note = _command_line(folder, result)
        if twin and run.effects:
            write_run(folder, "twin", simulate_case(drive, case, seed, without_effects=True), drive.input_names)
            without = close_loop(drive, [load_measurement(folder / "twin.yaml")]).to_json()
            score.knowing_rad = _plain(without["error"]["before_rad"])
    return score


def _plain(figure: object) -> float | None:
    if isinstance(figure, dict):
        figure = figure.get("value")
    return float(figure) if isinstance(figure, int | float) else None


def _command_line(folder: Path, expected: dict[str, object]) -> str:
    """Run `mbcdm loop` on the same files; a word if it says something else."""
    target = folder / "result.json"
    command = [sys.executable, "-m", "mbcdm_cad", "loop", str(DESIGN), str(folder / "run.yaml"), "--json", str(target)]
    done = subprocess.run(command, capture_output=True, text=True, cwd=folder, check=False)
    if done.returncode != 0:
        return f"command line: exit {done.returncode}: {done.stderr.strip()[-200:]}"
    said = said_of(json.loads(target.read_text()))
    return "" if said == said_of(expected) else f"command line said {said}"


def _task(task: tuple[str, int, bool, bool]) -> Score:
    return judge(*task)


def state_of_code() -> str:
    """Digest of what the figures depend on."""
    files = [
        p
        for room in ("measurement", "loop", "planning", "model", "design")
        for p in sorted((ROOT / "mbcdm_cad" / room).rglob("*.py"))
    ]
    files += sorted((ROOT / "tests" / "support").glob("bench_*.py"))
    digest = hashlib.sha256()
    for path in files:
        digest.update(path.read_bytes())
    return digest.hexdigest()[:16]


def study(cases: list[str], options: argparse.Namespace) -> list[Score]:
    """Judge every case and seed that the store does not hold yet; all scores, in order of case and seed.

    ``judged_only`` judges none and gives those of a study that was stopped.
    """
    code = state_of_code()
    options.store.parent.mkdir(parents=True, exist_ok=True)
    done: dict[tuple[str, int], Score] = {}
    if options.store.exists() and not options.fresh:
        for line in options.store.read_text().splitlines():
            kept = json.loads(line)
            if kept.pop("code") == code:
                done[kept["case"], kept["seed"]] = Score(**kept)
    wanted = [(case, seed) for case in cases for seed in range(options.seeds)]
    tasks = (
        []
        if options.judged_only
        else [
            (c, s, s < options.twins, s == 0 and k % COMMAND_LINE_EVERY == 0)
            for s in range(options.seeds)
            for k, c in enumerate(cases)
            if (c, s) not in done
        ]
    )
    with options.store.open("w" if options.fresh else "a") as kept_file:
        for score in run_many(_task, tasks, options):
            done[score.case, score.seed] = score
            kept_file.write(json.dumps({"code": code, **score.as_dict()}) + "\n")
            kept_file.flush()
            if not options.quiet:
                print(
                    f"{score.case:20s} {score.seed:3d} {score.outcome:12s} {score.seconds:5.1f} s  true: {score.true}; "
                    f"said: {score.said} {score.note}",
                    flush=True,
                )
    return [done[key] for key in wanted if key in done]


def document(scores: list[Score], command: str) -> str:
    """The page of the docs."""
    errors = sorted({f"- {s.case} seed {s.seed}: {s.note}" for s in scores if s.note})
    parts = [
        "# How often the loop names the right effect",
        f"Made by `{command}`: {len(scores)} runs, seeds fixed.",
        "The runs are simulated without the project's model (tests/support/bench_chain.py: each cable is a chain of "
        "short pieces under Coulomb friction), with sensors as on the bench. Sizes and phases come from the seed. "
        "Motions: +-50 mrad, +-0.45 and +-0.6 rad, triangle or sine, 0.05 to 0.1 Hz, 160 s at 100 Hz. Loads: a brake; "
        "a brake at several levels; a brake with a bias; torque steps independent of the motion; none.",
        "## Comparison with the aims",
        aims_table(scores),
        "## By case",
        "exact: all effects are named, and nothing else. set: each effect that is not named is a member of a set. "
        "partial: the names are right, but an effect is missing. wrong: a named effect is not present. wrong set: no "
        "member of a set is present. For runs without an effect `none` is right. For causes outside the loop's library "
        "of effects `unknown` is right, and `wrong` means that an effect of the library was named instead. Error after "
        "/ knowing: held-out error of the result over that of the same run without the effect.",
        outcome_table(scores),
        "## Findings",
        matrix(scores),
        "## Sizes found",
        value_table(scores),
    ]
    if errors:
        parts += ["## Remarks", "\n".join(errors[:40])]
    return "\n\n".join(parts) + "\n"


def main() -> None:
    """Parse and do."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--make", type=Path, metavar="DIR")
    parser.add_argument("--case", default="null", choices=sorted(CASES))
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--list", action="store_true")
    parser.add_argument("--only", default="", help="cases or groups, separated by commas")
    parser.add_argument("--seeds", type=int, default=5)
    parser.add_argument("--twins", type=int, default=3)
    add_workers(parser)
    parser.add_argument("--store", type=Path, default=STORE)
    parser.add_argument("--fresh", action="store_true")
    parser.add_argument("--judged-only", action="store_true", help="tables of what a study that was stopped has judged")
    parser.add_argument("--quiet", action="store_true")
    parser.add_argument("--table", type=Path, metavar="FILE.md")
    options = parser.parse_args()
    if options.list:
        print("\n".join(CASES))
        return
    if options.make:
        print(write_case(options.make, options.case, options.seed, load_design(DESIGN).drive))
        return
    asked = [word for word in options.only.split(",") if word]
    cases = [name for name, case in CASES.items() if not asked or name in asked or case.group in asked]
    scores = study(cases, options)
    only = f" --only {options.only}" if options.only else ""
    text = document(scores, f"python tests/confusion.py{only} --seeds {options.seeds} --twins {options.twins}")
    if options.table:
        options.table.write_text(text)
    print(text)


if __name__ == "__main__":
    main()
