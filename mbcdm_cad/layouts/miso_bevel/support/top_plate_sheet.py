"""Sheet of the top plate."""

from __future__ import annotations

from mbcdm_cad.layouts.miso_bevel.support.boxed_plate_sheet import boxed_plate_sheet
from mbcdm_cad.layouts.miso_bevel.support.dims import TopPlateDims
from mbcdm_cad.layouts.miso_bevel.support.plate_holes import mounting_holes
from mbcdm_cad.parts.fits import FITS
from mbcdm_cad.parts.sheets.description import CuttingLine, Linear, Radius, Sheet, View, X, Y, Z
from mbcdm_cad.parts.sheets.holes import THROUGH, Holes, hole_labels, hole_table, position_table


def _holes(d: TopPlateDims, head_radius: float, head_depth: float) -> tuple[Holes, ...]:
    low = d.levels.top_plate_bottom_z
    axle, screws, dowels = mounting_holes(d)
    encoder = tuple((x + s * d.encoder_circle_radius, d.input_y, low) for x in d.input_x for s in (-1, 1))
    return (
        axle,
        Holes(
            "B",
            2 * d.shoulder_radius,
            THROUGH,
            tuple((x, d.input_y, low) for x in d.input_x),
            "below",
            "bearing seats",
            counterbore=(2 * d.seat_radius, d.seat_depth, FITS["input_seat"].code),
        ),
        Holes(
            "C",
            2 * d.encoder_screw_clearance,
            THROUGH,
            encoder,
            "below",
            "encoder screws",
            counterbore=(2 * head_radius, head_depth, ""),
        ),
        screws,
        dowels,
    )


def top_plate_sheet(part: str, d: TopPlateDims, encoder_head_radius: float, encoder_head_depth: float) -> Sheet:
    """View from above with the trace of a section through the bearing seats; the holes as tables."""
    if d.box is not None:
        return boxed_plate_sheet(part, d, d.box)
    v = d.levels
    low, high, x, r = v.top_plate_bottom_z, v.top_plate_top_z, v.side_outer_x, d.corner_radius
    holes = _holes(d, encoder_head_radius, encoder_head_depth)
    marks = []
    for group in holes:
        reach = group.reach + 0.8
        for px, py, _ in group.places:
            marks += [
                ((px - reach, py, high), (px + reach, py, high)),
                ((px, py - reach, high), (px, py + reach, high)),
            ]
    top = View("top", right=X, up=Y, hidden=True, axes=tuple(marks))
    section = View(
        "section",
        right=X,
        up=Z,
        row=1,
        title="A-A",
        cut=(0.0, 0.0, 0.0),
        axes=tuple(((px, 0.0, low), (px, 0.0, high)) for px in (0.0, *d.input_x)),
    )
    corner = 0.5**0.5 * r
    return Sheet(
        part=part,
        title="Top plate",
        paper="A3",
        views=(section, top),
        dimensions=(
            Linear("section", (x, 0.0, low), (x, 0.0, high), high - low, "right"),
            Linear("top", (-x, v.back_y + r, high), (x, v.back_y + r, high), 2 * x, "below"),
            Linear("top", (-x, v.back_y + r, high), (0.0, 0.0, high), x, "below"),
            Linear("top", (x - r, v.back_y, high), (x - r, v.front_y, high), v.front_y - v.back_y, "right", decimals=3),
            Linear("top", (0.0, 0.0, high), (x - r, v.front_y, high), v.front_y, "right", decimals=3),
            Radius(
                "top", (r - x, v.front_y - r, high), (r - x - corner, v.front_y - r + corner, high), r, prefix="4x "
            ),
        ),
        labels=hole_labels(holes, "top"),
        cutting_lines=(CuttingLine("top", (-x - 4.0, 0.0, high), (x + 4.0, 0.0, high), "A", Y),),
        tables=(
            hole_table(holes),
            position_table(holes, (0, 1), "Positions from the axis of hole A"),
        ),
        holes=holes,
        fits=tuple(line for group in holes for line in group.fit_lines()),
        notes=(
            "Bearing seats Ra 0.8, their shoulders flat within 0.01 to the lower face.",
            "Faces Ra 1.6, parallel within 0.02.",
        ),
    )
