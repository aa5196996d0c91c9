"""What the loop says of every experiment of the rig's library, judged by the truth, which the loop is not told.

    python tests/rig_study.py --jobs 2 --table docs/loop-on-rig.md      all experiments of params/experiments
    python tests/rig_study.py --only null-long-brake,out-wear           a few

The rig shares no code with the model that the loop uses. ``--noise N`` runs each N times with other noise.
"""

from __future__ import annotations

import argparse
import multiprocessing
import sys
import tempfile
import time
from collections import Counter
from dataclasses import dataclass
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT / "tests" / "support"))

from bench_effects import Effect  # noqa: E402
from bench_score import label, outcome_of, said_of  # noqa: E402

DESIGN = ROOT / "params" / "mbcdm.yaml"
LIBRARY = ROOT / "params" / "experiments"


@dataclass(frozen=True)
class Row:
    """One experiment judged: true causes, what was said, errors in rad, and whether that is right."""

    experiment: str
    noise: int
    true: str
    said: str
    outcome: str
    right: bool
    before_rad: float
    after_rad: float
    seconds: float


def judge(task: tuple[str, int]) -> Row:
    """Simulate one experiment, give it to the loop, compare with the truth."""
    import yaml

    from mbcdm_cad.configurations.loader import load_design
    from mbcdm_cad.identification.engine import close_loop
    from mbcdm_cad.measurement.reading import load_measurement
    from mbcdm_cad.model.si import to_si
    from mbcdm_cad.rig.quasistatic.experiment import Experiment
    from mbcdm_cad.rig.quasistatic.simulate import simulate
    from mbcdm_cad.rig.reading import read_experiment
    from mbcdm_cad.rig.writing import run_files, write_run

    name, noise = task
    drive = load_design(DESIGN).drive
    cables = to_si(drive).cable_names
    experiment = read_experiment(LIBRARY / f"{name}.yaml")
    assert isinstance(experiment, Experiment), "the library holds quasi-static experiments"
    experiment = experiment.model_copy(update={"seed": experiment.seed + 1000 * noise})
    with tempfile.TemporaryDirectory() as folder:
        target = Path(folder) / name
        write_run(target, run_files(simulate(drive, experiment), experiment, drive.input_names))
        truth = yaml.safe_load((target / f"{name}.truth.yaml").read_text())["effects"]
        start = time.perf_counter()
        result = close_loop(drive, [load_measurement(target / f"{name}.yaml")]).to_json()
        seconds = time.perf_counter() - start
    effects = tuple(_effect(entry, cables) for entry in truth if entry.get("in_vocabulary", True))
    outside = [str(entry["name"]) for entry in truth if not entry.get("in_vocabulary", True)]
    outcome = outcome_of(result, effects)
    if outside:
        right = outcome in ("unknown", "exact", "set") and result["unknown"] is not None
    elif effects:
        right = outcome in ("exact", "set")
    else:
        right = outcome == "none"
    true = " + ".join([label(effect) for effect in effects] + outside) or "none"
    before, after = (float(result["error"][key]) for key in ("before_rad", "after_rad"))
    return Row(name, noise, true, said_of(result), outcome, right, before, after, seconds)


def _effect(entry: dict[str, Any], cables: tuple[str, ...]) -> Effect:
    """An entry of a truth file as the study of the other runs has it."""
    touched = tuple(cables.index(one) for one in entry.get("cables", ()))
    if entry["name"] == "preload_error" and not touched:
        touched = tuple(range(len(cables)))
    return Effect(entry["name"], str(entry.get("cause", "")), {}, entry.get("stage"), touched)


def page(rows: list[Row], command: str) -> str:
    """The table as a page."""
    right = sum(row.right for row in rows)
    kinds = Counter(row.outcome for row in rows)
    lines = [
        "# What the loop says of the rig's library",
        "",
        f"Made by `{command}`: {len(rows)} runs, of which {right} are right: none where nothing was put in; the",
        "name of the effect, or a set that holds it, where the vocabulary has it; something unknown where it has not.",
        "Each run is simulated by the rig ([rig.md](rig.md)), which shares no code with the model; its effects stand",
        "in the truth file alone, which the loop does not read.",
        "",
        "Outcomes: " + ", ".join(f"{kind} {number}" for kind, number in kinds.most_common()) + ".",
        "",
        "| experiment | true | said | right | held-out error before (urad) | after | s |",
        "| --- | --- | --- | --- | --- | --- | --- |",
    ]
    for row in rows:
        name = row.experiment + (f" ({row.noise})" if row.noise else "")
        said = row.said.replace("|", "or")
        lines.append(
            f"| {name} | {row.true} | {said} | {'yes' if row.right else '**no**'} | {1e6 * row.before_rad:.1f} | "
            f"{1e6 * row.after_rad:.1f} | {row.seconds:.1f} |"
        )
    return "\n".join([*lines, ""])


def main() -> int:
    """Command line; exit code 0 whatever is found."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--only", help="names of experiments, with commas")
    parser.add_argument("--noise", type=int, default=1, help="runs of each, with other noise")
    parser.add_argument("--jobs", type=int, default=1, help="processes")
    parser.add_argument("--table", type=Path, help="Markdown file to write")
    options = parser.parse_args()
    names = options.only.split(",") if options.only else sorted(path.stem for path in LIBRARY.glob("*.yaml"))
    tasks = [(name, noise) for name in names for noise in range(options.noise)]
    rows = []
    with multiprocessing.get_context("spawn").Pool(options.jobs) as pool:
        for row in pool.imap(judge, tasks):
            rows.append(row)
            print(
                f"{'ok ' if row.right else 'NO '} {row.experiment:32s} true: {row.true}; said: {row.said}", flush=True
            )
    print(f"{sum(row.right for row in rows)} of {len(rows)} right")
    if options.table:
        command = "python tests/rig_study.py" + (f" --noise {options.noise}" if options.noise > 1 else "")
        options.table.write_text(page(rows, command), encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
