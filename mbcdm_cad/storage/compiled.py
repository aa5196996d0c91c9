"""Scalar loops compiled by numba where it is installed; the same functions run as plain Python where it is not.

numba keeps compiled code beside the sources and drops it when the file of the function itself changes, but not when a
function that it calls from another file does. So each room that compiles calls :func:`drop_stale` on its folder.
numba takes longer to import than the whole of ``check``: only modules that are loaded for a time series import this.
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable
from contextlib import suppress
from importlib.util import find_spec
from pathlib import Path
from typing import Any, TypeVar, cast

Function = TypeVar("Function", bound=Callable[..., Any])
COMPILED = find_spec("numba") is not None
_STAMP = "sources.stamp"


def compiled(function: Function) -> Function:
    """The function compiled to machine code, cached on disk and free of the interpreter's lock; else itself."""
    if not COMPILED:
        return function
    import numba

    return cast(Function, numba.njit(cache=True, error_model="numpy", nogil=True)(function))


def drop_stale(folder: Path) -> bool:
    """Drop compiled code in and below ``folder`` if its sources are not those of the last time; whether that was so.

    Where the folder cannot be written nothing is dropped; numba keeps its code elsewhere then.
    """
    stats = [(str(path.relative_to(folder)), path.stat()) for path in sorted(folder.rglob("*.py"))]
    now = hashlib.sha256(repr([(name, s.st_size, s.st_mtime_ns) for name, s in stats]).encode()).hexdigest()
    cache = folder / "__pycache__"
    stamp = cache / _STAMP
    with suppress(OSError):
        if stamp.is_file() and stamp.read_text() == now:
            return False
        cache.mkdir(exist_ok=True)
        for path in [*folder.rglob("__pycache__/*.nbi"), *folder.rglob("__pycache__/*.nbc")]:
            path.unlink(missing_ok=True)
        stamp.write_text(now)
        return True
    return False
