"""One build at a time into a folder, by a lock file that is gone when the last of them is done."""

from __future__ import annotations

import os
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

_POLL_S = 0.05


@contextmanager
def folder_lock(path: Path, timeout_s: float) -> Iterator[None]:
    """Hold the lock file ``path`` for the block; the system lets go of it when a process dies.

    Raises ``TimeoutError`` if another process holds it for longer than ``timeout_s``, ``OSError`` if it cannot be made.
    """
    if os.name != "posix":
        # Elsewhere a file that somebody has open cannot be removed: it stays.
        import filelock

        lock = filelock.FileLock(path, timeout=timeout_s)
        try:
            lock.acquire()
        except filelock.Timeout:
            raise TimeoutError from None
        try:
            yield
        finally:
            lock.release()
        return
    descriptor = _held(path, time.monotonic() + timeout_s)
    try:
        yield
    finally:
        # Removed while it is held: who waits for it sees that its file is no longer the one of that name.
        path.unlink(missing_ok=True)
        os.close(descriptor)


def _held(path: Path, until_s: float) -> int:
    """Descriptor of the locked file that stands under ``path``."""
    import fcntl

    while True:
        descriptor = os.open(path, os.O_RDWR | os.O_CREAT, 0o666)
        try:
            fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
            if _is_at(descriptor, path):
                return descriptor
        except BlockingIOError:
            if time.monotonic() >= until_s:
                os.close(descriptor)
                raise TimeoutError from None
            time.sleep(_POLL_S)
        except OSError:
            os.close(descriptor)
            raise
        os.close(descriptor)


def _is_at(descriptor: int, path: Path) -> bool:
    try:
        return os.path.samestat(os.fstat(descriptor), os.stat(path))
    except FileNotFoundError:
        return False
