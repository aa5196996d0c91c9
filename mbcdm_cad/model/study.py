"""The files of ``mbcdm sensitivity``: Fig. 5 as plots and CSV, global indices, tolerance stack, intervals, summary.

Plots for print: units on every axis; lines differ by colour, dash and marker, bars by hatch, so that they can be
distinguished in grey and by colour-blind readers.

Figures are drawn without a display and written as SVG or PNG, by the suffix; the same data gives the same bytes.
"""

import csv
import json
from collections.abc import Sequence
from dataclasses import asdict
from itertools import pairwise
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from mbcdm_cad.model.capability import Modelled, requirements, sigmas_si
from mbcdm_cad.model.hysteresis import simulate
from mbcdm_cad.model.sensitivity import GlobalIndices, Panel, elasticities, figure_5, global_indices, intervals
from mbcdm_cad.model.si import DriveSI
from mbcdm_cad.model.tolerance import DRAWS, StackUp, Tolerances, ToleranceStack, stack_data, tolerance_stack
from mbcdm_cad.parallel.forks import Crew
from mbcdm_cad.storage.cache import with_floats

# Okabe and Ito's palette without its yellow, which is hardly visible on paper.
COLOURS = ("#000000", "#0072B2", "#D55E00", "#009E73", "#CC79A7", "#56B4E9")
DASHES: tuple[Any, ...] = ("-", (0, (5, 2)), (0, (1, 1.5)), (0, (6, 2, 1, 2)), (0, (3, 1, 1, 1, 1, 1)), (0, (8, 3)))
HATCHES = ("////", "\\\\\\\\", "....", "xxxx")
MARKERS = ("o", "s", "^", "D", "v", "x")
FIXED: dict[Any, Any] = {
    "svg.hashsalt": "mbcdm",
    "svg.fonttype": "none",
    "font.size": 9.0,
    "axes.grid": True,
    "grid.alpha": 0.3,
}


def _style(k: int) -> dict[str, Any]:
    n = len(COLOURS)
    return {"color": COLOURS[k % n], "linestyle": DASHES[k % n], "marker": MARKERS[k % n], "markersize": 3.5}


def _canvas(width_in: float, height_in: float, columns: int = 1) -> tuple[Figure, Any]:
    figure = Figure(figsize=(width_in, height_in), layout="constrained")
    FigureCanvasAgg(figure)
    return figure, figure.subplots(ncols=columns)


def _save(figure: Figure, path: Path) -> None:
    # By default matplotlib writes the date and its version into the file, so equal plots would differ.
    metadata = {"Date": None, "Creator": None} if path.suffix == ".svg" else {"Software": None}
    figure.savefig(path, dpi=150, metadata=metadata)


def plot_panel(panel: Panel, path: Path) -> None:
    """One panel of Fig. 5: backlash over preload."""
    with mpl.rc_context(FIXED):
        figure, axes = _canvas(4.5, 3.4)
        unit = "" if panel.unit == "-" else f" {panel.unit}"
        for k, (value, line) in enumerate(zip(panel.value, panel.backlash_rad, strict=True)):
            axes.plot(panel.preload_N, line * 1e3, label=f"{value:g}{unit}", markevery=5, **_style(k))
        axes.set(xlabel="preload (N)", ylabel="backlash (mrad)", title=f"({panel.letter}) {panel.parameter}")
        axes.set_ylim(bottom=0.0)
        axes.legend(title=panel.parameter, fontsize="small")
        _save(figure, path)


def plot_indices(indices: GlobalIndices, path: Path) -> None:
    """Total Sobol' indices of every figure, bars with the first-order share hatched."""
    with mpl.rc_context(FIXED):
        figure, axes = _canvas(6.5, 3.6)
        place, width = np.arange(len(indices.parameter)), 0.8 / len(indices.total)
        for k, (name, total) in enumerate(indices.total.items()):
            at = place + (k - (len(indices.total) - 1) / 2) * width
            label = name.removesuffix("_rad").removesuffix("_Nm").replace("_", " ")
            axes.bar(at, total, width, color=COLOURS[k], alpha=0.35)
            alone = {"hatch": HATCHES[k], "edgecolor": COLOURS[k], "linewidth": 0.6, "fill": False}
            axes.bar(at, indices.first[name], width, label=label, **alone)
        axes.set_xticks(place, [name.rsplit("_", 1)[0].replace("_", " ") for name in indices.parameter], rotation=20)
        axes.set(
            xlabel="parameter (-)", ylabel="share of variance (-)", title="hatched: alone; whole bar: with interactions"
        )
        axes.legend(fontsize="small")
        _save(figure, path)


def plot_tolerance(stack: ToleranceStack, path: Path) -> None:
    """Standard deviation of the transmission error over the travel, and what each source adds alone."""
    with mpl.rc_context(FIXED):
        figure, (over, parts) = _canvas(8.0, 3.8, columns=2)
        pose = np.degrees(stack.pose_rad)
        over.plot(pose, stack.linear_rad * 1e6, label="linear theory", markevery=12, **_style(0))
        over.plot(pose, stack.monte_carlo_rad * 1e6, label="Monte Carlo with friction", markevery=12, **_style(2))
        over.set(xlabel="drum angle (deg)", ylabel="standard deviation (urad)", title="zeroed at the centre")
        over.legend(fontsize="small")
        order = np.argsort(stack.contribution_rad)
        order = order[stack.contribution_rad[order] > 0.0]
        parts.barh([stack.contributor[k] for k in order], stack.contribution_rad[order] * 1e6, color=COLOURS[1])
        parts.set(xlabel="RMS over the travel (urad)", ylabel="source, one standard deviation (-)")
        parts.tick_params(axis="y", labelsize=6)
        _save(figure, path)


