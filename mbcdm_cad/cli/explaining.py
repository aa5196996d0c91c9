"""The command ``explain``: why a field has its value, for one field or all."""

from __future__ import annotations

import json
from pathlib import Path

import click

from mbcdm_cad.configurations.loader import load_design
from mbcdm_cad.report.explain import chain_lines, explain_all, explain_field, table_lines


def explain_command(design: Path, field: str | None, *, as_json: bool) -> int:
    """Print the table of all sized fields, or the chain of one. Raises ``MbcdmError`` for an unknown field."""
    loaded = load_design(design)
    if as_json:
        entries = [explain_field(loaded, field)] if field else list(explain_all(loaded))
        found = [entry.to_dict() for entry in entries]
        click.echo(json.dumps(found[0] if field else found, indent=1, allow_nan=False))
        return 0
    for line in chain_lines(loaded, field) if field else table_lines(loaded):
        click.echo(line)
    return 0
