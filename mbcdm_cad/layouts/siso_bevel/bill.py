"""The frame as a part: one block, milled from the front in three pockets, bored for drum and input; and the bill."""

from collections.abc import Sequence
from dataclasses import dataclass
from math import radians
from typing import Any

from mbcdm_cad.layouts.assembly import add_drum_bearings, add_stop_pin, steps
from mbcdm_cad.layouts.siso_bevel.layout import DirectLayout
from mbcdm_cad.layouts.siso_bevel.support import ColumnDims
from mbcdm_cad.parts.bill import UPSIDE_DOWN, AssemblyStep, Bill, BillBuilder
from mbcdm_cad.parts.boss import boss_bores, boss_of_column, boss_threads, in_section, open_behind, seats_mm
from mbcdm_cad.parts.drum_sector.items import add_cables, add_drum, add_drum_encoder
from mbcdm_cad.parts.fits import DRUM_AXIS, FITS, one_axis, square
from mbcdm_cad.parts.input_pulley.items import UPRIGHT, add_input_pulley
from mbcdm_cad.parts.milled import Bores, Feature, Milled, MilledPocket, Slab, corner_table, rounding, span, wide
from mbcdm_cad.parts.motor_head import part
from mbcdm_cad.parts.motor_head.dims import flange_screw
from mbcdm_cad.parts.sheet import CuttingLine, FitLine, Linear, Sheet, View, X, Y, Z, minus, mm
from mbcdm_cad.parts.sheet_blocks import THROUGH, hole_labels, hole_table, position_table

# Parts of the input are drawn with the gearhead below.


def bill(lay: DirectLayout, drum_angle_deg: float = 0.0) -> Bill:
    """All parts and instances with the drum at ``drum_angle_deg``."""
    drive, head, f = lay.drive, lay.head, lay.frame
    b = BillBuilder(lay.moving_bodies, drum_angle_deg)
    b.add("frame", ColumnFrame(f), material=drive.frame_material)
    part.add_motor_head(b, drive, head, UPRIGHT)
    add_stop_pin(b, lay, f.stop_pin_start_y)
    part.add_flange_fixings(b, drive, head, f.flange_insert, UPRIGHT)
    add_drum_bearings(b, lay)
    shelf = part.EncoderShelf(
        f.encoder_shelf_bottom_z, f.encoder_shelf_top_z, f.encoder_circle_radius, f.encoder_head_depth
    )
    part.add_input_bearings(b, drive, head, shelf, UPRIGHT)
    part.add_input_line(b, drive, head, shelf, UPRIGHT)
    add_drum_encoder(b, drive, f.boss.encoder_pocket_floor_y, f.boss.screw_circle)
    add_drum(b, drive, lay.drum, lay.drum_shaft)
    for pulley in lay.inputs:
        add_input_pulley(b, drive, pulley, lay.collar, drive.frame_material, UPSIDE_DOWN)
    add_cables(b, drive, lay.cable_paths(radians(drum_angle_deg)))
    return b.bill()


def steps_of(lay: DirectLayout, **more: Any) -> tuple[AssemblyStep, ...]:
    """Steps of the assembly with the sizes of this design."""
    return steps(lay, flange=flange_screw(lay.drive).name, **more)


def _pockets(d: ColumnDims) -> tuple[MilledPocket, ...]:
    """All from the front, to one floor."""
    v, r, x = d.levels, d.corner_radius, (-d.pocket_half_width, d.pocket_half_width)
    y, box = (v.pocket_floor_y, v.front_y), (-v.side_inner_x, v.side_inner_x)
    high, over, under = (
        (d.encoder_shelf_top_z, d.top_z),
        (d.stop_shelf_top_z, d.encoder_shelf_bottom_z),
        (d.low_pocket_bottom_z, d.stop_shelf_bottom_z),
    )
    return (
        MilledPocket(name="box", x=box, y=y, z=high, radius=r, open_top=True),
        MilledPocket(name="over the stop shelf", x=x, y=y, z=over, radius=r),
        MilledPocket(name="under the stop shelf", x=x, y=y, z=under, radius=r),
    )


