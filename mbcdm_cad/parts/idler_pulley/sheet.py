"""Sheet of the guide pulley."""

from __future__ import annotations

from itertools import pairwise

from mbcdm_cad.parts.fits import FITS
from mbcdm_cad.parts.idler_pulley.dims import IdlerDims
from mbcdm_cad.parts.sheets.description import FitLine, Label, Sheet, Table
from mbcdm_cad.parts.sheets.turned import ALONG_Z, MAIN
from mbcdm_cad.parts.sheets.words import mm, mm3


def idler_pulley_sheet(part: str, dims: IdlerDims) -> Sheet:
    """Section along the axis; the steps as a table from end A, the lower end."""
    low, high = dims.bottom_z, dims.top_z
    levels = (low, *dims.walls_z, high)
    seat, land = FITS["idler_seat"].code, FITS["land"].code
    largest = max(dims.surface_radii)
    dimensions = (
        ALONG_Z.diameter(dims.seat_radius, low, "left", fit=seat, count=2),
        ALONG_Z.diameter(dims.shoulder_radius, high - dims.seat_depth, "right"),
        ALONG_Z.length(low, low + dims.seat_depth, "below", (dims.surface_radii[0], dims.seat_radius), count=2),
        ALONG_Z.length(low, high, "below", (dims.surface_radii[0], dims.surface_radii[-1]), decimals=3),
    )
    labels = tuple(
        Label(MAIN, ALONG_Z.point(radius, (a + b) / 2), str(n), leader=True)
        for n, (radius, (a, b)) in enumerate(zip(dims.surface_radii, pairwise(levels), strict=True), 1)
    )
    rows = tuple(
        (str(n), mm3(2 * radius), land, "end" if end == high else mm3(end - low))
        for n, (radius, end) in enumerate(zip(dims.surface_radii, levels[1:], strict=True), 1)
    )
    return Sheet(
        part=part,
        title="Guide pulley",
        views=(ALONG_Z.view(low, high, section=True),),
        dimensions=dimensions,
        labels=(*labels, Label(MAIN, ALONG_Z.point(-(dims.seat_radius + largest) / 2, low), "A", leader=True)),
        tables=(Table("Steps, ends measured from face A", ("Step", "%%c", "Fit", "ends at"), rows),),
        fits=(
            FitLine(2 * dims.seat_radius, seat, "bearing seats"),
            *(FitLine(round(2 * r, 6), land, f"step {n}") for n, r in enumerate(dims.surface_radii, 1)),
        ),
        notes=(
            "Steps: Ra 0.8, no flanges; corner between two steps at most R0.05.",
            "Run-out of the steps to the common axis of both bearing seats: 0.01.",
            f"Shoulders of the seats {mm(dims.seat_depth)} deep, square to the axis within 0.01.",
        ),
    )
