"""Files that are written completely or not at all, and manifest.json: files of a build, their input, versions used."""

from __future__ import annotations

import hashlib
import json
import os
import platform
import re
import secrets
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from functools import cache
from pathlib import Path

import mbcdm_cad
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


MANIFEST_NAME = "manifest.json"
_GENERATOR = "mbcdm_cad"
_FORMAT = 1


@dataclass(frozen=True)
class FileEntry:
    """One file of the output: its SHA-256 (hex) and size in bytes."""

    sha256: str
    size: int


@dataclass(frozen=True)
class Manifest:
    """The content of ``manifest.json`` without the versions.

    ``design_sha256`` is the hash of the design alone; ``inputs_sha256`` that of all inputs of the output (design,
    options, program, versions): with equal inputs and unchanged files there is nothing to build. ``failed_checks`` are
    the ids of the checks that fail; where there are any, ``forced`` is true.
    """

    design_sha256: str
    inputs_sha256: str
    forced: bool = False
    failed_checks: tuple[str, ...] = ()
    files: dict[str, FileEntry] = field(default_factory=dict)

    def text(self) -> str:
        """The file's text: sorted keys, no time."""
        content = {"generator": _GENERATOR, "format": _FORMAT, "versions": versions(), **asdict(self)}
        return json.dumps(content, indent=1, sort_keys=True) + "\n"


@cache
def versions() -> dict[str, str]:
    """Versions that the output depends on: this package, its libraries, Python. No import of them."""
    from importlib import metadata  # a tenth of the start of a command, and few ask

    return {
        "mbcdm_cad": mbcdm_cad.__version__,
        "cadquery": metadata.version("cadquery"),
        **{name: metadata.version(name) for name in ("cadquery-ocp", "ezdxf", "matplotlib", "numpy")},
        "python": platform.python_version(),
    }


def read_manifest(folder: Path) -> Manifest | None:
    """The manifest of an output folder; None if there is none, or if this program did not write it."""
    try:
        content = json.loads((folder / MANIFEST_NAME).read_text("utf-8"))
        if content["generator"] != _GENERATOR or content["format"] != _FORMAT:
            return None
        return Manifest(
            content["design_sha256"],
            content["inputs_sha256"],
            content["forced"],
            tuple(content["failed_checks"]),
            {name: FileEntry(**entry) for name, entry in content["files"].items()},
        )
    except (OSError, ValueError, KeyError, TypeError, AttributeError, RecursionError):
        return None


def file_entry(path: Path) -> FileEntry:
    """Hash and size of a file. Raises ``OSError`` if it cannot be read."""
    with path.open("rb") as stream:
        digest = hashlib.file_digest(stream, "sha256").hexdigest()
    return FileEntry(digest, path.stat().st_size)


def altered_files(folder: Path, manifest: Manifest) -> list[str]:
    """Names of the files that are missing or differ from the manifest, sorted."""

    def is_as_written(name: str, entry: FileEntry) -> bool:
        path = folder / name
        try:
            return path.stat().st_size == entry.size and file_entry(path) == entry
        except OSError:
            return False

    return sorted(name for name, entry in manifest.files.items() if not is_as_written(name, entry))
