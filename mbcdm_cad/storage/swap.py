"""Replace one folder by another, in one step if the system can do it."""

from __future__ import annotations

import ctypes
import errno
import os
import shutil
from pathlib import Path

_AT_FDCWD = -100
_RENAME_EXCHANGE = 2
_NOT_OFFERED = {errno.ENOSYS, errno.EINVAL, errno.ENOTSUP, errno.EPERM}


def replace_folder(new: Path, target: Path, old: Path) -> None:
    """Replace ``target`` by ``new``, and remove the old one. All three lie in one parent folder.

    On Linux the two are exchanged in one step of the file system. Elsewhere the target is first moved to ``old``; if
    the process dies before the second rename, :func:`recover` puts it back.
    """
    if not target.exists():
        new.rename(target)
    elif _exchange(new, target):
        shutil.rmtree(new, ignore_errors=True)
    else:
        target.rename(old)
        new.rename(target)
        shutil.rmtree(old, ignore_errors=True)


def recover(target: Path, old: Path) -> None:
    """Finish or undo a :func:`replace_folder` that died between its two renames."""
    if old.exists():
        if target.exists():
            shutil.rmtree(old, ignore_errors=True)
        else:
            old.rename(target)


def _exchange(first: Path, second: Path) -> bool:
    """Exchange two folders in one step; False if the system or the file system cannot do it."""
    renameat2 = getattr(ctypes.CDLL(None, use_errno=True), "renameat2", None) if os.name == "posix" else None
    if renameat2 is None:
        return False
    if renameat2(_AT_FDCWD, os.fsencode(first), _AT_FDCWD, os.fsencode(second), _RENAME_EXCHANGE) == 0:
        return True
    number = ctypes.get_errno()
    if number in _NOT_OFFERED:
        return False
    raise OSError(number, os.strerror(number), str(first), None, str(second))
