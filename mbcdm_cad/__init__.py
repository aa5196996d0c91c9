"""Design of cable drives from one file: checks, parts, report, model, test rig, and the loop with measured data.

The names for scripts and notebooks are those of :mod:`mbcdm_cad.api`: ``import mbcdm_cad as mc; mc.load(...)``.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from mbcdm_cad.api import *  # noqa: F403

__version__ = "0.1.0"


def __getattr__(name: str) -> Any:
    """Names of the API, imported when they are first used: the command line needs none of them."""
    api = import_module("mbcdm_cad.api")
    if name in api.__all__:
        return getattr(api, name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted([*globals(), *import_module("mbcdm_cad.api").__all__])
