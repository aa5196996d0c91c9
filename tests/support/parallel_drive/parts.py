"""The parts of the parallel drive: a cylinder and a box."""

from __future__ import annotations

import cadquery as cq


def create_cylinder(radius: float, half_width: float) -> cq.Solid:
    """Cylinder along Y about the middle."""
    return cq.Solid.makeCylinder(radius, 2 * half_width, cq.Vector(0, -half_width, 0), cq.Vector(0, 1, 0))


def create_base(length: float, thickness: float, width: float) -> cq.Solid:
    """Box below y = 0."""
    return cq.Solid.makeBox(length, thickness, width, cq.Vector(-length / 2, -thickness, -width / 2))
