"""The command ``explain``: why a field has its value, for one field or all."""

from __future__ import annotations

import json
from pathlib import Path

import click

from mbcdm_cad.cli.screen import screen_width
from mbcdm_cad.design.loaded import LoadedDesign
from mbcdm_cad.errors import InputError, MbcdmError, Problem
from mbcdm_cad.layouts.loader import load_design
from mbcdm_cad.report.explain import chain_lines, explain_all, explain_field, fields_data, table_lines
from mbcdm_cad.storage.files import refuse_missing_folder, write_whole


def explain_command(design: Path, field: str | None, *, as_json: bool, graph: Path | None) -> int:
    """Print the table of all fields with a rule, or the chain of one; or write the graph of all.

    Raises ``MbcdmError`` for an unknown field, ``InputError`` for a graph file that is not an SVG.
    """
    loaded = load_design(design)
    if graph is not None:
        _write_graph(loaded, graph)
        return 0
    if as_json:
        entries = [explain_field(loaded, field)] if field else list(explain_all(loaded))
        found = [entry.to_dict() for entry in entries]
        click.echo(json.dumps(found[0] if field else found, indent=1, allow_nan=False))
        return 0
    width = screen_width()
    for line in chain_lines(loaded, field, width) if field else table_lines(loaded, width):
        click.echo(line)
    return 0


def _write_graph(loaded: LoadedDesign, svg: Path) -> None:
    # Imported here because the layout of the graph loads a library that the other output does not need.
    from mbcdm_cad.report.dependencies import dependency_graph, dependency_svg

    if svg.suffix.lower() != ".svg":
        remedy = f"name it {svg.with_suffix('.svg').name}"
        raise InputError([Problem(str(svg), 1, "", "graphs are SVG files", svg.suffix, ".svg", remedy)])
    found = dependency_graph(fields_data(loaded)["fields"])
    if not found.nodes:
        raise MbcdmError(f"{loaded.path}: no graph, because {loaded.drive.configuration} has no sizing rules")
    refuse_missing_folder(svg)
    title = f"{loaded.drive.name}: dependencies of all values"
    write_whole({svg: dependency_svg(found, title).encode()})
    click.echo(f"{svg}: {len(found.nodes)} fields, {len(found.lines)} lines")
