"""The command ``picture --travel``: a moving picture of the drum's swing."""

from __future__ import annotations

from pathlib import Path

import click

from mbcdm_cad.build.bodies import bodies, is_cable
from mbcdm_cad.build.progress import progress
from mbcdm_cad.build.run import drawn
from mbcdm_cad.configurations.loader import load_design
from mbcdm_cad.configurations.registry import configuration
from mbcdm_cad.errors import InputError, Problem
from mbcdm_cad.storage.cache import Cache, cache_folder
from mbcdm_cad.storage.files import write_whole


def moving_picture_command(path: Path, gif: Path, *, view: str, use_cache: bool) -> int:
    """Draw the travel into one GIF, without a display. Raises ``InputError`` for a file that cannot be a GIF."""
    loaded = load_design(path)
    if gif.suffix.lower() != ".gif":
        remedy = f"name it {gif.with_suffix('.gif').name}"
        raise InputError([Problem(str(gif), 1, "", "moving pictures are GIF files", gif.suffix, ".gif", remedy)])
    from mbcdm_cad.build.export.moving import travel_gif  # the renderer, once the names are known to be good

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
