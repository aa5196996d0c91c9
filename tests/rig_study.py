"""Findings of the loop on every experiment of the rig's library, compared with the truth, which the loop never reads.

    python tests/rig_study.py --workers 2 --table docs/loop-on-rig.md      all experiments of params/experiments
    python tests/rig_study.py --only null-long-brake,out-wear           a few

The rig shares no code with the model that the loop uses. ``--noise N`` runs each N times with different noise.
``--store`` keeps the judged runs, so that an interrupted study continues.

A result is right if it names every effect, alone or in a set, or if it names none and the run contains none that can be
seen (``seen: false`` in the truth). An effect that changes the reading by less than ``LEAST`` of the sensors' floor
must not be named; the table marks it.
"""

from __future__ import annotations

import argparse
import json
import sys
import tempfile
import time
from collections import Counter
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from mbcdm_cad.design.drive import Drive
    from mbcdm_cad.rig.quasistatic.experiment import Experiment

ROOT = Path(__file__).resolve().parents[1]
sys.path[:0] = [str(ROOT / "tests" / "support"), str(ROOT)]

from bench_effects import Effect  # noqa: E402
from bench_score import label, outcome_of, said_of  # noqa: E402

from tests.support.many import add_workers, run_many  # noqa: E402

DESIGN = ROOT / "params" / "mbcdm.yaml"
LIBRARY = ROOT / "params" / "experiments"
# RMS over the floor from which an effect is to be named: the loop's own rule (loop/search/select.py).
LEAST = 0.45


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

    from mbcdm_cad.layouts.loader import load_design
    from mbcdm_cad.loop.search.engine import close_loop
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
    simulated = simulate(drive, experiment)
    with tempfile.TemporaryDirectory() as folder:
        target = Path(folder) / name
        write_run(target, run_files(simulated, experiment, drive.input_names))
        truth = yaml.safe_load((target / f"{name}.truth.yaml").read_text())["effects"]
        run = load_measurement(target / f"{name}.yaml")
    start = time.perf_counter()
    result = close_loop(drive, [run]).to_json()
    seconds = time.perf_counter() - start
    true = _label(truth, cables)
    outcome, right = _judged(result, truth, cables)
    small = [] if right else _too_small(drive, experiment, simulated.measured_output_rad, result["noise"])
    if small:
        outcome, right = _judged(result, [entry for entry in truth if entry not in small], cables)
        true += f" (too small to be named: {_label(small, cables)})"
    before, after = (float(result["error"][key]) for key in ("before_rad", "after_rad"))
    return Row(name, noise, true, said_of(result), outcome, right, before, after, seconds)


def _judged(result: dict[str, Any], truth: list[dict[str, Any]], cables: tuple[str, ...]) -> tuple[str, bool]:
    """The outcome, and whether it is right."""
    seen = [entry for entry in truth if entry.get("seen", True)]
    effects = tuple(_effect(entry, cables) for entry in seen if entry["in_vocabulary"])
    outcome = outcome_of(result, effects)
    if len(effects) < len(seen):
        return outcome, outcome in ("unknown", "exact", "set") and result["unknown"] is not None
    return outcome, outcome in (("exact", "set") if effects else ("none", "not_testable"))


def _label(truth: list[dict[str, Any]], cables: tuple[str, ...]) -> str:
    """The true causes in one line."""
    words = [
        label(_effect(entry, cables)) if entry["in_vocabulary"] else str(entry["name"])
        for entry in sorted(truth, key=lambda entry: not entry["in_vocabulary"])
    ]
    return " + ".join(words) or "none"


def _too_small(
    drive: Drive, experiment: Experiment, reading_rad: np.ndarray, noise: dict[str, float]
) -> list[dict[str, Any]]:
    """Entries of the truth that are below ``LEAST``: by the same run, with the same noise, without the effect."""
    from mbcdm_cad.rig.quasistatic.simulate import simulate

    truth, small = simulate(drive, experiment).truth, []
    for left_out in experiment.effects:
        rest = [effect for effect in experiment.effects if effect is not left_out]
        less = simulate(drive, experiment.model_copy(update={"effects": rest}))
        if float(np.std(reading_rad - less.measured_output_rad)) < LEAST * noise["declared_rad"]:
            small += [entry for entry in truth if entry not in less.truth]
    return small


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
        "# Findings of the loop on the experiments of the rig",
        "",
        f"Made by `{command}`: {len(rows)} runs, of which {right} are right: no name in a run without an",
        "effect; the effect named, or in a set, if the library has it; something unknown if not. Each run is simulated",
        "by the rig ([rig.md](rig.md)), which shares no code with the model. The effects of a run are stated only in",
        "the truth file, which the loop does not read.",
        "",
        "Outcomes: " + ", ".join(f"{kind} {number}" for kind, number in kinds.most_common()) + ".",
        "",
        "| experiment | true | finding | right | held-out error before (urad) | after | s |",
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
    add_workers(parser)
    parser.add_argument("--first-noise", type=int, default=0, help="number of the first noise; 0 is that of the files")
    parser.add_argument("--store", type=Path, help="JSON lines of what was judged")
    parser.add_argument("--table", type=Path, help="Markdown file to write")
    options = parser.parse_args()
    names = options.only.split(",") if options.only else sorted(path.stem for path in LIBRARY.glob("*.yaml"))
    stored = options.store.read_text().splitlines() if options.store and options.store.exists() else []
    rows = [Row(**json.loads(line)) for line in stored]
    done = {(row.experiment, row.noise) for row in rows}
    noises = range(options.first_noise, options.first_noise + options.noise)
    tasks = [(name, noise) for noise in noises for name in names if (name, noise) not in done]
    for row in run_many(judge, tasks, options):
        rows.append(row)
        if options.store:
            with options.store.open("a") as kept:
                kept.write(json.dumps(asdict(row)) + "\n")
        print(f"{'ok ' if row.right else 'NO '} {row.experiment:32s} true: {row.true}; said: {row.said}", flush=True)
    print(f"{sum(row.right for row in rows)} of {len(rows)} right")
    if options.table:
        command = "python tests/rig_study.py" + (f" --noise {options.noise}" if options.noise > 1 else "")
        options.table.write_text(page(rows, command), encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
