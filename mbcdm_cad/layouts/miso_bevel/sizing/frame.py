"""Rules of the frame: depths along Y, walls and shelves, the space for couplings, the gearheads' turn."""

from __future__ import annotations

from contextlib import suppress
from dataclasses import replace

from mbcdm_cad.checks.fixings import stop_pin
from mbcdm_cad.checks.input_pulley import GRIP_DIAMETERS, PASSAGE_MM
from mbcdm_cad.layouts.base import NoFigureError
from mbcdm_cad.layouts.common_rules import STOP_PINS_MM
from mbcdm_cad.layouts.miso_bevel.checks.support_fits import head_seats, key_access
from mbcdm_cad.layouts.miso_bevel.checks.support_walls import front_wall
from mbcdm_cad.layouts.miso_bevel.drive import BevelDrive
from mbcdm_cad.layouts.miso_bevel.layout import BevelLayout
from mbcdm_cad.layouts.miso_bevel.plate_screws import PLATE_SCREWS
from mbcdm_cad.layouts.miso_bevel.sizing.boxes import box_mm, raised, side_wall
from mbcdm_cad.layouts.miso_bevel.sizing.known import LATER, BevelKnown
from mbcdm_cad.layouts.miso_bevel.sizing.parts import PLATE_SPARE_MM
from mbcdm_cad.layouts.miso_bevel.sizing.radii import drive_radius_mm
from mbcdm_cad.layouts.miso_bevel.support.dims import (
    AXLE_SCREW,
    ENCODER_HEAD_SUNK_MM,
    HEAD_ROOM_MM,
    MOUNT_GRIP_MM,
    MOUNT_ROOM_MM,
    STOP_PIN_DEPTH_MM,
)
from mbcdm_cad.parts.coupling import collar_sweep_mm, collar_width_mm
from mbcdm_cad.parts.drum_sector.sizes import SPRING_HEIGHT_MM
from mbcdm_cad.sizing.rule import Found, Rule, largest, rounded_down, rule, smallest

# Walls of the frame as shares of the outermost drum radius (estimate; a check of its own holds the frame's stiffness).
BACK_SHARE, RIB_SHARE = 1.0 / 13.0, 1.0 / 9.2
# Shoulders a little stronger than the thinnest wall: they carry bearings.
SHELF_SPARE_MM = 0.2
# Collar above the heads of the gearhead's screws, and journal above them.
COLLAR_LIFT_MM, SLIT_ABOVE_MM, JOURNAL_LIFT_MM = 0.8, 1.0, 0.5
SPACE_SPARE_MM = 0.1
# Pins thinner than this share of the diameter that the previous trial required are not tried.
PIN_SPARE = 0.75


@rule(
    "support.motor_shelf_mm",
    "thickness that leaves enough engagement for the gearhead's screws and shaft",
    "engagement",
)
def motor_shelf(given: BevelKnown) -> Found:
    head = given.entry("gearheads", "drive.gearhead")
    screw = given.screw(head["screw"])
    limits = {
        "engagement": screw.length_mm - screw.thread_mm,
        "shaft_grip": head["shaft_length_mm"]
        - screw.head_height_mm
        - COLLAR_LIFT_MM
        - GRIP_DIAMETERS * head["shaft_diameter_mm"],
    }
    return smallest(limits, 0.1)


@rule("support.bearing_shelf_mm", "the lower bearings and a shoulder", "bearing_shelf")
def bearing_shelf(given: BevelKnown) -> Found:
    wall = given.wall_mm("support")
    needs = {
        "bearing_shelf": given.entry("bearings", given.shelf_bearing)["width_mm"] + wall + SHELF_SPARE_MM,
        "axle's set screw": given.screw(AXLE_SCREW).thread_mm + 2 * wall,
    }
    if given.motors_above:
        needs["encoders' screws"] = _sunk_mm(given) + wall
    return raised(given, needs)


def _sunk_mm(given: BevelKnown) -> float:
    """Depth of the counterbores for the screws of the inputs' encoders."""
    encoder = given.screw(given.entry("encoders", "drive.encoder")["screw"])
    return encoder.head_height_mm + ENCODER_HEAD_SUNK_MM


