"""Top plate: the upper bearings of the input pulleys from below, located by dowels on the frame; its sheet.

On it are the encoders or, with motors above, a coupling box for each gearhead, in one piece with the plate.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

from mbcdm_cad.layouts.miso_bevel.support.dims import TopPlateDims
from mbcdm_cad.parts.fits import FACE_MM, FITS, REST, SHOULDER_MM, Datum, GeometricTolerance, level, shoulder_place
from mbcdm_cad.parts.milled import Bores, Feature, Milled, Slab, rounding
from mbcdm_cad.parts.motor_head.dims import CouplingBox
from mbcdm_cad.parts.motor_head.part import box_bodies, box_taken
from mbcdm_cad.parts.part import pocket_corner_mm
from mbcdm_cad.parts.sheet import CuttingLine, Linear, Radius, Sheet, Side, View, X, Y, Z, minus, mm
from mbcdm_cad.parts.sheet_blocks import THROUGH, hole_labels, hole_marks, hole_table, position_table


@dataclass(frozen=True)
class TopPlate(Milled):
    """Top plate where it stands in the assembly; counterbores of the encoders' screws, in its underside, in mm."""

    what = "top plate"

    dims: TopPlateDims
    encoder_head_radius: float
    encoder_head_depth: float

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
        heads, sliding = (2 * d.screw_head_radius, d.screw_head_depth, ""), FITS["pin_slide"].code
        axle = ("A", 2 * d.axle_radius, THROUGH, axis, "top", "guide axle")
        screw = ("D", 2 * d.screw_clearance, THROUGH, screws, "top", "screws")
        mounting = (
            Bores(*axle, fit=FITS["axle_bore"].code, into=down, metal=thick),
            Bores(*screw, counterbore=heads, into=down, metal=thick),
            Bores("E", 2 * d.dowel_radius, THROUGH, dowels, "top", "dowels", fit=sliding, into=down, metal=thick),
        )
        if d.box is not None:
            words = ("bearing seats", "gearheads", "gearhead screws", "key for gearhead screws")
            return (*mounting, *box_taken(d.boxes, d.input_y, "BFGC", words))
        seats = tuple((x, d.input_y, low) for x in d.input_x)
        beside = tuple((x + s * d.encoder_circle_radius, d.input_y, low) for x in d.input_x for s in (-1, 1))
        seat = (2 * d.seat_radius, d.seat_depth, FITS["input_seat"].code)
        sunk = (2 * self.encoder_head_radius, self.encoder_head_depth, "")
        encoder = ("C", 2 * d.encoder_screw_clearance, THROUGH, beside, "below", "encoder screws")
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
            datums=(Datum("section", (0.0, y, low), REST),),
            tolerances=(
                *_tolerances(d, box.seat_radius, box.seat_depth, box.shoulder_radius),
                level("section", (at + 0.5 * (box.inner_x + box.outer_x), y, box.top_z), FACE_MM),
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


def _tolerances(d: TopPlateDims, seat: float, depth: float, shoulder: float) -> tuple[GeometricTolerance, ...]:
    """Shoulders of the bearing seats parallel to the lower face."""
    z = d.levels.top_plate_bottom_z + depth
    dx, dy = shoulder_place(seat, shoulder)
    first, *rest = ((x + dx, d.input_y + dy, z) for x in d.input_x)
    return (level("section", first, SHOULDER_MM, tuple(rest)),)
