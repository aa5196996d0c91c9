"""Frame: plate with boss and yoke, milled from one block, with bores from behind for drum and input."""

from __future__ import annotations

from dataclasses import dataclass
from math import asin, pi, sqrt
from typing import TYPE_CHECKING, Any

from mbcdm_cad.design.bought import InsertSpec
from mbcdm_cad.layouts.siso_spur.overhung import MotorSeat, pocket_mm3
from mbcdm_cad.layouts.siso_spur.support.dims import YokeDims
from mbcdm_cad.layouts.siso_spur.support.idlers import StandDims
from mbcdm_cad.parts.boss import boss_bodies, boss_bores, boss_bores_mm3, boss_tools, flange_mm3, seats_mm
from mbcdm_cad.parts.fits import FITS
from mbcdm_cad.parts.motor_head.dims import Places
from mbcdm_cad.parts.part import MadePart
from mbcdm_cad.parts.shapes import block, cut, cylinder_y, fuse
from mbcdm_cad.parts.sheets.description import (
    CuttingLine,
    FitLine,
    Holes,
    Linear,
    Radius,
    Sheet,
    Side,
    View,
    X,
    Y,
    Z,
    minus,
    mm,
)
from mbcdm_cad.parts.sheets.holes import THROUGH, hole_labels, hole_table, position_table
from mbcdm_cad.parts.sheets.tolerances import DRUM_AXIS, TO_AXIS_MM, GeometricTolerance, one_axis
from mbcdm_cad.parts.volume import CORNER, ring_mm3

if TYPE_CHECKING:
    import cadquery as cq

# Letters of the holes for idlers, two for each pair.
_STAND_LETTERS = "JKLMNPQRSTUVWXYZ"


def arm_mm3(d: YokeDims) -> float:
    """Plate from the drum's axis upwards, and the yoke on it, less their bores and holes."""
    v = d.levels
    plate = (2 * d.half_width * d.plate_top_z - 2 * CORNER * d.corner_radius**2) * (v.front_y - v.plate_back_y)
    yoke = _yoke_mm3(d) if d.motor is None else 0.0
    return plate + yoke + sum(_posts_mm3(stand) for stand in d.stands) - _holes_mm3(d)


def _posts_mm3(stand: StandDims) -> float:
    """Both posts of a pair of idlers, less their threads."""
    (near, far), (low, high) = stand.post_x, stand.post_z
    post = (far - near) * (high - low) * (stand.strap_back_y - stand.front_y)
    return 2 * (post - ring_mm3(stand.thread_radius, 0.0, stand.thread_depth))


def _yoke_mm3(d: YokeDims) -> float:
    """Volume in front of the plate: the bridge, and the shelf under it."""
    v, wide = d.levels, 2 * d.shelf_half_width
    rounded = 2 * CORNER * d.corner_radius**2
    bridge = (wide * (d.top_z - d.bridge_bottom_z) - rounded) * (v.top_plate_top_z - v.front_y)
    shelf = (wide * (d.bridge_bottom_z - d.shelf_bottom_z) - rounded) * (v.top_plate_top_z - v.top_plate_bottom_z)
    return bridge + shelf


def round_end_mm2(d: YokeDims) -> float:
    """Area of the plate's round end about the drum's axis outside the arm; a boss wider than the arm is part of it."""
    w, r = d.half_width, max(d.half_width, d.boss.radius)
    return pi * r**2 - w * sqrt(r**2 - w**2) - r**2 * asin(w / r)


def boss_mm3(d: YokeDims) -> float:
    """Boss outside the plate, less the bores of both and the hole of the stop pin."""
    v, b = d.levels, d.boss
    disc = pi * b.radius**2
    behind, before = v.plate_back_y - b.end_y, b.front_y - v.front_y
    ears = 4 * max(b.ear_reach - b.radius, 0.0) * b.ear_half_height if b.has_encoder else 0.0
    return (
        disc * (behind + before)
        + ears * max(min(b.ear_front_y, v.plate_back_y) - b.encoder_pocket_floor_y, 0.0)
        + flange_mm3(b)
        - boss_bores_mm3(b)
        - ring_mm3(d.stop_pin_radius, 0.0, v.front_y - v.plate_back_y)
    )


