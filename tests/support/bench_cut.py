"""Runs of benches cut anywhere, with wrong zeros, load cells of a wrong gain, zero and sign, and columns left out.

    python -m tests.support.bench_cut --count 300 --workers 2

Each run is one of tests/support/bench_real.py, changed by its seed. A run must end in a verdict, or in a message that
says what is wrong and where; the table lists how many ended in each, and every message.
"""

import argparse
import tempfile
from collections import Counter
from dataclasses import replace
from pathlib import Path

import numpy as np

from benchmarks.study import ROOT, add_workers, run_many
from mbcdm_cad.errors import MbcdmError
from mbcdm_cad.layouts.loader import load_design
from mbcdm_cad.loop.judge import judge
from mbcdm_cad.measurement.file import load_file
from tests.support.bench_data import Simulated, write_run
from tests.support.bench_motion import Bench
from tests.support.bench_real import REAL_CASES, simulate_real

LOADED = load_design(ROOT / "params" / "mbcdm.yaml")
# Shortest piece that is cut from a run, s.
SHORTEST_S = 2.0


def cut_run(seed: int) -> tuple[Simulated, str]:
    """A run and the text of what was changed in it."""
    rng = np.random.default_rng([seed, 77])
    case = str(rng.choice(list(REAL_CASES)))
    run = simulate_real(LOADED.drive, case, 20_000 + seed)
    time = run.bench.time_s
    length = float(np.exp(rng.uniform(np.log(SHORTEST_S), np.log(time[-1]))))
    begin = float(rng.uniform(0.0, time[-1] - length))
    kept = (time >= begin) & (time <= begin + length)
    sensed = {name: np.array(values[..., kept]) for name, values in run.sensed.items()}
    gain = float(rng.choice([1.0, 1.0, -1.0, rng.uniform(0.3, 3.0)]))
    tare = float(rng.choice([0.0, rng.uniform(-0.6, 0.6)]))
    zero, apart = float(rng.uniform(-3.0, 3.0)), float(rng.choice([0.0, rng.uniform(-3.0, 3.0)]))
    sensed["torque"] = gain * sensed["torque"] + tare
    sensed["output"] = sensed["output"] + zero
    sensed["inputs"] = sensed["inputs"] + rng.uniform(-60.0, 60.0) + apart * np.array([[0.0], [1.0]])
    columns = tuple(name for name in run.columns if name in ("inputs", "output") or rng.random() < 0.8)
    changed = replace(
        run,
        bench=Bench(time[kept], sensed["inputs"], sensed["torque"], np.zeros(0), np.zeros(0)),
        sensed=sensed,
        columns=columns,
    )
    words = f"{case}: {begin:.1f} s to {begin + length:.1f} s, torque times {gain:.2f} plus {tare:.2f} N m, "
    return changed, words + f"inputs {apart:.2f} rad apart, columns {', '.join(columns)}"


def ending(seed: int) -> tuple[str, str]:
    """The verdict, or ``message``, and the text of both run and message."""
    run, words = cut_run(seed)
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        write_run(folder, "run", run, LOADED.drive.input_names)
        try:
            return judge(LOADED, [load_file(folder / "run.yaml")]).result.verdict, words
        except MbcdmError as error:
            return "message", f"{words}: {str(error).replace(name, '')}"


def _task(seed: int) -> tuple[int, str, str]:
    try:
        return seed, *ending(seed)
    except Exception as fault:  # the count goes on and reports the fault
        return seed, "fault", f"{cut_run(seed)[1]}: {type(fault).__name__}: {fault}"


def main() -> None:
    """Parse and do."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--count", type=int, default=300)
    add_workers(parser)
    options = parser.parse_args()
    ends: Counter[str] = Counter()
    for seed, end, words in run_many(_task, range(options.count), options):
        ends[end] += 1
        if end in ("message", "fault"):
            print(f"{seed} {end}: {words}", flush=True)
    print(", ".join(f"{end} {number}" for end, number in ends.most_common()))


if __name__ == "__main__":
    main()
