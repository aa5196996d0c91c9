"""A frame's boss: seats of the drum's two bearings, and the pocket of its ring encoder, if any, behind them."""

from __future__ import annotations

from dataclasses import dataclass
from math import pi, sqrt

from mbcdm_cad.parts.drum_sector.design import SectorDrive
from mbcdm_cad.parts.drum_sector.sizes import SPRING_HEIGHT_MM
from mbcdm_cad.parts.fits import DRUM_AXIS, FITS
from mbcdm_cad.parts.milled import Bores, Form, block, cylinder_y, span
from mbcdm_cad.parts.part import cq, ring_mm3, segment_mm2
from mbcdm_cad.parts.sheet import Linear, Y
from mbcdm_cad.parts.sheet_blocks import THROUGH
from mbcdm_cad.parts.turned import DrumShaftDims

BEARING_WALL_MM = 3.0
EAR_WALL_MM = 1.2
# Thread of the encoder's screws that its housing takes.
ENCODER_GRIP_MM = 2.0
# Wall beside the encoder's pocket where a column as wide as the boss begins.
COLUMN_WALL_MM = 1.2


@dataclass(frozen=True)
class BossFlange:
    """Flange at the end of a boss whose shaft stands out, mm: its face lies at the boss's back.

    The boss goes on through it as a pilot. ``screws`` are the places (x, z) of its threads, which go through.
    """

    radius: float
    thickness: float
    pilot: float
    screws: tuple[tuple[float, float], ...]
    screw_radius: float


@dataclass(frozen=True)
class BossDims:
    """Boss about the drum's axis, from the frame's back to its own front; ears take the ring encoder's screws."""

    radius: float
    back_y: float
    front_y: float
    encoder_pocket_radius: float
    encoder_pocket_floor_y: float
    seat_radius: float
    rear_seat_end_y: float
    front_seat_start_y: float
    shoulder_radius: float
    screw_radius: float
    screw_circle: float
    screw_depth: float
    ear_reach: float
    ear_half_height: float
    ear_front_y: float
    flange: BossFlange | None = None

    @property
    def has_encoder(self) -> bool:
        """Whether an encoder is screwed on behind the boss, on its ears."""
        return self.screw_circle > 0.0

    @property
    def end_y(self) -> float:
        """Its rear end: that of the pilot, or the floor of the encoder's pocket."""
        return self.back_y - self.flange.pilot if self.flange else self.encoder_pocket_floor_y

    @property
    def reach(self) -> float:
        """Largest distance from the axis behind the plate."""
        return max(self.radius, self.ear_reach, self.flange.radius if self.flange else 0.0)


def boss(drive: SectorDrive, shaft: DrumShaftDims, back_y: float, front_y: float) -> BossDims:
    """Boss for the drum's bearings, shaft and encoder."""
    bearing, encoder = drive.bearings.drum, drive.drum_encoder
    screw = drive.screw(encoder.screw)
    return BossDims(
        radius=bearing.outer_diameter_mm / 2 + BEARING_WALL_MM,
        back_y=back_y,
        front_y=front_y,
        encoder_pocket_radius=encoder.diameter_mm / 2 + drive.clearances.running_mm,
        encoder_pocket_floor_y=back_y + encoder.length_mm,
        seat_radius=bearing.outer_diameter_mm / 2,
        rear_seat_end_y=shaft.rear_bearing_y + bearing.width_mm + SPRING_HEIGHT_MM,
        front_seat_start_y=shaft.front_bearing_y,
        shoulder_radius=bearing.outer_shoulder_mm / 2,
        screw_radius=screw.thread_mm / 2,
        screw_circle=encoder.bolt_circle_mm / 2,
        screw_depth=screw.length_mm - ENCODER_GRIP_MM + 0.5,
        ear_reach=encoder.bolt_circle_mm / 2 + screw.thread_mm / 2 + EAR_WALL_MM,
        ear_half_height=screw.thread_mm / 2 + 2 * EAR_WALL_MM,
        ear_front_y=back_y + encoder.length_mm + screw.length_mm - ENCODER_GRIP_MM + 1.0,
    )


def seats_mm(d: BossDims) -> tuple[tuple[float, float, float], ...]:
    """A point on the wall of each of the two seats, the front one first."""
    ends = ((d.front_seat_start_y, d.front_y), (d.end_y, d.rear_seat_end_y))
    return tuple((0.0, (low + high) / 2, -d.seat_radius) for low, high in ends)


def seat_diameters(d: BossDims) -> tuple[Linear, Linear]:
    """Diameters of seats and shoulder in a section along the drum's axis."""

    def bore(radius: float, y: float, count: str = "", fit: str = "", datum: str = "") -> Linear:
        ends = ((0.0, y, -radius), (0.0, y, radius))
        return Linear("section", *ends, 2 * radius, "right", f"{count}%%c", fit=fit, datum=datum)

    seats = bore(d.seat_radius, d.front_y, "2x ", FITS["drum_seat"].code, DRUM_AXIS)
    return seats, bore(d.shoulder_radius, d.front_seat_start_y)


