"""Array type and compiler of the dynamic rig's scalar loops."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeVar, cast

import numba
import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Function = TypeVar("Function", bound=Callable[..., Any])


def compiled(function: Function) -> Function:
    """The function compiled to machine code, cached on disk."""
    return cast(Function, numba.njit(cache=True, error_model="numpy")(function))
