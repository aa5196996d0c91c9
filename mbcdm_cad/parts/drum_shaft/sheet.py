"""Sheet of the drum's shaft."""

from __future__ import annotations

from math import cos, radians, sin

from mbcdm_cad.parts.drum_shaft.dims import CHAMFER_MM, DrumShaftDims
from mbcdm_cad.parts.fits import FITS
from mbcdm_cad.parts.sheets.description import FitLine, Linear, Sheet, Vector, View, Y, minus
from mbcdm_cad.parts.sheets.turned import ALONG_Y

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


def drum_shaft_sheet(part: str, dims: DrumShaftDims) -> Sheet:
    """Section along the axis, and the side with the flats."""
    low, high, r = dims.y_start, dims.y_end, dims.radius
    fit = FITS["drum_shaft"].code
    bore = (ALONG_Y.diameter(dims.bore_radius, high, "right"),) if dims.bore_radius > 0.0 else ()
    return Sheet(
        part=part,
        title="Drum shaft",
        views=(ALONG_Y.view(low, high, section=True), _flat_view(dims)),
        dimensions=(
            *bore,
            ALONG_Y.diameter(r, low + CHAMFER_MM, "left", fit=fit, count=2),
            ALONG_Y.diameter(dims.flange_radius, dims.flange_start_y, "left"),
            ALONG_Y.length(low, dims.flange_start_y, "below", (r, dims.flange_radius)),
            ALONG_Y.length(dims.flange_start_y, dims.flange_end_y, "below", (dims.flange_radius, dims.flange_radius)),
            ALONG_Y.length(low, high, "below", (r - CHAMFER_MM, r - CHAMFER_MM)),
            ALONG_Y.chamfer(CHAMFER_MM, r, high, -1.0, "above", count=2),
            *_flats(dims),
        ),
        fits=(FitLine(2 * r, fit, "bearings, encoder, hub"),),
        notes=(
            "Outside ground, Ra 0.4; flange square to the axis within 0.01.",
            "Flats for the hub's set screws at a right angle to each other.",
        ),
    )
