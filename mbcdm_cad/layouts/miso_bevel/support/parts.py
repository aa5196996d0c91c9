"""Frame and top plate as parts, with their sheets.

The frame is one block, milled from the front in four pockets, bored for the drum's shaft along Y. The top plate has the
upper bearings of the input pulleys from below, located by dowels on the frame; on it are the encoders or, with motors
above, a coupling box for each gearhead, in one piece with the plate.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

from mbcdm_cad.layouts.miso_bevel.support import FrameDims, TopPlateDims
from mbcdm_cad.parts import fits
from mbcdm_cad.parts.boss import boss_bores, boss_of_column, boss_threads, in_section, open_behind, seats_mm
from mbcdm_cad.parts.milled import Bores, Feature, Milled, MilledPocket, Slab, corner_table, rounding, span, wide
from mbcdm_cad.parts.motor_head.dims import CouplingBox
from mbcdm_cad.parts.motor_head.part import box_bodies, box_taken
from mbcdm_cad.parts.part import pocket_corner_mm
from mbcdm_cad.parts.sheet import CuttingLine, FitLine, Holes, Linear, Radius, Sheet, Side, View, X, Y, Z, minus, mm
from mbcdm_cad.parts.sheet_blocks import THROUGH, hole_labels, hole_marks, hole_table, position_table


def _pockets(d: FrameDims) -> tuple[MilledPocket, ...]:
    """From the front; the last one, in the column, only where there is room."""
    v, r, side, inner = d.levels, d.corner_radius, d.levels.side_inner_x, d.boss.radius - d.rib_thickness
    y, top = (v.pocket_floor_y, v.front_y), (v.bearing_shelf_top_z, v.top_plate_bottom_z)
    beside, column = (v.shelf_top_z, v.bearing_shelf_bottom_z), (d.column_pocket_bottom_z, v.shelf_bottom_z)
    return (
        MilledPocket(name="top pocket", x=(-side, side), y=(d.upper_floor_y, y[1]), z=top, radius=r, open_top=True),
        MilledPocket(name="", x=(-side, -d.web_half_width), y=y, z=beside, radius=r),
        MilledPocket(name="beside the web", x=(d.web_half_width, side), y=y, z=beside, radius=r),
        MilledPocket(name="column", x=(-inner, inner), y=y, z=column, radius=r),
    )


def _at_inputs(d: FrameDims) -> tuple[Bores, ...]:
    """Bearing seats and what is beside them: holes for the key of the gearheads' screws, or the encoders' screws.

    The gearheads hang from the lowest shelf.
    """
    v, down, y = d.levels, minus(Z), d.input_y
    high, low = v.bearing_shelf_top_z, v.shelf_top_z
    bearing, lowest = high - v.bearing_shelf_bottom_z, low - v.shelf_bottom_z
    seat = (2 * d.seat_radius, d.seat_depth, fits.FITS["input_seat"].code)
    axes, screws = tuple((x, y, high) for x in d.input_x), 2 * d.gear_screw_clearance
    shoulder = ("B", 2 * d.seat_shoulder_radius, THROUGH, axes, "bearing shelf", "bearing seats")
    seats = Bores(*shoulder, counterbore=seat, into=down, metal=bearing)
    if d.encoder_holes is not None:
        e = d.encoder_holes
        places = tuple((at, y, high) for x in d.input_x for at in e.places(x))
        of = ("C", 2 * e.clearance, THROUGH, places, "bearing shelf", "encoder screws")
        return seats, Bores(*of, counterbore=(2 * e.head_radius, e.head_depth, ""), into=down, metal=bearing)
    # About half of each key hole lies outside the shoulder's bore, or nothing: then it is not drilled.
    share = max(bearing - d.seat_depth, 0.0) / bearing / 2
    keyed = "C" if d.gear_bolt_circle + d.key_hole_radius > d.seat_shoulder_radius else ""
    keys, through = (tuple((*place, z) for place in d.gear_screws) for z in (high, low))
    pilots, pilot = tuple((x, y, low) for x in d.input_x), 2 * d.pilot_radius
    key = (keyed, 2 * d.key_hole_radius, THROUGH, keys, "bearing shelf", "key for gearhead screws")
    centred = ("F", pilot, THROUGH, pilots, "motor shelf", "gearheads")
    return (
        seats,
        Bores(*key, into=down, metal=bearing, share=share),
        Bores(*centred, fit=fits.FITS["pilot"].code, into=down, metal=lowest),
        Bores("G", screws, THROUGH, through, "motor shelf", "gearhead screws", into=down, metal=lowest),
    )


def _fixings(d: FrameDims) -> tuple[Bores, ...]:
    """Holes for the guide's axle, the top plate, the stop pin and the mounting screws."""
    v, down, back, pressed = d.levels, minus(Z), minus(Y), fits.FITS["pin_press"].code
    shelf, top, floor = v.bearing_shelf_top_z, v.top_plate_bottom_z, v.pocket_floor_y
    thick, sunk = shelf - v.bearing_shelf_bottom_z, floor - d.mount_seat_y
    screws, dowels = (tuple((x, y, top) for x, y in at) for at in (d.plate_screws, d.dowels))
    mounts, pin = tuple((x, floor, z) for x, z in d.mounts), ((0.0, v.front_y, d.stop_pin_z),)
    set_screw = ((0.0, v.front_y, (v.bearing_shelf_bottom_z + shelf) / 2),)
    heads = (2 * d.mount_head_radius, sunk, "") if sunk > 0.0 else None
    axle = ("A", 2 * d.axle_radius, THROUGH, ((0.0, 0.0, shelf),), "bearing shelf", "guide axle")
    to_plate = ("D", d.plate_screw_radius * 2, d.plate_screw_depth, screws, "top", "top plate")
    to_axle = ("H", 2 * d.axle_screw_radius, "to A", set_screw, "front", "axle set screw")
    stop = ("J", 2 * d.stop_pin_radius, v.front_y - d.stop_pin_start_y, pin, "front", "stop pin")
    mount = ("K", 2 * d.mount_radius, THROUGH, mounts, "pocket floor", "mounting screws")
    insert = d.plate_insert
    return (
        # It ends on the shelf's lower face.
        Bores(*axle, fit=fits.FITS["axle_bore"].code, into=down, metal=thick, beyond=0.0),
        Bores(*to_plate, threaded=insert is None, insert=insert, into=down),
        Bores("E", 2 * d.dowel_radius, d.dowel_depth, dowels, "top", "dowels", fit=pressed, into=down),
        Bores(*to_axle, threaded=True, into=back, metal=v.front_y - d.axle_radius, beyond=d.axle_radius),
        Bores(*stop, fit=pressed, into=back),
        Bores(*mount, counterbore=heads, into=back, metal=floor - v.back_y),
    )


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
                *hole_marks(front_seen, X, Z),
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
                *hole_marks(tuple(g for g in behind if g.letter == "L"), X, Z),
                ((0.0, v.back_y, -d.boss.encoder_pocket_radius), (0.0, v.back_y, d.boss.encoder_pocket_radius)),
            ),
        ),
        View("top", minus(X), minus(Y), row=-1, axes=hole_marks(high, X, Y)),
        View(
            "shelf", minus(X), minus(Y), row=-2, title="B-B", cut=(0.0, 0.0, middle), axes=hole_marks(low_shelf, X, Y)
        ),
    )


