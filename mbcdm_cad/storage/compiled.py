"""Scalar loops compiled by numba where it is installed; the same functions run as plain Python where it is not.

numba keeps machine code on the disk and discards it when the file of the function itself changes, but not when a
function that it calls from another file changes. So the name of its folder contains the hash of all compiled sources.
numba takes longer to import than the whole of ``check``: only modules that are loaded for a time series import this.
"""

import hashlib
import shutil
import time
from collections.abc import Callable
from functools import cache
from importlib.util import find_spec
from pathlib import Path
from typing import Any, Literal, TypeVar, cast

Function = TypeVar("Function", bound=Callable[..., Any])
COMPILED = find_spec("numba") is not None
_ROOT = Path(__file__).parents[1]
_UNUSED_S = 86400.0


def compiled(function: Function, inline: Literal["never", "always"] = "never") -> Function:
    """The function compiled to machine code, cached on disk and free of the interpreter's lock; else itself."""
    if not COMPILED:
        return function
    import numba

    cast(Any, numba.config).CACHE_DIR = str(
        machine_code_folder()
    )  # where it cannot be written, numba finds another place
    return cast(Function, numba.njit(cache=True, error_model="numpy", nogil=True, inline=inline)(function))


def inlined(function: Function) -> Function:
    """As :func:`compiled`, its code put in place of each call: for a small function of arrays in an innermost loop."""
    return compiled(function, "always")


@cache
def machine_code_folder() -> Path:
    """Folder of the code compiled from the present sources. Folders of other sources are removed after a day."""
    digest = hashlib.sha256()
    for file in sorted(_ROOT.rglob("*.py")):
        content = file.read_bytes()
        if b"\n@compiled\n" in content:
            digest.update(hashlib.sha256(content).digest())
    folder = _ROOT / "__pycache__" / f"numba-{digest.hexdigest()[:16]}"
    for other in folder.parent.glob("numba-*"):
        if other != folder and time.time() - other.stat().st_mtime > _UNUSED_S:
            shutil.rmtree(other, ignore_errors=True)
    return folder
