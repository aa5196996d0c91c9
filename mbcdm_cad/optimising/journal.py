"""The file of a search: what was asked, then one line for each evaluated point, in order, as JSON.

Lines are only added. A line that a kill cut off is removed when the search goes on.
"""

from __future__ import annotations

import json
import os
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from types import TracebackType
from typing import Any, Self

import filelock

from mbcdm_cad.errors import OutputError

Record = dict[str, Any]


@contextmanager
def sole_search(path: Path) -> Iterator[None]:
    """Hold the journal ``path`` for the block; raises ``OutputError`` if another process holds it."""
    lock = path.with_name(f".{path.name}.lock")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        with filelock.FileLock(lock, timeout=0):
            yield
    except filelock.Timeout:
        raise OutputError(f"{path}: another search is writing it; wait for it, or choose another --out") from None
    except OSError as error:
        raise OutputError(f"{path}: cannot write: {error.strerror or error}; choose another --out") from error


class Journal:
    """The records of one search, read from its file and added to it. ``request``: all that its results depend on."""

    def __init__(self, path: Path, request: Mapping[str, Any], *, resume: bool) -> None:
        """Open the file, or begin it.

        Raises ``OutputError`` if there is one and ``resume`` is not given, if it belongs to another search, or if the
        system refuses.
        """
        self.path = path
        self.records: list[Record] = []
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
            lines = path.read_bytes().splitlines(keepends=True) if path.exists() else []
            whole = [line for line in lines if line.endswith(b"\n")]
            if whole and not resume:
                raise OutputError(
                    f"{path}: there are {len(whole) - 1} evaluated points of a search before; add --resume to go on "
                    "with it, or remove the file to begin anew"
                )
            if whole:
                self._refuse_other(json.loads(whole[0]), request)
                self.records = [json.loads(line) for line in whole[1:]]
            # Without a buffer, so that what a call has written is with the system even if this process is killed.
            self._file = open(path, "ab", buffering=0)  # noqa: SIM115 - closed by __exit__
            self._file.truncate(sum(map(len, whole)))
            # Written with the first record: a request that turns out to be wrong begins no search.
            self._head: tuple[Record, ...] = () if whole else (dict(request),)
        except OSError as error:
            raise self._refused(error) from error
        except ValueError as error:
            raise OutputError(f"{path}: damaged ({error}); remove it and begin anew") from None

    def add(self, record: Record) -> None:
        """Add one record. Raises ``OutputError`` if the system refuses, such as for a full disk."""
        try:
            for content in (*self._head, record):
                self._write(content)
            self._head = ()
        except OSError as error:
            raise self._refused(error) from error
        self.records.append(record)

    def keep(self) -> None:
        """Have all records on the disk. Raises as :meth:`add`."""
        try:
            os.fsync(self._file.fileno())
        except OSError as error:
            raise self._refused(error) from error

    def _write(self, content: Record) -> None:
        line = json.dumps(content, separators=(",", ":"), allow_nan=False).encode() + b"\n"
        written = self._file.write(line)
        while written < len(line):  # a full disk takes a part, then refuses with a reason
            written += self._file.write(line[written:])

    def _refuse_other(self, before: Mapping[str, Any], request: Mapping[str, Any]) -> None:
        asked = json.loads(json.dumps(request))
        differ = [name for name in asked if before.get(name) != asked[name]]
        if differ:
            raise OutputError(
                f"{self.path}: belongs to a search with another {', '.join(differ)}; remove it, or choose another "
                "folder with --out"
            )

    def _refused(self, error: OSError) -> OutputError:
        return OutputError(
            f"{self.path}: cannot write: {error.strerror or error}; make room or rights, then go on with --resume"
        )

    def __enter__(self) -> Self:
        """The journal itself."""
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Close the file."""
        self._file.close()
