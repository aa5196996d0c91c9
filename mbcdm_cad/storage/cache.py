"""The cache: earlier results by the hash of their inputs, in the user's cache folder, shared by all processes.

Equal inputs, code and versions have equal keys. The hash of the code is part of a key, so that a changed program does
not use results of the old one: all of the code, since what a result follows from is not known in advance.
"""

import hashlib
import json
import math
import os
import re
import sys
import time
from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import fields, is_dataclass
from functools import cache
from pathlib import Path, PurePath
from typing import Any

from mbcdm_cad.storage.folders import asides, is_left, versions, write_whole

_PACKAGE = __name__.partition(".")[0]
_ROOT = Path(__file__).parents[1]


def content_key(kind: str, data: Any, module: str = _PACKAGE) -> str:
    """SHA-256 (hex) that names what this program makes from ``data`` (plain data and dataclasses) as ``kind``.

    It depends on the program, with the folder of a ``module`` from elsewhere that makes it (:func:`code_hash`), and on
    the versions of the libraries that it uses. Raises as :func:`canonical_json` does.
    """
    text = canonical_json({"kind": kind, "data": data, "source": code_hash(module), "versions": versions()})
    return hashlib.sha256(text.encode("utf-8")).hexdigest()


def canonical_json(value: Any) -> str:
    """JSON text that is equal for equal values: keys sorted, floats to the last bit, dataclasses with their class.

    Raises ``TypeError`` for a value that is not plain data, ``ValueError`` for a number that is not finite.
    """
    return json.dumps(_plain(value), sort_keys=True, separators=(",", ":"), allow_nan=False)


def _plain(value: Any) -> Any:
    if value is None or isinstance(value, bool | int | float | str):
        return value
    if is_dataclass(value) and not isinstance(value, type):
        name = f"{type(value).__module__}.{type(value).__qualname__}"
        return {"class": name, "fields": {field.name: _plain(getattr(value, field.name)) for field in fields(value)}}
    if isinstance(value, Mapping):
        return {"pairs": sorted(([_plain(key), _plain(content)] for key, content in value.items()), key=json.dumps)}
    if isinstance(value, list | tuple):
        return [_plain(element) for element in value]
    if isinstance(value, PurePath):
        return {"path": value.as_posix()}
    if hasattr(value, "tolist"):  # an array or a number of numpy, without importing it
        return _plain(value.tolist())
    raise TypeError(f"{type(value).__name__} is not plain data and cannot be part of a key: {value!r:.80}")


