"""Sheet of the frame: envelope, walls and floors as dimensions, all holes as tables."""

from __future__ import annotations

from mbcdm_cad.layouts.miso_bevel.support.dims import FrameDims
from mbcdm_cad.parts.boss import boss_bores, seats_mm
from mbcdm_cad.parts.fits import FITS
from mbcdm_cad.parts.sheets.description import (
    CuttingLine,
    FitLine,
    Holes,
    Linear,
    Radius,
    Sheet,
    Side,
    Table,
    Vector,
    View,
    X,
    Y,
    Z,
    minus,
    mm,
)
from mbcdm_cad.parts.sheets.holes import THROUGH, hole_labels, hole_table, outside_bore, position_table
from mbcdm_cad.parts.sheets.tolerances import DRUM_AXIS, GeometricTolerance, one_axis, square
from mbcdm_cad.parts.volume import pocket_corner_mm


def _from_above(d: FrameDims) -> tuple[Holes, ...]:
    """Holes along Z."""
    v = d.levels
    shelf, lowest, top = v.bearing_shelf_top_z, v.shelf_top_z, v.top_plate_bottom_z
    seat = (2 * d.seat_radius, d.seat_depth, FITS["input_seat"].code)
    groups = (
        Holes(
            "A",
            2 * d.axle_radius,
            THROUGH,
            ((0.0, 0.0, shelf),),
            "bearing shelf",
            "guide axle",
            fit=FITS["axle_bore"].code,
        ),
        Holes(
            "B",
            2 * d.seat_shoulder_radius,
            THROUGH,
            tuple((x, d.input_y, shelf) for x in d.input_x),
            "bearing shelf",
            "bearing seats",
            counterbore=seat,
        ),
        _beside_seats(d),
        Holes(
            "D",
            d.plate_screw_radius * 2,
            d.plate_screw_depth,
            tuple((x, y, top) for x, y in d.plate_screws),
            "top",
            "top plate",
            threaded=d.plate_insert is None,
            insert=d.plate_insert,
        ),
        Holes(
            "E",
            2 * d.dowel_radius,
            d.dowel_depth,
            tuple((x, y, top) for x, y in d.dowels),
            "top",
            "dowels",
            fit=FITS["pin_press"].code,
        ),
        Holes(
            "F",
            2 * d.pilot_radius,
            THROUGH,
            tuple((x, d.input_y, lowest) for x in d.input_x if d.carries_drives),
            "motor shelf",
            "gearheads",
            fit=FITS["pilot"].code,
        ),
        Holes(
            "G",
            2 * d.gear_screw_clearance,
            THROUGH,
            tuple((x, y, lowest) for x, y in d.gear_screws),
            "motor shelf",
            "gearhead screws",
        ),
    )
    return tuple(group for group in groups if group.places)


def _beside_seats(d: FrameDims) -> Holes:
    """Holes of the bearing shelf beside the bearings: for the key of the gearheads' screws, or the encoders' screws."""
    shelf = d.levels.bearing_shelf_top_z
    if d.encoder_holes is not None:
        return Holes(
            "C",
            2 * d.encoder_holes.clearance,
            THROUGH,
            tuple((at, d.input_y, shelf) for x in d.input_x for at in d.encoder_holes.places(x)),
            "bearing shelf",
            "encoder screws",
            counterbore=(2 * d.encoder_holes.head_radius, d.encoder_holes.head_depth, ""),
        )
    return Holes(
        "C",
        2 * d.key_hole_radius,
        THROUGH,
        outside_bore(
            tuple((x, y, shelf) for x, y in d.gear_screws),
            d.gear_bolt_circle + d.key_hole_radius,
            d.seat_shoulder_radius,
        ),
        "bearing shelf",
        "key for gearhead screws",
    )


def _from_front(d: FrameDims) -> tuple[Holes, ...]:
    """Holes along Y, from the front or from behind."""
    v = d.levels
    shelf_z = (v.bearing_shelf_bottom_z + v.bearing_shelf_top_z) / 2
    sunk = v.pocket_floor_y - d.mount_seat_y
    encoder = tuple((s * d.boss.screw_circle, d.boss.encoder_pocket_floor_y, 0.0) for s in (-1, 1))
    groups = [
        Holes(
            "H", 2 * d.axle_screw_radius, "to A", ((0.0, v.front_y, shelf_z),), "front", "axle set screw", threaded=True
        ),
        Holes(
            "J",
            2 * d.stop_pin_radius,
            v.front_y - d.stop_pin_start_y,
            ((0.0, v.front_y, d.stop_pin_z),),
            "front",
            "stop pin",
            fit=FITS["pin_press"].code,
        ),
        Holes(
            "K",
            2 * d.mount_radius,
            THROUGH,
            tuple((x, v.pocket_floor_y, z) for x, z in d.mounts),
            "pocket floor",
            "mounting screws",
            counterbore=(2 * d.mount_head_radius, sunk, "") if sunk > 0.0 else None,
        ),
        Holes(
            "L",
            2 * d.boss.screw_radius,
            d.encoder_screw_depth,
            encoder,
            "encoder pocket",
            "drum encoder",
            threaded=True,
        ),
    ]
    return tuple(groups)


