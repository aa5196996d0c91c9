"""What the commands print, and the exit code they end with."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from mbcdm_cad.cachedir import Cache, cache_folder
from mbcdm_cad.checks import CheckResult
from mbcdm_cad.design.loaded import LoadedDesign


def build_command(
    loaded: LoadedDesign, *, angle_deg: float, force: bool, out: Path, use_cache: bool, jobs: int | None
) -> int:
    """Build and say what came of it. 0 built, 1 refused or forced against a failing check."""
    from mbcdm_cad.report.build import build
    from mbcdm_cad.report.progress import progress

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
    from mbcdm_cad.export.picture import picture_png
    from mbcdm_cad.report.build import drawn
    from mbcdm_cad.report.progress import progress

    with progress() as tell:
        items, parts = drawn(loaded.drive, angle_deg, Cache(cache_folder() if use_cache else None), tell)
    data = picture_png(items, {name: part.files.mesh for name, part in parts.items()}, view)
    aside = png.with_name(f".{png.name}.new")
    aside.write_bytes(data)
    aside.replace(png)
    click.echo(f"{png}: {view} view, drum at {angle_deg:g} deg")
    return 0


def sensitivity_command(loaded: LoadedDesign, *, out: Path) -> int:
    """Write the sensitivity study into a folder of its own."""
    from mbcdm_cad.contentkey import content_key
    from mbcdm_cad.export.manifest import Manifest, versions
    from mbcdm_cad.export.outputfolder import output_folder
    from mbcdm_cad.model.study import write_study
    from mbcdm_cad.sourcehash import package_hash

    target = out / f"{loaded.drive.name}-sensitivity"
    inputs = content_key("sensitivity", loaded.sha256, package_hash(), versions())
    with output_folder(target, Manifest(loaded.sha256, inputs)) as folder:
        summary = write_study(loaded.drive, folder.path)
    click.echo(f"{target}: fig5_a to fig5_d, indices, tolerance, loop as plots; sensitivity.json")
    for name, interval in summary["intervals"].items():
        click.echo(f"  {name}: " + ", ".join(f"{k} {v:.4g}" for k, v in interval.items() if isinstance(v, float)))
    return 0


def reproduce_command(path: Path | None) -> int:
    """Print the paper table; 1 if a figure leaves its tolerance."""
    from mbcdm_cad.design import load_design
    from mbcdm_cad.design.loader import load_text
    from mbcdm_cad.design.template import new_design_text
    from mbcdm_cad.model.reproduce import as_markdown, reproduce

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
