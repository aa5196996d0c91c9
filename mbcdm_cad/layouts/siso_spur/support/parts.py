"""Frame: plate with boss and yoke, milled from one block, with bores from behind for drum and input."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import asin, pi, sqrt
from typing import TYPE_CHECKING

from mbcdm_cad.layouts.siso_spur.idlers import StandDims
from mbcdm_cad.layouts.siso_spur.pulley import MotorSeat
from mbcdm_cad.layouts.siso_spur.support import YokeDims
from mbcdm_cad.parts.boss import boss_bodies, boss_bores, boss_threads, seat_diameters, seats_mm
from mbcdm_cad.parts.fits import DRUM_AXIS, FITS, TO_AXIS_MM, GeometricTolerance, one_axis
from mbcdm_cad.parts.milled import Bores, Feature, Form, Milled, Slab, block, cylinder_y, fuse, rounded, span, wide
from mbcdm_cad.parts.motor_head.dims import Places
from mbcdm_cad.parts.part import CORNER, ring_mm3
from mbcdm_cad.parts.sheet import CuttingLine, FitLine, Linear, Radius, Sheet, Side, Vector, View, X, Y, Z, minus, mm
from mbcdm_cad.parts.sheet_blocks import THROUGH, hole_labels, hole_table, position_table

if TYPE_CHECKING:
    import cadquery as cq

# Letters of the holes for idlers, two for each pair.
_STAND_LETTERS = "JKLMNPQRSTUVWXYZ"


def _on(y: float, places: Places) -> tuple[Vector, ...]:
    return tuple((x, y, z) for x, z in places)


def arm_bodies(d: YokeDims) -> list[Feature]:
    """Plate from the drum's axis past the input, the yoke on it, and posts of idlers."""
    v, x, r, top = d.levels, d.half_width, d.corner_radius, d.plate_top_z
    corners = 2 * CORNER * r**2
    plate_mm3 = (2 * x * top - corners) * (v.front_y - v.plate_back_y)

    def plate() -> list[cq.Shape]:
        return [rounded(block((-x, x), (v.plate_back_y, v.front_y), (0.0, top)), r, "|Y and >Z")]

    found: list[Feature] = [Form(plate_mm3, plate)]
    if d.motor is None:
        found.append(_yoke(d))
    inside = (v.plate_back_y + v.front_y) / 2
    for stand in d.stands:
        near, far = stand.post_x
        # In the plate, which has its volume, the posts begin within.
        y, z, into = (inside, stand.strap_back_y), stand.post_z, stand.front_y - inside
        found += [Slab(at, y, z, along="Y", into_mm=into) for at in ((-far, -near), (near, far))]
    return found


def _yoke(d: YokeDims) -> Form:
    """In front of the plate: the bridge, and the shelf under it."""
    v, shelf, r = d.levels, d.shelf_half_width, d.corner_radius
    across, corners, y = 2 * shelf, 2 * CORNER * r**2, (v.plate_back_y, v.top_plate_top_z)

    def drawn() -> list[cq.Shape]:
        bridge = block((-shelf, shelf), y, (d.bridge_bottom_z, d.top_z))
        bearing = block((-shelf, shelf), (v.top_plate_bottom_z, v.top_plate_top_z), (d.shelf_bottom_z, d.top_z))
        return [rounded(fuse([bridge, bearing], "yoke"), r, "|Y", "<Z or >Z")]

    bridge_mm3 = (across * (d.top_z - d.bridge_bottom_z) - corners) * (v.top_plate_top_z - v.front_y)
    shelf_mm2 = across * (d.bridge_bottom_z - d.shelf_bottom_z) - corners
    return Form(bridge_mm3 + shelf_mm2 * (v.top_plate_top_z - v.top_plate_bottom_z), drawn)


def round_end_mm2(d: YokeDims) -> float:
    """Area of the plate's round end about the drum's axis outside the arm; a boss wider than the arm is part of it."""
    w, r = d.half_width, max(d.half_width, d.boss.radius)
    return pi * r**2 - w * sqrt(r**2 - w**2) - r**2 * asin(w / r)


