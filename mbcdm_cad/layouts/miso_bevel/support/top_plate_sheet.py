"""Sheet of the top plate, plain or with a coupling box for each gearhead."""

from __future__ import annotations

from mbcdm_cad.layouts.miso_bevel.support.dims import TopPlateDims
from mbcdm_cad.parts.fits import FITS
from mbcdm_cad.parts.motor_head.dims import CouplingBox
from mbcdm_cad.parts.sheets.description import (
    CuttingLine,
    Holes,
    Linear,
    Radius,
    Sheet,
    Side,
    Vector,
    View,
    X,
    Y,
    Z,
    mm,
)
from mbcdm_cad.parts.sheets.holes import THROUGH, hole_labels, hole_table, outside_bore, position_table
from mbcdm_cad.parts.sheets.tolerances import (
    FACE_MM,
    REST,
    SHOULDER_MM,
    Datum,
    GeometricTolerance,
    level,
    shoulder_place,
)
from mbcdm_cad.parts.volume import pocket_corner_mm


def mounting_holes(d: TopPlateDims) -> tuple[Holes, Holes, Holes]:
    """Holes A for the guide's axle, D for the screws and E for the dowels, drilled along Z from the top."""
    high = d.levels.top_plate_top_z
    return (
        Holes("A", 2 * d.axle_radius, THROUGH, ((0.0, 0.0, high),), "top", "guide axle", fit=FITS["axle_bore"].code),
        Holes(
            "D",
            2 * d.screw_clearance,
            THROUGH,
            tuple((x, y, high) for x, y in d.screws),
            "top",
            "screws",
            counterbore=(2 * d.screw_head_radius, d.screw_head_depth, ""),
        ),
        Holes(
            "E",
            2 * d.dowel_radius,
            THROUGH,
            tuple((x, y, high) for x, y in d.dowels),
            "top",
            "dowels",
            fit=FITS["pin_slide"].code,
        ),
    )


def _boxed_holes(d: TopPlateDims, box: CouplingBox) -> tuple[Holes, ...]:
    """All along Z, from the faces that they are drilled from."""
    gear_screws = tuple((x + dx, d.input_y + dy) for x, at in d.boxes for dx, dy in at.gear_screws)
    keys = tuple(
        (x + dx, d.input_y + dy, z)
        for x, at in d.boxes
        for dx, dy, z in outside_bore(
            tuple((dx, dy, box.bottom_z) for dx, dy in at.gear_screws),
            box.gear_bolt_circle + box.key_hole_radius,
            box.shoulder_radius,
        )
    )
    axle, screws, dowels = mounting_holes(d)
    groups = (
        axle,
        Holes(
            "B",
            2 * box.shoulder_radius,
            THROUGH,
            tuple((x, d.input_y, box.bottom_z) for x in d.input_x),
            "below",
            "bearing seats",
            counterbore=(2 * box.seat_radius, box.seat_depth, FITS["input_seat"].code),
        ),
        Holes("C", 2 * box.key_hole_radius, THROUGH, keys, "below", "key for gearhead screws"),
        screws,
        dowels,
        Holes(
            "F",
            2 * box.pilot_radius,
            THROUGH,
            tuple((x, d.input_y, box.top_z) for x in d.input_x),
            "motor shelf",
            "gearheads",
            fit=FITS["pilot"].code,
        ),
        Holes(
            "G",
            2 * box.gear_screw_clearance,
            THROUGH,
            tuple((x, y, box.top_z) for x, y in gear_screws),
            "motor shelf",
            "gearhead screws",
        ),
    )
    return tuple(group for group in groups if group.places)


def _tolerances(d: TopPlateDims, seat: float, depth: float, shoulder: float) -> tuple[GeometricTolerance, ...]:
    """Shoulders of the bearing seats parallel to the lower face."""
    z = d.levels.top_plate_bottom_z + depth
    dx, dy = shoulder_place(seat, shoulder)
    first, *rest = ((x + dx, d.input_y + dy, z) for x in d.input_x)
    return (level("section", first, SHOULDER_MM, tuple(rest)),)


def _marks(holes: tuple[Holes, ...], z: float | None = None) -> tuple[tuple[Vector, Vector], ...]:
    """Centre marks of all holes; at the height ``z``, or each at that of its hole."""
    marks = []
    for group in holes:
        reach = group.reach + 0.8
        for x, y, own in group.places:
            at = own if z is None else z
            marks += [((x - reach, y, at), (x + reach, y, at)), ((x, y - reach, at), (x, y + reach, at))]
    return tuple(marks)


def _outline(d: TopPlateDims) -> tuple[Linear, ...]:
    """Width and depth of the plate, and where the axis of hole A is in it."""
    v, high, x, r = d.levels, d.levels.top_plate_top_z, d.levels.side_outer_x, d.corner_radius
    left, right = (-x, v.back_y + r, high), x - r
    return (
        Linear("top", left, (x, v.back_y + r, high), 2 * x, "below"),
        Linear("top", left, (0.0, 0.0, high), x, "below"),
        Linear("top", (right, v.back_y, high), (right, v.front_y, high), v.front_y - v.back_y, "right", decimals=3),
        Linear("top", (0.0, 0.0, high), (right, v.front_y, high), v.front_y, "right", decimals=3),
    )


