"""Sheet of the motor head: from above, a middle section, holes as tables."""

from __future__ import annotations

from mbcdm_cad.parts.corners import pocket_corner_mm
from mbcdm_cad.parts.fits import FITS
from mbcdm_cad.parts.motor_head.dims import HeadDims
from mbcdm_cad.parts.sheets.description import CuttingLine, Linear, Radius, Sheet, Side, View, X, Y, Z
from mbcdm_cad.parts.sheets.holes import THROUGH, Holes, hole_labels, hole_table, outside_bore, position_table
from mbcdm_cad.parts.sheets.words import mm


def _holes(d: HeadDims) -> tuple[Holes, ...]:
    """The holes, all along Z; the axis of hole A is that of the input."""
    seat = (2 * d.seat_radius, d.seat_depth, FITS["input_seat"].code)
    groups = (
        Holes("A", 2 * d.shoulder_radius, THROUGH, ((0.0, 0.0, d.bottom_z),), "below", "bearing", counterbore=seat),
        Holes(
            "B",
            2 * d.pilot_radius,
            THROUGH,
            ((0.0, 0.0, d.top_z),),
            "motor shelf",
            "pilot of the drive",
            fit=FITS["pilot"].code,
        ),
        Holes(
            "C",
            2 * d.gear_screw_clearance,
            THROUGH,
            tuple((x, y, d.top_z) for x, y in d.gear_screws),
            "motor shelf",
            "screws of the drive",
        ),
        Holes(
            "D",
            2 * d.key_hole_radius,
            THROUGH,
            outside_bore(
                tuple((x, y, d.bottom_z) for x, y in d.gear_screws),
                d.gear_bolt_circle + d.key_hole_radius,
                d.shoulder_radius,
            ),
            "below",
            "key for screws of the drive",
        ),
        Holes(
            "E",
            2 * d.screw_clearance,
            THROUGH,
            tuple((x, y, d.flange_top_z) for x, y in d.flange.screws),
            "flange",
            "screws",
        ),
        Holes(
            "F",
            2 * d.dowel_radius,
            THROUGH,
            tuple((x, y, d.flange_top_z) for x, y in d.flange.dowels),
            "flange",
            "dowels",
            fit=FITS["pin_slide"].code,
        ),
    )
    return tuple(group for group in groups if group.places)


def motor_head_sheet(part: str, d: HeadDims) -> Sheet:
    """From above and in section, with all heights from the lower face."""
    f, r = d.flange, d.corner_radius
    holes = _holes(d)
    corner_in = pocket_corner_mm(r, 2 * d.inner_x, d.shelf_bottom_z - d.flange_top_z)
    low, x, half = d.bottom_z, f.half_x, 0.5**0.5 * r
    seen = tuple(group for group in holes if group.letter in "BCEF")

    def tall(top: float, at: float) -> Linear:
        return Linear("section", (-x, 0.0, low), (at, 0.0, top), top - low, "left", decimals=3)

    def wide(half_width: float, z: float, what: str = "") -> Linear:
        side: Side = "above" if z > d.flange_top_z else "below"
        ends = ((-half_width, 0.0, z), (half_width, 0.0, z))
        return Linear("section", *ends, 2 * half_width, side, suffix=what)

    return Sheet(
        part=part,
        title="Motor head",
        paper="A3",
        views=(
            View(
                "section",
                right=X,
                up=Z,
                row=1,
                title="A-A",
                cut=(0.0, 0.0, 0.0),
                axes=(((0, 0, low), (0, 0, d.top_z)),),
            ),
            View("top", right=X, up=Y),
        ),
        dimensions=(
            tall(d.flange_top_z, -x),
            tall(d.shelf_bottom_z, -d.inner_x),
            tall(d.top_z, -d.outer_x),
            wide(x, low),
            wide(d.outer_x, d.top_z),
            wide(d.inner_x, d.shelf_bottom_z, " pocket"),
            Linear("top", (x - r, f.back_y, low), (x - r, f.front_y, low), f.front_y - f.back_y, "right", decimals=3),
            Linear("top", (0.0, 0.0, low), (x - r, f.front_y, low), f.front_y, "right", decimals=3),
            Linear("top", (0.0, 0.0, d.top_z), (-d.outer_x + r, d.front_y, d.top_z), d.front_y, "left", decimals=3),
            Linear("top", (-d.outer_x + r, d.back_y, d.top_z), (0.0, 0.0, d.top_z), -d.back_y, "left", decimals=3),
            Radius("top", (r - x, f.front_y - r, low), (r - x - half, f.front_y - r + half, low), r, prefix="8x "),
        ),
        labels=hole_labels(seen, "top"),
        cutting_lines=(CuttingLine("top", (-x - 4.0, 0.0, low), (x + 4.0, 0.0, low), "A", Y),),
        tables=(hole_table(holes), position_table(holes, (0, 1), "Positions from the axis of A")),
        holes=holes,
        fits=tuple(line for group in holes for line in group.fit_lines()),
        notes=(
            f"Pocket from the front, {mm(d.inner_x)} behind the axis of A; its corners R{mm(corner_in, 3)}.",
            "Bearing seat Ra 0.8, its shoulder flat within 0.01 to the lower face; motor shelf parallel to it in 0.02.",
        ),
    )
