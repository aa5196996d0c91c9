"""The commands ``analyse``, ``sensitivity`` and ``reproduce``: their output and exit codes.

Each imports its study inside: ``analyse`` must start fast and needs neither scipy nor plots, and writes no folder.
"""

from __future__ import annotations

import json
from pathlib import Path

import click

from mbcdm_cad.cli.screen import screen_width
from mbcdm_cad.layouts.loader import load_design, load_text, new_design_text
from mbcdm_cad.layouts.registry import configuration
from mbcdm_cad.model.figures import readable_figure
from mbcdm_cad.parts.making import model_tolerances
from mbcdm_cad.report.table import ReportTable


def analyse_command(path: Path, *, as_json: bool) -> int:
    """Print the figures of the model for one design."""
    loaded = load_design(path)
    from mbcdm_cad.report.analysis_report import analyse_design

    report = analyse_design(loaded.drive)
    click.echo(json.dumps(report.to_dict(), indent=1, allow_nan=False) if as_json else report.text(screen_width()))
    return 0


def sensitivity_command(path: Path, *, out: Path) -> int:
    """Write the sensitivity study into its own folder."""
    loaded = load_design(path)
    from mbcdm_cad.model.study import write_study
    from mbcdm_cad.storage.folders import output_folder
    from mbcdm_cad.storage.keys import content_key, package_hash
    from mbcdm_cad.storage.manifest import Manifest, versions

    target = out / f"{loaded.drive.name}-sensitivity"
    inputs = content_key("sensitivity", loaded.sha256, package_hash(), versions())
    with output_folder(target, Manifest(loaded.sha256, inputs), design=loaded.path) as folder:
        kind = configuration(loaded.drive.configuration)
        stacks = kind.tolerance_stacks(kind.layout(loaded.drive))
        summary = write_study(loaded.drive, folder.path, model_tolerances(loaded.drive), stacks)
    click.echo(f"{target}: fig5_a to fig5_d, indices, tolerance, loop as plots; sensitivity.json")
    rows = []
    for name, interval in summary["intervals"].items():
        plain, unit, scale = readable_figure(name)
        rows.append((plain.replace("_", " "), unit, *(interval[key] * scale for key in ("value", "low", "high"))))
    click.echo("95 % intervals:")
    click.echo(
        "\n".join(ReportTable(("figure", "unit", "value", "low", "high"), tuple(rows)).text(screen_width(), "  "))
    )
    return 0


def reproduce_command(path: Path | None) -> int:
    """Print the table of the paper's figures; 1 if a figure is outside its tolerance."""
    from mbcdm_cad.paper.reproduce import as_markdown, reproduce

    loaded = load_text(new_design_text("mbcdm")) if path is None else load_design(path)
    figures = reproduce(loaded.drive)
    click.echo(as_markdown(figures, loaded.drive.name), nl=False)
    outside = [f for f in figures if not f.within]
    for figure in outside:
        click.echo(
            f"{figure.name}: {figure.computed:.5g} {figure.unit} is {figure.difference:+.2%} from the paper's "
            f"{figure.paper:.5g} (tolerance {figure.tolerance:.2%})",
            err=True,
        )
    return 1 if outside else 0