def _marks(groups: tuple[Holes, ...], across: Vector, up: Vector) -> tuple[tuple[Vector, Vector], ...]:
    """Centre lines of holes seen from their end."""
    marks = []
    for group in groups:
        reach = group.reach + 0.8
        for place in group.places:
            for direction in (across, up):
                low, high = (
                    tuple(p + sign * reach * q for p, q in zip(place, direction, strict=True)) for sign in (-1, 1)
                )
                marks.append(((low[0], low[1], low[2]), (high[0], high[1], high[2])))
    return tuple(marks)


def _views(d: FrameDims, above: tuple[Holes, ...], behind: tuple[Holes, ...]) -> tuple[View, ...]:
    v = d.levels
    front_seen = tuple(g for g in behind if g.letter != "L")
    low_shelf = tuple(g for g in above if g.letter in "FG")
    high = tuple(g for g in above if g.letter not in "FG")
    middle = (v.shelf_top_z + v.bearing_shelf_bottom_z) / 2
    reach = max(d.boss.encoder_pocket_radius, d.boss.ear_reach) + 1.5
    axle = (((0.0, v.back_y, 0.0), (0.0, v.boss_front_y, 0.0)),)
    return (
        View(
            "front",
            minus(X),
            Z,
            axes=(
                *_marks(front_seen, X, Z),
                ((0.0, v.front_y, -d.boss.radius), (0.0, v.front_y, v.top_plate_bottom_z)),
                ((-d.boss.ear_reach, v.front_y, 0.0), (d.boss.ear_reach, v.front_y, 0.0)),
            ),
        ),
        View("section", Y, Z, column=1, title="A-A", cut=(0.0, 0.0, 0.0), axes=axle),
        View(
            "rear",
            X,
            Z,
            column=1,
            row=-1,
            title="Boss from behind",
            magnify=1.0 + 1e-9,
            window=((0.0, v.back_y, 1.0), reach, reach),
            axes=(
                *_marks(tuple(g for g in behind if g.letter == "L"), X, Z),
                ((0.0, v.back_y, -d.boss.encoder_pocket_radius), (0.0, v.back_y, d.boss.encoder_pocket_radius)),
            ),
        ),
        View("top", minus(X), minus(Y), row=-1, axes=_marks(high, X, Y)),
        View("shelf", minus(X), minus(Y), row=-2, title="B-B", cut=(0.0, 0.0, middle), axes=_marks(low_shelf, X, Y)),
    )


def _in_front(d: FrameDims) -> tuple[Linear, ...]:
    """Widths and heights, from the middle plane and the drum's axis."""
    v = d.levels
    y, top, low = v.front_y, v.top_plate_bottom_z, v.shelf_bottom_z
    inner = d.boss.radius - d.rib_thickness
    x_out, r = v.side_outer_x, d.corner_radius
    coupling = (v.shelf_top_z + v.bearing_shelf_bottom_z) / 2

    def wide(half: float, z: float, side: Side, what: str = "", decimals: int = 2) -> Linear:
        return Linear("front", (-half, y, z), (half, y, z), 2 * half, side, suffix=what, decimals=decimals)

    def tall(low_z: float, high_z: float, x: float, side: Side, decimals: int = 3) -> Linear:
        return Linear("front", (x, y, low_z), (x, y, high_z), high_z - low_z, side, decimals=decimals)

    ear = Linear(
        "front",
        (-d.boss.ear_reach, y, -d.boss.ear_half_height),
        (-d.boss.ear_reach, y, d.boss.ear_half_height),
        2 * d.boss.ear_half_height,
        "right",
        suffix=" ears",
    )
    pocket = (
        wide(inner, d.column_pocket_bottom_z, "below", " pocket"),
        tall(0.0, d.column_pocket_bottom_z, inner, "left"),
    )
    return (
        wide(x_out, top, "above"),
        wide(v.side_inner_x, top, "above", " pockets"),
        wide(d.web_half_width, coupling, "above", " web"),
        wide(d.boss.radius, d.column_start_z, "below", " column = %%c boss"),
        wide(d.boss.ear_reach, 0.0, "below", " ears"),
        tall(0.0, low, x_out, "left"),
        tall(0.0, top, x_out, "left"),
        tall(low, v.shelf_top_z, -x_out + r, "right"),
        tall(v.shelf_top_z, v.bearing_shelf_bottom_z, -v.side_inner_x, "right"),
        tall(v.bearing_shelf_bottom_z, v.bearing_shelf_top_z, -v.side_inner_x, "right"),
        ear,
        *(pocket if d.has_column_pocket else ()),
    )


