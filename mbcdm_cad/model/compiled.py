"""Compiler of the model's scalar loops; importing it drops what was compiled from older sources of this room."""

from __future__ import annotations

from pathlib import Path

from mbcdm_cad.storage.compiled import COMPILED, compiled, drop_stale

__all__ = ["COMPILED", "compiled"]

drop_stale(Path(__file__).parent)
