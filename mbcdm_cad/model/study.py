"""The files of ``mbcdm sensitivity``: Fig. 5 as plots and CSV, global indices, tolerance stack, intervals, summary."""

from __future__ import annotations

import csv
import json
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from mbcdm_cad.model import plots
from mbcdm_cad.model.ratings import requirements, sigmas_si
from mbcdm_cad.model.sensitivity import elasticities, figure_5, global_indices
from mbcdm_cad.model.si import to_si
from mbcdm_cad.model.stack_up import DRAWS, StackUp, stack_data
from mbcdm_cad.model.tolerance import Tolerances, tolerance_stack
from mbcdm_cad.model.uncertainty import intervals

if TYPE_CHECKING:
    from mbcdm_cad.design.drive import Drive

# Standard deviations for the intervals where the design file gives none, estimates relative to the value: preload by a
# hand-set tensioner, friction and modulus from tables, torque sensor, motor rating.
RELATIVE_SIGMA = {
    "preload_N": 0.05,
    "friction_coefficient": 0.10,
    "modulus_Pa": 0.05,
    "load_Nm": 0.01,
    "input_rating_Nm": 0.03,
}


def write_study(drive: Drive, folder: Path, tolerances: Tolerances, stacks: Sequence[StackUp] = ()) -> dict[str, Any]:
    """Write every file of the study into ``folder`` (made if missing) and return the summary, which is also a file.

    ``tolerances`` are those of the transmission error, ``stacks`` the gaps to stack up, here by Monte Carlo too.

    Files: fig5_a to fig5_d as .csv and .svg, indices.svg, tolerance.svg and .csv, loop.svg, sensitivity.json. Seeded:
    the same design gives the same bytes.
    """
    folder.mkdir(parents=True, exist_ok=True)
    d, need = to_si(drive), requirements(drive)
    for panel in figure_5(d, need.load_Nm):
        _write_csv(folder / f"fig5_{panel.letter}.csv", panel.header(), panel.rows())
        plots.plot_panel(panel, folder / f"fig5_{panel.letter}.svg")
    indices = global_indices(d, need)
    plots.plot_indices(indices, folder / "indices.svg")
    stack = tolerance_stack(d, float(need.half_travel_rad), tolerances)
    plots.plot_tolerance(stack, folder / "tolerance.svg")
    columns = np.stack([np.degrees(stack.pose_rad), stack.linear_rad * 1e6, stack.monte_carlo_rad * 1e6], axis=1)
    _write_csv(folder / "tolerance.csv", ["drum_angle_deg", "linear_urad", "monte_carlo_urad"], columns.tolist())
    plots.plot_loop(d, need.load_Nm, folder / "loop.svg")
    sigma = {
        name: share * float(np.mean(getattr(need if hasattr(need, name) else d, name)))
        for name, share in RELATIVE_SIGMA.items()
    } | sigmas_si(drive)
    summary = {
        "design": drive.name,
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
        "intervals": {name: asdict(interval) for name, interval in intervals(d, need, sigma).items()},
    }
    # Eight digits: further digits depend on the mathematics library, not on the design.
    text = json.dumps(_rounded(summary), indent=2, sort_keys=True)
    (folder / "sensitivity.json").write_text(text + "\n", encoding="utf-8")
    return summary


def _write_csv(path: Path, header: list[str], rows: list[list[float]]) -> None:
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(header)
        writer.writerows([f"{value:.6g}" for value in row] for row in rows)


def _rounded(value: Any) -> Any:
    if isinstance(value, dict):
        return {key: _rounded(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [_rounded(item) for item in value]
    if isinstance(value, float):
        return float(f"{value:.8g}")
    return value