def _from_above(d: ColumnDims) -> tuple[Bores, ...]:
    """Holes along Z; the axis of A is the input's."""
    shelf, top, pressed = d.encoder_shelf_top_z, d.top_z, FITS["pin_press"].code
    thick, down, cut = shelf - d.encoder_shelf_bottom_z, minus(Z), d.flange_insert is None
    seat = (2 * d.seat_radius, d.seat_depth, FITS["input_seat"].code)
    sunk = (2 * d.encoder_head_radius, d.encoder_head_depth, "")
    encoder = tuple((s * d.encoder_circle_radius, 0.0, shelf) for s in (-1, 1))
    flange, dowels = (tuple((x, y, top) for x, y in places) for places in (d.flange_screws, d.dowels))
    axis, screw, passing = ((0.0, 0.0, shelf),), 2 * d.flange_screw_radius, 2 * d.encoder_screw_clearance
    return (
        Bores(
            *("A", 2 * d.seat_shoulder_radius, THROUGH, axis, "shelf", "bearing"),
            counterbore=seat,
            into=down,
            metal=thick,
        ),
        Bores(*("B", passing, THROUGH, encoder, "shelf", "encoder screws"), counterbore=sunk, into=down, metal=thick),
        Bores(
            *("C", screw, d.flange_screw_depth, flange, "top", "motor head"),
            threaded=cut,
            insert=d.flange_insert,
            into=down,
        ),
        Bores("D", 2 * d.dowel_radius, d.dowel_depth, dowels, "top", "dowels", fit=pressed, into=down),
    )


def _from_front(d: ColumnDims) -> tuple[Bores, ...]:
    """Holes along Y, from the front or from behind."""
    v, back, pressed = d.levels, minus(Y), FITS["pin_press"].code
    pin, mounts = ((0.0, v.front_y, d.stop_pin_z),), tuple((x, v.pocket_floor_y, z) for x, z in d.mounts)
    deep, plate = v.front_y - d.stop_pin_start_y, v.pocket_floor_y - v.back_y
    return (
        Bores("E", 2 * d.stop_pin_radius, deep, pin, "front", "stop pin", fit=pressed, into=back),
        Bores("F", 2 * d.mount_radius, THROUGH, mounts, "pocket floor", "mounting screws", into=back, metal=plate),
        *boss_threads(d.boss, "G"),
    )


def _dimensions(d: ColumnDims) -> tuple[Linear, ...]:
    """Widths and heights in front, from the drum's axis; depths in the section, from the back."""
    v, b, x, y, back = d.levels, d.boss, d.levels.side_outer_x, d.levels.front_y, d.levels.back_y
    inner, column, start, top = d.pocket_half_width, d.column_half_width, d.column_start_z, d.top_z
    left = ((top, x), (d.encoder_shelf_top_z, x), (d.encoder_shelf_bottom_z, x))
    right = (
        (d.stop_shelf_top_z, -inner),
        (d.stop_shelf_bottom_z, -inner),
        (d.low_pocket_bottom_z, -inner),
        (d.post_bottom_z, -column),
    )
    above = (
        (v.front_y, d.encoder_shelf_bottom_z, ""),
        (v.pocket_floor_y, d.encoder_shelf_top_z, " pockets"),
        (0.0, d.encoder_shelf_top_z, " axis of A"),
    )
    return (
        wide("front", x, (y, top), "above"),
        wide("front", v.side_inner_x, (y, top), "above", " box"),
        wide("front", column, (y, d.post_bottom_z), "below", " column"),
        wide("front", inner, (y, d.low_pocket_bottom_z), "below", " pockets"),
        wide("front", b.radius, (y, 0.0), "below", " foot = %%c boss"),
        wide("front", b.ear_reach, (y, 0.0), "below", " ears"),
        *(span(2, "front", (0.0, y, 0.0), (at, y, z), "left") for z, at in left),
        *(span(2, "front", (0.0, y, 0.0), (at, y, z), "right") for z, at in right),
        *(span(1, "section", (0.0, back, top), (0.0, to, z), "above", what) for to, z, what in above),
        *in_section(b, start),
    )


@dataclass(frozen=True)
class ColumnFrame(Milled):
    """Frame where it stands in the assembly."""

    dims: ColumnDims

    def bodies(self) -> Sequence[Feature]:
        """Box, column, its foot on the boss, and the boss."""
        d, v, b = self.dims, self.dims.levels, self.dims.boss
        y, x, post = (v.back_y, v.front_y), v.side_outer_x, d.column_half_width
        return (
            Slab((-x, x), y, (d.encoder_shelf_bottom_z, d.top_z), d.corner_radius),
            Slab((-post, post), y, (d.post_bottom_z, d.encoder_shelf_bottom_z)),
            Slab((-b.radius, b.radius), y, (0.0, d.post_bottom_z)),
            boss_of_column(b, v.front_y),
        )

    def taken(self) -> Sequence[Feature]:
        """Pockets, bores and holes."""
        d = self.dims
        return (*_pockets(d), open_behind(d.boss, -1.0), boss_bores(d.boss), *_from_above(d), *_from_front(d))

    def sheet(self, part: str) -> Sheet:
        """Front, middle section and top."""
        d = self.dims
        v, r, b = d.levels, d.corner_radius, d.boss
        above, behind = _from_above(d), _from_front(d)
        front = tuple(group for group in behind if group.letter != "G")
        x, y = v.side_outer_x, v.front_y
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
            dimensions=(*_dimensions(d), rounding((-x, y, d.top_z), r, "4x ")),
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
                corner_table(_pockets(d)),
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