def _holes_mm3(d: YokeDims) -> float:
    v, plate = d.levels, d.levels.front_y - d.levels.plate_back_y
    shelf = v.top_plate_top_z - v.top_plate_bottom_z
    encoder = 0.0
    if d.has_encoder:
        encoder = ring_mm3(d.encoder_screw_clearance, 0.0, shelf - d.encoder_head_depth)
        encoder += ring_mm3(d.encoder_head_radius, 0.0, d.encoder_head_depth)
    if d.motor is None:
        own = ring_mm3(d.opening_radius, 0.0, plate)
        own += ring_mm3(d.seat_shoulder_radius, 0.0, shelf - d.seat_depth)
        own += ring_mm3(d.seat_radius, 0.0, d.seat_depth) + 2 * encoder
    else:
        own = pocket_mm3(d.motor, plate)
    return (
        own
        + len(d.flange_screws) * ring_mm3(d.flange_screw_radius, 0.0, plate)
        + len(d.dowels) * ring_mm3(d.dowel_radius, 0.0, d.dowel_depth)
        + len(d.mounts) * ring_mm3(d.mount_radius, 0.0, plate)
        + sum(2 * ring_mm3(stand.axle_radius, 0.0, plate) for stand in d.stands)
    )


def yoke_bodies(d: YokeDims) -> list[cq.Shape]:
    """Plate from the drum's axis past the input, and the yoke on it."""
    import cadquery as cq

    v, x, shelf = d.levels, d.half_width, d.shelf_half_width
    plate = block((-x, x), (v.plate_back_y, v.front_y), (0.0, d.plate_top_z))
    plate = cq.Workplane(obj=plate).edges("|Y and >Z").fillet(d.corner_radius).val()  # type: ignore[assignment]
    if d.motor is not None:
        return [plate]
    bridge = block((-shelf, shelf), (v.plate_back_y, v.top_plate_top_z), (d.bridge_bottom_z, d.top_z))
    bearing = block((-shelf, shelf), (v.top_plate_bottom_z, v.top_plate_top_z), (d.shelf_bottom_z, d.top_z))
    rounded = cq.Workplane(obj=fuse([bridge, bearing], "yoke")).edges("|Y").edges("<Z or >Z")
    inside = (v.plate_back_y + v.front_y) / 2
    posts = []
    for stand in d.stands:
        near, far = stand.post_x
        posts += [block(x, (inside, stand.strap_back_y), stand.post_z) for x in ((-far, -near), (near, far))]
    return [plate, rounded.fillet(d.corner_radius).val(), *posts]  # type: ignore[list-item]


def centre_bodies(d: YokeDims) -> list[cq.Shape]:
    """Rounded end of the plate about the drum's axis, and the boss."""
    return [cylinder_y(d.half_width, 0.0, 0.0, d.levels.plate_back_y, d.levels.front_y), *boss_bodies(d.boss)]


def _input_holes(d: YokeDims) -> list[cq.Shape]:
    v, z = d.levels, d.axis_z
    if d.motor is not None:
        behind, shelf = v.plate_back_y - 1.0, v.plate_back_y + d.motor.shelf
        if d.motor.window is not None:
            half, low, high = d.motor.window
            return [
                block((-half, half), (behind, v.front_y + 1.0), (low, high)),
                *(cylinder_y(d.motor.screw_clearance, x, at, behind, v.front_y + 1.0) for x, at in d.motor.screws),
            ]
        places = [(d.motor.pilot_radius, 0.0, z), *((d.motor.screw_clearance, *at) for at in d.motor.screws)]
        return [
            cylinder_y(d.motor.pocket_radius, 0, z, shelf, v.front_y + 1.0),
            *(cylinder_y(radius, x, height, behind, shelf + 1.0) for radius, x, height in places),
        ]
    near, far = v.top_plate_bottom_z, v.top_plate_top_z
    tools: list[cq.Shape] = [
        cylinder_y(d.opening_radius, 0, z, v.plate_back_y - 1.0, v.front_y + 1.0),
        cylinder_y(d.seat_shoulder_radius, 0, z, near, far + 1.0),
        cylinder_y(d.seat_radius, 0, z, near - 1.0, near + d.seat_depth),
    ]
    for x in (-d.encoder_circle_radius, d.encoder_circle_radius) if d.has_encoder else ():
        tools.append(cylinder_y(d.encoder_screw_clearance, x, z, near, far + 1.0))
        tools.append(cylinder_y(d.encoder_head_radius, x, z, near - 1.0, near + d.encoder_head_depth))
    return tools


