"""Draw a part from its entry in the bill."""

from __future__ import annotations

from importlib import import_module
from typing import Any

import cadquery as cq


def make(maker: str, args: tuple[Any, ...]) -> cq.Solid:
    """Call ``module:function`` (the module's full name) with ``args``."""
    module, _, function = maker.partition(":")
    solid = getattr(import_module(module), function)(*args)
    assert isinstance(solid, cq.Solid), f"{maker} returned {type(solid).__name__}"
    return solid