def in_section(d: BossDims, start_z: float) -> tuple[Linear, ...]:
    """Boss of a column in a section along its axis: depths from the back, where the column starts, and diameters."""
    depths = (
        (d.encoder_pocket_floor_y, -d.radius),
        (d.rear_seat_end_y, -d.seat_radius),
        (d.front_seat_start_y, -d.seat_radius),
        (d.front_y, -d.radius),
    )
    start, ears = (0.0, d.back_y, start_z), (0.0, d.ear_front_y, -d.ear_half_height)
    return (
        *(span(1, "section", start, (0.0, y, z), "below") for y, z in depths),
        span(1, "section", start, ears, "below", " ears"),
        *seat_diameters(d),
    )


def column_start_mm(d: BossDims) -> float:
    """Lowest z behind the boss of a column as wide as it: below, the encoder's pocket leaves less than a wall."""
    return sqrt(max(0.0, d.encoder_pocket_radius**2 - (d.radius - COLUMN_WALL_MM) ** 2))


def boss_of_column(d: BossDims, front_y: float) -> Form:
    """The boss, its volume outside a column as wide as it, up from the axis, whose front is at ``front_y``."""
    half_disc, h = pi * d.radius**2 / 2, d.ear_half_height
    # Below the axis the ears stand out of the boss, above it out of the column.
    chord = (d.radius + sqrt(max(d.radius**2 - h**2, 0.0))) / 2
    out = max(d.ear_reach - d.radius, 0.0) + max(d.ear_reach - chord, 0.0)
    ears = 2 * out * h * max(d.ear_front_y - d.encoder_pocket_floor_y, 0.0)
    lengths = d.front_y - d.encoder_pocket_floor_y + d.front_y - front_y
    return Form(half_disc * lengths + ears, lambda: boss_bodies(d))


def open_behind(d: BossDims, from_z: float) -> Form:
    """What is open behind the boss below a column as wide as it, the encoder's pocket there included.

    Its tool begins at ``from_z``, below the column.
    """
    start, beside = column_start_mm(d), d.radius + 1.0
    area = 2 * d.radius * start + segment_mm2(d.encoder_pocket_radius, start)
    y = (d.back_y - 1.0, d.encoder_pocket_floor_y)
    return Form(area * (d.encoder_pocket_floor_y - d.back_y), lambda: [block((-beside, beside), y, (from_z, start))])


def boss_bodies(d: BossDims) -> list[cq.Solid]:
    """Cylinder in front of the encoder's pocket, and the ears beside it; or with its flange."""
    body = cylinder_y(d.radius, 0.0, 0.0, d.end_y, d.front_y)
    if d.flange is not None:
        return [body, cylinder_y(d.flange.radius, 0.0, 0.0, d.back_y, d.back_y + d.flange.thickness)]
    if not d.has_encoder:
        return [body]
    reach, high = d.ear_reach, d.ear_half_height
    return [body, block((-reach, reach), (d.encoder_pocket_floor_y, d.ear_front_y), (-high, high))]


def boss_bores(d: BossDims) -> Form:
    """Seats and shoulder of the bearings; the encoder's pocket, from behind, lies outside the boss."""
    back = (d.end_y if d.flange else d.back_y) - 1.0
    steps = [
        (d.seat_radius, back, d.rear_seat_end_y),
        (d.shoulder_radius, d.rear_seat_end_y - 1.0, d.front_seat_start_y + 1.0),
        (d.seat_radius, d.front_seat_start_y, d.front_y + 1.0),
        *([(d.encoder_pocket_radius, back, d.encoder_pocket_floor_y)] if d.has_encoder else []),
    ]
    seats = d.rear_seat_end_y - d.end_y + d.front_y - d.front_seat_start_y
    shoulder = ring_mm3(d.shoulder_radius, 0.0, d.front_seat_start_y - d.rear_seat_end_y)
    return Form(
        ring_mm3(d.seat_radius, 0.0, seats) + shoulder,
        lambda: [cylinder_y(radius, 0, 0, start, end) for radius, start, end in steps],
    )


def boss_threads(d: BossDims, letter: str, from_face: str = "encoder pocket") -> tuple[Bores, ...]:
    """Threads of the drum encoder's screws in the ears, or of what the shaft turns in the flange."""
    if d.flange is not None:
        f = d.flange
        places = tuple((x, d.back_y, z) for x, z in f.screws)
        of = (letter, 2 * f.screw_radius, THROUGH, places, "flange", "what the shaft turns")
        return (Bores(*of, threaded=True, into=Y, metal=f.thickness),)
    if not d.has_encoder:
        return ()
    beside = tuple((s * d.screw_circle, d.encoder_pocket_floor_y, 0.0) for s in (-1, 1))
    return (Bores(letter, 2 * d.screw_radius, d.screw_depth, beside, from_face, "drum encoder", threaded=True, into=Y),)