def _dimensions(d: FrameDims) -> tuple[Linear | Radius, ...]:
    """In front from the middle plane and the drum's axis, in the section from the back face; the boss from behind."""
    v, b, r, back, start = d.levels, d.boss, d.corner_radius, d.levels.back_y, d.column_start_z
    y, top, low, x, side = v.front_y, v.top_plate_bottom_z, v.shelf_bottom_z, v.side_outer_x, v.side_inner_x
    inner, shelf, under = b.radius - d.rib_thickness, v.bearing_shelf_top_z, v.bearing_shelf_bottom_z
    left = [(low, x), (top, x), *([(d.column_pocket_bottom_z, inner)] if d.has_column_pocket else [])]
    right = ((low, v.shelf_top_z, r - x), (v.shelf_top_z, under, -side), (under, shelf, -side))
    above = (
        (v.front_y, top, ""),
        (v.pocket_floor_y, under, " pockets"),
        (d.upper_floor_y, top, " top pocket"),
        (0.0, shelf, " axis of A"),
    )
    ears = ((-b.ear_reach, y, -b.ear_half_height), (-b.ear_reach, y, b.ear_half_height))
    pocket_r = b.encoder_pocket_radius
    pocket = (wide("front", inner, (y, d.column_pocket_bottom_z), "below", " pocket"),)
    tall = [span(2, "front", (at, y, 0.0), (at, y, z), "left") for z, at in left]
    return (
        wide("front", x, (y, top), "above"),
        wide("front", side, (y, top), "above", " pockets"),
        wide("front", d.web_half_width, (y, (v.shelf_top_z + under) / 2), "above", " web"),
        wide("front", b.radius, (y, start), "below", " column = %%c boss"),
        wide("front", b.ear_reach, (y, 0.0), "below", " ears"),
        *tall[:2],
        *(span(2, "front", (at, y, from_z), (at, y, z), "right") for from_z, z, at in right),
        span(2, "front", *ears, "right", " ears", decimals=2),
        *(pocket if d.has_column_pocket else ()),
        *tall[2:],
        *(span(1, "section", (0.0, back, top), (0.0, to, z), "above", what) for to, z, what in above),
        *in_section(b, start),
        span(2, "rear", (b.radius, back, 0.0), (b.radius, back, start), "right", " column"),
        Radius("rear", (0.0, back, 0.0), (-pocket_r * 0.6, back, pocket_r * 0.8), pocket_r),
        rounding((-x, y, top), r, "4x "),
    )


