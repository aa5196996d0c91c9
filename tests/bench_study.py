"""How often the loop is right on benches as they are: noisier than declared, servos unlike, loggers that jitter.

    python tests/bench_study.py --runs 800 --first-seed 30000 --store out/bench-study.jsonl
    python tests/bench_study.py --only null --runs 20 --first-seed 3000
    python tests/bench_study.py --runs 0 --store out/bench-study.jsonl --table docs/loop-benches.md

Runs are made by tests/support/bench_real.py. Which of them count is worked out from the truth by
tests/support/bench_separable.py. The groups take turns in the proportion of the study that is aimed at, so that a study
that was stopped is a smaller study of the same kind; runs that the store holds are not made again.
"""

from __future__ import annotations

import argparse
import json
import sys
import time
from collections.abc import Iterator
from itertools import cycle, islice
from pathlib import Path
from typing import Any

import numpy as np

ROOT = Path(__file__).resolve().parents[1]
sys.path[:0] = [str(ROOT / "tests" / "support"), str(ROOT)]

from bench_data import through_files  # noqa: E402
from bench_page import page, summary  # noqa: E402
from bench_real import DECLARED_FLOOR_RAD, REAL_CASES, simulate_real, truth_of  # noqa: E402
from bench_score import label, outcome_of, said_of, values_of  # noqa: E402
from bench_separable import separability  # noqa: E402

from mbcdm_cad.design.drive import Drive  # noqa: E402
from mbcdm_cad.layouts.loader import load_design  # noqa: E402
from tests.support.many import add_workers, run_many  # noqa: E402

DESIGN = ROOT / "params" / "mbcdm.yaml"
# Of 800 runs 200 effect-free, 300 with one effect, 150 with two, 50 with three, and 100 with a cause that has no name.
TURN = ("null", "single", "pair", "single", "null", "single", "three", "single", "null", "pair", "single", "outside")
TURN += ("null", "single", "pair", "outside")
GROUP_OF = {"texture": "null", "fair": "single"}


def judge(task: tuple[str, int]) -> dict[str, Any]:
    """Make the run, give it to the loop, compare."""
    from mbcdm_cad.loop.search.engine import close_loop

    case, seed = task
    drive = load_design(DESIGN).drive
    truth = truth_of(drive, case, seed)
    known = [effect for effect in truth.effects if effect.in_vocabulary]
    row: dict[str, Any] = {
        "case": case,
        "seed": seed,
        "group": REAL_CASES[case].group,
        "load": truth.plan.load,
        "wave": truth.plan.wave,
        "half_travel_rad": truth.plan.amplitude_rad,
        "rate_hz": truth.traits.rate_hz,
        "gaps": truth.traits.gaps,
        "noise": truth.traits.floor_rad / DECLARED_FLOOR_RAD,
        "true": " + ".join(label(effect) for effect in truth.effects) or "none",
        "true_floor": truth.traits.floor_rad,
    }
    if known and len(known) == len(truth.effects):
        told = separability(truth, drive.input_names)
        row |= {"gain": told.gain_rad, "large": told.large, "separable": told.separable}
        row |= {"rival": told.rival, "confusion": told.confusion}
    measured = through_files(simulate_real(drive, case, seed), drive.input_names)
    start = time.process_time()
    try:
        result = close_loop(drive, [measured]).to_json()
    except Exception as fault:  # a study of hundreds of runs goes on and reports the fault
        return row | {"outcome": "error", "said": f"{type(fault).__name__}: {fault}", "seconds": 0.0}
    seconds = time.process_time() - start
    error = {key: _plain(result["error"][key]) for key in ("before_rad", "after_rad", "floor_rad")}
    return row | {
        "outcome": outcome_of(result, truth.effects),
        "said": said_of(result),
        "verdict": result["verdict"],
        "before": error["before_rad"],
        "after": error["after_rad"],
        "floor": error["floor_rad"],
        "knowing": _knowing(drive, case, seed) if known else None,
        "values": values_of(result, truth.effects),
        "seconds": seconds,
    }


