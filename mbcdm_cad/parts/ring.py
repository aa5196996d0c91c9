"""Plain round rings and pins: swaged stops, nuts, pins. Axis Z from z = 0."""

from __future__ import annotations

import cadquery as cq

from mbcdm_cad.parts.shapes import cut, cylinder_z, hexagon_z, turned


def create_sleeve(bore_radius: float, radius: float, length: float) -> cq.Solid:
    """Sleeve: the stop swaged on a cable's end."""
    return turned([(bore_radius, 0.0), (radius, 0.0), (radius, length), (bore_radius, length)], "sleeve")


def create_nut(across_flats: float, height: float, thread: float) -> cq.Solid:
    """Hexagon nut; the thread is a plain bore at the nominal diameter."""
    return cut(hexagon_z(across_flats, 0.0, height), [cylinder_z(thread / 2, 0, 0, -1.0, height + 1.0)], "nut")


def create_pin(radius: float, length: float) -> cq.Solid:
    """Dowel pin with chamfered ends."""
    c = min(0.3, radius / 3)
    return turned(
        [(0.0, 0.0), (radius - c, 0.0), (radius, c), (radius, length - c), (radius - c, length), (0.0, length)], "pin"
    )
