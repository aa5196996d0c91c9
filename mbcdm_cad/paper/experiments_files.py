"""The files of one of the paper's experiments: figure, result as JSON, and a short text."""

from __future__ import annotations

import json
import math

from mbcdm_cad.design.drive import Drive
from mbcdm_cad.paper.experiments import Compared, PaperResult


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
    from mbcdm_cad.paper.experiments_plots import plot_png  # matplotlib is slow to import

    return {
        f"{result.name}.png": plot_png(result, drive),
        f"{result.name}.result.json": result_json(result, drive),
        f"{result.name}.txt": result_text(result).encode(),
    }