def yoke_tools(d: YokeDims) -> list[cq.Shape]:
    """Bores for the input, and holes of the parts that are screwed on."""
    back, front = d.levels.plate_back_y - 1.0, d.levels.front_y + 1.0
    tools = _input_holes(d)
    tools += [cylinder_y(d.flange_screw_radius, x, z, back, front) for x, z in d.flange_screws]
    tools += [cylinder_y(d.dowel_radius, x, z, back, back + 1.0 + d.dowel_depth) for x, z in d.dowels]
    tools += [cylinder_y(d.mount_radius, x, z, back, front) for x, z in d.mounts]
    for stand in d.stands:
        for side in (-1, 1):
            tools.append(cylinder_y(stand.axle_radius, side * stand.x, stand.z, back, front))
            end = stand.strap_back_y
            at = (side * stand.screw_x, stand.screw_z)
            tools.append(cylinder_y(stand.thread_radius, *at, end - stand.thread_depth, end + 1.0))
    return tools


def centre_tools(d: YokeDims) -> list[cq.Shape]:
    """Bores of the boss, and the stop pin's hole."""
    if d.stop_pin_radius <= 0.0:
        return [*boss_tools(d.boss)]
    pin = cylinder_y(d.stop_pin_radius, 0, d.stop_pin_z, d.levels.plate_back_y - 1.0, d.levels.front_y + 1.0)
    return [*boss_tools(d.boss), pin]


def _thread(insert: InsertSpec | None) -> dict[str, Any]:
    """Arguments of a hole for a thread, or for an insert."""
    return {"threaded": insert is None, "insert": insert}


def _head_holes(d: YokeDims) -> tuple[Holes, ...]:
    """Opening for the pulley, holes of the motor head's flange."""
    y, screw = d.levels.plate_back_y, 2 * d.flange_screw_radius

    def on(places: Places) -> tuple[tuple[float, float, float], ...]:
        return tuple((x, y, z) for x, z in places)

    pressed = FITS["pin_press"].code
    return (
        Holes("A", 2 * d.opening_radius, THROUGH, on(((0.0, d.axis_z),)), "plate", "input pulley"),
        Holes("B", screw, THROUGH, on(d.flange_screws), "plate", "motor head", **_thread(d.flange_insert)),
        Holes("C", 2 * d.dowel_radius, d.dowel_depth, on(d.dowels), "behind", "dowels", fit=pressed),
    )


def _seat_holes(seat: MotorSeat, back_y: float, front_y: float, axis_z: float) -> tuple[Holes, ...]:
    """Pilot of the motor with the pocket in front of it, and its screws."""
    if seat.window is not None:
        screws = tuple((x, back_y, z) for x, z in seat.screws)
        return (Holes("B", 2 * seat.screw_clearance, THROUGH, screws, "plate", "servo's screws", threaded=True),)
    pocket = (2 * seat.pocket_radius, front_y - back_y - seat.shelf, "")
    fit, screws = FITS["pilot"].code, tuple((x, back_y, z) for x, z in seat.screws)
    pilot = ((0.0, back_y, axis_z),)
    return (
        Holes("A", 2 * seat.pilot_radius, THROUGH, pilot, "front", "motor's pilot", fit=fit, counterbore=pocket),
        Holes("B", 2 * seat.screw_clearance, THROUGH, screws, "pocket", "motor's screws"),
    )