def _plain(figure: Any) -> float:
    return float(figure["value"] if isinstance(figure, dict) else figure)


def _knowing(drive: Drive, case: str, seed: int) -> float:
    """Held-out error that knowing the truth would leave, rad: that of the same run without the effects."""
    from mbcdm_cad.loop.prepare.prepared import prepare
    from mbcdm_cad.loop.search.fit import Fitter
    from mbcdm_cad.measurement.vet import arranged
    from mbcdm_cad.model.si import to_si

    d = to_si(drive)
    twin = simulate_real(drive, case, seed, without_effects=True)
    ratio = float(np.mean(d.total_ratio))
    fitter = Fitter(d, ratio, [prepare(arranged(through_files(twin, drive.input_names), drive), ratio)[1]])
    return float(np.sqrt(np.mean(fitter.fit().residual[fitter.test] ** 2)))


def tasks(words: list[str], first_seed: int) -> Iterator[tuple[str, int]]:
    """Cases and seeds without end: groups in turn, within a group its cases in turn, each round with the next seed."""
    groups: dict[str, list[str]] = {}
    for name, case in REAL_CASES.items():
        if not words or case.group in words or any(name.startswith(word) for word in words):
            groups.setdefault(GROUP_OF.get(case.group, case.group), []).append(name)
    endless = {group: _rounds(names, first_seed) for group, names in groups.items()}
    for group in cycle([group for group in TURN if group in groups]):
        yield next(endless[group])


def _rounds(names: list[str], first_seed: int) -> Iterator[tuple[str, int]]:
    seed = first_seed
    while True:
        yield from ((name, seed) for name in names)
        seed += 1


def main() -> None:
    """Parse and do."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--only", default="", help="cases, groups or beginnings of names, separated by commas")
    parser.add_argument("--runs", type=int, default=15, help="how many runs the study has, those in the store included")
    parser.add_argument("--first-seed", type=int, default=0)
    add_workers(parser)
    parser.add_argument("--store", type=Path, default=ROOT / "out" / "bench-study.jsonl")
    parser.add_argument("--table", type=Path, help="Markdown page to write")
    options = parser.parse_args()
    words = [word for word in options.only.split(",") if word]
    options.store.parent.mkdir(parents=True, exist_ok=True)
    rows = [json.loads(line) for line in options.store.read_text().splitlines()] if options.store.exists() else []
    done = {(r["case"], r["seed"]) for r in rows}
    wanted = [task for task in islice(tasks(words, options.first_seed), options.runs) if task not in done]
    if wanted:
        with options.store.open("a") as kept:
            for row in run_many(judge, wanted, options):
                rows.append(row)
                kept.write(json.dumps(row) + "\n")
                kept.flush()
                print(_line(row), flush=True)
    if options.table:
        command = f"python tests/bench_study.py --runs {len(rows)} --first-seed {options.first_seed}"
        before = options.table.read_text(encoding="utf-8") if options.table.exists() else ""
        options.table.write_text(page(rows, command, before), encoding="utf-8")
    print(summary(rows))


def _line(row: dict[str, Any]) -> str:
    """One run, for the terminal."""
    counts = (
        "" if "large" not in row else f"{'large' if row['large'] else 'small'} {row['confusion']:.1e} {row['rival']}"
    )
    return (
        f"{row['case']:28s} {row['seed']:5d} {row['load']:8s} {row['rate_hz']:5.0f} Hz {row['outcome']:9s} "
        f"{row['seconds']:5.1f} s floor {1e6 * row['true_floor']:5.1f} ({1e6 * row.get('floor', 0.0):5.1f}) before "
        f"{1e6 * row.get('before', 0.0):6.1f} after {1e6 * row.get('after', 0.0):6.1f} knowing "
        f"{1e6 * (row.get('knowing') or 0.0):5.1f}; {counts}; true: {row['true']}; said: {row['said']}"
    )


if __name__ == "__main__":
    main()
