"""Rate of a search for the best designs, as ratios in one run.

    python benchmarks/optimise.py [miso_bevel] [--designs N]

Evaluates the first designs of a search with one worker and with two. Meaningful on an idle machine only; exit code 1 if
two workers give different points than one.
"""

from __future__ import annotations

import argparse
import sys
import time
from pathlib import Path
from tempfile import TemporaryDirectory

import mbcdm_cad as mc
from mbcdm_cad.parallel.forks import allow_processes

AIMS = ["mass_g:min", "swing_mrad:min"]


def main() -> int:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("layout", nargs="?", default="miso_bevel")
    parser.add_argument("--designs", type=int, default=120)
    given = parser.parse_args()
    allow_processes()
    design = mc.new_design("drive", given.layout)
    took, points = [], []
    with TemporaryDirectory() as folder:
        for workers in (1, 2):
            start = time.perf_counter()
            found = mc.optimise(design, AIMS, f"{folder}/{workers}", effort=mc.Effort(given.designs, workers=workers))
            took.append(time.perf_counter() - start)
            points.append((Path(folder) / str(workers) / "drive-optimum.jsonl").read_bytes())
    rate = given.designs / took[0]
    print(
        f"{given.designs} designs of {given.layout}, {found.searched.passing} pass: {rate:.1f} a second with one worker"
    )
    print(f"two workers over one: {took[0] / took[1]:.2f}")
    return int(points[0] != points[1])


if __name__ == "__main__":
    sys.exit(main())