def boxed_plate_sheet(part: str, d: TopPlateDims, box: CouplingBox) -> Sheet:
    """From above, and a section through the inputs' axes with all heights from the lower face."""
    v, holes = d.levels, _boxed_holes(d, box)
    low, high, x, r = v.top_plate_bottom_z, v.top_plate_top_z, v.side_outer_x, d.corner_radius
    at, y, edge, half = max(d.input_x), d.input_y, box.corner_radius, 0.5**0.5
    inner_corner = pocket_corner_mm(box.corner_radius, 2 * box.inner_x, box.shelf_bottom_z - box.flange_top_z)

    def tall(top: float, start_x: float) -> Linear:
        return Linear("section", (-x, y, low), (start_x, y, top), top - low, "left", decimals=3)

    def wide(half_width: float, z: float, side: Side, what: str) -> Linear:
        ends = ((at - half_width, y, z), (at + half_width, y, z))
        return Linear("section", *ends, 2 * half_width, side, suffix=what)

    def deep(from_y: float, what: str) -> Linear:
        """To the front of the boxes."""
        left = -at - box.outer_x + edge
        ends = ((left, from_y, high), (left, front, high))
        return Linear("top", *ends, front - from_y, "left", suffix=what, decimals=3)

    front, back = y + box.front_y, y + box.back_y
    return Sheet(
        part=part,
        title="Top plate",
        paper="A3",
        views=(
            View(
                "section",
                right=X,
                up=Z,
                row=1,
                title="A-A",
                cut=(0.0, y, 0.0),
                axes=tuple(((px, y, low), (px, y, box.top_z)) for px in d.input_x),
            ),
            View("top", right=X, up=Y, hidden=True, axes=_marks(holes)),
        ),
        dimensions=(
            tall(high, -x),
            tall(box.shelf_bottom_z, -at - box.inner_x),
            tall(box.top_z, -at - box.outer_x),
            wide(box.outer_x, box.top_z, "above", " box"),
            wide(box.inner_x, box.shelf_bottom_z, "above", " pocket"),
            *_outline(d),
            deep(back, " boxes"),
            deep(v.back_y, " front of boxes"),
            Radius(
                "top", (r - x, v.front_y - r, high), (r - x - half * r, v.front_y - r + half * r, high), r, prefix="4x "
            ),
            Radius(
                "top",
                (at - box.outer_x + edge, back + edge, box.top_z),
                (at - box.outer_x + edge - half * edge, back + edge - half * edge, box.top_z),
                edge,
                prefix="8x ",
            ),
        ),
        labels=hole_labels(tuple(group for group in holes if group.letter != "C"), "top"),
        datums=(Datum("section", (0.0, y, low), REST),),
        tolerances=(
            *_tolerances(d, box.seat_radius, box.seat_depth, box.shoulder_radius),
            level("section", (at + 0.5 * (box.inner_x + box.outer_x), y, box.top_z), FACE_MM),
        ),
        cutting_lines=(CuttingLine("top", (-x - 4.0, y, low), (x + 4.0, y, low), "A", Y),),
        tables=(hole_table(holes), position_table(holes, (0, 1), "Positions from the axis of hole A")),
        holes=holes,
        fits=tuple(line for group in holes for line in group.fit_lines()),
        notes=(
            "Plate and boxes in one piece; each box and its pocket symmetrical to the axis of B.",
            f"Pockets from the front, {mm(box.inner_x)} behind the axes of B; their corners R{mm(inner_corner, 3)}.",
            "F on the axis of B within 0.02. Bearing seats Ra 0.8, lower face and motor shelf Ra 1.6.",
        ),
    )


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
    top = View("top", right=X, up=Y, hidden=True, axes=_marks(holes, high))
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
            *_outline(d),
            Radius(
                "top", (r - x, v.front_y - r, high), (r - x - corner, v.front_y - r + corner, high), r, prefix="4x "
            ),
        ),
        labels=hole_labels(holes, "top"),
        datums=(Datum("section", (0.5 * max(d.input_x), 0.0, low), REST),),
        tolerances=(
            *_tolerances(d, d.seat_radius, d.seat_depth, d.shoulder_radius),
            level("section", (0.5 * max(d.input_x), 0.0, high), FACE_MM),
        ),
        cutting_lines=(CuttingLine("top", (-x - 4.0, 0.0, high), (x + 4.0, 0.0, high), "A", Y),),
        tables=(hole_table(holes), position_table(holes, (0, 1), "Positions from the axis of hole A")),
        holes=holes,
        fits=tuple(line for group in holes for line in group.fit_lines()),
        notes=("Bearing seats Ra 0.8, faces Ra 1.6.",),
    )
