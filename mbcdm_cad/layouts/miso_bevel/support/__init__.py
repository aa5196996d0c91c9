"""Dimensions of the support: a frame milled from one block, pockets from the front, and a separate top plate.

Seen from the front (x across, z up):

    =========================   top plate (upper bearings, encoders on top)
    |  pulleys |guide|      |   upper pocket, open at the top
    |=======================|   bearing shelf
    |   coupling  ||  coupling  two pockets, a web between them that carries the stop pin
    |=======================|   motor shelf, gearheads hang below
          |  ribs   |
           (  boss )            drum bearings, drum encoder from behind

With motors above, each stands on a coupling box in one piece with the top plate, and the encoders hang from the bearing
shelf in the two lower pockets:

          gearhead  gearhead
          |box |    |box |
    =========================   top plate (bearings next to the gearheads)
    |  pulleys |guide|      |
    |=======================|   bearing shelf (bearings next to the encoders)
    |   encoder  ||  encoder|   lower pockets
    |=======================|   lowest shelf
"""

from dataclasses import dataclass, replace

from mbcdm_cad.design.bought import InsertSpec
from mbcdm_cad.layouts.miso_bevel.drive import BevelDrive
from mbcdm_cad.layouts.miso_bevel.stack import (
    Edges,
    Stack,
    counterbore_radius_mm,
    milled_corner_mm,
    plate_screw_of,
    stop_pin_z,
)
from mbcdm_cad.parts.bodies import screw_places
from mbcdm_cad.parts.boss import boss, column_start_mm
from mbcdm_cad.parts.drum_sector.sizes import drum_shaft
from mbcdm_cad.parts.fits import MOUNT_SCREWS
from mbcdm_cad.parts.motor_head.dims import CouplingBox, SectorFrameDims, coupling_box, key_hole_mm

STOP_WEB_MM = 7.0
AXLE_SCREW = "M2x3-set"
# Play of a mounting screw's head in its bore, on the radius.
MOUNT_HEAD_PLAY_MM = 0.2
# Distance from a mounting screw's head to the wall beside it, and its least value for the bearing face (estimates).
MOUNT_ROOM_MM, HEAD_ROOM_MM = 1.0, 0.5
# From the bore of a head to the walls of its pocket, in front of which the pocket's corners are (estimate).
MOUNT_WALL_MM = 1.3
MOUNT_GRIP_MM = 2.6
STOP_PIN_DEPTH_MM = 12.0
DOWEL_MM = 2.0
# Counterbore of the encoders' screws over their heads: play on the radius, and depth.
ENCODER_HEAD_PLAY_MM, ENCODER_HEAD_SUNK_MM = 0.1, 0.2
DOWEL_LENGTHS_MM = (6.0, 8.0, 10.0, 12.0, 14.0)


@dataclass(frozen=True)
class EncoderHoles:
    """Holes for the screws of an input's encoder, their heads sunk in the face on the pulley's side (mm)."""

    circle_radius: float
    clearance: float
    head_radius: float
    head_depth: float

    def places(self, x: float) -> tuple[float, float]:
        """x of both screws of the encoder at ``x``."""
        return x - self.circle_radius, x + self.circle_radius


@dataclass(frozen=True, kw_only=True)
class FrameDims(SectorFrameDims):
    """Frame dimensions (mm)."""

    levels: Stack
    rib_thickness: float
    web_half_width: float
    upper_floor_y: float  # floor of the upper pocket, deeper where the guide's cables need it
    column_pocket_bottom_z: float
    input_x: tuple[float, ...]
    input_y: float
    pilot_radius: float
    gear_screw_clearance: float
    gear_bolt_circle: float
    gear_screw_count: int
    key_hole_radius: float
    axle_radius: float
    axle_screw_radius: float
    stop_pin_start_y: float
    plate_screw_radius: float
    plate_screw_depth: float
    plate_insert: InsertSpec | None
    plate_screws: tuple[tuple[float, float], ...]  # (x, y)
    mount_head_radius: float
    mount_head_height: float
    mount_seat_y: float  # heads are sunk in a thick back plate, out of the collars' way
    encoder_holes: EncoderHoles | None = None  # in the bearing shelf, with motors above
    gear_turn_deg: float = 0.0  # of the gearheads at +x about their axes; those at -x mirror them

    @property
    def carries_drives(self) -> bool:
        """Whether the gearheads hang below the lowest shelf; else the encoders below the bearing shelf."""
        return self.encoder_holes is None

    @property
    def gear_screws(self) -> tuple[tuple[float, float], ...]:
        """(x, y) of the screws of all gearheads below the lowest shelf."""
        return tuple(place for x in self.input_x for place in self.gear_screws_at(x))

    def gear_screws_at(self, x: float) -> tuple[tuple[float, float], ...]:
        """(x, y) of the screws of the gearhead at this input."""
        if not self.carries_drives:
            return ()
        turn = self.gear_turn_deg if x > 0.0 else -self.gear_turn_deg
        places = screw_places(self.gear_screw_count, self.gear_bolt_circle, turn)
        return tuple((x + dx, self.input_y + dy) for dx, dy in places)

    @property
    def has_column_pocket(self) -> bool:
        """Whether the column is hollow; that of a small drum is solid."""
        return self.column_pocket_bottom_z < self.levels.shelf_bottom_z

    @property
    def column_start_z(self) -> float:
        """Lowest z of the column behind the boss: below it the encoder's pocket leaves less than a wall."""
        return column_start_mm(self.boss)


