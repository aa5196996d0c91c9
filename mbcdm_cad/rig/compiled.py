"""Array type and compiler of the rig's loops; importing it drops what was compiled from older sources of this room."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from mbcdm_cad.storage.compiled import compiled, drop_stale

__all__ = ["Floats", "compiled"]

Floats = NDArray[np.float64]

drop_stale(Path(__file__).parent)
