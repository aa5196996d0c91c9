"""Sheet of the clamp collar."""

from __future__ import annotations

from math import sqrt

from mbcdm_cad.parts.collar.dims import HEAD_PLAY_MM, CollarDims
from mbcdm_cad.parts.fits import FITS
from mbcdm_cad.parts.sheets.description import FitLine, Linear, Sheet, View, X, Y, Z, minus
from mbcdm_cad.parts.sheets.holes import Holes, hole_labels, hole_table
from mbcdm_cad.parts.sheets.words import mm
from mbcdm_cad.parts.threads import thread


def collar_sheet(part: str, d: CollarDims, screw_thread: float, screw_clearance: float, head_diameter: float) -> Sheet:
    """View along the axis, section through the bore, and a view onto the screw's seat."""
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
        "side", right=Z, up=Y, column=1, cut=(0.0, 0.0, 0.0), title="A-A", axes=(((0.0, 0.0, low), (0.0, 0.0, high)),)
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
        notes=(
            "Both holes on one axis, half way up the width.",
            "The flat is open towards the slit's side and over the whole width.",
            f"{thread(screw_thread).name} reaches through the lower half; slit sawn last, {mm(d.slit_width)} wide.",
        ),
    )
