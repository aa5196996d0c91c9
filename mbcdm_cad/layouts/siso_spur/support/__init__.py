"""Dimensions of the frame: a plate with the drum's boss, and a yoke over the input that carries its front bearing.

In section, y to the right (front), z up:

      bridge  ______________
             |  ________    |
    motor    | |        |   |  encoder
    head ====|        pulley|====
             | |         ---    encoder shelf
             | |
             | |   drum's rim passes here
        _____| |
       | boss  |               drum bearings, drum encoder behind
"""

from dataclasses import dataclass, replace
from math import ceil, inf, pi, tan

from mbcdm_cad.checks.geometry import HOLE_WEB_MM
from mbcdm_cad.design.bought import InsertSpec, Screw
from mbcdm_cad.layouts.sector import head_frame
from mbcdm_cad.layouts.siso_spur.drive import SpurDrive, boss_front_y_mm, drum_inner_y_mm, groove_depth_mm, run_out_mm
from mbcdm_cad.layouts.siso_spur.idlers import FLANGE_MM, StandDims, stands
from mbcdm_cad.layouts.siso_spur.pulley import MotorSeat, without_bearings
from mbcdm_cad.parts.bodies import screw_places
from mbcdm_cad.parts.boss import BEARING_WALL_MM, BossFlange, boss
from mbcdm_cad.parts.drum_sector.design import END_PLAY_MM, SHELF_GAP_MM, LandLevels
from mbcdm_cad.parts.drum_sector.sizes import SLOT_WALLS, STOP_SLOT_PLAY_MM, terminal_half_mm
from mbcdm_cad.parts.input_pulley.dims import helix_stop_land_mm
from mbcdm_cad.parts.motor_head import dims
from mbcdm_cad.parts.turned import DrumShaftDims

# Land beyond the cable at each end of its walk.
BAND_MARGIN_MM = 0.5
# Least length of the collar between plate and idler.
COLLAR_MM = 1.0


@dataclass(frozen=True, kw_only=True)
class SpurStack(LandLevels):
    """Levels, all along Y: ``bearing_shelf_top_z`` is the plate's back, ``back_y`` the end of the drum's encoder."""

    plate_back_y: float


def reach_mm(drive: SpurDrive) -> float:
    """Half the length of the input that cables, grooves and walk use."""
    if drive.anchored:
        return drive.dead_end_mm + drive.cable.diameter_mm / 2
    return drive.leave_mm + drive.walk_mm / 2 + run_out_mm(drive)


def idlers_back_mm(drive: SpurDrive) -> float:
    """Lowest y of any idler with the collar behind it; infinite without idlers."""
    half = drive.idlers.width_mm / 2 + FLANGE_MM + COLLAR_MM if drive.idlers else 0.0
    return min((-abs(level) - half for level in drive.idler_levels_mm), default=inf)


