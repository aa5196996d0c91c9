"""A cable's path without a gap or a kink between its pieces."""

from __future__ import annotations

from typing import Any

import numpy as np


def assert_joined(path: Any) -> None:
    """Each piece of a cable's path begins where the one before ends, in its direction."""
    for (one, before), (two, after) in zip(path.pieces[:-1], path.pieces[1:], strict=True):
        gap = np.abs(before.points(np.array([1.0])) - after.points(np.array([0.0]))).max()
        kink = np.abs(before.tangent(1.0) - after.tangent(0.0)).max()
        assert gap < 1e-9 and kink < 1e-9, f"{path.cable.name}, {one} to {two}: {gap} mm, {kink}"
