"""Write a file completely or not at all: under a temporary name, then renamed."""

from __future__ import annotations

import os
import re
import secrets
from collections.abc import Mapping
from pathlib import Path

from mbcdm_cad.errors import InputError, Problem


def aside(target: Path) -> Path:
    """An unused path beside ``target``, for a file or folder that will replace it."""
    return target.with_name(f".{target.name}.new-{secrets.token_hex(8)}")


def is_aside(path: Path, target: Path | None = None) -> bool:
    """Whether ``path`` has a name that :func:`aside` gives, for ``target`` if that is given."""
    name = ".*" if target is None else re.escape(target.name)
    return re.fullmatch(rf"\.{name}\.new-[0-9a-f]{{16}}", path.name) is not None


def refuse_missing_folder(path: Path) -> None:
    """Raise ``InputError`` if the folder into which ``path`` is written does not exist."""
    if not path.parent.is_dir():
        what = f"there is no folder {path.parent}"
        raise InputError([Problem(str(path), 1, "", what, remedy="make it first, or choose another path")])


def write_whole(files: Mapping[Path, bytes], *, durable: bool = True) -> None:
    """Write all files; none is replaced before all are on the disk. Raises OSError that names the file concerned.

    Missing folders are made. With ``durable`` the content is on the disk before a file gets its name, so that even
    after a crash of the machine the old or the new file exists completely; without, this holds only for a crash of the
    program.
    """
    written: dict[Path, Path] = {}
    try:
        for target, content in files.items():
            new = aside(target)
            try:
                target.parent.mkdir(parents=True, exist_ok=True)
                if target.is_dir():
                    raise IsADirectoryError(21, "is a folder", str(target))
                with open(new, "xb") as file:
                    written[new] = target
                    file.write(content)
                    if durable:
                        file.flush()
                        os.fsync(file.fileno())
            except OSError as error:
                raise OSError(error.errno, error.strerror, str(target)) from error
        for new, target in written.items():
            new.replace(target)
    finally:
        for new in written:
            new.unlink(missing_ok=True)