def centre_bodies(d: YokeDims, end_mm2: float = 0.0) -> Form:
    """The boss, and about it the plate's round end, which has this area outside the arm."""
    v, b, f = d.levels, d.boss, d.boss.flange
    plate = v.front_y - v.plate_back_y
    ears = 4 * max(b.ear_reach - b.radius, 0.0) * b.ear_half_height if b.has_encoder else 0.0
    outside = (
        pi * b.radius**2 * (v.plate_back_y - b.end_y + b.front_y - v.front_y)
        + ears * max(min(b.ear_front_y, v.plate_back_y) - b.encoder_pocket_floor_y, 0.0)
        + (ring_mm3(f.radius, b.radius, f.thickness) if f else 0.0)
    )
    end = (d.half_width, 0.0, 0.0, v.plate_back_y, v.front_y)
    return Form(outside + end_mm2 * plate, lambda: [cylinder_y(*end), *boss_bodies(b)])


def centre_taken(d: YokeDims) -> tuple[Feature, ...]:
    """Bores of the boss, the stop pin's hole, and threads in the boss."""
    v, b = d.levels, d.boss
    pin = ("E", 2 * d.stop_pin_radius, THROUGH, ((0.0, v.plate_back_y, d.stop_pin_z),), "plate", "stop pin")
    stop = Bores(*pin, fit=FITS["pin_press"].code, into=Y, metal=v.front_y - v.plate_back_y)
    return boss_bores(b), *([stop] if d.stop_pin_radius > 0.0 else []), *boss_threads(b, "H", "boss")


def motor_seat(d: YokeDims, seat: MotorSeat) -> tuple[Feature, ...]:
    """Pilot of the motor with the pocket in front of it, and its screws; a window for a servo."""
    back, plate = d.levels.plate_back_y, d.levels.front_y - d.levels.plate_back_y
    screws, wide_mm = _on(back, seat.screws), 2 * seat.screw_clearance
    if seat.window is not None:
        half, low, high = seat.window
        y = (back - 1.0, d.levels.front_y + 1.0)
        window = Form(2 * half * (high - low) * plate, lambda: [block((-half, half), y, (low, high))])
        of = ("B", wide_mm, THROUGH, screws, "plate", "servo's screws")
        return window, Bores(*of, threaded=True, into=Y, metal=plate)
    shelf, pocket = min(seat.shelf, plate), (2 * seat.pocket_radius, plate - seat.shelf, "")
    pilot = ("A", 2 * seat.pilot_radius, THROUGH, _on(back, ((0.0, d.axis_z),)), "front", "motor's pilot")
    return (
        # The pocket is in front, the pilot's place behind.
        FrontPocket(*pilot, fit=FITS["pilot"].code, counterbore=pocket, into=Y, metal=plate),
        Bores("B", wide_mm, THROUGH, screws, "pocket", "motor's screws", into=Y, metal=shelf),
    )


@dataclass(frozen=True, kw_only=True)
class FrontPocket(Bores):
    """Holes from behind, counterbored from the front."""

    def shapes(self) -> list[cq.Shape]:
        """Both tools."""
        bored = replace(self, counterbore=None)
        if self.counterbore is None:
            return Bores.shapes(bored)
        across, deep, _ = self.counterbore
        front = tuple((x, y + self.metal, z) for x, y, z in self.places)
        sunk = replace(bored, diameter=across, depth=deep, places=front, into=minus(self.into))
        return [*Bores.shapes(sunk), *Bores.shapes(bored)]


def _input_holes(d: YokeDims) -> tuple[Feature, ...]:
    """Opening for the pulley, bearing and encoder's screws in the shelf, holes of the motor head's flange."""
    v, near, axis = d.levels, d.levels.top_plate_bottom_z, ((0.0, d.axis_z),)
    back, plate, shelf = v.plate_back_y, v.front_y - v.plate_back_y, v.top_plate_top_z - near
    beside = tuple((s * d.encoder_circle_radius, d.axis_z) for s in (-1, 1))
    insert, pressed = d.flange_insert, FITS["pin_press"].code
    head = ("B", 2 * d.flange_screw_radius, THROUGH, _on(back, d.flange_screws), "plate", "motor head")
    bearing = ("F", 2 * d.seat_shoulder_radius, THROUGH, _on(near, axis), "shelf", "bearing")
    seat = (2 * d.seat_radius, d.seat_depth, FITS["input_seat"].code)
    encoder = ("G", 2 * d.encoder_screw_clearance, THROUGH, _on(near, beside), "shelf", "encoder screws")
    sunk, dowel = (2 * d.encoder_head_radius, d.encoder_head_depth, ""), 2 * d.dowel_radius
    return (
        Bores("A", 2 * d.opening_radius, THROUGH, _on(back, axis), "plate", "input pulley", into=Y, metal=plate),
        Bores(*head, threaded=insert is None, insert=insert, into=Y, metal=plate),
        Bores("C", dowel, d.dowel_depth, _on(back, d.dowels), "behind", "dowels", fit=pressed, into=Y),
        Bores(*bearing, counterbore=seat, into=Y, metal=shelf),
        *([Bores(*encoder, counterbore=sunk, into=Y, metal=shelf)] if d.has_encoder else []),
    )


