"""Clamp collar that couples an input pulley to its gearhead: slit on one side, one tangential screw.

Seen along the axis: the slit points to the right, the screw crosses it from top to bottom, its head on an open flat.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import hypot, pi, sqrt
from typing import TYPE_CHECKING, Protocol

import numpy as np

from mbcdm_cad.design.bought import Gearhead, Screw
from mbcdm_cad.parts.fits import FITS
from mbcdm_cad.parts.milled import block, cut, cylinder, turned
from mbcdm_cad.parts.part import MadePart, Ring, rings_mm3
from mbcdm_cad.parts.sheet import CuttingLine, FitLine, Holes, Linear, Sheet, View, X, Y, Z, minus, mm
from mbcdm_cad.parts.sheet_blocks import hole_labels, hole_table
from mbcdm_cad.parts.threads import thread

if TYPE_CHECKING:
    import cadquery as cq

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


@dataclass(frozen=True)
class Collar(MadePart):
    """Collar about its own axis, heights as in the assembly; slit towards +X, screw along Y with its head at +Y.

    Diameters in mm: of the screw's thread, which the drill for tapping may replace, clearance hole and head.
    """

    dims: CollarDims
    screw_thread: float
    screw_clearance: float
    head_diameter: float

    def solid(self) -> cq.Solid:
        """Collar about its own axis, heights as in the assembly; slit towards +X, screw along Y with its head at +Y."""
        dims = self.dims
        screw_thread, screw_clearance, head_diameter = self.screw_thread, self.screw_clearance, self.head_diameter
        ring = turned(
            [
                (dims.bore_radius, dims.bottom_z),
                (dims.radius, dims.bottom_z),
                (dims.radius, dims.top_z),
                (dims.bore_radius, dims.top_z),
            ],
            "collar",
        )
        z = (dims.bottom_z + dims.top_z) / 2
        x, reach = dims.screw_offset, dims.radius + 1.0
        slit = block((0.0, reach), (-dims.slit_width / 2, dims.slit_width / 2), (dims.bottom_z - 1, dims.top_z + 1))
        return cut(
            ring,
            [
                slit,
                cylinder(screw_clearance / 2, (x, 0.0, z), (0, 1, 0), reach),
                cylinder(screw_thread / 2, (x, 0.0, z), (0, -1, 0), reach),
                # An open flat, because a counterbore would leave walls of only a quarter of a millimetre.
                block(
                    (x - head_diameter / 2 - HEAD_PLAY_MM, reach),
                    (dims.head_seat, reach),
                    (dims.bottom_z - 1, dims.top_z + 1),
                ),
            ],
            "collar",
        )

    def in_rings(self) -> tuple[Ring, ...]:
        """Its ring, whole."""
        return ((self.dims.radius, self.dims.bore_radius, self.dims.bottom_z, self.dims.top_z),)

    def volume_mm3(self) -> float:
        """Clamp collar: ring less slit, screw and the flat of the screw's head."""
        d = self.dims
        screw_thread, screw_clearance, head_diameter = self.screw_thread, self.screw_clearance, self.head_diameter
        width = d.top_z - d.bottom_z
        slit = d.slit_width * (d.radius - d.bore_radius) * width
        hole = (
            pi
            / 4
            * (screw_clearance**2 * d.head_seat + screw_thread**2 * sqrt(max(d.radius**2 - d.screw_offset**2, 0)))
        )
        edge = d.screw_offset - head_diameter / 2 - HEAD_PLAY_MM
        x = np.linspace(edge, d.radius, 101)
        flat = float(np.maximum(np.sqrt(np.maximum(d.radius**2 - x**2, 0.0)) - d.head_seat, 0.0).mean()) * (
            d.radius - edge
        )
        return rings_mm3(self.in_rings()) - slit - hole - max(flat, 0.0) * width

    def sheet(self, part: str) -> Sheet:
        """View along the axis, section through the bore, and a view onto the screw's seat."""
        d = self.dims
        screw_thread, screw_clearance, head_diameter = self.screw_thread, self.screw_clearance, self.head_diameter
        low, high, r = d.bottom_z, d.top_z, d.radius
        z, flat = (low + high) / 2, d.screw_offset - head_diameter / 2 - HEAD_PLAY_MM
        half = d.slit_width / 2
        fit = FITS["collar_bore"].code
        # The screw's two holes end at the slit; they break out of the ring below.
        seat = (d.screw_offset, d.head_seat, z)
        above = Holes("S", screw_clearance, "to slit", (seat,), "seat", "clamp screw")
        below = Holes("T", screw_thread, "through", ((d.screw_offset, -half, z),), "slit", "clamp screw", threaded=True)
        end = View(
            "end",
            right=X,
            up=Y,
            hidden=True,
            axes=(
                ((-r, 0.0, high), (r, 0.0, high)),
                ((0.0, -r, high), (0.0, r, high)),
                ((d.screw_offset, -sqrt(r**2 - d.screw_offset**2), z), (d.screw_offset, d.head_seat, z)),
            ),
        )
        side = View(
            "side",
            right=Z,
            up=Y,
            column=1,
            cut=(0.0, 0.0, 0.0),
            title="A-A",
            axes=(((0.0, 0.0, low), (0.0, 0.0, high)),),
        )
        top = View(
            "top",
            right=X,
            up=minus(Z),
            row=-1,
            axes=(
                ((0.0, 0.0, low), (0.0, 0.0, high)),
                ((d.screw_offset, 0.0, low), (d.screw_offset, 0.0, high)),
                ((d.screw_offset - head_diameter / 2, 0.0, z), (d.screw_offset + head_diameter / 2, 0.0, z)),
            ),
        )
        edge = sqrt(r**2 - half**2)
        corner = sqrt(max(r**2 - d.head_seat**2, 0.0))
        return Sheet(
            part=part,
            title="Clamp collar",
            views=(end, side, top),
            dimensions=(
                Linear("end", (0.0, -r, high), (0.0, r, high), 2 * r, "left", "%%c"),
                Linear("end", (edge, -half, high), (edge, half, high), d.slit_width, "right"),
                Linear("end", (0.0, 0.0, high), (corner, d.head_seat, high), d.head_seat, "right", decimals=3),
                Linear("end", (0.0, 0.0, high), (d.screw_offset, -r / 2, z), d.screw_offset, "below"),
                Linear("end", (0.0, r, high), (flat, d.head_seat, high), flat, "above"),
                Linear(
                    "side",
                    (0.0, -d.bore_radius, high),
                    (0.0, d.bore_radius, high),
                    2 * d.bore_radius,
                    "right",
                    "%%c",
                    fit=fit,
                ),
                Linear("side", (0.0, -r, low), (0.0, -r, high), high - low, "below"),
            ),
            labels=hole_labels((above,), "top"),
            tables=(hole_table((above, below)),),
            holes=(above, below),
            fits=(FitLine(2 * d.bore_radius, fit, "bore"),),
            cutting_lines=(CuttingLine("end", (0.0, -r, high), (0.0, r, high), "A", X),),
            notes=(
                "Both holes on one axis, half way up the width.",
                "The flat is open towards the slit's side and over the whole width.",
                f"{thread(screw_thread).name} reaches through the lower half; slit sawn last, {mm(d.slit_width)} wide.",
            ),
        )
