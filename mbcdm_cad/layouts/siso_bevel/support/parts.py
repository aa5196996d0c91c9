"""Frame: one block, milled from the front in three pockets, bored for drum and input."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from mbcdm_cad.layouts.siso_bevel.support.dims import ColumnDims
from mbcdm_cad.parts.boss import boss_below_column_mm3, boss_bodies, boss_bores, boss_tools, column_bores_mm3, seats_mm
from mbcdm_cad.parts.fits import FITS
from mbcdm_cad.parts.motor_head.part import rounded
from mbcdm_cad.parts.part import MadePart
from mbcdm_cad.parts.shapes import block, cut, cylinder_y, cylinder_z, fuse, pocket_y
from mbcdm_cad.parts.sheets.description import (
    CuttingLine,
    FitLine,
    Holes,
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
    mm,
)
from mbcdm_cad.parts.sheets.holes import THROUGH, hole_labels, hole_table, position_table
from mbcdm_cad.parts.sheets.tolerances import DRUM_AXIS, one_axis, square
from mbcdm_cad.parts.volume import CORNER, pocket_corner_mm, pocket_mm3, ring_mm3

if TYPE_CHECKING:
    import cadquery as cq


def _body_mm3(d: ColumnDims) -> float:
    v, depth = d.levels, d.levels.front_y - d.levels.back_y
    box = 2 * v.side_outer_x * depth - 4 * CORNER * d.corner_radius**2
    post = 2 * d.column_half_width * depth * (d.encoder_shelf_bottom_z - d.post_bottom_z)
    foot = 2 * d.boss.radius * depth * d.post_bottom_z
    return box * (d.top_z - d.encoder_shelf_bottom_z) + post + foot + boss_below_column_mm3(d.boss, v.front_y)


def _pockets_mm3(d: ColumnDims) -> float:
    v, r = d.levels, d.corner_radius
    depth, inner = v.front_y - v.pocket_floor_y, 2 * d.pocket_half_width
    return (
        pocket_mm3(2 * v.side_inner_x, depth, d.top_z - d.encoder_shelf_top_z, r, 2)
        + pocket_mm3(inner, depth, d.encoder_shelf_bottom_z - d.stop_shelf_top_z, r)
        + pocket_mm3(inner, depth, d.stop_shelf_bottom_z - d.low_pocket_bottom_z, r)
    )


def _holes_mm3(d: ColumnDims) -> float:
    v, shelf = d.levels, d.encoder_shelf_top_z - d.encoder_shelf_bottom_z
    encoder = ring_mm3(d.encoder_screw_clearance, 0.0, shelf - d.encoder_head_depth)
    encoder += ring_mm3(d.encoder_head_radius, 0.0, d.encoder_head_depth)
    return (
        ring_mm3(d.seat_shoulder_radius, 0.0, shelf - d.seat_depth)
        + ring_mm3(d.seat_radius, 0.0, d.seat_depth)
        + 2 * encoder
        + ring_mm3(d.stop_pin_radius, 0.0, v.front_y - d.stop_pin_start_y)
        + len(d.flange_screws) * ring_mm3(d.flange_screw_radius, 0.0, d.flange_screw_depth)
        + len(d.dowels) * ring_mm3(d.dowel_radius, 0.0, d.dowel_depth)
        + len(d.mounts) * ring_mm3(d.mount_radius, 0.0, v.pocket_floor_y - v.back_y)
    )


def _body(d: ColumnDims) -> cq.Solid:
    v = d.levels
    box = block((-v.side_outer_x, v.side_outer_x), (v.back_y, v.front_y), (d.encoder_shelf_bottom_z, d.top_z))
    wide = d.column_half_width
    post = block((-wide, wide), (v.back_y, v.front_y), (d.post_bottom_z, d.encoder_shelf_bottom_z))
    foot = block((-d.boss.radius, d.boss.radius), (v.back_y, v.front_y), (0.0, d.post_bottom_z))
    return fuse([rounded(box, d.corner_radius), post, foot, *boss_bodies(d.boss)], "frame")


def _pockets(d: ColumnDims) -> list[cq.Shape]:
    v, r = d.levels, d.corner_radius
    y = (v.pocket_floor_y, v.front_y + 1.0)
    side, inner = v.side_inner_x, d.pocket_half_width
    beside = d.boss.radius + 1.0
    return [
        # Open at the top: the rounded corners there fall outside the block.
        pocket_y((-side, side), y, (d.encoder_shelf_top_z, d.top_z + 2 * r + 1.0), r),
        pocket_y((-inner, inner), y, (d.stop_shelf_top_z, d.encoder_shelf_bottom_z), r),
        pocket_y((-inner, inner), y, (d.low_pocket_bottom_z, d.stop_shelf_bottom_z), r),
        # Behind the boss, below the encoder's pocket, the column is removed.
        block((-beside, beside), (v.back_y - 1.0, d.boss.encoder_pocket_floor_y), (-1.0, d.column_start_z)),
    ]


def _input_holes(d: ColumnDims) -> list[cq.Shape]:
    low, high = d.encoder_shelf_bottom_z, d.encoder_shelf_top_z
    tools: list[cq.Shape] = [
        cylinder_z(d.seat_shoulder_radius, 0, 0, low - 1.0, high),
        cylinder_z(d.seat_radius, 0, 0, high - d.seat_depth, high + 1.0),
    ]
    for sign in (-1, 1):
        x = sign * d.encoder_circle_radius
        tools.append(cylinder_z(d.encoder_screw_clearance, x, 0, low - 1.0, high + 1.0))
        tools.append(cylinder_z(d.encoder_head_radius, x, 0, high - d.encoder_head_depth, high + 1.0))
    return tools


def _fixing_holes(d: ColumnDims) -> list[cq.Shape]:
    v, top = d.levels, d.top_z
    tools: list[cq.Shape] = [cylinder_y(d.stop_pin_radius, 0, d.stop_pin_z, d.stop_pin_start_y, v.front_y + 1.0)]
    for x, y in d.flange_screws:
        tools.append(cylinder_z(d.flange_screw_radius, x, y, top - d.flange_screw_depth, top + 1.0))
    tools += [cylinder_z(d.dowel_radius, x, y, top - d.dowel_depth, top + 1.0) for x, y in d.dowels]
    tools += [cylinder_y(d.mount_radius, x, z, v.back_y - 1.0, v.pocket_floor_y + 1.0) for x, z in d.mounts]
    return tools


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

    return (
        deep(v.front_y, d.encoder_shelf_bottom_z, "above", d.top_z),
        deep(v.pocket_floor_y, d.encoder_shelf_top_z, "above", d.top_z, " pockets"),
        deep(0.0, d.encoder_shelf_top_z, "above", d.top_z, " axis of A"),
        deep(b.encoder_pocket_floor_y, -b.radius, "below", start),
        deep(b.rear_seat_end_y, -b.seat_radius, "below", start),
        deep(b.front_seat_start_y, -b.seat_radius, "below", start),
        deep(b.front_y, -b.radius, "below", start),
        deep(b.ear_front_y, -b.ear_half_height, "below", start, " ears"),
        *boss_bores(b),
    )


def _pocket_table(d: ColumnDims) -> Table:
    """Corners of each pocket: the cutter's, or less where the pocket is narrow."""
    v, r, inner = d.levels, d.corner_radius, 2 * d.pocket_half_width
    sizes = (
        ("box", 2 * v.side_inner_x, 2 * r + d.top_z - d.encoder_shelf_top_z),
        ("over the stop shelf", inner, d.encoder_shelf_bottom_z - d.stop_shelf_top_z),
        ("under the stop shelf", inner, d.stop_shelf_bottom_z - d.low_pocket_bottom_z),
    )
    rows = tuple((name, mm(pocket_corner_mm(r, width, height), 3)) for name, width, height in sizes)
    return Table("Corners of the pockets", ("Pocket", "R"), rows)


