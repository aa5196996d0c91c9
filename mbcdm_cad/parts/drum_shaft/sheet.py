"""Sheet of the drum's shaft."""

from __future__ import annotations

from mbcdm_cad.parts.drum_shaft.dims import CHAMFER_MM, DrumShaftDims
from mbcdm_cad.parts.fits import FITS
from mbcdm_cad.parts.sheets.description import FitLine, Sheet
from mbcdm_cad.parts.sheets.turned import ALONG_Y


def drum_shaft_sheet(part: str, dims: DrumShaftDims) -> Sheet:
    """Section along the axis where the shaft is bored, else the side view."""
    low, high, r = dims.y_start, dims.y_end, dims.radius
    fit = FITS["drum_shaft"].code
    bore = (ALONG_Y.diameter(dims.bore_radius, high, "right"),) if dims.bore_radius > 0.0 else ()
    return Sheet(
        part=part,
        title="Drum shaft",
        views=(ALONG_Y.view(low, high, section=dims.bore_radius > 0.0),),
        dimensions=(
            *bore,
            ALONG_Y.diameter(r, low + CHAMFER_MM, "left", fit=fit, count=2),
            ALONG_Y.diameter(dims.flange_radius, dims.flange_start_y, "left"),
            ALONG_Y.length(low, dims.flange_start_y, "below", (r, dims.flange_radius)),
            ALONG_Y.length(dims.flange_start_y, dims.flange_end_y, "below", (dims.flange_radius, dims.flange_radius)),
            ALONG_Y.length(low, high, "below", (r - CHAMFER_MM, r - CHAMFER_MM)),
            ALONG_Y.chamfer(CHAMFER_MM, r, high, -1.0, "above", count=2),
        ),
        fits=(FitLine(2 * r, fit, "bearings, encoder, hub"),),
        notes=(
            "Outside ground, Ra 0.4; flange square to the axis within 0.01.",
            "Two flats 0.3 deep for the hub's set screws at assembly, spotted through the hub.",
        ),
    )