def _tolerances(d: FrameDims) -> tuple[fits.GeometricTolerance, ...]:
    """Seats of the drum on one axis; bores of guide and inputs square to it."""
    v, depth = d.levels, d.seat_depth / 2
    shelf = (v.bearing_shelf_bottom_z + v.bearing_shelf_top_z) / 2
    first, *rest = ((x, d.input_y - d.seat_radius, v.bearing_shelf_top_z - depth) for x in d.input_x)
    return (
        fits.one_axis("section", seats_mm(d.boss), fits.DRUM_AXIS),
        fits.square("section", (0.0, -d.axle_radius, shelf), fits.DRUM_AXIS, "A"),
        fits.square("top", first, fits.DRUM_AXIS, "B", tuple(rest)),
    )


@dataclass(frozen=True)
class Frame(Milled):
    """Frame where it stands in the assembly."""

    dims: FrameDims

    def bodies(self) -> Sequence[Feature]:
        """Slab, column and boss."""
        d, v, b = self.dims, self.dims.levels, self.dims.boss
        y, x, z = (v.back_y, v.front_y), v.side_outer_x, (v.shelf_bottom_z, v.top_plate_bottom_z)
        column = Slab((-b.radius, b.radius), y, (0.0, v.shelf_bottom_z))
        return Slab((-x, x), y, z, d.corner_radius), column, boss_of_column(b, v.front_y)

    def taken(self) -> Sequence[Feature]:
        """Pockets, bores and holes."""
        d = self.dims
        pockets: Sequence[Feature] = _pockets(d) if d.has_column_pocket else _pockets(d)[:-1]
        boss: Sequence[Feature] = (
            open_behind(d.boss, -d.boss.radius - 1.0),
            boss_bores(d.boss),
            *boss_threads(d.boss, "L"),
        )
        return (*pockets, *boss, *_at_inputs(d), *_fixings(d))

    def sheet(self, part: str) -> Sheet:
        """Front, middle section, rear, top, and a section above the lowest shelf."""
        d, holes = self.dims, self.bores()
        v = d.levels
        above, behind = (tuple(g for g in holes if (g.into[2] != 0.0) == along_z) for along_z in (True, False))
        seen = tuple(g for g in behind if g.letter != "L")
        x, y = v.side_outer_x, v.front_y
        middle = (v.shelf_top_z + v.bearing_shelf_bottom_z) / 2
        return Sheet(
            part=part,
            title="Frame",
            paper="A2",
            views=_views(d, above, behind),
            dimensions=_dimensions(d),
            labels=(
                *hole_labels(seen, "front"),
                *hole_labels(tuple(g for g in behind if g.letter == "L"), "rear"),
                *hole_labels(tuple(g for g in above if g.letter not in "FG"), "top"),
                *hole_labels(tuple(g for g in above if g.letter in "FG"), "shelf"),
            ),
            tolerances=_tolerances(d),
            cutting_lines=(
                CuttingLine(
                    "front", (0.0, y, -d.boss.radius - 2.0), (0.0, y, v.top_plate_bottom_z + 2.0), "A", minus(X)
                ),
                CuttingLine("front", (x + 2.0, y, middle), (-x - 2.0, y, middle), "B", minus(Z)),
            ),
            tables=(
                hole_table(holes),
                position_table(above, (0, 1), "Positions from A and the drum axis, along Z"),
                position_table(behind, (0, 2), "Positions from A and the drum axis, along Y"),
                corner_table(p for p in _pockets(d) if p.name),
            ),
            holes=holes,
            fits=(
                FitLine(2 * d.boss.seat_radius, fits.FITS["drum_seat"].code, "drum bearing seats"),
                *(line for group in holes for line in group.fit_lines()),
            ),
            notes=(
                "One piece. X to the right in the rear view, Y to the front, Z up; Y = 0 at the axis of A.",
                "The radius in the rear view is that of the encoder's pocket.",
                "Seats Ra 0.8, elsewhere Ra 3.2.",
            ),
        )


