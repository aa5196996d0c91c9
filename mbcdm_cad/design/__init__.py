"""The design file: schema, catalogue, loader, and the resolved ``Drive`` that all other rooms read.

These are imported on first use, so that a process which only needs the dataclasses of
:mod:`mbcdm_cad.design.drive` does not pay for pydantic and yaml.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from mbcdm_cad.design.loaded import LoadedDesign
    from mbcdm_cad.design.loader import load_design, load_text

_MODULES = {"LoadedDesign": "loaded", "load_design": "loader", "load_text": "loader"}

__all__ = ["LoadedDesign", "load_design", "load_text"]


def __getattr__(name: str) -> Any:
    if name in _MODULES:
        from importlib import import_module

        return getattr(import_module(f"{__name__}.{_MODULES[name]}"), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
