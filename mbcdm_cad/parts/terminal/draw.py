"""Threaded terminal of a cable: swage with a bore and two flats, stud behind it. Axis Z, the cable comes from -Z."""

from __future__ import annotations

import cadquery as cq

from mbcdm_cad.parts.shapes import cut, turned
from mbcdm_cad.parts.terminal.dims import CHAMFER_MM


def create_terminal(
    swage_start: float,
    cable_end: float,
    swage_end: float,
    tip: float,
    swage_radius: float,
    flat: float,
    stud_radius: float,
    bore_radius: float,
) -> cq.Solid:
    """Terminal, slack, all mm; z = 0 where the cable leaves the drum's land, ``cable_end`` the bottom of its bore.

    The swage has flats at y = +-``flat``: one slides along the wall of its pocket and keeps the rope from twisting.
    """
    c = CHAMFER_MM
    body = turned(
        [
            (0.0, cable_end),
            (bore_radius, cable_end),
            (bore_radius, swage_start),
            (swage_radius - c, swage_start),
            (swage_radius, swage_start + c),
            (swage_radius, swage_end),
            (stud_radius, swage_end),
            (stud_radius, tip - c),
            (stud_radius - c, tip),
            (0.0, tip),
        ],
        "terminal",
    )
    length = swage_end - swage_start
    sides = [
        cq.Solid.makeBox(2.0 * swage_radius, swage_radius, length, cq.Vector(-swage_radius, y, swage_start))
        for y in (flat, -flat - swage_radius)
    ]
    return cut(body, sides, "terminal")