@dataclass(frozen=True)
class TopPlateDims:
    """Top plate dimensions (mm)."""

    levels: Stack
    corner_radius: float
    input_x: tuple[float, ...]
    input_y: float
    seat_radius: float
    seat_depth: float
    shoulder_radius: float
    axle_radius: float
    screw_clearance: float
    screw_head_radius: float
    screw_head_depth: float
    screws: tuple[tuple[float, float], ...]
    dowels: tuple[tuple[float, float], ...]
    dowel_radius: float
    encoder_holes: EncoderHoles | None  # none with motors above
    box: CouplingBox | None = None  # on the plate at the input at +x, with motors above; that at -x mirrors it

    @property
    def boxes(self) -> tuple[tuple[float, CouplingBox], ...]:
        """x of each input with its box; none with motors below."""
        if self.box is None:
            return ()
        mirrored = replace(self.box, gear_screws=tuple(sorted((0.0 - x, y) for x, y in self.box.gear_screws)))
        return tuple((x, self.box if x > 0.0 else mirrored) for x in self.input_x)


def dowel_length_mm(drive: BevelDrive) -> float:
    """The shortest dowel that reaches into the frame by its diameter, else the longest."""
    reaching = (length for length in DOWEL_LENGTHS_MM if length - drive.support.top_plate_mm >= DOWEL_MM)
    return next(reaching, DOWEL_LENGTHS_MM[-1])


def plate_screws(drive: BevelDrive, levels: Stack) -> tuple[tuple[float, float], ...]:
    """(x, y) of the screws that hold the top plate: in the side walls, front and back, clear of the rounded corners."""
    x = (levels.side_inner_x + levels.side_outer_x) / 2
    front, back = Edges(levels.front_y, levels.back_y, pocket_corner_radius_mm(drive, levels)).screws_y
    return ((-x, front), (x, front), (-x, back), (x, back))


def dowels(levels: Stack) -> tuple[tuple[float, float], ...]:
    """(x, y) of the two dowels that locate the top plate on the side walls."""
    x = (levels.side_inner_x + levels.side_outer_x) / 2
    y = (levels.front_y + levels.back_y) / 2
    return ((-x, y), (x, y))


def pocket_corner_radius_mm(drive: BevelDrive, levels: Stack) -> float:
    """Corner radius of the frame's pockets: an end mill no longer than four times its diameter reaches the floor."""
    return milled_corner_mm(drive, levels.front_y - levels.pocket_floor_y)


def frame(drive: BevelDrive, levels: Stack) -> FrameDims:
    """Dimensions of the frame."""
    round_boss = boss(drive, drum_shaft(drive, levels), levels.back_y, levels.boss_front_y)
    in_shelf, gear = drive.shelf_bearing, drive.gearhead
    gear_screw = drive.screw(gear.screw)
    plate_screw = plate_screw_of(drive)
    plate_insert = drive.insert(drive.frame_material, plate_screw.thread_mm)
    column_z = max(round_boss.radius, round_boss.encoder_pocket_radius) + drive.support.rib_mm
    pocket_z = (levels.shelf_top_z + levels.bearing_shelf_bottom_z) / 2
    screw, printed = MOUNT_SCREWS[drive.support.mount_screw], drive.frame_material.printed
    head = screw.seat_mm(printed) / 2 + MOUNT_HEAD_PLAY_MM
    mounts, pocket_bottom_z = _mounts(levels, pocket_z, column_z, head)
    return FrameDims(
        levels=levels,
        boss=round_boss,
        rib_thickness=drive.support.rib_mm,
        web_half_width=STOP_WEB_MM / 2,
        upper_floor_y=min(
            levels.pocket_floor_y,
            -max(c.guide_radius_mm for c in drive.cables) - drive.cable.diameter_mm / 2 - drive.clearances.running_mm,
        ),
        column_pocket_bottom_z=pocket_bottom_z,
        corner_radius=pocket_corner_radius_mm(drive, levels),
        input_x=tuple(side * drive.input_x_mm for side in drive.input_sides),
        input_y=drive.input_y_mm,
        pilot_radius=gear.pilot_diameter_mm / 2,
        gear_screw_clearance=gear_screw.clearance_mm / 2,
        gear_bolt_circle=gear.bolt_circle_mm / 2,
        gear_screw_count=gear.screw_count,
        # The hexagon key passes through the bearing shelf to the gearhead's screws before the bearing is inserted.
        key_hole_radius=key_hole_mm(drive),
        seat_radius=in_shelf.outer_diameter_mm / 2,
        seat_depth=in_shelf.width_mm,
        seat_shoulder_radius=in_shelf.outer_shoulder_mm / 2,
        axle_radius=drive.bearings.guide.bore_mm / 2,
        axle_screw_radius=drive.screw(AXLE_SCREW).thread_mm / 2,
        stop_pin_radius=drive.drum.stop_pin_mm / 2,
        stop_pin_z=stop_pin_z(drive, levels),
        stop_pin_start_y=levels.front_y - STOP_PIN_DEPTH_MM,
        plate_screw_radius=(plate_insert.hole_mm if plate_insert else plate_screw.thread_mm) / 2,
        plate_screw_depth=max(
            plate_screw.length_mm - (drive.support.top_plate_mm - plate_screw.head_height_mm) + 0.5,
            plate_insert.depth_mm if plate_insert else 0.0,
        ),
        plate_insert=plate_insert,
        plate_screws=plate_screws(drive, levels),
        dowels=dowels(levels),
        dowel_radius=DOWEL_MM / 2,
        dowel_depth=dowel_length_mm(drive) - drive.support.top_plate_mm + 0.5,
        mounts=mounts,
        mount_radius=screw.hole_mm / 2,
        mount_head_radius=head,
        mount_head_height=screw.height_mm(printed),
        mount_seat_y=min(levels.pocket_floor_y, levels.back_y + MOUNT_GRIP_MM),
        encoder_holes=encoder_holes(drive) if drive.motors_above else None,
        gear_turn_deg=drive.gearhead_angle_deg,
    )


