"""Dimensions of the clamp collar that couples an input pulley to its gearhead.

Seen along the axis: the slit points to the right, the screw crosses it from top to bottom, its head on an open flat.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import hypot, sqrt
from typing import Protocol

from mbcdm_cad.design.bought import Gearhead, Screw

# Default screw: it holds the torque of gearheads of 16 mm.
COLLAR_SCREW = "M1.6x6"
COLLAR_SLIT_MM = 1.0
HEAD_PLAY_MM = 0.1
# Collar above and below its screw's head, and beyond a grip of one shaft's diameter.
HEAD_EDGE_MM = 0.2
# Collar over the heads of the gearhead's screws.
COLLAR_OVER_HEADS_MM = 0.8


class Coupled(Protocol):
    """The data of a drive from which its collars are dimensioned."""

    @property
    def gearhead(self) -> Gearhead:
        """The gearhead whose shaft is clamped."""

    def screw(self, name: str) -> Screw:
        """A screw of the catalogue."""


@dataclass(frozen=True)
class CollarDims:
    """Clamp collar that squeezes the slit journal onto the gearhead's shaft; one tangential screw."""

    bore_radius: float
    radius: float
    bottom_z: float
    top_z: float
    slit_width: float
    screw: str
    screw_offset: float
    head_seat: float  # along the screw, from the slit's middle to the head's seat


def _section(drive: Coupled, bore_mm: float, min_wall_mm: float, screw_name: str) -> tuple[float, float, float]:
    """Outer radius, screw's distance from the axis, and its seat's distance from the slit's middle."""
    screw = drive.screw(screw_name)
    bore, wall = bore_mm / 2, min_wall_mm
    offset = bore + wall + screw.clearance_mm / 2
    inner_edge = offset - screw.head_diameter_mm / 2 - HEAD_PLAY_MM
    # Below the flat a wall remains round the bore, and one beside the slit.
    seat = max(sqrt(max(0.0, (bore + wall) ** 2 - inner_edge**2)), COLLAR_SLIT_MM / 2 + 1.0)
    # The thread has a wall around it up to the screw's end.
    return hypot(offset + screw.thread_mm / 2 + wall, screw.length_mm - seat), offset, seat


def collar_width_mm(drive: Coupled, screw_name: str = COLLAR_SCREW) -> float:
    """Least width, mm, for the screw's head and a grip length of one shaft diameter.

    It is not larger, because in the coupling space the collar must pass over the end of the gearhead's shaft.
    """
    head, shaft = drive.screw(screw_name).head_diameter_mm, drive.gearhead.shaft_diameter_mm
    return max(head + 2 * HEAD_EDGE_MM, shaft + HEAD_EDGE_MM)


def collar_sweep_mm(drive: Coupled, bore_mm: float, min_wall_mm: float, screw_name: str = COLLAR_SCREW) -> float:
    """Radius that collar and screw sweep about the pulley's axis; ``bore_mm`` fits the journal that it clamps."""
    radius, offset, seat = _section(drive, bore_mm, min_wall_mm, screw_name)
    screw = drive.screw(screw_name)
    return max(radius, hypot(offset + screw.head_diameter_mm / 2, seat + screw.head_height_mm))


def collar_over_shelf_mm(drive: Coupled) -> float:
    """Height of the collar over the motor shelf: just above the heads of the gearhead's screws."""
    return drive.screw(drive.gearhead.screw).head_height_mm + COLLAR_OVER_HEADS_MM


def collar(drive: Coupled, bore_mm: float, min_wall_mm: float, screw_name: str, motor_shelf_top_z: float) -> CollarDims:
    """Collar about its own axis, heights as in the assembly: just above the gearhead's screws, whose heads lie on the
    motor shelf."""
    radius, offset, seat = _section(drive, bore_mm, min_wall_mm, screw_name)
    bottom = motor_shelf_top_z + collar_over_shelf_mm(drive)
    return CollarDims(
        bore_radius=bore_mm / 2,
        radius=radius,
        bottom_z=bottom,
        top_z=bottom + collar_width_mm(drive, screw_name),
        slit_width=COLLAR_SLIT_MM,
        screw=screw_name,
        screw_offset=offset,
        head_seat=seat,
    )
