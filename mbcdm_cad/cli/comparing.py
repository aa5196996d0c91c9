"""The command ``compare``: designs side by side; those that are not built yet are built first."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import click

from mbcdm_cad.build.made_parts import drawn
from mbcdm_cad.build.progress import progress
from mbcdm_cad.design.drive import Drive
from mbcdm_cad.errors import MbcdmError
from mbcdm_cad.jobs.build import build
from mbcdm_cad.layouts.loader import load_design
from mbcdm_cad.report.comparison import (
    ComparedDesign,
    compared,
    comparison_data,
    comparison_table,
    distinct_labels,
    own_folder,
)
from mbcdm_cad.storage.cache import Cache, cache_folder
from mbcdm_cad.storage.files import refuse_missing_folder, write_whole

_VIEW, _PICTURE_PX = "output", (900, 720)


def compare_command(
    paths: tuple[Path, ...],
    *,
    out: Path,
    as_json: bool,
    markdown: bool,
    page: Path | None,
    use_cache: bool,
    jobs: int | None,
) -> int:
    """Print the comparison, and write it as ``page``.

    Raises ``MbcdmError`` for a design that fails a check.
    """
    if page is not None:
        refuse_missing_folder(page)
    designs = [load_design(path) for path in paths]
    load = min(design.drive.loads.test_torque_Nm for design in designs)
    cache = Cache(cache_folder() if use_cache else None)
    found = []
    labels = distinct_labels([(design.drive.name, design.path) for design in designs])
    for path, design, label in zip(paths, designs, labels, strict=True):
        folder = out if label == design.drive.name else out / own_folder(label)
        with progress() as note:
            outcome = build(design, folder, angle_deg=0.0, force=False, cache=cache, jobs=jobs, progress=note)
        if outcome.folder is None or outcome.data is None:
            failed = ", ".join(check.id for check in outcome.checks.failed)
            raise MbcdmError(f"{path}: not compared, because it fails {failed}; see mbcdm check {path}")
        found.append(replace(compared(design.drive, outcome.data, load), name=label))
    if page is not None:
        _write_page(page, [design.drive for design in designs], found, cache)
    if as_json:
        click.echo(json.dumps(comparison_data(found), indent=1))
        return 0
    table = comparison_table(found)
    for line in table.markdown() if markdown else table.text():
        click.echo(line)
    return 0


def _write_page(page: Path, drives: Sequence[Drive], found: Sequence[ComparedDesign], cache: Cache) -> None:
    # Imported here because they load the drawing libraries, which the table does not need.
    from mbcdm_cad.build.export.picture import picture_png
    from mbcdm_cad.report.page.compared import comparison_page

    pictures = []
    with progress() as note:
        for drive in drives:
            items, parts = drawn(drive, 0.0, cache, note)
            note(f"picture of {drive.name}")
            meshes = {name: part.files.mesh for name, part in parts.items()}
            pictures.append(picture_png(items, meshes, _VIEW, _PICTURE_PX))
    write_whole({page: comparison_page(found, drives, pictures)})
    click.echo(f"{page}: {len(drives)} designs side by side, opens in any browser", err=True)