@dataclass(frozen=True)
class TopPlate(Milled):
    """Top plate where it stands in the assembly."""

    what = "top plate"

    dims: TopPlateDims

    def bodies(self) -> Sequence[Feature]:
        """Plate, with the coupling boxes on it."""
        d, v = self.dims, self.dims.levels
        x, y, z = v.side_outer_x, (v.back_y, v.front_y), (v.top_plate_bottom_z, v.top_plate_top_z)
        return Slab((-x, x), y, z, d.corner_radius), *box_bodies(d.boxes, d.input_y)

    def taken(self) -> Sequence[Feature]:
        """Bearing seats and holes for encoders or gearheads from below, the others from the top."""
        d, v, down = self.dims, self.dims.levels, minus(Z)
        low, high, thick = v.top_plate_bottom_z, v.top_plate_top_z, v.top_plate_top_z - v.top_plate_bottom_z
        axis, (screws, dowels) = (
            ((0.0, 0.0, high),),
            (tuple((x, y, high) for x, y in at) for at in (d.screws, d.dowels)),
        )
        heads, sliding = (2 * d.screw_head_radius, d.screw_head_depth, ""), fits.FITS["pin_slide"].code
        axle = ("A", 2 * d.axle_radius, THROUGH, axis, "top", "guide axle")
        screw = ("D", 2 * d.screw_clearance, THROUGH, screws, "top", "screws")
        mounting = (
            Bores(*axle, fit=fits.FITS["axle_bore"].code, into=down, metal=thick),
            Bores(*screw, counterbore=heads, into=down, metal=thick),
            Bores("E", 2 * d.dowel_radius, THROUGH, dowels, "top", "dowels", fit=sliding, into=down, metal=thick),
        )
        if d.box is not None:
            words = ("bearing seats", "gearheads", "gearhead screws", "key for gearhead screws")
            return (*mounting, *box_taken(d.boxes, d.input_y, "BFGC", words))
        seats = tuple((x, d.input_y, low) for x in d.input_x)
        e = d.encoder_holes
        assert e is not None, "the encoders stand on the plate where no gearhead does"
        beside = tuple((at, d.input_y, low) for x in d.input_x for at in e.places(x))
        seat = (2 * d.seat_radius, d.seat_depth, fits.FITS["input_seat"].code)
        sunk = (2 * e.head_radius, e.head_depth, "")
        encoder = ("C", 2 * e.clearance, THROUGH, beside, "below", "encoder screws")
        return (
            *mounting,
            Bores(
                *("B", 2 * d.shoulder_radius, THROUGH, seats, "below", "bearing seats"),
                counterbore=seat,
                into=Z,
                metal=thick,
            ),
            Bores(*encoder, counterbore=sunk, into=Z, metal=thick),
        )

    def sheet(self, part: str) -> Sheet:
        """Plain or with a coupling box for each gearhead; the holes as tables."""
        return self._plain(part) if self.dims.box is None else self._boxed(part, self.dims.box)

    def _plain(self, part: str) -> Sheet:
        """View from above with the trace of a section through the bearing seats; the holes as tables."""
        d, holes = self.dims, self.bores()
        v = d.levels
        low, high, x, r = v.top_plate_bottom_z, v.top_plate_top_z, v.side_outer_x, d.corner_radius
        top = View("top", right=X, up=Y, hidden=True, axes=hole_marks(holes, X, Y, high))
        section = View(
            "section",
            right=X,
            up=Z,
            row=1,
            title="A-A",
            cut=(0.0, 0.0, 0.0),
            axes=tuple(((px, 0.0, low), (px, 0.0, high)) for px in (0.0, *d.input_x)),
        )
        return Sheet(
            part=part,
            title="Top plate",
            paper="A3",
            views=(section, top),
            dimensions=(
                Linear("section", (x, 0.0, low), (x, 0.0, high), high - low, "right"),
                *_outline(d),
                rounding((-x, v.front_y, high), r, "4x "),
            ),
            labels=hole_labels(holes, "top"),
            datums=(fits.Datum("section", (0.5 * max(d.input_x), 0.0, low), fits.REST),),
            tolerances=(
                *_of_plate(d, d.seat_radius, d.seat_depth, d.shoulder_radius),
                fits.level("section", (0.5 * max(d.input_x), 0.0, high), fits.FACE_MM),
            ),
            cutting_lines=(CuttingLine("top", (-x - 4.0, 0.0, high), (x + 4.0, 0.0, high), "A", Y),),
            tables=(hole_table(holes), position_table(holes, (0, 1), "Positions from the axis of hole A")),
            holes=holes,
            fits=tuple(line for group in holes for line in group.fit_lines()),
            notes=("Bearing seats Ra 0.8, faces Ra 1.6.",),
        )

    def _boxed(self, part: str, box: CouplingBox) -> Sheet:
        """From above, and a section through the inputs' axes with all heights from the lower face."""
        d, holes = self.dims, self.bores()
        v = d.levels
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
        return replace(
            self._plain(part),
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
                View("top", right=X, up=Y, hidden=True, axes=hole_marks(holes, X, Y)),
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
                rounding((-x, v.front_y, high), r, "4x "),
                Radius(
                    "top",
                    (at - box.outer_x + edge, back + edge, box.top_z),
                    (at - box.outer_x + edge - half * edge, back + edge - half * edge, box.top_z),
                    edge,
                    prefix="8x ",
                ),
            ),
            labels=hole_labels(tuple(group for group in holes if group.letter != "C"), "top"),
            datums=(fits.Datum("section", (0.0, y, low), fits.REST),),
            tolerances=(
                *_of_plate(d, box.seat_radius, box.seat_depth, box.shoulder_radius),
                fits.level("section", (at + 0.5 * (box.inner_x + box.outer_x), y, box.top_z), fits.FACE_MM),
            ),
            cutting_lines=(CuttingLine("top", (-x - 4.0, y, low), (x + 4.0, y, low), "A", Y),),
            notes=(
                "Plate and boxes in one piece; each box and its pocket symmetrical to the axis of B.",
                f"Pockets from the front, {mm(box.inner_x)} behind the axes of B; "
                f"their corners R{mm(inner_corner, 3)}.",
                "F on the axis of B within 0.02. Bearing seats Ra 0.8, lower face and motor shelf Ra 1.6.",
            ),
        )


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


def _of_plate(d: TopPlateDims, seat: float, depth: float, shoulder: float) -> tuple[fits.GeometricTolerance, ...]:
    """Shoulders of the bearing seats parallel to the lower face."""
    z = d.levels.top_plate_bottom_z + depth
    dx, dy = fits.shoulder_place(seat, shoulder)
    first, *rest = ((x + dx, d.input_y + dy, z) for x in d.input_x)
    return (fits.level("section", first, fits.SHOULDER_MM, tuple(rest)),)