def plot_loop(d: DriveSI, load_Nm: float, path: Path) -> None:
    """Drum angle over load with the inputs locked: first loading, the full loop and a minor loop in it."""
    with mpl.rc_context(FIXED):
        figure, axes = _canvas(4.5, 3.6)
        turns = np.array([0.0, 1.0, -1.0, 1.0, -0.2, 0.4, -0.2, 1.0]) * load_Nm
        load = np.concatenate([np.linspace(a, b, 60)[1:] for a, b in pairwise(turns)])
        drum = simulate(d, np.zeros((d.n_inputs, load.size)), load).drum_angle_rad
        parts = {"first loading": slice(0, 59), "loop": slice(58, 177), "minor loop": slice(176, None)}
        for k, (label, part) in enumerate(parts.items()):
            axes.plot(load[part], drum[part] * 1e3, label=label, markevery=12, **_style(k))
        axes.set(xlabel="load torque (N m)", ylabel="drum angle (mrad)", title="inputs locked")
        axes.legend(fontsize="small")
        _save(figure, path)


# Standard deviations for the intervals where the design file gives none, estimates relative to the value: preload by a
# hand-set tensioner, friction and modulus from tables, torque sensor, motor rating.
RELATIVE_SIGMA = {
    "preload_N": 0.05,
    "friction_coefficient": 0.10,
    "modulus_Pa": 0.05,
    "load_Nm": 0.01,
    "input_rating_Nm": 0.03,
}


def write_study(
    design: Modelled, folder: Path, tolerances: Tolerances, stacks: Sequence[StackUp] = (), workers: Crew | None = None
) -> dict[str, Any]:
    """Write every file of the study into ``folder`` (made if missing) and return the summary, which is also a file.

    ``tolerances`` are those of the transmission error, ``stacks`` the gaps to stack up, here by Monte Carlo too;
    ``workers`` as in :func:`mbcdm_cad.model.bulk.analyse_many`.

    Files: fig5_a to fig5_d as .csv and .svg, indices.svg, tolerance.svg and .csv, loop.svg, sensitivity.json. Seeded:
    the same design gives the same bytes.
    """
    folder.mkdir(parents=True, exist_ok=True)
    d, need = design.si, requirements(design)
    for panel in figure_5(d, need.load_Nm):
        _write_csv(folder / f"fig5_{panel.letter}.csv", panel.header(), panel.rows())
        plot_panel(panel, folder / f"fig5_{panel.letter}.svg")
    indices = global_indices(d, need, workers=workers)
    plot_indices(indices, folder / "indices.svg")
    stack = tolerance_stack(d, float(need.half_travel_rad), tolerances)
    plot_tolerance(stack, folder / "tolerance.svg")
    columns = np.stack([np.degrees(stack.pose_rad), stack.linear_rad * 1e6, stack.monte_carlo_rad * 1e6], axis=1)
    _write_csv(folder / "tolerance.csv", ["drum_angle_deg", "linear_urad", "monte_carlo_urad"], columns.tolist())
    plot_loop(d, need.load_Nm, folder / "loop.svg")
    sigma = {
        name: share * float(np.mean(getattr(need if hasattr(need, name) else d, name)))
        for name, share in RELATIVE_SIGMA.items()
    } | sigmas_si(design)
    summary = {
        "design": design.drive.name,
        "elasticities": elasticities(d, need),
        "global_indices": asdict(indices),
        "tolerances": asdict(tolerances),
        "tolerance_stack": {
            "rms_by_source_rad": dict(zip(stack.contributor, stack.contribution_rad.tolist(), strict=True)),
            "peak_to_peak_rad": {
                "linear": {"median": stack.peak_to_peak_rad[0, 0], "p95": stack.peak_to_peak_rad[0, 1]},
                "monte_carlo": {"median": stack.peak_to_peak_rad[1, 0], "p95": stack.peak_to_peak_rad[1, 1]},
            },
        },
        "gap_stacks": [stack_data(stack, DRAWS) for stack in stacks],
        "sigma": {name: np.asarray(size).tolist() for name, size in sigma.items()},
        "intervals": {name: asdict(one) for name, one in intervals(d, need, sigma, workers=workers).items()},
    }
    # Eight digits: further digits depend on the mathematics library, not on the design.
    text = json.dumps(with_floats(summary, lambda number: float(f"{number:.8g}")), indent=2, sort_keys=True)
    (folder / "sensitivity.json").write_text(text + "\n", encoding="utf-8")
    return summary


def _write_csv(path: Path, header: list[str], rows: list[list[float]]) -> None:
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(header)
        writer.writerows([f"{value:.6g}" for value in row] for row in rows)
