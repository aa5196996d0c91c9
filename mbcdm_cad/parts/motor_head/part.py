"""Motor head: bearing shelf as a flange, a box above it for the coupling, open to the front, the motor shelf on top."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from mbcdm_cad.parts.fits import FITS
from mbcdm_cad.parts.motor_head.dims import CouplingBox, HeadDims
from mbcdm_cad.parts.part import MadePart
from mbcdm_cad.parts.shapes import block, cut, cylinder_z, fuse, pocket_y
from mbcdm_cad.parts.sheets.description import CuttingLine, Holes, Linear, Radius, Sheet, Side, View, X, Y, Z, mm
from mbcdm_cad.parts.sheets.holes import THROUGH, hole_labels, hole_table, outside_bore, position_table
from mbcdm_cad.parts.sheets.tolerances import FACE_MM, REST, SHOULDER_MM, Datum, level, shoulder_place
from mbcdm_cad.parts.volume import CORNER, pocket_corner_mm, pocket_mm3, ring_mm3

if TYPE_CHECKING:
    import cadquery as cq


def coupling_box_mm3(d: CouplingBox, plate_mm3: float = 0.0) -> float:
    """A plate with a coupling box on it, less the box's pocket, bearing seat and holes."""
    flange, height = d.flange_top_z - d.bottom_z, d.top_z - d.flange_top_z
    body = plate_mm3 + (2 * d.outer_x * (d.front_y - d.back_y) - 4 * CORNER * d.corner_radius**2) * height
    inner, shelf = d.inner_x, d.top_z - d.shelf_bottom_z
    longer = 4.0 * d.take_up * shelf * (d.pilot_radius + len(d.gear_screws) * d.gear_screw_clearance)
    keys = 0.0 if d.beside_y else ring_mm3(d.key_hole_radius, 0.0, flange - d.seat_depth) / 2
    return (
        body
        - pocket_mm3(2 * inner, d.front_y + inner, d.shelf_bottom_z - d.flange_top_z, d.corner_radius)
        - ring_mm3(d.pilot_radius, 0.0, shelf)
        - longer
        - ring_mm3(d.shoulder_radius, 0.0, flange - d.seat_depth)
        - ring_mm3(d.seat_radius, 0.0, d.seat_depth)
        # About half of each key hole lies outside the shoulder's bore.
        - len(d.gear_screws) * (ring_mm3(d.gear_screw_clearance, 0.0, shelf) + keys)
    )


def box_body(d: CouplingBox, into_plate_mm: float = 0.0) -> cq.Shape:
    """The box without its pocket and holes, reaching this far into its plate."""
    box = block((-d.outer_x, d.outer_x), (d.back_y, d.front_y), (d.flange_top_z - into_plate_mm, d.top_z))
    return rounded(box, d.corner_radius)


def box_tools(d: CouplingBox) -> list[cq.Shape]:
    """Pocket, pilot, bearing seat, and the holes for the gearhead's screws and their key."""
    inner = d.inner_x
    tools: list[cq.Shape] = [
        pocket_y((-inner, inner), (-inner, d.front_y + 1.0), (d.flange_top_z, d.shelf_bottom_z), d.corner_radius),
        _slot(d.pilot_radius, 0.0, d.beside_y, d.shelf_bottom_z - 1.0, d.top_z + 1.0, d.take_up),
        cylinder_z(d.shoulder_radius, 0, 0, d.bottom_z, d.flange_top_z + 1.0),
        cylinder_z(d.seat_radius, 0, 0, d.bottom_z - 1.0, d.bottom_z + d.seat_depth),
    ]
    for x, y in d.gear_screws:
        tools.append(_slot(d.gear_screw_clearance, x, y, d.shelf_bottom_z - 1.0, d.top_z + 1.0, d.take_up))
        if not d.beside_y:
            tools.append(cylinder_z(d.key_hole_radius, x, y, d.bottom_z, d.flange_top_z + 1.0))
    return tools


def _slot(radius: float, x: float, y: float, start_z: float, end_z: float, longer: float) -> cq.Shape:
    """Hole along Z, ``longer`` each way along y."""
    if not longer:
        return cylinder_z(radius, x, y, start_z, end_z)
    ends = [cylinder_z(radius, x, y + way * longer, start_z, end_z) for way in (-1, 1)]
    return fuse([block((x - radius, x + radius), (y - longer, y + longer), (start_z, end_z)), *ends], "slot")