def spur_stack(drive: SpurDrive) -> SpurStack:
    """Compute the levels of a design, without validation: the checks find levels that are impossible."""
    running, s = drive.clearances.running_mm, drive.support
    land = reach_mm(drive) + (helix_stop_land_mm(drive) if drive.anchored else BAND_MARGIN_MM)
    # The last of several cables side by side.
    last = drive.level_mm + drive.band_mm + land
    plane = abs(drive.terminal_mm)
    drum_inner = drum_inner_y_mm(drive)
    hub = without_bearings(drive).hub_length_mm if drive.overhung else 0.0
    # Heads on the flange of a servo's horn stay behind the rim too.
    land_or_rim = min(-land, drum_inner - running) if drive.servo is not None else -land
    front = min(-plane - terminal_half_mm(drive), drum_inner, land_or_rim - hub, idlers_back_mm(drive)) - running
    plate_back = front - s.plate_mm
    if drive.overhung:
        # The motor's face lies on the back of the plate; nothing is in front of the pulley.
        bearing_bottom = motor_bottom = plate_back
        motor_top = plate_back + s.motor_shelf_mm
        end = last
        if drive.servo is None:
            end = max(end, plate_back + drive.gearhead.shaft_length_mm)
        shelf_bottom = shelf_top = end
    else:
        bearing_bottom = plate_back - s.bearing_shelf_mm
        motor_top = bearing_bottom - s.coupling_space_mm
        motor_bottom = motor_top - s.motor_shelf_mm
        shelf_bottom = last + SHELF_GAP_MM + END_PLAY_MM
        shelf_top = shelf_bottom + s.encoder_shelf_mm
    # The motor of a first stage is not behind it.
    motor = drive.motor.length_mm if drive.cable_stage is None else 0.0
    return SpurStack(
        motor_bottom_z=motor_bottom - drive.gearhead.length_mm - motor,
        gearhead_bottom_z=motor_bottom - drive.gearhead.length_mm,
        motor_shelf_bottom_z=motor_bottom,
        motor_shelf_top_z=motor_top,
        bearing_shelf_bottom_z=bearing_bottom,
        bearing_shelf_top_z=plate_back,
        land_bottom_z=drive.level_mm - land,
        land_top_z=last,
        top_plate_bottom_z=shelf_bottom,
        top_plate_top_z=shelf_top,
        encoder_top_z=shelf_top + drive.encoder.length_mm,
        back_y=s.back_y_mm,
        plate_back_y=plate_back,
        front_y=front,
        drum_inner_y=drum_inner,
        drum_outer_y=drive.drum.outer_face_y_mm,
        hub_face_y=drive.drum.hub_face_y_mm,
        boss_front_y=boss_front_y_mm(drive),
    )


def least_wall_z_mm(drive: SpurDrive) -> float:
    """Least distance of the encoder shelf from the drum's axis: it must clear the rim with its cables."""
    return drive.drum_radius_mm + drive.cable.diameter_mm / 2 + drive.clearances.running_mm


# Width of the shelf beyond the encoder, on each side.
SHELF_MARGIN_MM = 0.5
# Width of shelf and bridge beyond the plate's opening on each side, where no encoder stands on the shelf (estimate).
BRIDGE_BESIDE_MM = 4.0
# Width of shelf and bridge over their reach in front of the plate, as far as the plate is so wide: an arm of the
# proportions of a bracket, not of a bar (choice).
YOKE_SHARE = 0.6
# Space above the pulley for the fingers that lead the cable round it.
WINDING_ROOM_MM = 3.0
# Wall beside a flange screw's thread, in its diameters.
SCREW_WALL = 0.65
# Metal between the opening of the plate and the nearest hole of the flange.
OPENING_WEB_MM = 0.6
# Gap between the heads of the flange's screws and the wall of the motor head.
HEAD_ROOM_MM = 0.15
# Radius of the stop pin's middle over the inner radius of the rim, where the hub leaves it room.
STOP_SHARE = 0.62
STOP_STEP_MM = 0.1
CORNER_MM = 2.0
# Flange of the boss behind which the drum's shaft stands out: its screws, their heads from the pilot, thickness, and
# the pilot before it (choices; each a usual size of small gearheads).
FLANGE_SCREW, FLANGE_SCREWS = "M3x8", 4
FLANGE_HEAD_PLAY_MM, FLANGE_THICK_MM, FLANGE_PILOT_MM = 0.3, 5.0, 2.0


@dataclass(frozen=True, kw_only=True)
class YokeDims(dims.HeadFrameDims):
    """Dimensions of the frame in mm, in the position that it has in the assembly; all screws and dowels at (x, z)."""

    levels: SpurStack
    axis_z: float  # of the input
    half_width: float
    shelf_half_width: float
    shelf_bottom_z: float
    bridge_bottom_z: float
    top_z: float  # of the bridge
    plate_top_z: float  # above the bridge behind a wide wheel of a stage, else the same
    opening_radius: float
    mount_insert: InsertSpec | None
    stands: tuple[StandDims, ...] = ()
    motor: MotorSeat | None = None  # on the plate, without a yoke; None: the motor is on a head of its own

    @property
    def has_encoder(self) -> bool:
        """Whether an encoder is screwed on the shelf."""
        return self.encoder_circle_radius > 0.0

    @property
    def encoder_shelf_bottom_z(self) -> float:
        """Face of the encoder shelf away from the pulley, as a coordinate along -Y."""
        return -self.levels.top_plate_top_z

    @property
    def encoder_shelf_top_z(self) -> float:
        """Face of the encoder shelf towards the pulley, as a coordinate along -Y."""
        return -self.levels.top_plate_bottom_z


