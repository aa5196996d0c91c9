"""Rate of a search for the best designs, as ratios in one run.

    python benchmarks/optimise.py [miso_bevel] [--designs N]

Evaluates the first designs of a search with one worker and with two, and prints processor seconds too, since clock time
says little on a busy machine. Exit code 1 if two workers give different points than one.
"""

import argparse
import resource
import sys
import time
from pathlib import Path
from tempfile import TemporaryDirectory

import mbcdm_cad as mc
from mbcdm_cad.parallel.forks import allow_processes

AIMS = ["mass_g:min", "swing_mrad:min"]


def processor_s() -> tuple[float, float]:
    """Processor seconds of this process, and of workers that have ended."""
    kinds = resource.getrusage(resource.RUSAGE_SELF), resource.getrusage(resource.RUSAGE_CHILDREN)
    own, others = (kind.ru_utime + kind.ru_stime for kind in kinds)
    return own, others


def main() -> int:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("layout", nargs="?", default="miso_bevel")
    parser.add_argument("--designs", type=int, default=120)
    given = parser.parse_args()
    allow_processes()
    design = mc.new_design("drive", given.layout)
    took, spent, points = [], [], []
    with TemporaryDirectory() as folder:
        for workers in (1, 2):
            start, before = time.perf_counter(), processor_s()
            found = mc.optimise(design, AIMS, f"{folder}/{workers}", effort=mc.Effort(given.designs, workers=workers))
            took.append(time.perf_counter() - start)
            spent.append([now - then for now, then in zip(processor_s(), before, strict=True)])
            points.append((Path(folder) / str(workers) / "drive-optimum.jsonl").read_bytes())
    by_clock, by_processor = given.designs / took[0], given.designs / sum(spent[0])
    print(
        f"{given.designs} designs of {given.layout}, {found.searched.passing} pass: {by_clock:.1f} a second with one "
        f"worker, {by_processor:.1f} a second of processor time"
    )
    own, workers = spent[1]
    print(
        f"two workers over one: {took[0] / took[1]:.2f} by the clock, {sum(spent[0]) / (own + workers / 2):.2f} if each"
    )
    print(f"had a core: the search itself takes {own:.2f} s, evaluation {workers:.2f} s")
    return int(points[0] != points[1])


if __name__ == "__main__":
    sys.exit(main())
