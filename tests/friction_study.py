"""Which form of friction the loop finds: benches with laws, presliding and noise of their own.

    python tests/friction_study.py --runs 48 --rows out/friction.jsonl     prints the table of docs/loop.md

Laws are drawn by seed: sizes, an exponent of the Stribeck part between 1 and 3, a presliding of 30 to 1000 urad, and a
noise of the output encoder of up to two floors that no file declares. Rows that are there already are not run again.
"""

from __future__ import annotations

import argparse
import json
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np

ROOT = Path(__file__).resolve().parents[1]
sys.path[:0] = [str(ROOT / "tests" / "support"), str(ROOT)]

from bench_data import friction_run, through_files  # noqa: E402

from mbcdm_cad.layouts.loader import load_design  # noqa: E402
from mbcdm_cad.loop.search.engine import close_loop  # noqa: E402

# Sizes of each law, ranges; a share of its own for the load that drives is drawn apart.
SIZES = {
    "torque_Nm": (0.06, 0.2),
    "drag_Nm_s": (0.4, 1.2),
    "stribeck_Nm": (0.08, 0.2),
    "load_share": (0.06, 0.15),
    "driving_share": (0.1, 0.18),
    "driven_share": (0.01, 0.06),
}
LAWS: dict[str, tuple[str, ...]] = {
    "none": (),
    "constant": ("torque_Nm",),
    "viscous (M1)": ("torque_Nm", "drag_Nm_s"),
    "Stribeck": ("torque_Nm", "stribeck_Nm"),
    "Stribeck, viscous (M2)": ("torque_Nm", "drag_Nm_s", "stribeck_Nm"),
    "load alone": ("load_share",),
    "load": ("torque_Nm", "load_share"),
    "load, viscous (M3)": ("torque_Nm", "drag_Nm_s", "load_share"),
    "by the sense of power": ("torque_Nm", "driving_share", "driven_share"),
    "constant, one speed": ("torque_Nm",),
    "Stribeck, one speed": ("torque_Nm", "stribeck_Nm"),
}


def judged(name: str, seed: int) -> dict[str, Any]:
    """One run: its law, what the loop says, and whether the intervals hold the truth."""
    rng = np.random.default_rng([seed, *map(ord, name)])
    law = {key: float(rng.uniform(*SIZES[key])) for key in LAWS[name]}
    real = {key: value for key, value in law.items() if key != "load_share"}
    if "load_share" in law:
        real |= {"driving_share": law["load_share"], "driven_share": law["load_share"]}
    real |= {"fades_rad_s": float(rng.uniform(0.02, 0.06)), "exponent": float(rng.uniform(1.0, 3.0))}
    real["presliding_rad"] = float(np.exp(rng.uniform(np.log(3e-5), np.log(1e-3))))
    one_speed = "one speed" in name
    plan = {"wave": "triangle" if one_speed else "sine", "load": str(rng.choice(["steps", "bias"]))}
    drive = load_design(ROOT / "params" / "mbcdm.yaml").drive
    run = friction_run(drive, real if law else None, seed, float(rng.uniform(0.0, 1e-5)), **plan)
    start = time.process_time()
    result = close_loop(drive, [through_files(run, drive.input_names)])
    found = [one for one in result.effects if one.name == "friction"]
    figures = found[0].parameters if found else {}
    sizes = {key: value for key, value in figures.items() if key not in ("fades_rad_s", "built_up_rad")}
    others = sorted({one.name for one in result.effects if one.name != "friction"})
    others += [" | ".join(sorted(one.name for one in group)) for group in result.one_of]
    return {
        "law": name,
        "seed": seed,
        "true": law,
        "said": {key: [v.value, v.low, v.high] for key, v in sizes.items()},
        "others": others,
        "verdict": result.verdict,
        "alike": list(found[0].equivalent) if found else [],
        "cpu_s": time.process_time() - start,
    }


def table(rows: list[dict[str, Any]]) -> str:
    """Rows by law: form exact, terms missing, terms too many, another name; share of intervals that hold the truth."""
    lines = [
        "| law | runs | this form | fewer terms | other terms | another name | within 95 % | CPU s |",
        "|" + " --- |" * 8,
    ]
    for name in LAWS:
        mine = [row for row in rows if row["law"] == name]
        if not mine:
            continue
        said, true = [{*row["said"]} for row in mine], [{*row["true"]} for row in mine]
        wrong = [bool(row["others"]) for row in mine]
        exact = [s == t and not w for s, t, w in zip(said, true, wrong, strict=True)]
        fewer = [s < t and not w for s, t, w in zip(said, true, wrong, strict=True)]
        other = [not (e or f or w) for e, f, w in zip(exact, fewer, wrong, strict=True)]
        held = [
            low <= row["true"][key] <= high
            for row, good in zip(mine, exact, strict=True)
            if good
            for key, (_, low, high) in row["said"].items()
        ]
        cells = [name, len(mine), *map(sum, (exact, fewer, other, wrong)), f"{sum(held)} of {len(held)}"]
        lines.append("| " + " | ".join(map(str, [*cells, f"{np.median([row['cpu_s'] for row in mine]):.1f}"])) + " |")
    return "\n".join(lines)


def main() -> None:
    options = argparse.ArgumentParser(description=__doc__)
    options.add_argument("--runs", type=int, default=44)
    options.add_argument("--first-seed", type=int, default=100)
    options.add_argument("--rows", type=Path, default=ROOT / "out" / "friction.jsonl")
    given = options.parse_args()
    given.rows.parent.mkdir(parents=True, exist_ok=True)
    rows = [json.loads(line) for line in given.rows.read_text().splitlines()] if given.rows.exists() else []
    done = {(row["law"], row["seed"]) for row in rows}
    for k in range(given.runs):
        name, seed = list(LAWS)[k % len(LAWS)], given.first_seed + k // len(LAWS)
        if (name, seed) in done:
            continue
        rows.append(judged(name, seed))
        with given.rows.open("a") as out:
            out.write(json.dumps(rows[-1]) + "\n")
        print(name, seed, f"{rows[-1]['cpu_s']:.0f} s", *rows[-1]["said"], *rows[-1]["others"], flush=True)
    print(table(rows))


if __name__ == "__main__":
    main()
