"""manifest.json: the files of a build, their input and the versions used. The same build gives the same text."""

from __future__ import annotations

import hashlib
import json
import platform
from dataclasses import asdict, dataclass, field
from importlib import metadata
from pathlib import Path

import mbcdm_cad

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


def versions() -> dict[str, str]:
    """Versions that the output depends on: this package, the CAD library, its kernel, Python. No import of them."""
    return {
        "mbcdm_cad": mbcdm_cad.__version__,
        "cadquery": metadata.version("cadquery"),
        "cadquery-ocp": metadata.version("cadquery-ocp"),
        "numpy": metadata.version("numpy"),
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
