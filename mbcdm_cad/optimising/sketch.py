"""A design in space without CAD: the centre lines of its cables, and circles where they lie on drum and pulleys."""

from __future__ import annotations

from typing import Any

import numpy as np

from mbcdm_cad.design.drive import Drive
from mbcdm_cad.routes import Floats

# Points of a cable and of a circle, about: a page of a hundred designs stays below 2 MB.
_LINE, _CIRCLE = 90, 48


def sketch(drive: Drive) -> dict[str, Any]:
    """Lines by kind, each a list of points (x, y, z) in mm, drum centred: ``cables``, ``bodies``."""
    layout = drive.layout
    paths = layout.cable_paths(0.0)
    return {
        "cables": [_points(path.sample(max(path.length_mm / _LINE, 0.5))) for path in paths],
        "bodies": [_points(circle) for circle in _circles(drive)],
    }


def _circles(drive: Drive) -> list[Floats]:
    """One circle for each wrap of a cable, about the body's axis."""
    routes = drive.layout.loads.si.routes
    turn = np.linspace(0.0, 2.0 * np.pi, _CIRCLE + 1)[:, None]
    found = []
    for cable in routes.cables:
        for wrap in cable.wraps:
            body = routes.body(wrap.body)
            axis, first = np.array(body.axis), np.array(body.reference)
            middle = np.array(body.point_m) + wrap.height_m * axis
            around = np.cos(turn) * first + np.sin(turn) * np.cross(axis, first)
            found.append((middle + wrap.radius_m * around) * 1e3)
    return found


def _points(line: Floats) -> list[list[float]]:
    rounded: list[list[float]] = np.asarray(line).round(1).tolist()
    return rounded