@rule("support.top_plate_mm", "the upper bearings and a shoulder", "top_plate")
def top_plate(given: BevelKnown) -> Found:
    wall = given.wall_mm("support")
    sunk = {} if given.motors_above else {"encoders' screws": _sunk_mm(given) + wall}
    needs = {
        "top_plate": given.entry("bearings", given.plate_bearing)["width_mm"] + wall + PLATE_SPARE_MM,
        **sunk,
        "plate's screws": given.screw(PLATE_SCREWS[0]).head_height_mm + wall,
    }
    return largest(needs, 0.1)


@rule("support.coupling_space_mm", "space to insert the collar, the gearhead's screws and their key", "coupling_height")
def coupling_space(given: BevelKnown) -> Found:
    head, above_plate = given.entry("gearheads", "drive.gearhead"), given.motors_above
    screw, collar = given.screw(head["screw"]), collar_width_mm(given, given["input_pulleys.collar_screw"])
    running = given["clearances.running_mm"]
    shelf = given["support.top_plate_mm" if above_plate else "support.bearing_shelf_mm"]
    lower = given.entry("bearings", "input_pulleys.lower_bearing")["width_mm"]
    above = screw.head_height_mm
    shaft = max(head["shaft_length_mm"] - given["support.motor_shelf_mm"], 0.0)
    needs = {
        "coupling_height": above + COLLAR_LIFT_MM + collar + running,
        "journal's slit": above + JOURNAL_LIFT_MM + collar + SLIT_ABOVE_MM + running - (shelf - lower),
        "gearhead's screws": screw.length_mm + above + running,
        "collar on its way in": shaft + collar + PASSAGE_MM,
    }
    if not above_plate:
        needs["mounts"] = 2 * (given.mount_head_mm + HEAD_ROOM_MM)
    needs = {name: need + SPACE_SPARE_MM for name, need in needs.items()}
    return largest(needs, 0.1)


@rule("drum.stop_pin_mm", "the thinnest pin that holds both stalled motors", "stop_pin")
def _stop_pin(given: BevelKnown) -> Found:
    """The thinnest pin of the usual sizes that holds both motors stalled."""
    thinnest = 0.0
    for size in STOP_PINS_MM:
        if size < thinnest:
            continue
        with suppress(NoFigureError):
            trial = given.trial(**LATER, drum__stop_pin_mm=size)
            found = stop_pin(BevelLayout(trial))
            if found.margin >= 0.0:
                return Found(size, "stop_pin", "to a usual size")
            # Stress falls with the cube of the diameter; a thicker pin also moves outwards a little.
            thinnest = PIN_SPARE * size * (found.limit / found.actual) ** (1 / 3)
    return Found(STOP_PINS_MM[-1], "stop_pin", "the thickest of the usual sizes")


@rule("support.back_plate_mm", "a share of the drum's radius, for the stiffness of the frame", "frame_windup")
def back_plate(given: BevelKnown) -> Found:
    stiff = BACK_SHARE * given.frame.stiffer * max(given.drum_mm)
    return largest({"frame_windup": stiff, "walls": 2 * given.wall_mm("support")}, 0.1)


@rule("support.rib_mm", "a share of the drum's radius, or less for the heads of the mounting screws", "frame_windup")
def rib(given: BevelKnown) -> Found:
    bearing = given.entry("bearings", "drum.bearing")["outer_diameter_mm"] / 2
    ring = given.entry("encoders", "drive.drum_encoder")["diameter_mm"]
    head, least = given.mount_head_mm, given.wall_mm("support")
    # The column's pocket should have room for a mounting screw's head in width and height. If the motors are so low
    # that even the thinnest rib leaves too little height, the column has no pocket.
    boss = max(bearing + 3.0, ring / 2 + given["clearances.running_mm"])
    along = given.shelf_bottom_mm - boss - 2 * head - HEAD_ROOM_MM - MOUNT_ROOM_MM + 0.2
    across = bearing + 3.0 - head - HEAD_ROOM_MM
    most = min(across, along) if along >= least else across
    wanted = max(RIB_SHARE * given.frame.stiffer * max(given.drum_mm), least)
    driver = "frame_windup" if wanted <= most else "mounts"
    return Found(max(rounded_down(min(wanted, most), 0.1), least), driver, "down to 0.1")