def _round_thread_mm(drive: SpurDrive, screw: Screw, cut_mm: float) -> float:
    """Distance from a screw's axis to the next edge: ``cut_mm``, or more if the wall of an insert needs it."""
    insert = drive.insert(drive.frame_material, screw.thread_mm)
    return cut_mm if insert is None else max(cut_mm, insert.hole_mm / 2 + insert.wall_mm)


def opening_radius_mm(drive: SpurDrive) -> float:
    """Radius of the plate's opening for the pulley with anchored cables, the bearing and the encoder's screws."""
    encoder, screw = drive.encoder, drive.screw(drive.encoder.screw)
    land = drive.input_radius_mm + max(groove_depth_mm(drive) - drive.cable.diameter_mm / 2, 0.0)
    heads = encoder.bolt_circle_mm / 2 + screw.head_diameter_mm / 2 + 0.1
    beside = drive.cable.diameter_mm if drive.anchored else 0.0
    return max(land + beside + 0.3, drive.bearings.input_upper.outer_diameter_mm / 2 + 0.3, heads + 0.1)


def flange(drive: SpurDrive) -> dims.Flange:
    """Flange of the motor head on the back of the plate, or outline round the motor; y points away from the drum."""
    if drive.overhung:
        mount = drive.screw(drive.support.mount_bolt)
        return without_bearings(drive).flange(_round_thread_mm(drive, mount, mount.thread_mm), mount.thread_mm)
    inner = dims.inner_half_width_mm(drive)
    outer = inner + drive.support.side_wall_mm / 2
    screw = dims.flange_screw(drive)
    wall = _round_thread_mm(drive, screw, (SCREW_WALL + 0.5) * screw.thread_mm)
    # The screws are driven from behind, beside the motor.
    beside = dims.body_radius_mm(drive) + drive.clearances.running_mm
    x = max(outer, beside) + screw.head_diameter_mm / 2 + HEAD_ROOM_MM
    # Screws and dowels lie outside the opening for the pulley.
    x = max(x, opening_radius_mm(drive) + OPENING_WEB_MM + max(screw.thread_mm, dims.DOWEL_MM) / 2)
    front = dims.flange_front_mm(drive)
    back = -outer
    high, low = front - wall, back + wall
    return dims.Flange(
        half_x=x + wall,
        back_y=back,
        front_y=front,
        screws=((-x, high), (x, high), (-x, low), (x, low)),
        dowels=((-x, (high + low) / 2), (x, (high + low) / 2)),
    )


def _stop_pin_z_mm(drive: SpurDrive, boss_radius_mm: float) -> float:
    """Distance of the stop pin from the drum's axis: further out beside a wide boss or hub."""
    d, running = drive.drum, drive.clearances.running_mm
    slot = (d.stop_pin_mm + STOP_SLOT_PLAY_MM) / 2
    beside = max(
        d.hub_diameter_mm / 2 + SLOT_WALLS * drive.drum_material.min_wall_mm + slot,
        boss_radius_mm + d.stop_pin_mm / 2 + running,
    )
    return max(STOP_SHARE * d.rim_inner_radius_mm, ceil(beside / STOP_STEP_MM) * STOP_STEP_MM)


def boss_flange(drive: SpurDrive) -> BossFlange | None:
    """Flange of the boss of a drive whose drum's shaft is the output behind the frame; None without."""
    if drive.drum.shaft_end_mm <= 0.0:
        return None
    screw = drive.screw(FLANGE_SCREW)
    pilot = drive.bearings.drum.outer_diameter_mm / 2 + BEARING_WALL_MM
    circle = pilot + screw.head_diameter_mm / 2 + FLANGE_HEAD_PLAY_MM
    return BossFlange(
        radius=circle + screw.head_diameter_mm / 2,
        thickness=FLANGE_THICK_MM,
        pilot=FLANGE_PILOT_MM,
        screws=screw_places(FLANGE_SCREWS, circle),
        screw_radius=screw.thread_mm / 2,
    )