def frame_holes(d: YokeDims) -> tuple[Holes, ...]:
    """Holes along Y: first those of the plate, from behind, then those of the shelf and of the drum's encoder."""
    v, b, z = d.levels, d.boss, d.axis_z
    back, near, floor = v.plate_back_y, v.top_plate_bottom_z, b.encoder_pocket_floor_y
    pressed = FITS["pin_press"].code

    def on(y: float, places: Places) -> tuple[tuple[float, float, float], ...]:
        return tuple((x, y, height) for x, height in places)

    axis = ((0.0, z),)
    beside = tuple((s * d.encoder_circle_radius, z) for s in (-1, 1))
    encoder = tuple((s * b.screw_circle, 0.0) for s in (-1, 1))
    seat = (2 * d.seat_radius, d.seat_depth, FITS["input_seat"].code)
    sunk = (2 * d.encoder_head_radius, d.encoder_head_depth, "")
    passing = 2 * d.encoder_screw_clearance
    pin = on(back, ((0.0, d.stop_pin_z),))
    return (
        *(_head_holes(d) if d.motor is None else _seat_holes(d.motor, v.plate_back_y, v.front_y, z)),
        Holes(
            "D", 2 * d.mount_radius, THROUGH, on(back, d.mounts), "plate", "mounting screws", **_thread(d.mount_insert)
        ),
        *(
            [Holes("E", 2 * d.stop_pin_radius, THROUGH, pin, "plate", "stop pin", fit=pressed)]
            if d.stop_pin_radius > 0.0
            else []
        ),
        *(
            [Holes("F", 2 * d.seat_shoulder_radius, THROUGH, on(near, axis), "shelf", "bearing", counterbore=seat)]
            if d.motor is None
            else []
        ),
        *(
            [Holes("G", passing, THROUGH, on(near, beside), "shelf", "encoder screws", counterbore=sunk)]
            if d.has_encoder
            else []
        ),
        *(
            [Holes("H", 2 * b.screw_radius, b.screw_depth, on(floor, encoder), "boss", "drum encoder", threaded=True)]
            if b.has_encoder
            else []
        ),
        *(
            [
                Holes(
                    "H",
                    2 * b.flange.screw_radius,
                    THROUGH,
                    on(b.back_y, b.flange.screws),
                    "flange",
                    "what the shaft turns",
                    threaded=True,
                )
            ]
            if b.flange
            else []
        ),
        *(group for stand in d.stands for group in _stand_holes(d, stand)),
    )


def _stand_holes(d: YokeDims, stand: StandDims) -> tuple[Holes, Holes]:
    """Bores of the axles of a pair of idlers, from behind, and the threads of its strap in the posts."""
    first = 2 * d.stands.index(stand)
    axles = tuple((side * stand.x, d.levels.plate_back_y, stand.z) for side in (-1, 1))
    screws = tuple((side * stand.screw_x, stand.strap_back_y, stand.screw_z) for side in (-1, 1))
    return (
        Holes(
            _STAND_LETTERS[first],
            2 * stand.axle_radius,
            THROUGH,
            axles,
            "plate",
            "axles of the idlers",
            fit=FITS["axle_bore"].code,
        ),
        Holes(
            _STAND_LETTERS[first + 1],
            2 * stand.thread_radius,
            stand.thread_depth,
            screws,
            "posts",
            "strap",
            threaded=True,
        ),
    )


def _from_behind(d: YokeDims) -> tuple[Linear, ...]:
    """Widths, and heights from the drum's axis."""
    y, x, b = d.levels.plate_back_y, d.half_width, d.boss

    def wide(half: float, z: float, side: Side, what: str = "") -> Linear:
        return Linear("rear", (-half, y, z), (half, y, z), 2 * half, side, suffix=what)

    return (
        wide(x, d.plate_top_z, "above"),
        wide(b.radius, 0.0, "below", " = %%c boss"),
        *([wide(b.ear_reach, 0.0, "below", " ears")] if b.has_encoder else []),
        *([wide(b.flange.radius, 0.0, "below", " = %%c flange")] if b.flange else []),
        *_window(d),
        Linear("rear", (0.0, y, 0.0), (x, y, d.plate_top_z), d.plate_top_z, "right", decimals=3),
        Linear("rear", (0.0, y, 0.0), (0.0, y, d.axis_z), d.axis_z, "left", decimals=3),
    )


def _window(d: YokeDims) -> tuple[Linear, ...]:
    """Window for a servo's housing, from behind."""
    if d.motor is None or d.motor.window is None:
        return ()
    y, (half, low, high) = d.levels.plate_back_y, d.motor.window
    return (
        Linear("rear", (-half, y, high), (half, y, high), 2 * half, "above", suffix=" window"),
        Linear("rear", (0.0, y, 0.0), (-half, y, low), low, "left", decimals=3),
        Linear("rear", (0.0, y, 0.0), (-half, y, high), high, "left", decimals=3),
    )


