"""The analytic model: pure numpy, SI inside, a :class:`~mbcdm_cad.design.drive.Drive` in and figures out.

``analyse`` gives everything the report prints; the small functions stand in the modules named after their subject.
Slower matters (time series, bulk, sensitivity, plots) are imported from their modules only where they are used.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from mbcdm_cad.model.analysis import analyse
    from mbcdm_cad.model.errors import ModelError
    from mbcdm_cad.model.figures import (
        Analysis,
        BearingFigures,
        CableFigures,
        LoadCase,
        ModulusReading,
        UncertainFigure,
    )
    from mbcdm_cad.model.si import DriveSI, to_si

_MODULES = {
    **dict.fromkeys(
        ("Analysis", "BearingFigures", "CableFigures", "LoadCase", "ModulusReading", "UncertainFigure"), "figures"
    ),
    **{"DriveSI": "si", "ModelError": "errors", "analyse": "analysis", "to_si": "si"},
}

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


def __getattr__(name: str) -> Any:
    """Imported on first use: the checks need a part of the model only, and every start counts."""
    if name in _MODULES:
        from importlib import import_module

        return getattr(import_module(f"{__name__}.{_MODULES[name]}"), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
