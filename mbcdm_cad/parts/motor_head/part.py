"""Motor head: bearing shelf as a flange, a box above it for the coupling, open to the front, the motor shelf on top.

Also with gearhead, motor and encoder as items of a bill, all in the head's frame: Z along the input's axis, from the
encoder towards the motor.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

from mbcdm_cad.design.bought import InsertSpec
from mbcdm_cad.parts import milled
from mbcdm_cad.parts.bill import UPSIDE_DOWN, BillBuilder, Placement
from mbcdm_cad.parts.bodies import EncoderBody
from mbcdm_cad.parts.drum_sector.design import SectorDrive
from mbcdm_cad.parts.drum_sector.items import ENCODER_COLOUR
from mbcdm_cad.parts.fits import FACE_MM, FITS, REST, SHOULDER_MM, Datum, level, shoulder_place
from mbcdm_cad.parts.input_pulley.dims import ENCODER_INSERTION_MM
from mbcdm_cad.parts.input_pulley.items import add_train
from mbcdm_cad.parts.motor_head.dims import CouplingBox, HeadDims, dowel_length_mm, flange_screw
from mbcdm_cad.parts.part import CORNER, cq, pocket_corner_mm
from mbcdm_cad.parts.sheet import CuttingLine, Linear, Sheet, Side, View, X, Y, Z, minus, mm
from mbcdm_cad.parts.sheet_blocks import THROUGH, hole_labels, hole_table, position_table
from mbcdm_cad.parts.turned import Dowel


@dataclass(frozen=True, kw_only=True)
class Slots(milled.Bores):
    """Holes along Z through the metal that are ``longer`` each way along y, mm."""

    longer: float

    def shapes(self) -> list[cq.Shape]:
        """Slots; round holes where they are no longer."""
        return [self._slot(*place) for place in self.places] if self.longer else super().shapes()

    def _slot(self, x: float, y: float, top: float) -> cq.Shape:
        r, z, y_ends = (
            self.diameter / 2,
            (top - self.metal - milled.BEYOND_MM, top + milled.BEYOND_MM),
            (y - self.longer, y + self.longer),
        )
        return milled.fuse(
            [milled.block((x - r, x + r), y_ends, z), *(milled.cylinder_z(r, x, end, *z) for end in y_ends)], "slot"
        )

    def volume_mm3(self) -> float:
        """With what makes them longer."""
        return super().volume_mm3() + len(self.places) * 2.0 * self.longer * self.diameter * self.metal


def box_bodies(
    boxes: Sequence[tuple[float, CouplingBox]], y: float, into_plate_mm: float = 0.0
) -> tuple[milled.Slab, ...]:
    """The boxes at their x without pocket and holes; what reaches into the plate counts with it."""
    return tuple(
        milled.Slab(
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
) -> tuple[milled.Feature, ...]:
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
    keys = milled.Bores(
        *(k[0] if drilled else "", 2 * d.key_hole_radius, THROUGH, below, "below", k[1]),
        into=Z,
        metal=plate,
        share=share,
    )
    return (
        *(
            milled.MilledPocket(
                name="box",
                x=(x - inner, x + inner),
                y=(y - inner, y + d.front_y),
                z=(d.flange_top_z, d.shelf_bottom_z),
                radius=d.corner_radius,
            )
            for x, _ in boxes
        ),
        milled.Bores(
            *(a[0], 2 * d.shoulder_radius, THROUGH, seats, "below", a[1]), counterbore=seat, into=Z, metal=plate
        ),
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


def _open_below(d: HeadDims) -> milled.Form:
    """With a stage the box reaches beyond the flange, where it is open downwards: shelf and two walls.

    Besides the pocket that takes its lower corners.
    """
    front = (d.flange.front_y, d.front_y + 1.0)
    low, middle = d.flange_top_z - 1.0, (d.flange_top_z + d.shelf_bottom_z) / 2
    beyond = d.outer_x + 1.0
    corner = pocket_corner_mm(d.corner_radius, 2 * d.inner_x, d.shelf_bottom_z - d.flange_top_z)
    return milled.Form(
        2 * CORNER * corner**2 * (d.front_y - d.flange.front_y),
        lambda: [
            milled.block((-beyond, beyond), front, (low, d.flange_top_z)),
            milled.block((-d.inner_x, d.inner_x), front, (low, middle)),
        ],
    )


@dataclass(frozen=True)
class MotorHead(milled.Milled):
    """Motor head, its axis Z."""

    what = "motor head"

    dims: HeadDims

    def bodies(self) -> Sequence[milled.Feature]:
        """Flange and box."""
        d, f = self.dims, self.dims.flange
        flange = milled.Slab(
            (-f.half_x, f.half_x), (f.back_y, f.front_y), (d.bottom_z, d.flange_top_z), d.corner_radius
        )
        return flange, *box_bodies([(0.0, d)], 0.0, 0.5)

    def taken(self) -> Sequence[milled.Feature]:
        """Pocket, seat and holes; the axis of hole A is that of the input."""
        d, down, thick = self.dims, minus(Z), self.dims.flange_top_z - self.dims.bottom_z
        words = ("bearing", "pilot of the drive", "screws of the drive", "key for screws of the drive")
        screws, dowels = (tuple((x, y, d.flange_top_z) for x, y in at) for at in (d.flange.screws, d.flange.dowels))
        sliding = FITS["pin_slide"].code
        return (
            *box_taken([(0.0, d)], 0.0, "ABCD", words),
            *([_open_below(d)] if d.beside_y else []),
            milled.Bores("E", 2 * d.screw_clearance, THROUGH, screws, "flange", "screws", into=down, metal=thick),
            milled.Bores(
                "F", 2 * d.dowel_radius, THROUGH, dowels, "flange", "dowels", fit=sliding, into=down, metal=thick
            ),
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
            return milled.span(2, "section", (-x, 0.0, low), (at, 0.0, top), "left")

        def across(half_width: float, z: float, what: str = "") -> Linear:
            side: Side = "above" if z > d.flange_top_z else "below"
            return milled.wide("section", half_width, (0.0, z), side, what)

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
                milled.span(1, "top", (x - r, f.back_y, low), (x - r, f.front_y, low), "right"),
                milled.span(1, "top", axis, (x - r, f.front_y, low), "right"),
                *([milled.span(1, "top", axis, (0.0, d.beside_y, d.top_z), "right")] if d.beside_y else []),
                milled.span(1, "top", (0.0, 0.0, d.top_z), (-d.outer_x + r, d.front_y, d.top_z), "left"),
                milled.span(1, "top", (-d.outer_x + r, d.back_y, d.top_z), (0.0, 0.0, d.top_z), "left"),
                milled.rounding((-x, f.front_y, low), r, "8x "),
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


@dataclass(frozen=True)
class EncoderShelf:
    """The shelf that carries bearing and encoder: its face towards the pulley is ``top_z``; screws sunk in it, mm."""

    bottom_z: float
    top_z: float
    screw_circle: float
    head_depth: float


def _at(stand: Placement, x: float, y: float, z: float) -> Placement:
    return stand @ Placement.translation(x, y, z)


def add_motor_head(b: BillBuilder, drive: SectorDrive, head: HeadDims, stand: Placement, mark: str = "") -> None:
    """Add the head. ``mark`` in the names distinguishes its items from those of other heads."""
    b.add(f"motor_head{mark}", MotorHead(head), part="motor_head", material=drive.frame_material, place=stand)


def add_flange_fixings(
    b: BillBuilder, drive: SectorDrive, head: HeadDims, insert: InsertSpec | None, stand: Placement, mark: str = ""
) -> None:
    """Add the dowels and screws of the head on the frame, and the inserts if the frame has no threads of its own.

    ``mark`` as for the head.
    """
    steel, top, pin = drive.material("steel"), head.flange_top_z, dowel_length_mm(drive)
    for n, (x, y) in enumerate(head.flange.dowels, 1):
        b.standard(
            f"dowel{mark}_{n}",
            Dowel(head.dowel_radius, pin),
            part="dowel",
            material=steel,
            place=_at(stand, x, y, top - pin),
        )
    for n, (x, y) in enumerate(head.flange.screws, 1):
        b.screw(f"flange_screw{mark}_{n}", flange_screw(drive), steel, _at(stand, x, y, top))
        if insert is not None:
            b.insert(f"flange_insert{mark}_{n}", insert, drive.material("brass"), _at(stand, x, y, head.bottom_z))


def add_motor(b: BillBuilder, drive: SectorDrive, face: Placement) -> None:
    """Gearhead and motor of the one input on their shelf, whose face they lie on has its Z towards them."""
    depth = drive.screw(drive.gearhead.screw).length_mm - drive.support.motor_shelf_mm + 1.0
    add_train(b, drive, drive.input_names[0], depth, face @ UPSIDE_DOWN, drive.gearhead_angle_deg)


def add_input_line(b: BillBuilder, drive: SectorDrive, head: HeadDims, shelf: EncoderShelf, stand: Placement) -> None:
    """Gearhead and motor on the head, encoder, if any, behind its shelf, with their screws; ``drive`` has one input."""
    body, steel = drive.material("stainless"), drive.material("steel")
    gear, encoder = drive.gearhead, drive.encoder
    gear_screw, encoder_screw = drive.screw(gear.screw), drive.screw(encoder.screw)
    name = drive.input_names[0]
    add_motor(b, drive, _at(stand, 0.0, head.beside_y, head.top_z))
    sunk, thick = shelf.head_depth, shelf.top_z - shelf.bottom_z
    encoder_screws = 0 if encoder.absent else 2
    if not encoder.absent:
        b.add(
            f"encoder_{name}",
            EncoderBody(
                encoder, encoder_screw, ENCODER_INSERTION_MM + 0.5, encoder_screw.length_mm - (thick - sunk) + 0.5
            ),
            part="encoder",
            material=replace(body, colour=ENCODER_COLOUR),
            place=_at(stand, 0.0, 0.0, shelf.bottom_z) @ UPSIDE_DOWN,
            mass_g=encoder.mass_g,
        )
    for n in range(max(encoder_screws, len(head.gear_screws))):
        if n < len(head.gear_screws):
            x, y = head.gear_screws[n]
            place = _at(stand, x, y, head.shelf_bottom_z) @ UPSIDE_DOWN
            b.screw(f"{drive.mounted_stem}_screw_{name}_{n + 1}", gear_screw, steel, place)
        if n < encoder_screws:
            place = _at(stand, (-1, 1)[n] * shelf.screw_circle, 0.0, shelf.top_z - sunk)
            b.screw(f"encoder_screw_{name}_{n + 1}", encoder_screw, steel, place)


def add_input_bearings(
    b: BillBuilder, drive: SectorDrive, head: HeadDims, shelf: EncoderShelf, stand: Placement
) -> None:
    """The pulley's bearings: in the head's flange and in the encoder's shelf, both on the pulley's side."""
    ring, bearings, name = drive.material("bearing-steel"), drive.bearings, drive.input_names[0]
    b.bearing(f"input_bearing_lower_{name}", bearings.input_lower, ring, _at(stand, 0.0, 0.0, head.bottom_z))
    seat = shelf.top_z - bearings.input_upper.width_mm
    b.bearing(f"input_bearing_upper_{name}", bearings.input_upper, ring, _at(stand, 0.0, 0.0, seat))