def encoder_holes(drive: BevelDrive) -> EncoderHoles:
    """Holes for the screws of an input's encoder."""
    screw = drive.screw(drive.encoder.screw)
    return EncoderHoles(
        circle_radius=drive.encoder.bolt_circle_mm / 2,
        clearance=screw.clearance_mm / 2,
        head_radius=screw.head_diameter_mm / 2 + ENCODER_HEAD_PLAY_MM,
        head_depth=screw.head_height_mm + ENCODER_HEAD_SUNK_MM,
    )


def _mounts(
    levels: Stack, pocket_z: float, pocket_bottom_z: float, head_mm: float
) -> tuple[tuple[tuple[float, float], ...], float]:
    """(x, z) of the mounting screws, and the lower end of the column's pocket.

    Four screws are in the pockets beside the web, one in the column. If the lowest shelf is so near to the bearings of
    a small drum that the column has no room for a screw's head, the column is solid, its pocket ends at the shelf.
    ``head_mm``: radius of a head's bore.
    """
    wall = head_mm + MOUNT_WALL_MM
    outer_x, inner_x = levels.side_inner_x - wall, STOP_WEB_MM / 2 + wall
    beside = ((-outer_x, pocket_z), (outer_x, pocket_z), (-inner_x, pocket_z), (inner_x, pocket_z))
    # As low in the column's pocket as its head has room: nearer to the drum's bearings the frame is stiffer.
    column_z = pocket_bottom_z + head_mm - MOUNT_HEAD_PLAY_MM + MOUNT_ROOM_MM
    if levels.shelf_bottom_z - column_z - head_mm < HEAD_ROOM_MM:
        return beside, levels.shelf_bottom_z
    return (*beside, (0.0, column_z)), pocket_bottom_z


def top_plate(drive: BevelDrive, levels: Stack) -> TopPlateDims:
    """Dimensions of the top plate."""
    in_plate, screw = drive.plate_bearing, plate_screw_of(drive)
    return TopPlateDims(
        levels=levels,
        corner_radius=pocket_corner_radius_mm(drive, levels),
        input_x=tuple(side * drive.input_x_mm for side in drive.input_sides),
        input_y=drive.input_y_mm,
        seat_radius=in_plate.outer_diameter_mm / 2,
        seat_depth=in_plate.width_mm,
        shoulder_radius=in_plate.outer_shoulder_mm / 2,
        axle_radius=drive.bearings.guide.bore_mm / 2,
        screw_clearance=screw.clearance_mm / 2,
        screw_head_radius=counterbore_radius_mm(drive),
        screw_head_depth=screw.head_height_mm,
        screws=plate_screws(drive, levels),
        dowels=dowels(levels),
        dowel_radius=DOWEL_MM / 2,
        encoder_holes=None if drive.motors_above else encoder_holes(drive),
        box=_box(drive, levels) if drive.motors_above else None,
    )


def _box(drive: BevelDrive, levels: Stack) -> CouplingBox:
    """The coupling box of an input, its gearhead turned over about Y."""
    gear = drive.gearhead
    places = screw_places(gear.screw_count, gear.bolt_circle_mm / 2, drive.gearhead_angle_deg)
    return coupling_box(drive, levels.from_gearhead, tuple(sorted((0.0 - x, y) for x, y in places)))