@dataclass(frozen=True)
class ColumnFrame(MadePart):
    """Frame where it stands in the assembly."""

    dims: ColumnDims

    def solid(self) -> cq.Solid:
        """Frame in its position in the assembly."""
        dims = self.dims
        return cut(
            _body(dims), _pockets(dims) + boss_tools(dims.boss) + _input_holes(dims) + _fixing_holes(dims), "frame"
        )

    def volume_mm3(self) -> float:
        """Block, column and boss less pockets, bores and holes."""
        d = self.dims
        return _body_mm3(d) - _pockets_mm3(d) - column_bores_mm3(d.boss) - _holes_mm3(d)

    def sheet(self, part: str) -> Sheet:
        """Front, middle section and top."""
        d = self.dims
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
            tolerances=(
                one_axis("section", seats_mm(b), DRUM_AXIS),
                square("section", (0.0, d.seat_radius, d.encoder_shelf_top_z - d.seat_depth / 2), DRUM_AXIS, "A"),
            ),
            cutting_lines=(CuttingLine("front", (0.0, y, -b.radius - 2.0), (0.0, y, d.top_z + 2.0), "A", minus(X)),),
            holes=(*above, *behind),
            tables=(
                hole_table((*above, *behind)),
                position_table(above, (0, 1), "Positions from A, along Z"),
                position_table(behind, (0, 2), "Positions from A and the drum axis, along Y"),
                _pocket_table(d),
            ),
            fits=(
                FitLine(2 * b.seat_radius, FITS["drum_seat"].code, "drum bearing seats"),
                *(line for group in (*above, *behind) for line in group.fit_lines()),
            ),
            notes=(
                "One piece. X to the right in the rear view, Y to the front, Z up; Y = 0 at the axis of A.",
                "Encoder's pocket from behind: "
                f"R{mm(b.encoder_pocket_radius)} about the drum's axis, open below Z {mm(d.column_start_z)}.",
                f"Ears {mm(2 * b.ear_half_height)} high. Seats Ra 0.8, elsewhere Ra 3.2.",
            ),
        )
