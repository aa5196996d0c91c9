"""The volume that two bodies share, by a boolean of the kernel."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from OCP.BRepAlgoAPI import BRepAlgoAPI_Common
from OCP.BRepGProp import BRepGProp
from OCP.GProp import GProp_GProps

from mbcdm_cad.errors import GeometryError
from mbcdm_cad.parts.placement import Placement, Vector
from mbcdm_cad.parts.rod import swept_rod
from mbcdm_cad.routes.curves import Piece
from mbcdm_cad.workshop.kernel import Shape, kernel_shape, location


def common(first: Shape, second: Shape, placement: Placement) -> tuple[float, Vector]:
    """Volume (mm^3) that a solid shares with a second one moved by ``placement``, and the centre of that volume."""
    operation = BRepAlgoAPI_Common(kernel_shape(first), kernel_shape(second).Moved(location(placement)))
    properties = GProp_GProps()
    if not operation.IsDone() or operation.Shape().IsNull():
        return 0.0, (0.0, 0.0, 0.0)
    BRepGProp.VolumeProperties_s(operation.Shape(), properties)
    centre = properties.CentreOfMass()
    return properties.Mass(), (centre.X(), centre.Y(), centre.Z())


def rod(pieces: Sequence[Piece], radius_mm: float) -> Any:
    """The solid of a rod along ``pieces`` of a centre line. Raises ``GeometryError`` if the kernel cannot make it."""
    try:
        return swept_rod(pieces, radius_mm)
    except Exception as error:  # the kernel raises its own types, with texts such as StdFail_NotDone
        x, y, z = pieces[0].points(np.array([0.0]))[0]
        raise GeometryError(
            f"the stretch of a cable that begins at ({x:.2f}, {y:.2f}, {z:.2f}) mm cannot be drawn as a rod"
        ) from error
