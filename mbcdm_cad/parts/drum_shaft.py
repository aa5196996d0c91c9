"""The drum's hollow shaft with its flange and the spring that preloads its bearings; axles of guide and idlers.

An axle has a collar that carries the lower bearing's inner ring, and a spacer above it.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import cos, radians, sin
from typing import TYPE_CHECKING

from mbcdm_cad.parts.fits import FITS, Datum, GeometricTolerance
from mbcdm_cad.parts.milled import cut, stepped, turned, turned_about_y
from mbcdm_cad.parts.part import Gyration, MadePart, Ring, gyration, ring_mm3, rings_mm3, segment_mm2
from mbcdm_cad.parts.ring import Pin
from mbcdm_cad.parts.sheet import FitLine, Linear, Sheet, Vector, View, Y, minus
from mbcdm_cad.parts.sheet_blocks import ALONG_Y, ALONG_Z, MAIN

if TYPE_CHECKING:
    import cadquery as cq


# Depth of the flats for the hub's set screws: the burr of a screw then lies below the shaft's surface (estimate).
FLAT_DEPTH_MM = 0.3
# At 45 degrees, on every outer edge that is chamfered.
CHAMFER_MM = 0.3


@dataclass(frozen=True)
class DrumShaftDims:
    """Hollow shaft: flange behind the rear bearing, hub clamped in front, encoder at the back."""

    radius: float
    bore_radius: float
    y_start: float
    y_end: float
    flange_radius: float
    flange_start_y: float
    flange_end_y: float
    rear_bearing_y: float
    front_bearing_y: float
    flat_y: float  # middle of the two flats
    flat_length: float
    flat_angles_deg: tuple[float, float]  # directions in which the flats face, from +Z towards +X

    @property
    def flat(self) -> float:
        """From the axis to each flat."""
        return self.radius - FLAT_DEPTH_MM


@dataclass(frozen=True)
class PreloadSpringDims:
    """Wave spring that presses the two bearings apart, so that neither has play; bought, drawn as a plain ring."""

    inner_radius: float
    outer_radius: float
    height: float  # pressed to its force
    start_y: float
    force_N: float
    source: str


_FLATS = "flats"


def _facing(dims: DrumShaftDims, index: int) -> Vector:
    angle = radians(dims.flat_angles_deg[index])
    return (sin(angle), 0.0, cos(angle))


def _flat_view(dims: DrumShaftDims) -> View:
    """Square on the first flat, so that the second one, a right angle on, stands in the outline below."""
    axis = ((0.0, dims.y_start, 0.0), (0.0, dims.y_end, 0.0))
    return View(_FLATS, Y, minus(_facing(dims, 1)), row=-1, title="On a flat", axes=(axis,))


def _flats(dims: DrumShaftDims) -> tuple[Linear, ...]:
    """Where the flats stand along the shaft and what is left of its diameter there."""
    down = _facing(dims, 1)

    def point(out: float, y: float) -> Vector:
        return (down[0] * out, y, down[2] * out)

    low, high = dims.flat_y - dims.flat_length / 2, dims.flat_y + dims.flat_length / 2
    return (
        Linear(_FLATS, point(dims.flat, low), point(dims.flat, high), dims.flat_length, "below", "2x "),
        Linear(_FLATS, point(dims.flat, high), point(dims.radius, dims.y_end), dims.y_end - high, "below"),
        Linear(
            _FLATS,
            point(dims.flat, high),
            point(-dims.radius, high),
            dims.flat + dims.radius,
            "right",
            "2x ",
            " over flat",
        ),
    )


@dataclass(frozen=True)
class DrumShaft(MadePart):
    """Drum shaft where it stands in the assembly, axis Y."""

    dims: DrumShaftDims

    def solid(self) -> cq.Solid:
        """Drum shaft where it stands in the assembly, axis Y."""
        import cadquery as cq

        dims = self.dims
        r, bore = dims.radius, dims.bore_radius
        steps = (
            (r, dims.y_start, dims.flange_start_y),
            (dims.flange_radius, dims.flange_start_y, dims.flange_end_y),
            (r, dims.flange_end_y, dims.y_end),
        )
        profile = [(bore, dims.y_start), *stepped(steps, CHAMFER_MM), (bore, dims.y_end)]
        body = turned_about_y(profile, 0.0, 360.0, "drum shaft")
        box = cq.Solid.makeBox(2 * r, dims.flat_length, r, cq.Vector(-r, dims.flat_y - dims.flat_length / 2, dims.flat))
        origin, y = cq.Vector(0.0, 0.0, 0.0), cq.Vector(0.0, 1.0, 0.0)
        return cut(body, [box.rotate(origin, y, deg) for deg in dims.flat_angles_deg], "drum shaft")

    def in_rings(self) -> tuple[Ring, ...]:
        """Hollow shaft with its flange, without its flats."""
        d = self.dims
        flange = (d.flange_radius, d.radius, d.flange_start_y, d.flange_end_y)
        return ((d.radius, d.bore_radius, d.y_start, d.y_end), flange)

    def gyration(self) -> Gyration:
        """About Y."""
        return gyration(self.in_rings(), (0.0, 1.0, 0.0))

    def volume_mm3(self) -> float:
        """Hollow shaft with its flange."""
        return rings_mm3(self.in_rings()) - 2 * segment_mm2(self.dims.radius, self.dims.flat) * self.dims.flat_length

    def sheet(self, part: str) -> Sheet:
        """Section along the axis, and the side with the flats."""
        dims = self.dims
        low, high, r = dims.y_start, dims.y_end, dims.radius
        fit = FITS["drum_shaft"].code
        bore = (ALONG_Y.diameter(dims.bore_radius, high, "right"),) if dims.bore_radius > 0.0 else ()
        return Sheet(
            part=part,
            title="Drum shaft",
            views=(ALONG_Y.view(low, high, section=True), _flat_view(dims)),
            dimensions=(
                *bore,
                ALONG_Y.diameter(r, low + CHAMFER_MM, "left", fit=fit, count=2, datum="D"),
                ALONG_Y.diameter(dims.flange_radius, dims.flange_start_y, "left"),
                ALONG_Y.length(low, dims.flange_start_y, "below", (r, dims.flange_radius)),
                ALONG_Y.length(
                    dims.flange_start_y, dims.flange_end_y, "below", (dims.flange_radius, dims.flange_radius)
                ),
                ALONG_Y.length(low, high, "below", (r - CHAMFER_MM, r - CHAMFER_MM)),
                ALONG_Y.chamfer(CHAMFER_MM, r, high, -1.0, "above", count=2),
                *_flats(dims),
            ),
            tolerances=(ALONG_Y.square((r, dims.flange_radius), (dims.flange_end_y, dims.flange_start_y), 0.01, "D"),),
            fits=(FitLine(2 * r, fit, "bearings, encoder, hub"),),
            notes=("Outside ground, Ra 0.4.", "Flats for the hub's set screws at a right angle to each other."),
        )


# At 45 degrees, on both ends of the axle.


@dataclass(frozen=True)
class AxleDims:
    """Axle between two plates, of an idler or the guide, with a collar below the bearing and a spacer above."""

    radius: float
    bottom_z: float
    top_z: float
    collar_radius: float
    collar_bottom_z: float
    collar_top_z: float
    spacer_bottom_z: float
    spacer_top_z: float


@dataclass(frozen=True)
class Axle(MadePart):
    """Axle where it stands in the assembly, axis Z."""

    cut_in_sections = False

    dims: AxleDims
    title: str = "Guide axle"

    def solid(self) -> cq.Solid:
        """Axle where it stands in the assembly, axis Z."""
        d = self.dims
        steps = (
            (d.radius, d.bottom_z, d.collar_bottom_z),
            (d.collar_radius, d.collar_bottom_z, d.collar_top_z),
            (d.radius, d.collar_top_z, d.top_z),
        )
        return turned([(0.0, d.bottom_z), *stepped(steps, CHAMFER_MM), (0.0, d.top_z)], "axle")

    def volume_mm3(self) -> float:
        """Axle of an idler with its collar."""
        d = self.dims
        collar = ring_mm3(d.collar_radius, d.radius, d.collar_top_z - d.collar_bottom_z)
        return Pin(d.radius, d.top_z - d.bottom_z).volume_mm3() + collar

    def sheet(self, part: str) -> Sheet:
        """View from the side; the axle is solid, so it is not cut."""
        dims = self.dims
        low, high, r, collar = dims.bottom_z, dims.top_z, dims.radius, dims.collar_radius
        fit = FITS["idler_axle"].code
        return Sheet(
            part=part,
            title=self.title,
            views=(ALONG_Z.view(low, high, section=False),),
            dimensions=(
                ALONG_Z.diameter(r, low + CHAMFER_MM, "left", fit=fit, count=2, datum="D"),
                ALONG_Z.diameter(collar, dims.collar_top_z, "right"),
                ALONG_Z.length(low, dims.collar_bottom_z, "below", (r - CHAMFER_MM, collar)),
                ALONG_Z.length(dims.collar_bottom_z, dims.collar_top_z, "below", (collar, collar), decimals=3),
                ALONG_Z.length(low, high, "below", (r - CHAMFER_MM, r - CHAMFER_MM), decimals=3),
                ALONG_Z.chamfer(CHAMFER_MM, r, high, -1.0, "above", count=2),
            ),
            fits=(FitLine(2 * r, fit, "bearings, shelf, top plate"),),
            tolerances=(ALONG_Z.square((r, collar), (dims.collar_top_z, dims.collar_bottom_z), 0.01, "D"),),
            notes=("Bearing journals Ra 0.8.",),
        )


@dataclass(frozen=True)
class Spacer(MadePart):
    """Spacer above the upper bearing's inner ring, where it stands in the assembly, axis Z."""

    dims: AxleDims
    title: str = "Guide spacer"
    note: str = "Ground to the length that leaves the guide's bearings free of play."

    def solid(self) -> cq.Solid:
        """Spacer above the upper bearing's inner ring, where it stands in the assembly, axis Z."""
        dims = self.dims
        low, high = dims.spacer_bottom_z, dims.spacer_top_z
        return turned(
            [(dims.radius, low), (dims.collar_radius, low), (dims.collar_radius, high), (dims.radius, high)], "spacer"
        )

    def volume_mm3(self) -> float:
        """Spacer on an idler's axle."""
        d = self.dims
        return ring_mm3(d.collar_radius, d.radius, d.spacer_top_z - d.spacer_bottom_z)

    def sheet(self, part: str) -> Sheet:
        """Section along the axis."""
        dims = self.dims
        low, high = dims.spacer_bottom_z, dims.spacer_top_z
        fit, middle = FITS["spacer_bore"].code, (dims.radius + dims.collar_radius) / 2
        return Sheet(
            part=part,
            title=self.title,
            views=(ALONG_Z.view(low, high, section=True),),
            dimensions=(
                ALONG_Z.diameter(dims.radius, low, "left", fit=fit),
                ALONG_Z.diameter(dims.collar_radius, high, "right"),
                ALONG_Z.length(low, high, "below", (dims.collar_radius, dims.collar_radius), decimals=3),
            ),
            fits=(FitLine(2 * dims.radius, fit, "bore"),),
            datums=(Datum(MAIN, ALONG_Z.point(middle, low), "E"),),
            tolerances=(GeometricTolerance(MAIN, ALONG_Z.point(middle, high), "parallelism", 0.01, ("E",)),),
            notes=(self.note,),
        )
