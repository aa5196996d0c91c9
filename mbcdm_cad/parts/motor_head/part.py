"""Motor head: bearing shelf as a flange, a box above it for the coupling, open to the front, the motor shelf on top."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from mbcdm_cad.parts.fits import FITS
from mbcdm_cad.parts.milled import BEYOND_MM, Block, Bores, Feature, Form, Milled, Pocket, rounding, span, wide
from mbcdm_cad.parts.motor_head.dims import CouplingBox, HeadDims
from mbcdm_cad.parts.shapes import block, cylinder_z, fuse
from mbcdm_cad.parts.sheets.description import CuttingLine, Linear, Sheet, Side, View, X, Y, Z, minus, mm
from mbcdm_cad.parts.sheets.holes import THROUGH, hole_labels, hole_table, position_table
from mbcdm_cad.parts.sheets.tolerances import FACE_MM, REST, SHOULDER_MM, Datum, level, shoulder_place
from mbcdm_cad.parts.volume import CORNER, pocket_corner_mm

if TYPE_CHECKING:
    import cadquery as cq


@dataclass(frozen=True, kw_only=True)
class Slots(Bores):
    """Holes along Z through the metal that are ``longer`` each way along y, mm."""

    longer: float

    def shapes(self) -> list[cq.Shape]:
        """Slots; round holes where they are no longer."""
        return [self._slot(*place) for place in self.places] if self.longer else super().shapes()

    def _slot(self, x: float, y: float, top: float) -> cq.Shape:
        r, z, y_ends = (
            self.diameter / 2,
            (top - self.metal - BEYOND_MM, top + BEYOND_MM),
            (y - self.longer, y + self.longer),
        )
        return fuse([block((x - r, x + r), y_ends, z), *(cylinder_z(r, x, end, *z) for end in y_ends)], "slot")

    def volume_mm3(self) -> float:
        """With what makes them longer."""
        return super().volume_mm3() + len(self.places) * 2.0 * self.longer * self.diameter * self.metal


def box_bodies(boxes: Sequence[tuple[float, CouplingBox]], y: float, into_plate_mm: float = 0.0) -> tuple[Block, ...]:
    """The boxes at their x without pocket and holes; what reaches into the plate counts with it."""
    return tuple(
        Block(
            (x - d.outer_x, x + d.outer_x),
            (y + d.back_y, y + d.front_y),
            (d.flange_top_z - into_plate_mm, d.top_z),
            d.corner_radius,
            into_mm=into_plate_mm,
        )
        for x, d in boxes
    )


def box_taken(
    boxes: Sequence[tuple[float, CouplingBox]], y: float, letters: str, words: tuple[str, str, str, str]
) -> tuple[Feature, ...]:
    """Pockets, bearing seats, pilots, holes for the gearhead's screws and for their key, with letters and purposes."""
    _, d = boxes[0]
    inner, down, plate, shelf = d.inner_x, minus(Z), d.flange_top_z - d.bottom_z, d.top_z - d.shelf_bottom_z
    seat = (2 * d.seat_radius, d.seat_depth, FITS["input_seat"].code)
    # About half of each key hole lies outside the shoulder's bore, or nothing: then it is not drilled.
    share = max(plate - d.seat_depth, 0.0) / plate / 2
    drilled = d.gear_bolt_circle + d.key_hole_radius > d.shoulder_radius
    screws = [(x + dx, y + dy) for x, box in boxes for dx, dy in box.gear_screws]
    seats, pilots = (tuple((x, y + off, z) for x, _ in boxes) for off, z in ((0.0, d.bottom_z), (d.beside_y, d.top_z)))
    on_top, below = (tuple((*place, z) for place in screws) for z in (d.top_z, d.bottom_z))
    a, b, c, k = zip(letters, words, strict=True)
    keys = Bores(
        *(k[0] if drilled else "", 2 * d.key_hole_radius, THROUGH, below, "below", k[1]),
        into=Z,
        metal=plate,
        share=share,
    )
    return (
        *(
            Pocket(
                name="box",
                x=(x - inner, x + inner),
                y=(y - inner, y + d.front_y),
                z=(d.flange_top_z, d.shelf_bottom_z),
                radius=d.corner_radius,
            )
            for x, _ in boxes
        ),
        Bores(*(a[0], 2 * d.shoulder_radius, THROUGH, seats, "below", a[1]), counterbore=seat, into=Z, metal=plate),
        Slots(
            *(b[0], 2 * d.pilot_radius, THROUGH, pilots, "motor shelf", b[1]),
            fit=FITS["pilot"].code,
            into=down,
            metal=shelf,
            longer=d.take_up,
        ),
        Slots(
            *(c[0], 2 * d.gear_screw_clearance, THROUGH, on_top, "motor shelf", c[1]),
            into=down,
            metal=shelf,
            longer=d.take_up,
        ),
        *([] if d.beside_y else [keys]),
    )


