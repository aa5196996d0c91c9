"""The drum's hollow shaft with the flange that holds it in its bearings, and the spring that preloads these."""

from __future__ import annotations

from dataclasses import dataclass
from math import cos, radians, sin
from typing import TYPE_CHECKING

from mbcdm_cad.parts.fits import FITS
from mbcdm_cad.parts.part import MadePart
from mbcdm_cad.parts.shapes import cut, stepped, turned_about_y
from mbcdm_cad.parts.sheets.description import FitLine, Linear, Sheet, Vector, View, Y, minus
from mbcdm_cad.parts.sheets.turned import ALONG_Y
from mbcdm_cad.parts.volume import Gyration, Ring, gyration, rings_mm3, segment_mm2

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
