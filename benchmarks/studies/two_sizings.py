"""Closed rules of miso_bevel beside its trial rules, over the files of params and over random short files.

    python -m benchmarks.studies.two_sizings closed closed.json --seeds 40
    python -m benchmarks.studies.two_sizings trial trial.json --seeds 40 --only telescope

Each file is sized and checked; printed and written are the checks that fail with what they miss over their limits, the
CPU time, the turn of payload by cables and structure (urad per N m), and the mass without drawings (g).
"""

from __future__ import annotations

import argparse
import json
import time
from pathlib import Path
from typing import Any

import yaml

from mbcdm_cad.checks.size import kept_mass_g
from mbcdm_cad.design.loaded import LoadedDesign
from mbcdm_cad.errors import InputError
from mbcdm_cad.layouts.base import NoFigureError
from mbcdm_cad.layouts.loader import load_text
from mbcdm_cad.layouts.miso_bevel.design_file import DESIGN_FILE
from mbcdm_cad.layouts.stiff_sizing import misses
from tests.support.random_generator import WHOLE, requirements

TRIAL = "mbcdm_cad.layouts.miso_bevel.trial"


def files(seeds: int) -> dict[str, str]:
    """Text of each file by its name."""
    found = {str(path): path.read_text("utf-8") for path in sorted(Path("params").rglob("*.yaml"))}
    plain = {name: yaml.safe_load(text) for name, text in found.items()}
    named = [n for n, d in plain.items() if isinstance(d, dict) and d.get("configuration") == "miso_bevel"]
    drawn = {f"seed {seed}": yaml.safe_dump(requirements(seed, WHOLE)) for seed in range(1, seeds + 1)}
    return {name: found[name] for name in named if "transmission" in plain[name]} | drawn


def figures(loaded: LoadedDesign) -> dict[str, Any]:
    """What is compared."""
    layout = loaded.drive.layout
    found: dict[str, Any] = {"fails": {name: round(missed, 3) for name, missed in misses(layout).items()}}
    try:
        structure = layout.structure
        assert structure is not None
        found["urad_Nm"] = round(structure.cables_urad_Nm + structure.payload_urad_Nm, 1)
        found["mass_g"] = round(kept_mass_g(layout), 1)
    except (NoFigureError, ValueError):
        pass
    return found


def main() -> None:
    """The command."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("rules", choices=("closed", "trial"))
    parser.add_argument("out", type=Path)
    parser.add_argument("--seeds", type=int, default=0)
    parser.add_argument("--only", default="", help="files whose names contain this")
    args = parser.parse_args()
    if args.rules == "trial":
        assert DESIGN_FILE.sizing is not None
        DESIGN_FILE.sizing.module = TRIAL
    found = {}
    for name, text in files(args.seeds).items():
        if args.only not in name:
            continue
        start = time.process_time()
        try:
            loaded = load_text(text, name)
        except InputError as error:
            found[name] = {"fails": {"refused": str(error.problems[0])}}
        else:
            if not loaded.sized:
                continue
            cpu_s = time.process_time() - start
            found[name] = {**figures(loaded), "cpu_s": round(cpu_s, 2)}
        print(name, found[name], flush=True)
        args.out.write_text(json.dumps(found, indent=1))
    print(f"{sum(not one['fails'] for one in found.values())} of {len(found)} pass")


if __name__ == "__main__":
    main()