def _in_section(d: FrameDims) -> tuple[Linear, ...]:
    """Depths from the back face and the bores of the drum's shaft."""
    v = d.levels
    back = v.back_y
    high, low = v.top_plate_bottom_z, -d.boss.radius

    def deep(y: float, z: float, side: Side, start: float, what: str = "") -> Linear:
        return Linear("section", (0.0, back, start), (0.0, y, z), y - back, side, suffix=what, decimals=3)

    column_back = d.column_start_z
    return (
        deep(v.front_y, high, "above", high),
        deep(v.pocket_floor_y, v.bearing_shelf_bottom_z, "above", high, " pockets"),
        deep(d.upper_floor_y, high, "above", high, " top pocket"),
        deep(0.0, v.bearing_shelf_top_z, "above", high, " axis of A"),
        deep(d.boss.encoder_pocket_floor_y, low, "below", column_back),
        deep(d.boss.rear_seat_end_y, -d.boss.seat_radius, "below", column_back),
        deep(d.boss.front_seat_start_y, -d.boss.seat_radius, "below", column_back),
        deep(v.boss_front_y, low, "below", column_back),
        deep(d.boss.ear_front_y, -d.boss.ear_half_height, "below", column_back, " ears"),
        *boss_bores(d.boss),
    )


def _behind(d: FrameDims) -> tuple[Linear | Radius, ...]:
    v = d.levels
    r, y = d.boss.encoder_pocket_radius, v.back_y
    return (
        Linear(
            "rear",
            (d.boss.radius, y, 0.0),
            (d.boss.radius, y, d.column_start_z),
            d.column_start_z,
            "right",
            suffix=" column",
            decimals=3,
        ),
        Radius("rear", (0.0, y, 0.0), (-r * 0.6, y, r * 0.8), r),
    )


def _pockets(d: FrameDims) -> Table:
    """Corners of each pocket: the cutter's, or less where the pocket is narrow."""
    v, r = d.levels, d.corner_radius
    inner = d.boss.radius - d.rib_thickness
    sizes = (
        ("top pocket", 2 * v.side_inner_x, 2 * r + v.top_plate_bottom_z - v.bearing_shelf_top_z),
        ("beside the web", v.side_inner_x - d.web_half_width, v.bearing_shelf_bottom_z - v.shelf_top_z),
        ("column", 2 * inner, v.shelf_bottom_z - d.column_pocket_bottom_z),
    )
    rows = tuple((name, mm(pocket_corner_mm(r, width, height), 3)) for name, width, height in sizes)
    return Table("Corners of the pockets", ("Pocket", "R"), rows)


def _tolerances(d: FrameDims) -> tuple[GeometricTolerance, ...]:
    """Seats of the drum on one axis; bores of guide and inputs square to it."""
    v, depth = d.levels, d.seat_depth / 2
    shelf = (v.bearing_shelf_bottom_z + v.bearing_shelf_top_z) / 2
    first, *rest = ((x, d.input_y - d.seat_radius, v.bearing_shelf_top_z - depth) for x in d.input_x)
    return (
        one_axis("section", seats_mm(d.boss), DRUM_AXIS),
        square("section", (0.0, -d.axle_radius, shelf), DRUM_AXIS, "A"),
        square("top", first, DRUM_AXIS, "B", tuple(rest)),
    )


def frame_sheet(part: str, d: FrameDims) -> Sheet:
    """Front, middle section, rear, top, and a section above the lowest shelf."""
    v, r = d.levels, d.corner_radius
    above, behind = _from_above(d), _from_front(d)
    seen = tuple(g for g in behind if g.letter != "L")
    x, y = v.side_outer_x, v.front_y
    half = 0.5**0.5 * r
    middle = (v.shelf_top_z + v.bearing_shelf_bottom_z) / 2
    corner = Radius(
        "top", (r - x, y - r, v.top_plate_bottom_z), (r - x - half, y - r + half, v.top_plate_bottom_z), r, prefix="4x "
    )
    return Sheet(
        part=part,
        title="Frame",
        paper="A2",
        views=_views(d, above, behind),
        dimensions=(*_in_front(d), *_in_section(d), *_behind(d), corner),
        labels=(
            *hole_labels(seen, "front"),
            *hole_labels(tuple(g for g in behind if g.letter == "L"), "rear"),
            *hole_labels(tuple(g for g in above if g.letter not in "FG"), "top"),
            *hole_labels(tuple(g for g in above if g.letter in "FG"), "shelf"),
        ),
        tolerances=_tolerances(d),
        cutting_lines=(
            CuttingLine("front", (0.0, y, -d.boss.radius - 2.0), (0.0, y, v.top_plate_bottom_z + 2.0), "A", minus(X)),
            CuttingLine("front", (x + 2.0, y, middle), (-x - 2.0, y, middle), "B", minus(Z)),
        ),
        tables=(
            hole_table((*above, *behind)),
            position_table(above, (0, 1), "Positions from A and the drum axis, along Z"),
            position_table(behind, (0, 2), "Positions from A and the drum axis, along Y"),
            _pockets(d),
        ),
        holes=(*above, *behind),
        fits=(
            FitLine(2 * d.boss.seat_radius, FITS["drum_seat"].code, "drum bearing seats"),
            *(line for group in (*above, *behind) for line in group.fit_lines()),
        ),
        notes=(
            "One piece. X to the right in the rear view, Y to the front, Z up; Y = 0 at the axis of A.",
            "The radius in the rear view is that of the encoder's pocket.",
            "Seats Ra 0.8, elsewhere Ra 3.2.",
        ),
    )
