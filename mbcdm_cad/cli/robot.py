"""The command ``export``: the drive for robot simulators."""

from __future__ import annotations

from pathlib import Path

import click

from mbcdm_cad.build.made_parts import drawn
from mbcdm_cad.build.progress import progress
from mbcdm_cad.layouts.loader import load_design
from mbcdm_cad.robot.formats import robot_files
from mbcdm_cad.robot.mechanism import mechanism
from mbcdm_cad.storage.cache import Cache, cache_folder
from mbcdm_cad.storage.folders import output_folder
from mbcdm_cad.storage.keys import content_key, package_hash
from mbcdm_cad.storage.manifest import Manifest, versions


def export_command(path: Path, *, form: str, elastic: bool, out: Path, use_cache: bool) -> int:
    """Write ``out/<name>-<form>``: the description and its meshes."""
    loaded = load_design(path)

    drive = loaded.drive
    with progress() as tell:
        _, parts = drawn(drive, 0.0, Cache(cache_folder() if use_cache else None), tell)
    robot = mechanism(drive, {name: part.files for name, part in parts.items()})
    files = robot_files(robot, form, elastic)
    target = out / f"{drive.name}-{form}"
    inputs = content_key("export", (loaded.sha256, form, elastic), package_hash(), versions())
    with output_folder(target, Manifest(loaded.sha256, inputs), design=loaded.path) as folder:
        for name, content in files.items():
            folder.write(name, content)
    mass = sum(link.mass for link in (robot.base, *robot.links))
    size = sum(map(len, files.values())) / 1e6
    click.echo(
        f"{target / next(iter(files))}: {len(robot.joints)} joints, {mass * 1e3:.1f} g, {size:.1f} MB with meshes"
    )
    return 0
