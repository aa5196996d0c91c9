"""Write docs/experiments.md: the ready experiments as a table and a picture with one panel for each.

    python -m mbcdm_cad.rig.library_page params/mbcdm.yaml params/experiments docs

Writes ``experiments.md`` and ``pictures/experiments.png`` below the last folder. For each experiment it shows the
difference in transmission error to the same run without any effect, with perfect sensors.
"""

import argparse
from dataclasses import dataclass
from pathlib import Path
from typing import Any, get_args

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from mbcdm_cad.design.drive import Drive
from mbcdm_cad.layouts.loader import load_design
from mbcdm_cad.rig.bench import BenchSensors
from mbcdm_cad.rig.command import transmission_error_urad
from mbcdm_cad.rig.effects import AnyEffect
from mbcdm_cad.rig.experiment import Experiment, read_experiment
from mbcdm_cad.rig.quasistatic import set_up, simulate
from mbcdm_cad.routes import Floats

_ACROSS = 8
_OVER_TIME = {"temperature", "creep", "anchor_slip"}
_SHOWN = 1500
_HEAD = """\
# Ready experiments

This page lists the {count} experiment files for the [quasi-static rig](rig.md) in `params/experiments/`. Run one with
`mbcdm simulate params/mbcdm.yaml params/experiments/NAME.yaml`. This page is made by
`python -m mbcdm_cad.rig.library_page params/mbcdm.yaml params/experiments docs`.

A file's name begins with what it tests: `null` (no effect: the declared model), `winding` (only rope that is carried
along), the name of a single effect, `pair` and `three` (several effects), `out` (an effect that the loop has no name
for), `none` (an effect that the logged signals contain, so that nothing is left to explain).

`params/experiments/siso_spur/` has those for effects of a cable that nothing anchors on its input; run them with
`params/siso_spur.yaml`. `params/experiments/by-hand/` has tables of turning points and readings at rest
([other-runs.md](other-runs.md)).

The column "adds" is the difference in transmission error between this run and the same run without any effect, with
perfect sensors: its standard deviation and its spread (largest minus smallest), after the first eighth of the run.

![the transmission error that each experiment adds](pictures/experiments.png)

In the picture each panel shows this difference (urad) over the drum's angle (mrad), or over time (s) if the effect
acts in time. The title of a panel is the name of the file.

| experiment | description | truth | adds: std (urad) | spread (urad) |
| --- | --- | --- | --- | --- |
"""
_EFFECTS = """
## Effects
The list `effects:` of an experiment may have any number of these blocks. The docstrings of the classes in
`mbcdm_cad/rig/effects` explain the physics of each.

"""


@dataclass(frozen=True, eq=False)
class Added:
    """Change of the transmission error by an experiment, (n,) in urad, and the abscissa of its plot."""

    experiment: Experiment
    added_urad: Floats
    over: Floats
    truth: tuple[str, ...]


def added(drive: Drive, experiment: Experiment) -> Added:
    """Run an experiment with perfect sensors with and without its faults."""
    perfect = BenchSensors(
        input_at=experiment.sensors.input_at,
        input_resolution_rad=0.0,
        output_resolution_rad=0.0,
        torque_noise_Nm=0.0,
        temperature_noise_K=0.0,
    )
    faulty = experiment.model_copy(update={"sensors": perfect})
    physics = experiment.physics.model_copy(update={"cable_transport": False, "passed_slip": None})
    declared = faulty.model_copy(update={"effects": (), "physics": physics})
    bench = set_up(drive, declared)
    turns = [bench.turns(i) for i in range(len(drive.input_names))]
    run, plain = simulate(drive, faulty), simulate(drive, declared)
    difference = transmission_error_urad(run, turns) - transmission_error_urad(plain, turns)
    in_time = any(effect.effect in _OVER_TIME for effect in experiment.effects)
    over = run.time_s if in_time else run.drum_rad * 1e3
    begin = run.time_s.size // 8
    names = tuple(dict.fromkeys(str(entry["name"]) for entry in run.truth))
    return Added(experiment, difference[begin:], over[begin:], names)


def picture(all_added: list[Added], path: Path) -> None:
    """Small multiples as a PNG."""
    down = -(-len(all_added) // _ACROSS)
    figure = Figure(figsize=(2.1 * _ACROSS, 1.5 * down), layout="constrained")
    FigureCanvasAgg(figure)
    axes = figure.subplots(down, _ACROSS, squeeze=False).ravel()
    for axis, one in zip(axes, all_added, strict=False):
        every = max(1, one.over.size // _SHOWN)
        axis.plot(one.over[::every], one.added_urad[::every], lw=0.5)
        axis.set_title(one.experiment.name, fontsize=7)
        axis.tick_params(labelsize=5)
        if np.ptp(one.added_urad) < 1.0:
            axis.set_ylim(-1.0, 1.0)
    for axis in axes[len(all_added) :]:
        axis.set_axis_off()
    path.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(path, dpi=80, metadata={"Software": None})


def effects_table() -> str:
    """All effects with their fields, bounds and defaults, in Markdown."""
    lines = ["| effect | description | fields |", "| --- | --- | --- |"]
    for kind in get_args(get_args(AnyEffect)[0]):
        schema = kind.model_json_schema()["properties"]
        name = schema.pop("effect")["const"]
        fields = ", ".join(f"`{field}`{_bounds(node)}" for field, node in schema.items())
        lines.append(f"| `{name}` | {kind.__doc__.splitlines()[0]} | {fields} |")
    return "\n".join(lines)


def _bounds(node: dict[str, Any]) -> str:
    """Bounds, words and default of a field, in brackets."""
    low = node.get("minimum", node.get("exclusiveMinimum"))
    high = node.get("maximum", node.get("exclusiveMaximum"))
    words = [f"{low:g} to {high:g}"] if low is not None and high is not None else []
    words += [" or ".join(node["enum"])] if "enum" in node else []
    default = node.get("default")
    if default is not None:
        words.append("default all" if default in ([], ()) else f"default {default}")
    return f" ({'; '.join(words)})" if words else ""


def page(all_added: list[Added]) -> str:
    """The page's text."""
    lines = [
        f"| `{one.experiment.name}` | {one.experiment.about} | {', '.join(one.truth) or '-'} | "
        f"{np.std(one.added_urad):.1f} | {np.ptp(one.added_urad):.0f} |"
        for one in all_added
    ]
    return _HEAD.format(count=len(all_added)) + "\n".join(lines) + "\n" + _EFFECTS + effects_table() + "\n"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("design", type=Path)
    parser.add_argument("experiments", type=Path)
    parser.add_argument("docs", type=Path)
    arguments = parser.parse_args()
    drive = load_design(arguments.design).drive
    read = [read_experiment(path) for path in sorted(arguments.experiments.glob("*.yaml"))]
    all_added = [added(drive, experiment) for experiment in read if isinstance(experiment, Experiment)]
    picture(all_added, arguments.docs / "pictures" / "experiments.png")
    (arguments.docs / "experiments.md").write_text(page(all_added), "utf-8")


if __name__ == "__main__":
    main()
