"""The route of each cable through the drive: its wraps and spans, and the quantities computed from them.

A configuration describes its drive by :class:`~mbcdm_cad.routes.route.DriveRoutes`: the bodies that cables run on, one
:class:`~mbcdm_cad.routes.route.CableRoute` a cable, and a :class:`~mbcdm_cad.routes.route.Geometry` that gives
spans and wraps when a length of the design varies. Model, rig and loop work only on these.
"""

import numpy as np
from numpy.typing import NDArray

__all__ = ["Complex", "Floats"]

Floats = NDArray[np.float64]
Complex = NDArray[np.complex128]
