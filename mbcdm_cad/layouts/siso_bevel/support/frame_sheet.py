"""Sheet of the frame: from the front, a middle section, from above; all holes as tables."""

from __future__ import annotations

from mbcdm_cad.layouts.siso_bevel.support.dims import ColumnDims
from mbcdm_cad.parts.corners import pocket_corner_mm
from mbcdm_cad.parts.fits import FITS
from mbcdm_cad.parts.sheets.description import (
    CuttingLine,
    FitLine,
    Linear,
    Radius,
    Sheet,
    Side,
    Table,
    View,
    X,
    Y,
    Z,
    minus,
)
from mbcdm_cad.parts.sheets.holes import THROUGH, Holes, hole_labels, hole_table, position_table
from mbcdm_cad.parts.sheets.words import mm


def _from_above(d: ColumnDims) -> tuple[Holes, ...]:
    """Holes along Z; the axis of A is the input's."""
    shelf, top = d.encoder_shelf_top_z, d.top_z
    seat = (2 * d.seat_radius, d.seat_depth, FITS["input_seat"].code)
    sunk = (2 * d.encoder_head_radius, d.encoder_head_depth, "")
    encoder = tuple((s * d.encoder_circle_radius, 0.0, shelf) for s in (-1, 1))
    flange = tuple((x, y, top) for x, y in d.flange_screws)
    dowels = tuple((x, y, top) for x, y in d.dowels)
    return (
        Holes("A", 2 * d.seat_shoulder_radius, THROUGH, ((0.0, 0.0, shelf),), "shelf", "bearing", counterbore=seat),
        Holes("B", 2 * d.encoder_screw_clearance, THROUGH, encoder, "shelf", "encoder screws", counterbore=sunk),
        Holes(
            "C",
            2 * d.flange_screw_radius,
            d.flange_screw_depth,
            flange,
            "top",
            "motor head",
            threaded=d.flange_insert is None,
            insert=d.flange_insert,
        ),
        Holes("D", 2 * d.dowel_radius, d.dowel_depth, dowels, "top", "dowels", fit=FITS["pin_press"].code),
    )


def _from_front(d: ColumnDims) -> tuple[Holes, ...]:
    """Holes along Y, from the front or from behind."""
    v, b = d.levels, d.boss
    encoder = tuple((s * b.screw_circle, b.encoder_pocket_floor_y, 0.0) for s in (-1, 1))
    mounts = tuple((x, v.pocket_floor_y, z) for x, z in d.mounts)
    pin = ((0.0, v.front_y, d.stop_pin_z),)
    depth = v.front_y - d.stop_pin_start_y
    return (
        Holes("E", 2 * d.stop_pin_radius, depth, pin, "front", "stop pin", fit=FITS["pin_press"].code),
        Holes("F", 2 * d.mount_radius, THROUGH, mounts, "pocket floor", "mounting screws"),
        Holes("G", 2 * b.screw_radius, b.screw_depth, encoder, "encoder pocket", "drum encoder", threaded=True),
    )


def _in_front(d: ColumnDims) -> tuple[Linear, ...]:
    """Widths, and heights from the drum's axis."""
    v = d.levels
    y, x = v.front_y, v.side_outer_x

    def wide(half: float, z: float, side: Side, what: str = "") -> Linear:
        return Linear("front", (-half, y, z), (half, y, z), 2 * half, side, suffix=what)

    def tall(z: float, at: float, side: Side) -> Linear:
        return Linear("front", (0.0, y, 0.0), (at, y, z), z, side, decimals=3)

    return (
        wide(x, d.top_z, "above"),
        wide(v.side_inner_x, d.top_z, "above", " box"),
        wide(d.column_half_width, d.post_bottom_z, "below", " column"),
        wide(d.pocket_half_width, d.low_pocket_bottom_z, "below", " pockets"),
        wide(d.boss.radius, 0.0, "below", " foot = %%c boss"),
        wide(d.boss.ear_reach, 0.0, "below", " ears"),
        tall(d.top_z, x, "left"),
        tall(d.encoder_shelf_top_z, x, "left"),
        tall(d.encoder_shelf_bottom_z, x, "left"),
        tall(d.stop_shelf_top_z, -d.pocket_half_width, "right"),
        tall(d.stop_shelf_bottom_z, -d.pocket_half_width, "right"),
        tall(d.low_pocket_bottom_z, -d.pocket_half_width, "right"),
        tall(d.post_bottom_z, -d.column_half_width, "right"),
    )