@rule("support.back_y_mm", "nearest plane behind drum bearings, encoder, pulleys, collars and stop pin", "collar_space")
def back(given: BevelKnown) -> Found:
    """Outer face of the back plate: as far back as drum bearings, pulleys, collars and the stop pin need."""
    running, wall, plate = given["clearances.running_mm"], given.wall_mm("support"), given["support.back_plate_mm"]
    setback = float(given.get("transmission.input_setback_mm", 0.0))
    bearing = given.entry("bearings", "drum.bearing")["width_mm"]
    encoder = given.entry("encoders", "drive.drum_encoder")
    boss = given.drum_inner_mm - 3 * running
    front = min(given.guide_mm[0] - given.terminal_mm, given.drum_inner_mm) - running
    journal = given.entry("bearings", "input_pulleys.lower_bearing")["bore_mm"]
    collar = collar_sweep_mm(given, journal, given.wall_mm("support"), given["input_pulleys.collar_screw"])
    in_pocket, part = ("collar_space", collar + setback)
    if given.motors_above:
        in_pocket, part = ("encoders", given.entry("encoders", "drive.encoder")["diameter_mm"] / 2 + setback)
    pulley = max(given.input_mm) + given.d_mm / 2 + setback
    needs = {
        "drum_bearing_spacing": 3 * bearing + encoder["length_mm"] + 1.0 + SPRING_HEIGHT_MM - boss,
        "walls": max(given.guide_mm) + given.d_mm / 2 + running + wall,
        "drives_apart": drive_radius_mm(given) + setback + running,
        "pocket_depth": pulley + running + plate,
        in_pocket: part + running + plate,
        "mounting screws": part + running + MOUNT_GRIP_MM + given.mount.height_mm(given.printed("support")),
        "boss": STOP_PIN_DEPTH_MM + wall - front,
        "corner_radii": plate + 6.0 - front,
    }
    if given.motors_above:
        needs["coupling boxes"] = box_mm(given) + setback
    found = largest(needs, 0.5)
    return Found(-found.value, found.driver, found.rounding)


@rule("support.mount_screw", "the thinnest that holds the peak torque by friction", "mounting_screws")
def mount_screw(given: BevelKnown) -> Found:
    return Found(given.frame.mount_screw, "mounting_screws", "the thinnest of M3 to M6 that holds")


FRAME = (
    mount_screw,
    motor_shelf,
    bearing_shelf,
    top_plate,
    Rule("support.side_wall_mm", "walls beside the sunk heads of the top plate's screws", "side_wall", side_wall),
    coupling_space,
    back_plate,
    rib,
)
STOP_PIN = (_stop_pin,)


STEP_DEG = 15.0
FIELD = "drive.gearhead_angle_deg"


def _drive(given: BevelKnown) -> BevelDrive | None:
    """The drive so far; None where it is none yet."""
    try:
        return given.trial(**LATER)
    except NoFigureError:
        return None


def _failing(drive: BevelDrive | None, turn_deg: float) -> str:
    """The check of the gearheads' screws that fails with gearheads turned by this angle; empty if none does."""
    if drive is None:
        return ""
    try:
        design = BevelLayout(replace(drive, gearhead_angle_deg=turn_deg))
        found = {check.id: check(design) for check in (head_seats, key_access, front_wall)}
    except NoFigureError:
        return ""
    return next((name for name, comparison in found.items() if not comparison.holds), "")


def _turn(given: BevelKnown) -> float | None:
    """The least turn, deg, with which the screws have their places; None where no turn is better than none."""
    drive = _drive(given)
    if not _failing(drive, 0.0):
        return None
    steps = int(180.0 / given.gearhead.screw_count / STEP_DEG)
    turns = (sense * k * STEP_DEG for k in range(1, steps + 1) for sense in (1, -1))
    return next((turn for turn in turns if not _failing(drive, turn)), None)


def _helps(given: BevelKnown) -> bool:
    return _turn(given) is not None


# Where it does not apply, the schema's own value stays.
@rule(
    FIELD,
    "the least turn with which the heads of the gearheads' screws and their key clear the walls",
    "head_seats",
    _helps,
)
def gearhead_turn(given: BevelKnown) -> Found:
    return Found(_turn(given), _failing(_drive(given), 0.0), f"to {STEP_DEG:g}")
