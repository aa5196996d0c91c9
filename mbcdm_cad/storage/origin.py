"""Each output folder knows its design file, so that two files of one name do not replace each other's output.

The record is a hidden file in the folder. It holds the path of the design file relative to the folder, so it stays
right when both are moved together, and two builds of one design stay the same byte for byte.
"""

from __future__ import annotations

import os
from collections.abc import Mapping
from pathlib import Path

from mbcdm_cad.errors import OutputError
from mbcdm_cad.storage.files import write_whole

ORIGIN_NAME = ".design-file"


def write_from(design: Path, target: Path, files: Mapping[str, bytes]) -> None:
    """Write files by name into ``target``, with the record. Raises as :func:`refuse_other_origin`, and ``OSError``."""
    refuse_other_origin(target, design)
    record = {target / ORIGIN_NAME: origin_text(target, design).encode()} if design.is_file() else {}
    write_whole({target / name: data for name, data in files.items()} | record)


def origin_text(target: Path, design: Path) -> str:
    """Content of the record in ``target``."""
    source, folder = design.resolve(), target.resolve()
    try:
        return Path(os.path.relpath(source, folder)).as_posix() + "\n"
    except ValueError:  # another drive of Windows
        return source.as_posix() + "\n"


def refuse_other_origin(target: Path, design: Path) -> None:
    """Raise ``OutputError`` if ``target`` holds the output of another design file that is still there.

    Anything goes for a design without a file, and for a folder without a record.
    """
    try:
        other = (target / (target / ORIGIN_NAME).read_text("utf-8").strip()).resolve()
        if not design.is_file() or not other.is_file() or other.samefile(design):
            return
    except (OSError, ValueError, RuntimeError):  # no record, or one that names no path
        return
    raise OutputError(
        f"{target}: holds the output of {other}, another design file with the same name as {design}; change name in "
        "one of the two files, choose another folder with --out, or remove this folder if it is no longer needed"
    )
