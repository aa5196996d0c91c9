"""The commands that draw, such as ``build``, ``picture`` and ``drawings``: their output and exit codes.

Modules that draw pictures and drawings are imported inside: a build without changes needs no CAD.
"""

from __future__ import annotations

import shlex
from pathlib import Path

import click

from mbcdm_cad.build.bodies import bodies, is_cable
from mbcdm_cad.build.made_parts import drawn
from mbcdm_cad.build.progress import progress
from mbcdm_cad.errors import InputError, Problem
from mbcdm_cad.jobs.build import build
from mbcdm_cad.layouts.loader import load_design
from mbcdm_cad.layouts.registry import configuration
from mbcdm_cad.report.page import PAGE
from mbcdm_cad.storage.cache import Cache, cache_folder
from mbcdm_cad.storage.files import refuse_missing_folder, write_whole
from mbcdm_cad.storage.origin import refuse_other_origin, write_from


def build_command(path: Path, *, angle_deg: float, force: bool, out: Path, use_cache: bool, jobs: int | None) -> int:
    """Build and print the result. 0 built, 1 refused, or forced although a check fails."""
    loaded = load_design(path)

    cache = Cache(cache_folder() if use_cache else None)
    with progress() as note:
        report = build(loaded, out, angle_deg=angle_deg, force=force, cache=cache, jobs=jobs, progress=note)
    if cache.problem:
        click.echo(f"warning: {cache.problem}; built without it", err=True)
    for check in report.checks.failed:
        click.echo(f"fail: {check.id}: {check.message}; {check.remedy}", err=True)
    if report.folder is None:
        words = f"{path}: not built, {len(report.checks.failed)} check(s) fail; --force builds it anyway"
        click.echo(words, err=True)
    else:
        click.echo(report.text())
        if not (report.folder / PAGE).exists():
            click.echo(f"  mbcdm page {shlex.quote(str(path))} adds {PAGE}: the drive in 3D with all figures")
    return 0 if report.passed else 1


def picture_command(path: Path, png: Path, *, angle_deg: float, view: str, use_cache: bool) -> int:
    """Draw the assembly into one PNG, without a display. Raises ``InputError`` for a file that cannot be a PNG."""
    loaded = load_design(path)
    if png.suffix.lower() != ".png":
        remedy = f"name it {png.with_suffix('.png').name}"
        raise InputError([Problem(str(png), 1, "", "pictures are PNG files", png.suffix, ".png", remedy)])
    refuse_missing_folder(png)
    from mbcdm_cad.build.export.picture import picture_png

    with progress() as note:
        items, parts = drawn(loaded.drive, angle_deg, Cache(cache_folder() if use_cache else None), note)
    data = picture_png(items, {name: part.files.mesh for name, part in parts.items()}, view)
    write_whole({png: data})
    click.echo(f"{png}: {view} view, drum at {angle_deg:g} deg")
    return 0


def moving_picture_command(path: Path, gif: Path, *, view: str, use_cache: bool) -> int:
    """Draw the travel into one GIF, without a display. Raises ``InputError`` for a file that cannot be a GIF."""
    loaded = load_design(path)
    if gif.suffix.lower() != ".gif":
        remedy = f"name it {gif.with_suffix('.gif').name}"
        raise InputError([Problem(str(gif), 1, "", "moving pictures are GIF files", gif.suffix, ".gif", remedy)])
    from mbcdm_cad.build.export.moving import travel_gif

    drive = loaded.drive
    kind = configuration(drive.configuration)
    dims = kind.layout(drive)
    centred = kind.bill(dims)
    with progress() as note:
        _, parts = drawn(drive, 0.0, Cache(cache_folder() if use_cache else None), note)
        note("moving picture")
        colour = next(item.material.colour for item in centred.items if is_cable(item))
        data = travel_gif(
            [item for item in centred.items if not is_cable(item)],
            {name: part.files.mesh for name, part in parts.items()},
            bodies(kind.moving_bodies(dims), centred),
            (dims.cable_paths, drive.cable.diameter_mm, colour),
            drive.half_travel_deg,
            view=view,
        )
    write_whole({gif: data})
    click.echo(f"{gif}: {view} view, drum to +-{drive.half_travel_deg:g} deg, {len(data) / 1e6:.2f} MB")
    return 0


def drawings_command(path: Path, out: Path, *, part: str | None, use_cache: bool, jobs: int | None) -> int:
    """Write the workshop drawings into their own folder."""
    loaded = load_design(path)
    from mbcdm_cad.build.drawings import drawings_folder, drawings_of

    target = drawings_folder(out, loaded.drive.name)
    refuse_other_origin(target, path)
    with progress() as note:
        files = drawings_of(
            loaded.drive, Cache(cache_folder() if use_cache else None), part=part, jobs=jobs, progress=note
        )
    write_from(path, target, files)
    click.echo(f"{target}: {len(files)} files, {len(files) // 3} sheets as DXF, PDF and SVG")
    return 0


def pictures_command(path: Path, out: Path, *, use_cache: bool) -> int:
    """Write the pictures for the assembly into their own folder."""
    loaded = load_design(path)
    target = out / f"{loaded.drive.name}-pictures"
    refuse_other_origin(target, path)
    from mbcdm_cad.build.pictures import pictures_of

    with progress() as note:
        files = pictures_of(loaded.drive, Cache(cache_folder() if use_cache else None), note)
    write_from(path, target, files)
    click.echo(f"{target}: {', '.join(files)}")
    return 0


def prints_command(path: Path, out: Path, *, use_cache: bool) -> int:
    """Write the made parts for a 3D printer into their own folder."""
    loaded = load_design(path)
    target = out / f"{loaded.drive.name}-prints"
    refuse_other_origin(target, path)
    from mbcdm_cad.build.prints import prints_of

    with progress() as note:
        files = prints_of(loaded.drive, Cache(cache_folder() if use_cache else None), note)
    write_from(path, target, files)
    wider = loaded.drive.printing.hole_allowance_mm
    holes = f", round holes of printed materials {wider:g} mm wider than drawn" if wider else ""
    click.echo(f"{target}: {len(files)} parts as 3MF, each on its largest flat face{holes}")
    return 0
