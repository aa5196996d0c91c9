"""The command ``page``: builds the design if this is not done yet, and writes its page into the folder of the build."""

from __future__ import annotations

from pathlib import Path

import click

from mbcdm_cad.build.drawings import drawings_folder
from mbcdm_cad.build.made_parts import drawn
from mbcdm_cad.build.progress import progress
from mbcdm_cad.jobs.build import build
from mbcdm_cad.layouts.loader import load_design
from mbcdm_cad.report.page import PAGE
from mbcdm_cad.report.page.stage import page_figures, page_of
from mbcdm_cad.storage.cache import Cache, cache_folder
from mbcdm_cad.storage.files import write_whole


def page_command(path: Path, *, out: Path, force: bool, use_cache: bool) -> int:
    """Write ``out/<name>/report.html``. 0 written, 1 refused, or forced although a check fails."""
    loaded = load_design(path)
    cache = Cache(cache_folder() if use_cache else None)
    with progress() as tell:
        outcome = build(loaded, out, force=force, cache=cache, progress=tell)
        for check in outcome.checks.failed:
            click.echo(f"fail: {check.id}: {check.message}; {check.remedy}", err=True)
        if outcome.folder is None or outcome.data is None:
            text = f"{loaded.path}: no page, {len(outcome.checks.failed)} check(s) fail; --force writes it anyway"
            click.echo(text, err=True)
            return 1
        _, parts = drawn(loaded.drive, 0.0, cache, tell)
        tell("page")
        figures = page_figures(loaded.drive, outcome.data["fields"], cache)
        page = page_of(loaded.drive, outcome.data, parts, figures, drawings_folder(out, loaded.drive.name))
    target = outcome.folder / PAGE
    write_whole({target: page})
    click.echo(f"{target}: {len(page) / 1e6:.1f} MB, opens in any browser, needs no network")
    return 1 if outcome.checks.failed else 0