def arm_taken(d: YokeDims) -> tuple[Feature, ...]:
    """Bores for the input, and holes of the parts that are screwed on."""
    v, insert, plate = d.levels, d.mount_insert, d.levels.front_y - d.levels.plate_back_y
    mount = ("D", 2 * d.mount_radius, THROUGH, _on(v.plate_back_y, d.mounts), "plate", "mounting screws")
    return (
        *(_input_holes(d) if d.motor is None else motor_seat(d, d.motor)),
        Bores(*mount, threaded=insert is None, insert=insert, into=Y, metal=plate),
        *(hole for n, stand in enumerate(d.stands) for hole in _stand_holes(d, stand, _STAND_LETTERS[2 * n :])),
    )


def _stand_holes(d: YokeDims, stand: StandDims, letters: str) -> tuple[Bores, Bores]:
    """Bores of the axles of a pair of idlers, from behind, and the threads of its strap in the posts."""
    back, end = d.levels.plate_back_y, stand.strap_back_y
    axles, screws = (
        _on(y, ((-x, z), (x, z))) for x, y, z in ((stand.x, back, stand.z), (stand.screw_x, end, stand.screw_z))
    )
    bore = (letters[0], 2 * stand.axle_radius, THROUGH, axles, "plate", "axles of the idlers")
    thread = (letters[1], 2 * stand.thread_radius, stand.thread_depth, screws, "posts", "strap")
    fit = FITS["axle_bore"].code
    return (Bores(*bore, fit=fit, into=Y, metal=d.levels.front_y - back), Bores(*thread, threaded=True, into=minus(Y)))


def _dimensions(d: YokeDims) -> tuple[Linear, ...]:
    """Widths and heights from the drum's axis, from behind and in front; depths in the section."""
    v, b, x, back, end = d.levels, d.boss, d.half_width, d.levels.plate_back_y, d.boss.end_y
    f, seat, near, far, under, top = (
        b.flange,
        d.motor,
        v.top_plate_bottom_z,
        v.top_plate_top_z,
        d.bridge_bottom_z,
        d.top_z,
    )

    def tall(view: str, at: Vector, side: Side, what: str = "") -> Linear:
        return span(2, view, (0.0, at[1], 0.0), at, side, what)

    window: tuple[Linear, ...] = ()
    if seat is not None and seat.window is not None:
        half, low, high = seat.window
        ends = (tall("rear", (-half, back, z), "left") for z in (low, high))
        window = (wide("rear", half, (back, high), "above", " window"), *ends)
    deep = [
        (b.rear_seat_end_y, -b.seat_radius, ""),
        (back, -x, ""),
        (b.front_seat_start_y, -b.seat_radius, ""),
        (v.front_y, -x, ""),
        (b.front_y, -b.radius, ""),
        *([(b.ear_front_y, -b.ear_half_height, " ears")] if b.has_encoder else []),
        *([(b.back_y, -f.radius, " pilot"), (b.back_y + f.thickness, -f.radius, "")] if f else []),
    ]
    over = ((near, under), (far, top)) if seat is None else ((v.front_y, top),)
    found = [
        wide("rear", x, (back, d.plate_top_z), "above"),
        wide("rear", b.radius, (back, 0.0), "below", " = %%c boss"),
        *([wide("rear", b.ear_reach, (back, 0.0), "below", " ears")] if b.has_encoder else []),
        *([wide("rear", f.radius, (back, 0.0), "below", " = %%c flange")] if f else []),
        *window,
        tall("rear", (x, back, d.plate_top_z), "right"),
        tall("rear", (0.0, back, d.axis_z), "left"),
        *(span(1, "section", (0.0, end, -b.radius), (0.0, to, z), "below", what) for to, z, what in deep),
        *(span(1, "section", (0.0, back, top), (0.0, *at), "above") for at in over),
    ]
    if seat is None:
        found.append(span(2, "section", (0.0, near, under), (0.0, far, top), "right"))
    found += seat_diameters(b)
    if seat is None:
        found += [
            wide("front", d.shelf_half_width, (far, top), "above", " yoke"),
            tall("front", (d.shelf_half_width, far, d.shelf_bottom_z), "left"),
        ]
        if d.plate_top_z > top:
            found.append(tall("front", (d.shelf_half_width, far, top), "right", " yoke"))
    for stand in d.stands:
        y, (inner, outer), (low, high) = stand.strap_back_y, stand.post_x, stand.post_z
        found += [
            wide("front", inner, (y, high), "above", " between posts"),
            wide("front", outer, (y, high), "above", " over posts"),
            tall("front", (outer, y, low), "right"),
            span(2, "front", (outer, y, low), (outer, y, high), "right", decimals=2),
        ]
    return tuple(found)


