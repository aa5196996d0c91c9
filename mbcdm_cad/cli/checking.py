"""The command ``check``: one or several designs, as text or JSON, and its exit code."""

from __future__ import annotations

import json
import sys
from collections.abc import Sequence
from pathlib import Path

import click

from mbcdm_cad.cli.screen import coloured, screen_width
from mbcdm_cad.design.loaded import LoadedDesign
from mbcdm_cad.errors import MbcdmError
from mbcdm_cad.layouts.loader import design_file, load_design
from mbcdm_cad.report.check_report import CheckReport, Shown, check_design


def check_command(paths: Sequence[Path], *, as_json: bool, show: Shown) -> int:
    """Check all designs. 2 if one cannot be read (the others are still checked), else 1 if one fails, else 0."""
    reports: list[tuple[Path, CheckReport]] = []
    unread: list[str] = []
    for path in paths:
        try:
            loaded = load_design(path)
            reports.append((path, check_design(loaded)))
        except MbcdmError as error:
            unread.append(str(path))
            click.echo(str(error), err=True)
            continue
        if not as_json:
            text = reports[-1][1].text(width=screen_width(), colour=coloured(), show=show)
            click.echo(("\n" if len(reports) > 1 else "") + text, color=coloured())
            _hint(path, loaded)
    failing = [str(path) for path, report in reports if not report.passed]
    if as_json:
        found = [report.to_dict() for _, report in reports]
        if found:
            click.echo(json.dumps(found[0] if len(paths) == 1 else found, indent=1, allow_nan=False))
    elif len(paths) > 1:
        click.echo("\n" + _summary(len(paths), failing, unread))
    return 2 if unread else int(bool(failing))


def _hint(path: Path, loaded: LoadedDesign) -> None:
    """Print a hint on stderr for a file that states every value; only on a terminal."""
    if not sys.stderr.isatty():
        return
    if not loaded.sized and design_file(loaded.drive.configuration).size is not None:
        hint = "states every value; sizing rules compute the fields that a file leaves out"
        click.echo(f"{path}: {hint} (mbcdm explain)", err=True)


def _summary(count: int, failing: Sequence[str], unread: Sequence[str]) -> str:
    """One line about all designs: their number, and those that fail."""
    words = [f"{len(failing)} fail: {', '.join(failing)}"] if failing else []
    words += [f"{len(unread)} cannot be read: {', '.join(unread)}"] if unread else []
    return f"{count} designs: " + ("; ".join(words) or "all pass")
