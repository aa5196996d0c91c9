"""The command ``compare``: designs side by side, each built where that is not done yet."""

from __future__ import annotations

import json
from pathlib import Path

import click

from mbcdm_cad.build.progress import progress
from mbcdm_cad.build.run import build
from mbcdm_cad.configurations.loader import load_design
from mbcdm_cad.errors import MbcdmError
from mbcdm_cad.report.comparison import compared, comparison_data, comparison_table
from mbcdm_cad.storage.cache import Cache, cache_folder


def compare_command(
    paths: tuple[Path, ...], *, out: Path, as_json: bool, markdown: bool, use_cache: bool, jobs: int | None
) -> int:
    """Print the comparison. Raises ``MbcdmError`` for a design that fails a check: it could not be built as it is."""
    designs = [load_design(path) for path in paths]
    load = min(design.drive.loads.test_torque_Nm for design in designs)
    cache = Cache(cache_folder() if use_cache else None)
    found = []
    for path, design in zip(paths, designs, strict=True):
        with progress() as note:
            outcome = build(design, out, angle_deg=0.0, force=False, cache=cache, jobs=jobs, progress=note)
        if outcome.folder is None or outcome.data is None:
            failed = ", ".join(check.id for check in outcome.failed)
            raise MbcdmError(f"{path}: not compared, since it fails {failed}; see mbcdm check {path}")
        found.append(compared(design.drive, outcome.data, load))
    if as_json:
        click.echo(json.dumps(comparison_data(found), indent=1))
        return 0
    table = comparison_table(found)
    for line in table.markdown() if markdown else table.text():
        click.echo(line)
    return 0