def with_floats(value: Any, write: Callable[[float], Any]) -> Any:
    """Plain data, tuples and numpy's arrays as lists, with each float as ``write`` gives it."""
    if hasattr(value, "tolist"):  # an array or a number of numpy, without importing it
        value = value.tolist()
    if isinstance(value, Mapping):
        return {key: with_floats(item, write) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [with_floats(item, write) for item in value]
    return write(value) if isinstance(value, float) else value


def rounded(value: Any) -> Any:
    """Plain data with figures to nine significant digits; null for those that are not finite.

    Kernels of the linear algebra, which the processor chooses, differ by some 1e-12 (``OPENBLAS_CORETYPE``).
    """
    return with_floats(value, lambda number: float(f"{number:.9g}") if math.isfinite(number) else None)


@cache
def code_hash(module: str = _PACKAGE) -> str:
    """SHA-256 (hex) of every file of the program and its data: equal only if nothing of it has changed.

    A ``module`` of another package, as a layout from elsewhere has them, counts with its folder.
    """
    # This is part of every start, and would take half as long again with Path objects.
    files = [os.path.join(folder, name) for folder, _, names in os.walk(_ROOT) for name in names]
    outside = None if module.partition(".")[0] == _PACKAGE else getattr(sys.modules.get(module), "__file__", None)
    if outside:
        files += map(str, Path(outside).parent.iterdir())
    digest = hashlib.sha256()
    for file in sorted(name for name in files if name.endswith((".py", ".json", ".yaml", ".j2"))):
        with open(file, "rb") as content:
            sha256 = hashlib.sha256(content.read()).hexdigest()
        digest.update(f"{file.removeprefix(str(_ROOT))} {sha256}\n".encode())
    return digest.hexdigest()


ENVIRONMENT_VARIABLE = "MBCDM_CACHE_DIR"
DEFAULT_LIMIT_BYTES = 1 << 30
_MAGIC = b"mbcdm-cache-2\n"
_KEY = re.compile(r"[0-9a-f]{64}")


def cache_folder() -> Path:
    """``MBCDM_CACHE_DIR`` if set, else the system's cache folder of this user."""
    named = os.environ.get(ENVIRONMENT_VARIABLE)
    if named:
        return Path(named)
    import platformdirs  # only where the variable is not set

    return platformdirs.user_cache_path("mbcdm_cad")


class Cache:
    """Entries of named blobs by content key. ``Cache(None)`` is always empty and stores nothing.

    An entry is one file, written under a temporary name and then renamed, so that a reader never sees a part of one and
    processes need no lock. Every read is checked against the entry's own hash, of its key too; a broken entry, or one
    under another name, is removed and counts as absent. A cache that cannot be read or written, or that vanishes, never
    stops a build: ``problem`` then gives the reason in one sentence.
    """

    def __init__(self, folder: Path | None, limit_bytes: int = DEFAULT_LIMIT_BYTES) -> None:
        self._folder = folder
        self._limit_bytes = limit_bytes
        self.problem = ""

    def get(self, key: str) -> dict[str, bytes] | None:
        """The blobs under ``key`` by name; None where there are none."""
        if self._folder is None:
            return None
        path = self._path(key)
        blobs = self._read(path)
        if blobs is not None:
            with suppress(OSError):  # in a cache that may only be read
                os.utime(path)  # used now: evicted last
        return blobs

    def put(self, key: str, blobs: Mapping[str, bytes]) -> None:
        """Store the blobs under ``key``; beyond the limit of the cache the longest unused entries are removed."""
        if self._folder is None:
            return
        try:
            # An entry broken by a crash of the machine is found by its hash; waiting for the disk would take too long.
            write_whole({self._path(key): _packed(key, blobs)}, durable=False)
        except OSError as error:
            self._note(error)
        self.trim()

    def get_or_make(self, key: str, make: Callable[[], Mapping[str, bytes]]) -> dict[str, bytes]:
        """The blobs under ``key``, made and stored if there are none."""
        blobs = self.get(key)
        if blobs is None:
            blobs = dict(make())
            self.put(key, blobs)
        return blobs

    def trim(self) -> None:
        """Remove the longest unused entries until the cache is within its limit, and leftovers of dead processes."""
        now = time.time()
        entries = [(at if at <= now else 0.0, size, path) for at, size, path in self._entries()]
        excess = sum(size for _, size, _ in entries) - self._limit_bytes
        for _, size, path in sorted(entries):
            if excess <= 0:
                break
            self._remove(path)
            excess -= size

    def summary(self, *, verify: bool) -> tuple[int, int, int]:
        """Number of entries and of bytes; with ``verify`` all are read, and the third is how many were broken."""
        found = self._entries()
        broken = sum(self._read(path) is None for _, _, path in found) if verify else 0
        return len(found), sum(size for _, size, _ in found), broken

    def _entries(self) -> list[tuple[float, int, Path]]:
        """Time, bytes and file of each entry; leftovers of dead processes are removed."""
        found = list[tuple[float, int, Path]]()
        with suppress(OSError):  # what is gone: another process trims too, or somebody removes the cache
            for path in () if self._folder is None else self._folder.glob("*/*"):
                with suppress(OSError):
                    status = path.stat()
                    if _KEY.fullmatch(path.name):
                        found.append((status.st_mtime, status.st_size, path))
                    elif path.match(asides()) and is_left(path):
                        path.unlink()
        return found

    def _read(self, path: Path) -> dict[str, bytes] | None:
        """The blobs of one entry; None where there is none that is whole."""
        try:
            data = path.read_bytes()
        except FileNotFoundError:
            return None
        except OSError as error:
            self._note(error)
            return None
        blobs = _unpacked(path.name, data)
        if blobs is None:
            self._remove(path)
        return blobs

    def _path(self, key: str) -> Path:
        if not _KEY.fullmatch(key):
            raise ValueError(f"cache key must be 64 hexadecimal digits, got {key!r}")
        assert self._folder is not None
        return self._folder / key[:2] / key

    def _remove(self, path: Path) -> None:
        try:
            path.unlink(missing_ok=True)
        except OSError as error:
            self._note(error)

    def _note(self, error: OSError) -> None:
        self.problem = self.problem or f"cache {self._folder} is not usable: {error.strerror or error}"


def _packed(key: str, blobs: Mapping[str, bytes]) -> bytes:
    sizes = json.dumps([key, *([name, len(blob)] for name, blob in blobs.items())]).encode() + b"\n"
    body = sizes + b"".join(blobs.values())
    return _MAGIC + hashlib.sha256(body).digest() + body


def _unpacked(key: str, data: bytes) -> dict[str, bytes] | None:
    start = len(_MAGIC) + hashlib.sha256().digest_size
    body = data[start:]
    if data[: len(_MAGIC)] != _MAGIC or data[len(_MAGIC) : start] != hashlib.sha256(body).digest():
        return None
    header, _, rest = body.partition(b"\n")
    own, *sizes = json.loads(header)
    blobs: dict[str, bytes] = {}
    for name, size in sizes:
        blobs[name], rest = rest[:size], rest[size:]
    return blobs if own == key else None