def yoke(drive: SpurDrive, levels: SpurStack, shaft: DrumShaftDims, head: dims.Flange) -> YokeDims:
    """Dimensions of the frame; ``head``: the flange of the motor head."""
    s, encoder, own = drive.support, drive.encoder, head_frame(drive)
    round_boss = replace(boss(drive, shaft, levels.back_y, levels.boss_front_y), flange=boss_flange(drive))
    z = drive.centre_distance_mm
    bridge = z + drive.input_radius_mm + drive.cable.diameter_mm / 2 + WINDING_ROOM_MM
    bridge = max(bridge, z + encoder.diameter_mm / 2 + SHELF_MARGIN_MM - s.bridge_mm)
    if drive.stage is None:
        bridge = max(bridge, z + head.front_y - s.bridge_mm)
    mount = drive.screw(s.mount_bolt)
    mount_insert = drive.insert(drive.frame_material, mount.thread_mm)
    edge = _round_thread_mm(drive, mount, mount.thread_mm)
    beside = head.half_x - edge
    thread = (mount_insert.hole_mm if mount_insert else mount.thread_mm) / 2
    lowest, highest = round_boss.radius + edge, z + head.back_y - edge
    if drive.frame_angle_rad < pi:
        # Clear of the threads of the next arm.
        lowest = max(lowest, (beside + thread + HOLE_WEB_MM) / tan(drive.frame_angle_rad / 2))
    held = stands(drive, (levels.plate_back_y, levels.front_y))
    needed = max(
        encoder.diameter_mm / 2 + SHELF_MARGIN_MM,
        own["encoder_circle_radius"] + own["encoder_head_radius"] + drive.frame_material.min_wall_mm,
        own["seat_radius"] + drive.frame_material.min_wall_mm,
        # No encoder says how wide the bridge must be to be stiff.
        opening_radius_mm(drive) + BRIDGE_BESIDE_MM if encoder.absent else 0.0,
    )
    half_width = max(head.half_x, *(stand.half_width for stand in held)) if held else head.half_x
    reach = levels.top_plate_top_z - levels.front_y
    whole = YokeDims(
        levels=levels,
        boss=round_boss,
        axis_z=z,
        half_width=half_width,
        shelf_half_width=max(needed, min(YOKE_SHARE * reach / 2, half_width)),
        # Down to the drum's rim; with idlers between, or terminals that come by, no lower than the bearing needs.
        shelf_bottom_z=max(least_wall_z_mm(drive), z - needed) if held or drive.whole_drum else least_wall_z_mm(drive),
        bridge_bottom_z=bridge,
        top_z=bridge + s.bridge_mm,
        plate_top_z=max(bridge + s.bridge_mm, z + head.front_y),
        opening_radius=opening_radius_mm(drive),
        corner_radius=max(CORNER_MM, drive.frame_material.min_internal_radius_mm),
        stop_pin_z=_stop_pin_z_mm(drive, round_boss.radius),
        flange_screws=tuple((x, z + y) for x, y in head.screws),
        dowels=tuple((x, z + y) for x, y in head.dowels),
        mounts=((-beside, lowest), (beside, lowest), (-beside, highest), (beside, highest)),
        mount_radius=thread,
        mount_insert=mount_insert,
        stands=held,
        **own,
    )
    if not drive.overhung:
        return whole
    top = z + head.front_y
    seat = without_bearings(drive).seat
    return replace(
        whole,
        shelf_half_width=0.0,
        shelf_bottom_z=top,
        bridge_bottom_z=top,
        top_z=top,
        plate_top_z=top,
        opening_radius=seat.pocket_radius,
        seat_radius=0.0,
        seat_depth=0.0,
        seat_shoulder_radius=0.0,
        flange_insert=None,
        dowel_depth=0.0,
        motor=seat,
    )