def rounded(body: cq.Solid, radius: float) -> cq.Shape:
    """The body with its edges along Z rounded."""
    import cadquery as cq

    return cq.Workplane(obj=body).edges("|Z").fillet(radius).val()  # type: ignore[return-value]


def _holes(d: HeadDims) -> tuple[Holes, ...]:
    """The holes, all along Z; the axis of hole A is that of the input."""
    seat = (2 * d.seat_radius, d.seat_depth, FITS["input_seat"].code)
    groups = (
        Holes("A", 2 * d.shoulder_radius, THROUGH, ((0.0, 0.0, d.bottom_z),), "below", "bearing", counterbore=seat),
        Holes(
            "B",
            2 * d.pilot_radius,
            THROUGH,
            ((0.0, d.beside_y, d.top_z),),
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
            ()
            if d.beside_y
            else outside_bore(
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


def _open_below(d: HeadDims) -> list[cq.Shape]:
    """With a stage the box reaches beyond the flange, where it is open downwards: shelf and two walls."""
    front = (d.flange.front_y, d.front_y + 1.0)
    if not d.beside_y:
        return []
    middle = (d.flange_top_z + d.shelf_bottom_z) / 2
    beyond = d.outer_x + 1.0
    return [
        block((-beyond, beyond), front, (d.flange_top_z - 1.0, d.flange_top_z)),
        block((-d.inner_x, d.inner_x), front, (d.flange_top_z - 1.0, middle)),
    ]


def _open_below_mm3(d: HeadDims) -> float:
    """What that takes besides the pocket: its lower corners."""
    if not d.beside_y:
        return 0.0
    corner = pocket_corner_mm(d.corner_radius, 2 * d.inner_x, d.shelf_bottom_z - d.flange_top_z)
    return 2 * CORNER * corner**2 * (d.front_y - d.flange.front_y)


@dataclass(frozen=True)
class MotorHead(MadePart):
    """Motor head, its axis Z."""

    dims: HeadDims

    def solid(self) -> cq.Solid:
        """Motor head, its axis Z."""
        dims = self.dims
        d, f = dims, dims.flange
        flange = block((-f.half_x, f.half_x), (f.back_y, f.front_y), (d.bottom_z, d.flange_top_z))
        bodies = [rounded(flange, d.corner_radius), box_body(d, 0.5)]
        tools = [*box_tools(d), *_open_below(d)]
        tools += [cylinder_z(d.screw_clearance, x, y, d.bottom_z - 1.0, d.flange_top_z + 1.0) for x, y in f.screws]
        tools += [cylinder_z(d.dowel_radius, x, y, d.bottom_z - 1.0, d.flange_top_z + 1.0) for x, y in f.dowels]
        return cut(fuse(bodies, "motor head"), tools, "motor head")

    def volume_mm3(self) -> float:
        """Flange, box and motor shelf less pocket, seat and holes."""
        d = self.dims
        f, flange = d.flange, d.flange_top_z - d.bottom_z
        plate = (2 * f.half_x * (f.front_y - f.back_y) - 4 * CORNER * d.corner_radius**2) * flange
        return (
            coupling_box_mm3(d, plate)
            - _open_below_mm3(d)
            - len(f.screws) * ring_mm3(d.screw_clearance, 0.0, flange)
            - len(f.dowels) * ring_mm3(d.dowel_radius, 0.0, flange)
        )

    def sheet(self, part: str) -> Sheet:
        """From above and in section, with all heights from the lower face."""
        d = self.dims
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
                Linear(
                    "top", (x - r, f.back_y, low), (x - r, f.front_y, low), f.front_y - f.back_y, "right", decimals=3
                ),
                Linear("top", (0.0, 0.0, low), (x - r, f.front_y, low), f.front_y, "right", decimals=3),
                *(
                    [Linear("top", (0.0, 0.0, low), (0.0, d.beside_y, d.top_z), d.beside_y, "right", decimals=3)]
                    if d.beside_y
                    else []
                ),
                Linear("top", (0.0, 0.0, d.top_z), (-d.outer_x + r, d.front_y, d.top_z), d.front_y, "left", decimals=3),
                Linear("top", (-d.outer_x + r, d.back_y, d.top_z), (0.0, 0.0, d.top_z), -d.back_y, "left", decimals=3),
                Radius("top", (r - x, f.front_y - r, low), (r - x - half, f.front_y - r + half, low), r, prefix="8x "),
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
