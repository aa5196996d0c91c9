"""Compile scalar loops with numba where it is installed; the same functions run as plain Python where it is not.

Only the time-series modules import this: numba takes longer to import than the whole of `check`.
"""

from __future__ import annotations

from collections.abc import Callable
from importlib.util import find_spec
from typing import Any, TypeVar, cast

Function = TypeVar("Function", bound=Callable[..., Any])
COMPILED = find_spec("numba") is not None


def compiled(function: Function) -> Function:
    """The function compiled to machine code and cached on disk, or itself (then some 40 times slower)."""
    if not COMPILED:
        return function
    import numba

    return cast(Function, numba.njit(cache=True, error_model="numpy")(function))
