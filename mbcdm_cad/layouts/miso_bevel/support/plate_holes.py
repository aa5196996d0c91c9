"""Holes that the top plate has on either side of the motors, as its sheets show them."""

from __future__ import annotations

from mbcdm_cad.layouts.miso_bevel.support.dims import TopPlateDims
from mbcdm_cad.parts.fits import FITS
from mbcdm_cad.parts.sheets.holes import THROUGH, Holes


def mounting_holes(d: TopPlateDims) -> tuple[Holes, Holes, Holes]:
    """Holes A for the guide's axle, D for the screws and E for the dowels, drilled along Z from the top."""
    high = d.levels.top_plate_top_z
    return (
        Holes("A", 2 * d.axle_radius, THROUGH, ((0.0, 0.0, high),), "top", "guide axle", fit=FITS["axle_bore"].code),
        Holes(
            "D",
            2 * d.screw_clearance,
            THROUGH,
            tuple((x, y, high) for x, y in d.screws),
            "top",
            "screws",
            counterbore=(2 * d.screw_head_radius, d.screw_head_depth, ""),
        ),
        Holes(
            "E",
            2 * d.dowel_radius,
            THROUGH,
            tuple((x, y, high) for x, y in d.dowels),
            "top",
            "dowels",
            fit=FITS["pin_slide"].code,
        ),
    )
