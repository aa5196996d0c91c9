"""Which form of friction the loop finds: benches with laws, presliding and noise of their own.

    python -m benchmarks.studies.friction --runs 48 --first-seed 100 --rows out/friction.jsonl

Laws are drawn by seed: sizes, an exponent of the Stribeck part between 1 and 3, a presliding of 30 to 1000 urad, and a
noise of the output encoder of up to two floors that no file declares. Rows that are there already are not run again.
"""

import time

import numpy as np

from benchmarks.study import ROOT, Row, Study, parser
from mbcdm_cad.layouts.loader import load_design
from mbcdm_cad.loop.search.engine import close_loop
from tests.support.bench_data import friction_run, through_files

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


def judged(task: tuple[str, int]) -> Row:
    """One run: its law, what the loop says, and whether the intervals hold the truth."""
    name, seed = task
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
        "true": law,
        "said": {key: [v.value, v.low, v.high] for key, v in sizes.items()},
        "others": others,
        "verdict": result.verdict,
        "alike": list(found[0].equivalent) if found else [],
        "cpu_s": time.process_time() - start,
    }


def table(rows: list[Row]) -> str:
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
    """Parse and do."""
    given = parser(__doc__, runs=44).parse_args()
    tasks = [(name, seed) for seed in range(given.first_seed, given.first_seed + given.runs) for name in LAWS]
    Study(judged, table).run(tasks[: given.runs], given)


if __name__ == "__main__":
    main()
