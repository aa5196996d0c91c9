"""Array type and compiler of the rig's loops; importing it drops what was compiled from older sources of this room."""

from __future__ import annotations

from pathlib import Path

from mbcdm_cad.routes import Floats
from mbcdm_cad.storage.compiled import compiled, drop_stale

__all__ = ["Floats", "compiled"]

drop_stale(Path(__file__).parent)
