"""Sheets of pins, nuts and the cables' stops."""

from __future__ import annotations

from mbcdm_cad.parts.fits import FITS
from mbcdm_cad.parts.sheets.description import FitLine, Linear, Sheet, View, X, Y, Z, minus
from mbcdm_cad.parts.sheets.turned import ALONG_Z
from mbcdm_cad.parts.sheets.words import mm
from mbcdm_cad.parts.threads import thread


def pin_sheet(part: str, radius: float, length: float) -> Sheet:
    """Parallel pin."""
    chamfer = min(0.3, radius / 3)
    fit = FITS["pin"].code
    return Sheet(
        part=part,
        title="Parallel pin",
        views=(ALONG_Z.view(0.0, length, section=False),),
        dimensions=(
            ALONG_Z.diameter(radius, chamfer, "left", fit=fit),
            ALONG_Z.length(0.0, length, "below", (radius - chamfer, radius - chamfer)),
            ALONG_Z.chamfer(chamfer, radius, length, -1.0, "above", count=2),
        ),
        fits=(FitLine(2 * radius, fit, "pin"),),
        notes=("A parallel pin of ISO 2338 or ISO 8734 in this size may take its place.",),
    )


def sleeve_sheet(part: str, bore_radius: float, radius: float, length: float) -> Sheet:
    """Stop, after it is swaged on the cable's end."""
    return Sheet(
        part=part,
        title="Cable stop, swaged",
        views=(ALONG_Z.view(0.0, length, section=True),),
        dimensions=(
            ALONG_Z.diameter(bore_radius, 0.0, "left"),
            ALONG_Z.diameter(radius, length, "right", decimals=3),
            ALONG_Z.length(0.0, length, "below", (radius, radius), decimals=3),
        ),
        notes=("Sizes after swaging on the cable; the sleeve before swaging is that of the rope's maker.",),
    )


def nut_sheet(part: str, across_flats: float, height: float, thread_mm: float) -> Sheet:
    """Hexagon nut from the side and along its axis."""
    corner = across_flats / 3**0.5
    screw = thread(thread_mm)
    r = thread_mm / 2
    side = View("main", right=Z, up=Y, cut=(0.0, 0.0, 0.0), axes=(((0.0, 0.0, 0.0), (0.0, 0.0, height)),))
    end = View(
        "end",
        right=minus(X),
        up=Y,
        column=1,
        axes=(((-corner, 0.0, 0.0), (corner, 0.0, 0.0)), ((0.0, -across_flats / 2, 0.0), (0.0, across_flats / 2, 0.0))),
    )
    return Sheet(
        part=part,
        title="Hexagon nut",
        views=(side, end),
        dimensions=(
            Linear("main", (0.0, -across_flats / 2, 0.0), (0.0, -across_flats / 2, height), height, "below"),
            Linear("end", (0.0, -across_flats / 2, 0.0), (0.0, across_flats / 2, 0.0), across_flats, "right", "AF "),
            Linear("main", (0.0, -r, 0.0), (0.0, r, 0.0), thread_mm, "left", "M", "-6H"),
        ),
        notes=(
            f"{screw.name}: pitch {mm(screw.pitch_mm)}, drilled %%c{mm(screw.tap_drill_mm)}.",
            "A nut of ISO 4032 or ISO 4035 in this size may take its place.",
        ),
    )
