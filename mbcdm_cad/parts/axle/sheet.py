"""Sheets of the guide's axle and spacer, turned parts without a milled face."""

from __future__ import annotations

from mbcdm_cad.parts.axle.dims import CHAMFER_MM, AxleDims
from mbcdm_cad.parts.fits import FITS
from mbcdm_cad.parts.sheets.description import FitLine, Sheet
from mbcdm_cad.parts.sheets.turned import ALONG_Z


def axle_sheet(part: str, dims: AxleDims) -> Sheet:
    """View from the side; the axle is solid, so it is not cut."""
    low, high, r, collar = dims.bottom_z, dims.top_z, dims.radius, dims.collar_radius
    fit = FITS["idler_axle"].code
    return Sheet(
        part=part,
        title="Guide axle",
        views=(ALONG_Z.view(low, high, section=False),),
        dimensions=(
            ALONG_Z.diameter(r, low + CHAMFER_MM, "left", fit=fit, count=2),
            ALONG_Z.diameter(collar, dims.collar_top_z, "right"),
            ALONG_Z.length(low, dims.collar_bottom_z, "below", (r - CHAMFER_MM, collar)),
            ALONG_Z.length(dims.collar_bottom_z, dims.collar_top_z, "below", (collar, collar), decimals=3),
            ALONG_Z.length(low, high, "below", (r - CHAMFER_MM, r - CHAMFER_MM), decimals=3),
            ALONG_Z.chamfer(CHAMFER_MM, r, high, -1.0, "above", count=2),
        ),
        fits=(FitLine(2 * r, fit, "bearings, shelf, top plate"),),
        notes=("Bearing journals Ra 0.8; shoulders square to the axis within 0.01.",),
    )


def spacer_sheet(part: str, dims: AxleDims) -> Sheet:
    """Section along the axis."""
    low, high = dims.spacer_bottom_z, dims.spacer_top_z
    fit = FITS["spacer_bore"].code
    return Sheet(
        part=part,
        title="Guide spacer",
        views=(ALONG_Z.view(low, high, section=True),),
        dimensions=(
            ALONG_Z.diameter(dims.radius, low, "left", fit=fit),
            ALONG_Z.diameter(dims.collar_radius, high, "right"),
            ALONG_Z.length(low, high, "below", (dims.collar_radius, dims.collar_radius), decimals=3),
        ),
        fits=(FitLine(2 * dims.radius, fit, "bore"),),
        notes=("End faces parallel within 0.01, ground to the length that leaves the guide's bearings free of play.",),
    )