def _input_axis(d: YokeDims) -> tuple[GeometricTolerance, ...]:
    """The axis of the input's bearing, or of the motor's pilot, is parallel to the drum's; a servo has no pilot."""
    v, seat = d.levels, d.motor
    if seat is None:
        at, of = (0.0, v.top_plate_bottom_z + d.seat_depth / 2, d.axis_z + d.seat_radius), "F"
    elif seat.window is None:
        at, of = (0.0, v.plate_back_y + seat.shelf / 2, d.axis_z + seat.pilot_radius), "A"
    else:
        return ()
    return (GeometricTolerance("section", at, "parallelism", TO_AXIS_MM, (DRUM_AXIS,), axis=True, of=of),)


@dataclass(frozen=True)
class Yoke(Milled):
    """Frame where it stands in the assembly."""

    dims: YokeDims

    def bodies(self) -> Sequence[Feature]:
        """Plate, yoke and boss."""
        return *arm_bodies(self.dims), centre_bodies(self.dims, round_end_mm2(self.dims))

    def taken(self) -> Sequence[Feature]:
        """Bores and holes."""
        return *centre_taken(self.dims), *arm_taken(self.dims)

    def sheet(self, part: str) -> Sheet:
        """Rear, middle section and front."""
        d = self.dims
        v, b, r = d.levels, d.boss, d.corner_radius
        holes = self.bores()
        behind = tuple(group for group in holes if group.letter in f"ABCDEH{_STAND_LETTERS[::2]}")
        before = tuple(group for group in holes if group.letter in _STAND_LETTERS[1::2])
        half, y = 0.5**0.5 * r, v.plate_back_y
        corner = Radius(
            "rear",
            (d.half_width - r, y, d.plate_top_z - r),
            (d.half_width - r + half, y, d.plate_top_z - r + half),
            r,
            prefix="2x ",
        )
        axes = (
            ((0.0, b.end_y, 0.0), (0.0, b.front_y, 0.0)),
            ((0.0, y, d.axis_z), (0.0, v.top_plate_top_z if d.motor is None else v.front_y, d.axis_z)),
        )
        return Sheet(
            part=part,
            title="Frame",
            paper="A2",
            views=(
                View("rear", X, Z),
                View("section", Y, Z, column=1, title="A-A", cut=(0.0, 0.0, 0.0), axes=axes),
                View("front", minus(X), Z, column=2),
            ),
            dimensions=(*_dimensions(d), corner),
            labels=(*hole_labels(behind, "rear"), *hole_labels(before, "front")),
            cutting_lines=(
                CuttingLine("rear", (0.0, y, -d.half_width - 2.0), (0.0, y, d.plate_top_z + 2.0), "A", minus(X)),
            ),
            tolerances=(one_axis("section", seats_mm(b), DRUM_AXIS), *_input_axis(d)),
            holes=holes,
            tables=(hole_table(holes), position_table(holes, (0, 2), "Positions from the drum's axis")),
            fits=(
                FitLine(2 * b.seat_radius, FITS["drum_seat"].code, "drum bearing seats"),
                *(line for group in holes for line in group.fit_lines()),
            ),
            notes=(
                "Milled from one block. X to the right in the rear view, Y to the front, Z up from the drum's axis.",
                f"Outer corners of plate{' and yoke' if d.motor is None else ''} R{mm(r)}; lower end of the plate "
                "rounded about the drum's axis.",
                f"{f'Ears {mm(2 * b.ear_half_height)} high. ' if b.has_encoder else ''}Seats Ra 0.8, elsewhere Ra 3.2.",
            ),
        )
