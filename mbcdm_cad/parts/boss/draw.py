"""A frame's boss: solids that are added to the frame, and the cutting tools of its bores."""

from __future__ import annotations

from typing import TYPE_CHECKING

from mbcdm_cad.parts.boss.dims import BossDims
from mbcdm_cad.parts.shapes import block, cylinder_y

if TYPE_CHECKING:
    import cadquery as cq


def boss_bodies(d: BossDims) -> list[cq.Solid]:
    """Cylinder in front of the encoder's pocket, and the ears beside it."""
    ears = block(
        (-d.ear_reach, d.ear_reach),
        (d.encoder_pocket_floor_y, d.ear_front_y),
        (-d.ear_half_height, d.ear_half_height),
    )
    return [cylinder_y(d.radius, 0.0, 0.0, d.encoder_pocket_floor_y, d.front_y), ears]


def boss_tools(d: BossDims) -> list[cq.Shape]:
    """Encoder's pocket from behind, seats and shoulder of the bearings, threads for the encoder's screws."""
    back, floor = d.back_y - 1.0, d.encoder_pocket_floor_y
    tools: list[cq.Shape] = [
        cylinder_y(d.encoder_pocket_radius, 0, 0, back, floor),
        cylinder_y(d.seat_radius, 0, 0, back, d.rear_seat_end_y),
        cylinder_y(d.shoulder_radius, 0, 0, d.rear_seat_end_y - 1.0, d.front_seat_start_y + 1.0),
        cylinder_y(d.seat_radius, 0, 0, d.front_seat_start_y, d.front_y + 1.0),
    ]
    for sign in (-1, 1):
        x = sign * d.screw_circle
        tools.append(cylinder_y(d.screw_radius, x, 0, floor - 1.0, floor + d.screw_depth))
    return tools
