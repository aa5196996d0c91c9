"""Files of the paper's experiments: Figs. 7, 8 and 9 from runs of the rig, result as JSON, a short text.

python -m benchmarks.studies.paper_plots [--out out/paper] [driving-capability | positioning | backlash]
"""

import argparse
import io
import json
import math
from pathlib import Path

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from benchmarks.studies.paper_experiments import (
    EXPERIMENTS,
    LOWEST_ORDER,
    Compared,
    PaperResult,
    RAMP_Nm_s,
    angle_spectrum,
    given_way_index,
    transmission_error_rad,
)
from mbcdm_cad.design.drive import Drive
from mbcdm_cad.layouts.loader import load_design
from mbcdm_cad.storage.folders import write_whole

_SIZE_IN = (8.0, 6.0)
_DASHES = ("-", "--", "-.", ":")
_FAILURES = ("first input at its limit", "an input is off by 1 mrad", "drum is off by 20 mrad")


def plot_png(result: PaperResult, drive: Drive) -> bytes:
    """The figure as PNG; the same bytes for the same result."""
    figure = Figure(figsize=_SIZE_IN, layout="constrained")
    FigureCanvasAgg(figure)
    _DRAW[result.name](figure, result, drive)
    figure.suptitle(f"{result.figure}: {result.name.replace('-', ' ')}")
    buffer = io.BytesIO()
    figure.savefig(buffer, format="png", dpi=120, metadata={"Software": None})
    return buffer.getvalue()


def _driving(figure: Figure, result: PaperResult, _drive: Drive) -> None:
    axes = figure.subplots(2, 1, sharex=True)
    for (name, run), dash in zip(result.runs.items(), _DASHES, strict=False):
        end = given_way_index(run)
        (line,) = axes[0].plot(run.time_s[:end], np.abs(run.measured_torque_Nm[:end]), dash, label=name, linewidth=0.8)
        axes[1].plot(run.time_s[:end], 1e3 * (run.reference_rad - run.drum_rad)[:end], dash, linewidth=0.8)
        for mark, what in zip("o^x", _FAILURES, strict=True):
            (at,) = (c.rig for c in result.compared if c.quantity == f"{what}: {name}")
            axes[0].plot(at / RAMP_Nm_s, at, mark, color=line.get_color(), markersize=6)
    axes[0].axhline(3.3, color="black", linestyle=":", linewidth=0.8, label="paper: 3.3 N m")
    axes[0].set_ylabel("load torque, N m")
    axes[0].set_title(
        "circle: first input at its limit; triangle: an input off by 1 mrad; cross: drum off by 20 mrad", fontsize=8
    )
    axes[0].legend(fontsize=7)
    axes[1].set_ylabel("drum's error, mrad")
    axes[1].set_xlabel("time, s")


def _positioning(figure: Figure, result: PaperResult, _drive: Drive) -> None:
    run = result.runs["positioning"]
    error = run.reference_rad - run.measured_drum_rad
    axes = figure.subplots(2, 1)
    axes[0].plot(run.time_s, 1e3 * run.reference_rad, label="reference")
    axes[0].plot(run.time_s, 1e3 * run.measured_drum_rad, "--", label="response")
    axes[0].set_ylabel("angle, mrad")
    axes[0].set_xlabel("time, s")
    axes[0].legend(loc="upper left", fontsize=7)
    right = axes[0].twinx()
    right.plot(run.time_s, 1e3 * error, color="tab:red", linewidth=0.6)
    right.set_ylabel("error, mrad")
    settled = run.time_s > 1.0 / 0.05
    order, amplitude = angle_spectrum(run.reference_rad[settled], error[settled])
    shown = (order >= LOWEST_ORDER) & (order < 1000.0)
    axes[1].plot(order[shown], 1e6 * amplitude[shown], linewidth=0.8)
    axes[1].plot(694.3, 24.67, "k+", markersize=10, label="paper: 24.67 urad at 694.3")
    axes[1].set_xlabel("cycle/rad")
    axes[1].set_ylabel("amplitude of the error, urad")
    axes[1].legend(fontsize=7)


def _backlash(figure: Figure, result: PaperResult, drive: Drive) -> None:
    run = result.runs["backlash"]
    error = 1e3 * transmission_error_rad(run, drive)
    axes = figure.subplots(2, 1)
    axes[0].plot(run.time_s, run.measured_torque_Nm, linewidth=0.8, color="tab:blue", label="load torque")
    axes[0].set_ylabel("load torque, N m")
    axes[0].set_xlabel("time, s")
    right = axes[0].twinx()
    right.plot(run.time_s, error, "--", color="tab:red", linewidth=0.8)
    right.set_ylabel("transmission error, mrad (dashed)")
    axes[1].plot(1e3 * run.measured_drum_rad, error, linewidth=0.6)
    axes[1].set_xlabel("output, mrad")
    axes[1].set_ylabel("transmission error, mrad")


_DRAW = {"driving-capability": _driving, "positioning": _positioning, "backlash": _backlash}


def result_json(result: PaperResult, drive: Drive) -> bytes:
    """All figures of the experiment; a figure that the run did not reach is null."""
    content = {
        "experiment": result.name,
        "figure": result.figure,
        "design": drive.name,
        "compared": [
            {
                "quantity": c.quantity,
                "unit": c.unit,
                "rig": None if math.isnan(c.rig) else c.rig,
                "paper": c.paper,
                "note": c.note,
            }
            for c in result.compared
        ],
        "chosen": result.chosen,
        "energy_J": {name: run.energy_J for name, run in result.runs.items()},
    }
    return (json.dumps(content, indent=1) + "\n").encode()


def result_text(result: PaperResult) -> str:
    """A table of the rig's figures with the paper's, and the chosen values that the paper does not state."""
    width = max(len(c.quantity) for c in result.compared)
    lines = [f"{result.figure} of the paper: {result.name.replace('-', ' ')}", ""]
    lines.append(f"{'':<{width}}  {'rig':>9}  {'paper':>9}")
    lines += [_line(c, width) for c in result.compared]
    chosen = ", ".join(f"{name} {value}" for name, value in result.chosen.items())
    return "\n".join([*lines, "", f"Chosen here, not in the paper: {chosen}.", ""])


def _line(c: Compared, width: int) -> str:
    rig = "never" if math.isnan(c.rig) else f"{c.rig:.4g}"
    paper = "" if c.paper is None else f"{c.paper:.4g}"
    note = f"  ({c.note})" if c.note else ""
    return f"{c.quantity:<{width}}  {rig:>9}  {paper:>9}  {c.unit}{note}"


def result_files(result: PaperResult, drive: Drive) -> dict[str, bytes]:
    """Contents by file name: ``NAME.png``, ``NAME.result.json``, ``NAME.txt``."""
    return {
        f"{result.name}.png": plot_png(result, drive),
        f"{result.name}.result.json": result_json(result, drive),
        f"{result.name}.txt": result_text(result).encode(),
    }


def main() -> None:
    """Run the experiments on the reference design, write their files, print their tables."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("name", nargs="?", choices=[*EXPERIMENTS, "all"], default="all")
    parser.add_argument("--out", type=Path, default=Path("out/paper"))
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args()
    drive = load_design(Path(__file__).parents[2] / "params" / "mbcdm.yaml").drive
    for name in EXPERIMENTS if options.name == "all" else [options.name]:
        result = EXPERIMENTS[name](drive, options.seed)
        write_whole({options.out / file: content for file, content in result_files(result, drive).items()})
        print(result_text(result))


if __name__ == "__main__":
    main()
