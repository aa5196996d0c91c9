"""Single files that appear whole or not at all: written aside, then renamed into place."""

from __future__ import annotations

import os
import secrets
from collections.abc import Mapping
from pathlib import Path


def write_whole(files: Mapping[Path, bytes]) -> None:
    """Write all files; none is touched before all are on the disk. Raises OSError that names the file meant.

    Folders that are not there are made.
    """
    aside: dict[Path, Path] = {}
    try:
        for target, content in files.items():
            new = target.with_name(f".{target.name}.new-{secrets.token_hex(8)}")
            try:
                target.parent.mkdir(parents=True, exist_ok=True)
                if target.is_dir():
                    raise IsADirectoryError(21, "is a folder", str(target))
                with open(new, "xb") as file:
                    aside[new] = target
                    file.write(content)
                    file.flush()
                    os.fsync(file.fileno())
            except OSError as error:
                raise OSError(error.errno, error.strerror, str(target)) from error
        for new, target in aside.items():
            new.replace(target)
    finally:
        for new in aside:
            new.unlink(missing_ok=True)
