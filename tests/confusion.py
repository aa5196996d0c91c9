"""How often the loop says what is true: simulated runs of many cases and seeds, and what the loop makes of them.

python tests/confusion.py --make DIR --case NAME --seed N     write one run (CSV, measurement file, truth) and stop
python tests/confusion.py --list                              names of the cases
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT / "tests" / "support"))

from bench_data import CASES, write_case  # noqa: E402

from mbcdm_cad.design import load_design  # noqa: E402

DESIGN = ROOT / "params" / "mbcdm.yaml"


def main() -> None:
    """Parse and do."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--make", type=Path, metavar="DIR")
    parser.add_argument("--case", default="null", choices=sorted(CASES))
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--list", action="store_true")
    options = parser.parse_args()
    if options.list:
        print("\n".join(CASES))
    if options.make:
        print(write_case(options.make, options.case, options.seed, load_design(DESIGN).drive))


if __name__ == "__main__":
    main()
