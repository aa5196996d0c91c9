"""The analytic model: pure numpy, SI inside, from a :class:`~mbcdm_cad.design.drive.Drive` to its figures.

``analyse`` gives all figures of the report; functions for single questions are in the module named after the subject.
Modules that load slowly (time series, bulk, sensitivity, plots) are imported only where they are used.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from mbcdm_cad.model.analysis import analyse
    from mbcdm_cad.model.figures import (
        Analysis,
        BearingFigures,
        CableFigures,
        LoadCase,
        ModulusReading,
        UncertainFigure,
    )
    from mbcdm_cad.model.si import DriveSI, ModelError, to_si

_MODULES = {
    **dict.fromkeys(
        ("Analysis", "BearingFigures", "CableFigures", "LoadCase", "ModulusReading", "UncertainFigure"), "figures"
    ),
    **{"DriveSI": "si", "ModelError": "si", "analyse": "analysis", "to_si": "si"},
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
    """Import a name on first use: the checks need only a part of the model, and the start must be fast."""
    if name in _MODULES:
        from importlib import import_module

        return getattr(import_module(f"{__name__}.{_MODULES[name]}"), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