def _in_section(d: ColumnDims) -> tuple[Linear, ...]:
    """Depths from the back face, and the bores of the drum's shaft."""
    v, b = d.levels, d.boss
    back, start = v.back_y, d.column_start_z

    def deep(y: float, z: float, side: Side, from_z: float, what: str = "") -> Linear:
        return Linear("section", (0.0, back, from_z), (0.0, y, z), y - back, side, suffix=what, decimals=3)

    def bore(radius: float, y: float, fit: str = "", count: str = "") -> Linear:
        return Linear("section", (0.0, y, -radius), (0.0, y, radius), 2 * radius, "right", f"{count}%%c", fit=fit)

    return (
        deep(v.front_y, d.encoder_shelf_bottom_z, "above", d.top_z),
        deep(v.pocket_floor_y, d.encoder_shelf_top_z, "above", d.top_z, " pockets"),
        deep(0.0, d.encoder_shelf_top_z, "above", d.top_z, " axis of A"),
        deep(b.encoder_pocket_floor_y, -b.radius, "below", start),
        deep(b.rear_seat_end_y, -b.seat_radius, "below", start),
        deep(b.front_seat_start_y, -b.seat_radius, "below", start),
        deep(b.front_y, -b.radius, "below", start),
        deep(b.ear_front_y, -b.ear_half_height, "below", start, " ears"),
        bore(b.seat_radius, b.front_y, FITS["drum_seat"].code, "2x "),
        bore(b.shoulder_radius, b.front_seat_start_y),
    )


def _pockets(d: ColumnDims) -> Table:
    """Corners of each pocket: the cutter's, or less where the pocket is narrow."""
    v, r, inner = d.levels, d.corner_radius, 2 * d.pocket_half_width
    sizes = (
        ("box", 2 * v.side_inner_x, 2 * r + d.top_z - d.encoder_shelf_top_z),
        ("over the stop shelf", inner, d.encoder_shelf_bottom_z - d.stop_shelf_top_z),
        ("under the stop shelf", inner, d.stop_shelf_bottom_z - d.low_pocket_bottom_z),
    )
    rows = tuple((name, mm(pocket_corner_mm(r, width, height), 3)) for name, width, height in sizes)
    return Table("Corners of the pockets", ("Pocket", "R"), rows)


def column_sheet(part: str, d: ColumnDims) -> Sheet:
    """Front, middle section and top."""
    v, r, b = d.levels, d.corner_radius, d.boss
    above, behind = _from_above(d), _from_front(d)
    front = tuple(group for group in behind if group.letter != "G")
    x, y, half = v.side_outer_x, v.front_y, 0.5**0.5 * r
    corner = Radius("top", (r - x, y - r, d.top_z), (r - x - half, y - r + half, d.top_z), r, prefix="4x ")
    axle = (((0.0, v.back_y, 0.0), (0.0, b.front_y, 0.0)), ((0.0, 0.0, d.stop_shelf_top_z), (0.0, 0.0, d.top_z)))
    return Sheet(
        part=part,
        title="Frame",
        paper="A2",
        views=(
            View("front", minus(X), Z),
            View("section", Y, Z, column=1, title="A-A", cut=(0.0, 0.0, 0.0), axes=axle),
            View("top", minus(X), minus(Y), row=-1),
        ),
        dimensions=(*_in_front(d), *_in_section(d), corner),
        labels=(*hole_labels(front, "front"), *hole_labels(above, "top")),
        cutting_lines=(CuttingLine("front", (0.0, y, -b.radius - 2.0), (0.0, y, d.top_z + 2.0), "A", minus(X)),),
        holes=(*above, *behind),
        tables=(
            hole_table((*above, *behind)),
            position_table(above, (0, 1), "Positions from A, along Z"),
            position_table(behind, (0, 2), "Positions from A and the drum axis, along Y"),
            _pockets(d),
        ),
        fits=(
            FitLine(2 * b.seat_radius, FITS["drum_seat"].code, "drum bearing seats"),
            *(line for group in (*above, *behind) for line in group.fit_lines()),
        ),
        notes=(
            "One piece. X to the right in the rear view, Y to the front, Z up; Y = 0 at the axis of A.",
            "A square to the drum's axis within 0.02; both drum seats on one axis within 0.005.",
            "Encoder's pocket from behind: "
            f"R{mm(b.encoder_pocket_radius)} about the drum's axis, open below Z {mm(d.column_start_z)}.",
            f"Ears {mm(2 * b.ear_half_height)} high. Seats Ra 0.8, elsewhere Ra 3.2.",
        ),
    )
