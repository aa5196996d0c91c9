"""Sheet of a cable's threaded terminal."""

from __future__ import annotations

from mbcdm_cad.parts.sheets.description import Linear, Sheet, View, X, Y, minus
from mbcdm_cad.parts.sheets.turned import ALONG_Z
from mbcdm_cad.parts.sheets.words import mm
from mbcdm_cad.parts.terminal.dims import CHAMFER_MM
from mbcdm_cad.parts.threads import thread

_END = "end"


def terminal_sheet(
    part: str,
    swage_start: float,
    cable_end: float,
    swage_end: float,
    tip: float,
    swage_radius: float,
    flat: float,
    stud_radius: float,
    bore_radius: float,
) -> Sheet:
    """Section along the axis; the arguments are those of the part's drawing function."""
    c = CHAMFER_MM
    screw = thread(2 * stud_radius)
    return Sheet(
        part=part,
        title="Cable terminal",
        views=(
            ALONG_Z.view(swage_start, tip, section=True),
            View(_END, minus(X), Y, column=1, title="From the cable"),
        ),
        dimensions=(
            ALONG_Z.diameter(bore_radius, swage_start, "left"),
            ALONG_Z.diameter(swage_radius, swage_start + c, "left"),
            ALONG_Z.thread(stud_radius, tip - c, "right", "-6g"),
            ALONG_Z.length(swage_start, cable_end, "above", (swage_radius - c, bore_radius)),
            ALONG_Z.length(swage_start, swage_end, "below", (swage_radius - c, swage_radius)),
            ALONG_Z.length(swage_start, tip, "below", (swage_radius - c, stud_radius - c)),
            ALONG_Z.chamfer(c, stud_radius, tip, -1.0, "above", count=2),
            Linear(
                _END, (0.0, -flat, swage_start), (0.0, flat, swage_start), 2 * flat, "right", suffix=" over 2 flats"
            ),
        ),
        notes=(
            f"{screw.name}: pitch {mm(screw.pitch_mm)}; rolled, full length of the stud.",
            "Swage sizes after swaging on the cable.",
        ),
    )
