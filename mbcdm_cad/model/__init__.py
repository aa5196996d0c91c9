"""The analytic model: pure numpy, SI inside, a :class:`~mbcdm_cad.design.drive.Drive` in and figures out.

``analyse`` gives everything the report prints; the small functions stand in the modules named after their subject.
Slower matters (time series, bulk, sensitivity, plots) are imported from their modules only where they are used.
"""

from __future__ import annotations

from mbcdm_cad.model.analysis import analyse
from mbcdm_cad.model.errors import ModelError
from mbcdm_cad.model.figures import Analysis, BearingFigures, CableFigures, LoadCase, ModulusReading, UncertainFigure
from mbcdm_cad.model.si import DriveSI, to_si

__all__ = [
    "Analysis",
    "BearingFigures",
    "CableFigures",
    "DriveSI",
    "LoadCase",
    "ModelError",
    "ModulusReading",
    "UncertainFigure",
    "analyse",
    "to_si",
]
