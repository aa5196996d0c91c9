"""The commands that draw, ``build`` and ``picture``: what they print, and the exit code they end with."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from mbcdm_cad.checks.result import CheckResult
from mbcdm_cad.design.loaded import LoadedDesign
from mbcdm_cad.storage.cache import Cache, cache_folder


def build_command(
    loaded: LoadedDesign, *, angle_deg: float, force: bool, out: Path, use_cache: bool, jobs: int | None
) -> int:
    """Build and say what came of it. 0 built, 1 refused or forced against a failing check."""
    from mbcdm_cad.build.progress import progress
    from mbcdm_cad.build.run import build

    cache = Cache(cache_folder() if use_cache else None)
    with progress() as tell:
        outcome = build(loaded, out, angle_deg=angle_deg, force=force, cache=cache, jobs=jobs, progress=tell)
    if cache.problem:
        click.echo(f"warning: {cache.problem}; built without it", err=True)
    for check in outcome.checks:
        if check.status == "fail":
            click.echo(_failure(check), err=True)
    if outcome.folder is None:
        click.echo(
            f"{loaded.path}: not built, {len(outcome.failed)} check(s) fail; --force builds all the same", err=True
        )
        return 1
    assert outcome.data is not None
    click.echo(_summary(outcome.folder, outcome.data, outcome.unchanged, outcome.made))
    return 1 if outcome.failed else 0


def _failure(check: CheckResult) -> str:
    return f"fail: {check.id}: {check.message}; {check.remedy}"


def _summary(folder: Path, data: dict[str, Any], unchanged: bool, made: tuple[str, ...]) -> str:
    mass, box, run = data["mass"], data["envelope"], data["interference"]
    count = sum(1 for c in data["checks"] if c["status"] == "warn")
    drawn = (
        "nothing changed" if unchanged else f"{len(made)} made" + (f": {', '.join(made)}" if 0 < len(made) < 6 else "")
    )
    size = " x ".join(f"{v:.2f}" for v in box["size_mm"])
    lines = [
        f"{folder}: {drawn}",
        f"  mass {mass['mass_g']:.1f} g +- {mass['sigma_g']:.1f} "
        f"(target {mass['target_g']:g} +- {mass['tolerance_g']:g})",
        f"  box X x Z x Y {size} mm (target {' x '.join(f'{v:g}' for v in box['target_mm'])})",
        f"  interference: {len(run['clashes'])} clashes at {len(run['poses_deg'])} poses",
        f"  checks: {len(data['failed_checks'])} fail, {count} warn, of {len(data['checks'])}; see report.md",
    ]
    if data["forced"]:
        lines.insert(1, f"  FORCED although these fail: {', '.join(data['failed_checks'])}")
    return "\n".join(lines)


def picture_command(loaded: LoadedDesign, png: Path, *, angle_deg: float, view: str, use_cache: bool) -> int:
    """Draw the assembly into one PNG, without a display."""
    from mbcdm_cad.build.export.picture import picture_png
    from mbcdm_cad.build.progress import progress
    from mbcdm_cad.build.run import drawn

    with progress() as tell:
        items, parts = drawn(loaded.drive, angle_deg, Cache(cache_folder() if use_cache else None), tell)
    data = picture_png(items, {name: part.files.mesh for name, part in parts.items()}, view)
    aside = png.with_name(f".{png.name}.new")
    aside.write_bytes(data)
    aside.replace(png)
    click.echo(f"{png}: {view} view, drum at {angle_deg:g} deg")
    return 0
