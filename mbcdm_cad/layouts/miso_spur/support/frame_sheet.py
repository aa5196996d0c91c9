"""Sheet of the frame: that of siso_spur for the first arm, holes of all arms, and the differences of the arms."""

from __future__ import annotations

from dataclasses import replace

from mbcdm_cad.layouts.miso_spur.support.dims import StarDims
from mbcdm_cad.layouts.siso_spur.support.frame_sheet import frame_holes, yoke_sheet
from mbcdm_cad.parts.fits import FITS
from mbcdm_cad.parts.sheets.description import CuttingLine, FitLine, Sheet, Table, X, minus
from mbcdm_cad.parts.sheets.holes import Holes, hole_labels, hole_table, position_table
from mbcdm_cad.parts.sheets.words import mm, mm3

# Holes that exist once, about the drum's axis.
_IN_THE_MIDDLE = "EH"
_FROM_BEHIND = "ABCDEH"


def _holes(d: StarDims) -> tuple[Holes, ...]:
    """The holes of all arms, with the letters of the first arm."""
    groups = []
    for alike in zip(*(frame_holes(arm) for arm in d.arms), strict=True):
        first = alike[0]
        if first.letter not in _IN_THE_MIDDLE:
            places = tuple(
                (x, y, z)
                for k, group in enumerate(alike)
                for (_, y, _), (x, z) in zip(
                    group.places, d.turned(k, tuple((x, z) for x, _, z in group.places)), strict=True
                )
            )
            first = replace(first, places=places)
        groups.append(first)
    return tuple(groups)


def _arms(d: StarDims) -> Table:
    rows = []
    for n, (arm, angle) in enumerate(zip(d.arms, d.angles_deg, strict=True), 1):
        v = arm.levels
        back = v.plate_back_y
        rows.append((str(n), mm(angle), mm3(v.top_plate_bottom_z - back), mm3(v.top_plate_top_z - back)))
    return Table(
        "Arms: equal except for the shelf, from the plate's back",
        ("Arm", "deg from Z to X", "shelf from", "to"),
        tuple(rows),
    )


def star_sheet(part: str, d: StarDims) -> Sheet:
    """Rear, middle section and front."""
    first = d.arms[0]
    one, holes = yoke_sheet(part, first), _holes(d)
    behind = tuple(group for group in holes if group.letter in _FROM_BEHIND)
    y, reach = first.levels.plate_back_y, first.top_z + 2.0
    return replace(
        one,
        labels=(*hole_labels(behind, "rear"),),
        cutting_lines=(CuttingLine("rear", (0.0, y, -reach), (0.0, y, reach), "A", minus(X)),),
        holes=holes,
        tables=(hole_table(holes), _arms(d), position_table(holes, (0, 2), "Positions from the drum's axis")),
        fits=(
            FitLine(2 * first.boss.seat_radius, FITS["drum_seat"].code, "drum bearing seats"),
            *(line for group in holes for line in group.fit_lines()),
        ),
        notes=(
            "Milled from one block. X to the right in the rear view, Y to the front, Z up from the drum's axis. "
            "Dimensions of the first arm, at Z; the other arms are equal, turned about the drum's axis.",
            *one.notes[1:2],
            f"Outer corners of plates and yokes R{mm(first.corner_radius)}.",
            *one.notes[3:],
        ),
    )