def _open_below(d: HeadDims) -> Form:
    """With a stage the box reaches beyond the flange, where it is open downwards: shelf and two walls.

    Besides the pocket that takes its lower corners.
    """
    front = (d.flange.front_y, d.front_y + 1.0)
    low, middle = d.flange_top_z - 1.0, (d.flange_top_z + d.shelf_bottom_z) / 2
    beyond = d.outer_x + 1.0
    corner = pocket_corner_mm(d.corner_radius, 2 * d.inner_x, d.shelf_bottom_z - d.flange_top_z)
    return Form(
        2 * CORNER * corner**2 * (d.front_y - d.flange.front_y),
        lambda: [
            block((-beyond, beyond), front, (low, d.flange_top_z)),
            block((-d.inner_x, d.inner_x), front, (low, middle)),
        ],
    )


@dataclass(frozen=True)
class MotorHead(Milled):
    """Motor head, its axis Z."""

    what = "motor head"

    dims: HeadDims

    def bodies(self) -> Sequence[Feature]:
        """Flange and box."""
        d, f = self.dims, self.dims.flange
        flange = Block((-f.half_x, f.half_x), (f.back_y, f.front_y), (d.bottom_z, d.flange_top_z), d.corner_radius)
        return flange, *box_bodies([(0.0, d)], 0.0, 0.5)

    def taken(self) -> Sequence[Feature]:
        """Pocket, seat and holes; the axis of hole A is that of the input."""
        d, down, thick = self.dims, minus(Z), self.dims.flange_top_z - self.dims.bottom_z
        words = ("bearing", "pilot of the drive", "screws of the drive", "key for screws of the drive")
        screws, dowels = (tuple((x, y, d.flange_top_z) for x, y in at) for at in (d.flange.screws, d.flange.dowels))
        sliding = FITS["pin_slide"].code
        return (
            *box_taken([(0.0, d)], 0.0, "ABCD", words),
            *([_open_below(d)] if d.beside_y else []),
            Bores("E", 2 * d.screw_clearance, THROUGH, screws, "flange", "screws", into=down, metal=thick),
            Bores("F", 2 * d.dowel_radius, THROUGH, dowels, "flange", "dowels", fit=sliding, into=down, metal=thick),
        )

    def sheet(self, part: str) -> Sheet:
        """From above and in section, with all heights from the lower face."""
        d = self.dims
        f, r = d.flange, d.corner_radius
        holes = self.bores()
        corner_in = pocket_corner_mm(r, 2 * d.inner_x, d.shelf_bottom_z - d.flange_top_z)
        low, x = d.bottom_z, f.half_x
        axis, seen = (0.0, 0.0, low), tuple(group for group in holes if group.letter in "BCEF")

        def tall(top: float, at: float) -> Linear:
            return span(2, "section", (-x, 0.0, low), (at, 0.0, top), "left")

        def across(half_width: float, z: float, what: str = "") -> Linear:
            side: Side = "above" if z > d.flange_top_z else "below"
            return wide("section", half_width, (0.0, z), side, what)

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
                across(x, low),
                across(d.outer_x, d.top_z),
                across(d.inner_x, d.shelf_bottom_z, " pocket"),
                span(1, "top", (x - r, f.back_y, low), (x - r, f.front_y, low), "right"),
                span(1, "top", axis, (x - r, f.front_y, low), "right"),
                *([span(1, "top", axis, (0.0, d.beside_y, d.top_z), "right")] if d.beside_y else []),
                span(1, "top", (0.0, 0.0, d.top_z), (-d.outer_x + r, d.front_y, d.top_z), "left"),
                span(1, "top", (-d.outer_x + r, d.back_y, d.top_z), (0.0, 0.0, d.top_z), "left"),
                rounding((-x, f.front_y, low), r, "8x "),
            ),
            labels=hole_labels(seen, "top"),
            datums=(Datum("section", ((x + d.seat_radius) / 2, 0.0, low), REST),),
            tolerances=(
                level("section", (*shoulder_place(d.seat_radius, d.shoulder_radius), low + d.seat_depth), SHOULDER_MM),
                level("section", (0.5 * (d.inner_x + d.outer_x), 0.0, d.top_z), FACE_MM),
            ),
            cutting_lines=(CuttingLine("top", (-x - 4.0, 0.0, low), (x + 4.0, 0.0, low), "A", Y),),
            tables=(hole_table(holes), position_table(holes, (0, 1), "Positions from the axis of A")),
            holes=holes,
            fits=tuple(line for group in holes for line in group.fit_lines()),
            notes=(
                f"Pocket from the front, {mm(d.inner_x)} behind the axis of A; its corners R{mm(corner_in, 3)}.",
                *(["Before the flange the pocket is open downwards."] if d.beside_y else []),
                *([f"B and C are slots, {mm(d.take_up)} longer each way along Y."] if d.take_up else []),
                "Bearing seat Ra 0.8.",
            ),
        )