def _in_front(d: YokeDims) -> tuple[Linear, ...]:
    y, wide = d.levels.top_plate_top_z, d.shelf_half_width
    if d.motor is not None:
        return ()
    return (
        Linear("front", (-wide, y, d.top_z), (wide, y, d.top_z), 2 * wide, "above", suffix=" yoke"),
        Linear("front", (0.0, y, 0.0), (wide, y, d.shelf_bottom_z), d.shelf_bottom_z, "left", decimals=3),
        *(
            [Linear("front", (0.0, y, 0.0), (wide, y, d.top_z), d.top_z, "right", suffix=" yoke", decimals=3)]
            if d.plate_top_z > d.top_z
            else []
        ),
    )


def _of_posts(d: YokeDims) -> tuple[Linear, ...]:
    """Sizes and places of the posts of idlers, from the plane of symmetry and the drum's axis."""
    found = []
    for stand in d.stands:
        y, (near, far), (low, high) = stand.strap_back_y, stand.post_x, stand.post_z
        found += [
            Linear("front", (-near, y, high), (near, y, high), 2 * near, "above", suffix=" between posts"),
            Linear("front", (-far, y, high), (far, y, high), 2 * far, "above", suffix=" over posts"),
            Linear("front", (0.0, y, 0.0), (far, y, low), low, "right", decimals=3),
            Linear("front", (far, y, low), (far, y, high), high - low, "right"),
        ]
    return tuple(found)


def _in_section(d: YokeDims) -> tuple[Linear, ...]:
    """Depths from the end of the boss and from the plate's back, and the bores of the drum's shaft."""
    v, b = d.levels, d.boss
    end, back, top = b.end_y, v.plate_back_y, d.top_z
    near, far, under = v.top_plate_bottom_z, v.top_plate_top_z, d.bridge_bottom_z

    def deep(y: float, z: float, what: str = "") -> Linear:
        ends = ((0.0, end, -b.radius), (0.0, y, z))
        return Linear("section", *ends, y - end, "below", suffix=what, decimals=3)

    def over(y: float, z: float) -> Linear:
        return Linear("section", (0.0, back, top), (0.0, y, z), y - back, "above", decimals=3)

    return (
        deep(b.rear_seat_end_y, -b.seat_radius),
        deep(back, -d.half_width),
        deep(b.front_seat_start_y, -b.seat_radius),
        deep(v.front_y, -d.half_width),
        deep(b.front_y, -b.radius),
        *([deep(b.ear_front_y, -b.ear_half_height, " ears")] if b.has_encoder else []),
        *(
            [deep(b.back_y, -b.flange.radius, " pilot"), deep(b.back_y + b.flange.thickness, -b.flange.radius)]
            if b.flange
            else []
        ),
        *(
            (
                over(near, under),
                over(far, top),
                Linear("section", (0.0, near, under), (0.0, far, top), top - under, "right", decimals=3),
            )
            if d.motor is None
            else (over(v.front_y, top),)
        ),
        *boss_bores(b),
    )


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
class Yoke(MadePart):
    """Frame where it stands in the assembly."""

    dims: YokeDims

    def solid(self) -> cq.Solid:
        """Frame in its position in the assembly."""
        dims = self.dims
        return cut(
            fuse([*yoke_bodies(dims), *centre_bodies(dims)], "frame"), [*centre_tools(dims), *yoke_tools(dims)], "frame"
        )

    def volume_mm3(self) -> float:
        """Plate, boss and yoke less bores and holes."""
        d = self.dims
        thick = d.levels.front_y - d.levels.plate_back_y
        return arm_mm3(d) + round_end_mm2(d) * thick + boss_mm3(d)

    def sheet(self, part: str) -> Sheet:
        """Rear, middle section and front."""
        d = self.dims
        v, b, r = d.levels, d.boss, d.corner_radius
        holes = frame_holes(d)
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
            dimensions=(*_from_behind(d), *_in_section(d), *_in_front(d), *_of_posts(d), corner),
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
