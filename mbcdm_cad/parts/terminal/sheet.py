"""Sheet of a cable's threaded terminal."""

from __future__ import annotations

from mbcdm_cad.parts.sheets.description import Linear, Sheet, View, X, Y, minus
from mbcdm_cad.parts.sheets.turned import ALONG_Z
from mbcdm_cad.parts.sheets.words import mm
from mbcdm_cad.parts.terminal.dims import CHAMFER_MM, TerminalDims
from mbcdm_cad.parts.threads import thread

_END = "end"


def terminal_sheet(part: str, dims: TerminalDims) -> Sheet:
    """Section along the axis, and the end with the flats."""
    c = CHAMFER_MM
    screw = thread(2 * dims.stud_radius)
    return Sheet(
        part=part,
        title="Cable terminal",
        views=(
            ALONG_Z.view(dims.swage_start, dims.tip, section=True),
            View(_END, minus(X), Y, column=1, title="From the cable"),
        ),
        dimensions=(
            ALONG_Z.diameter(dims.bore_radius, dims.swage_start, "left"),
            ALONG_Z.diameter(dims.swage_radius, dims.swage_start + c, "left"),
            ALONG_Z.thread(dims.stud_radius, dims.tip - c, "right", "-6g"),
            ALONG_Z.length(dims.swage_start, dims.cable_end, "above", (dims.swage_radius - c, dims.bore_radius)),
            ALONG_Z.length(dims.swage_start, dims.swage_end, "below", (dims.swage_radius - c, dims.swage_radius)),
            ALONG_Z.length(dims.swage_start, dims.tip, "below", (dims.swage_radius - c, dims.stud_radius - c)),
            ALONG_Z.chamfer(c, dims.stud_radius, dims.tip, -1.0, "above", count=2),
            Linear(
                _END,
                (0.0, -dims.flat, dims.swage_start),
                (0.0, dims.flat, dims.swage_start),
                2 * dims.flat,
                "right",
                suffix=" over 2 flats",
            ),
        ),
        notes=(
            f"{screw.name}: pitch {mm(screw.pitch_mm)}; rolled, full length of the stud.",
            "Swage sizes after swaging on the cable.",
        ),
    )
