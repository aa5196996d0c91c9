"""Rules that choose bought parts from the catalogue: the lightest that carries the load and has room."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from math import pi, sqrt
from operator import itemgetter

from mbcdm_cad.checks.fixings import CLAMP_SAFETY, FRICTION, STRESS_SAFETY, grip_Nmm
from mbcdm_cad.checks.geometry import HOLE_WEB_MM
from mbcdm_cad.checks.input_pulley import FIT_MM, SHOULDER_MM
from mbcdm_cad.checks.springs import LEAST_PLAY_MM, MOST_PLAY_MM
from mbcdm_cad.checks.terminals import STUD_SAFETY, THREAD_OUT_PITCHES
from mbcdm_cad.design.blocks import NO_PAYLOAD
from mbcdm_cad.design.bought import NO_GEARHEAD
from mbcdm_cad.layouts.common_rules import COLLAR_SCREWS
from mbcdm_cad.layouts.head_basis import (
    HEAT_SPARE,
    backdrive_margin,
    counts_losses,
    gearhead_share,
    heat_margin,
    lasting_share,
    output_mNm,
    speed_margin,
    turns_back_Nm,
)
from mbcdm_cad.layouts.miso_bevel.sizing.known import BevelKnown
from mbcdm_cad.layouts.miso_bevel.sizing.picking import (
    LIGHTEST,
    Entry,
    Margins,
    by_mass,
    careful,
    first,
    lightest,
    ordered,
    with_partner,
)
from mbcdm_cad.layouts.miso_bevel.sizing.radii import least_step_mm, take_up_mm, take_up_with_mm
from mbcdm_cad.layouts.miso_bevel.support.dims import AXLE_SCREW, DOWEL_LENGTHS_MM, DOWEL_MM
from mbcdm_cad.model.losses import ROPE_EXPONENT, ROPE_FACTOR
from mbcdm_cad.parts.coupling import collar
from mbcdm_cad.parts.drum_sector.sizes import SPRING_HEIGHT_MM, SWAGE_FLOOR_MM
from mbcdm_cad.parts.fits import clamp_force_N
from mbcdm_cad.parts.input_pulley.dims import neck_mm
from mbcdm_cad.sizing.rule import Found, rounded_up, rule

# An input carries half the peak torque, a little more in the direction of the bias of its preload.
TORQUE_SPARE = 1.095
# Torque of the preload on an input, as a share of preload times its radius: the difference of neighbouring steps, at
# least this step of the drum's radii.
BIAS_SHARE, LEAST_STEP_MM = 0.067, 3.6
# Losses of an input's cables over that of one on the input: there, at both ends of the guide's wrap, on drum and in the
# bearings.
INPUT_LOSSES = 2.7
# Radial load of one bearing of an input pulley, in preloads: both cables pull, and one end carries most of it. The
# largest and the usual value: if no part of the catalogue carries the first, the second is used.
INPUT_PRELOADS = (1.65, 1.41)
# The same for the guide: four cables tilt it rather than push it aside, so the largest tension counts.
GUIDE_TENSIONS = 1.85
# The same for a drum's bearing, in tensions.
DRUM_TENSIONS = (1.62, 1.23)
# Radius of the drum's smallest land over the diameter of its shaft: the usual ratio, and that of a small drum with a
# large force at its land, whose thick stop pin needs a part of the space of boss and hub.
DRUM_SHAFTS, SMALL_DRUM_SHAFTS, SMALL_DRUM_MM, HARD_PULL_N = 8.0, 9.0, 36.0, 50.0
# Distance of the hub's face from the front bearing over the bore (estimate), and bending of the shaft with the cables'
# part over that by the payload alone.
FACE_BORES, SHAFT_SPARE = 2.2, 1.3
# Grip of a collar over the limit of its check: the input's torque is an estimate as long as the drum's steps are open.
GRIP_SPARE = 1.03
# Take-up over the need of the longest cable, whose length is an estimate until the drum's width is known.
TAKE_UP_SPARE = 1.04
# Strength of the stud over the limit of its check, because the nut also bends it a little.
STUD_SPARE = 1.2

# Thickness of the top plate over the width of the upper bearing, besides the wall of its shoulder.
PLATE_SPARE_MM = 0.3
# Gap from swage to lug with the terminal drawn in: the rounded corner of the pocket and a clearance.
END_ROOM_MM = 0.5


def _share_N(given: BevelKnown) -> float:
    return float(given["loads.peak_torque_Nm"] * 1e3 / (4.4 * given.first_drum_mm))


def _tension_N(given: BevelKnown) -> float:
    return float(given["rope.preload_N"] + _share_N(given))


def _input_torque_Nm(given: BevelKnown) -> float:
    radius = given.first_drum_mm / given.total_ratio
    step = max(LEAST_STEP_MM, least_step_mm(given))
    share = max(BIAS_SHARE, step / given.first_drum_mm)
    bias = share * given["rope.preload_N"] * radius * 1e-3
    needed = TORQUE_SPARE * given["loads.peak_torque_Nm"] / (2 * given.total_ratio) + bias
    if counts_losses(given):
        needed = needed + _lost_at_input_Nm(given)
    return float(needed)


def _lost_at_input_Nm(given: BevelKnown) -> float:
    """Friction of an input's cables, at the input: on input, guide and drum, two cables at their preload.

    No tangent point loses more than one on the input.
    """
    radius = given.first_drum_mm / given.total_ratio
    at_input = 0.5 * ROPE_FACTOR * (given.d_mm / (2.0 * radius)) ** ROPE_EXPONENT
    return float(INPUT_LOSSES * at_input * 2.0 * given["rope.preload_N"] * radius * 1e-3)


def _total_ratio(given: BevelKnown) -> float:
    return given.total_ratio


def _motor_margins(given: BevelKnown, motor: Entry, gearhead: Entry, geared: bool = True) -> Margins:
    """Margins of a motor with its gearhead, or with its own face in place of one."""
    needed, total = given.once(_input_torque_Nm) * 1e3, given.once(_total_ratio)
    shaft = gearhead["shaft_diameter_mm"]
    head = gearhead if geared else None
    lasting, asked = given.once(lasting_share), needed / output_mNm(given, motor, head) * motor["rated_torque_mNm"]
    return {
        "motor_torque_back": output_mNm(given, motor, head) / needed - 1.0,
        "collar_grip": _most_grip_Nmm(given, shaft) / (GRIP_SPARE * CLAMP_SAFETY * needed) - 1.0,
        "gearhead_maximum": gearhead["max_torque_mNm"] / needed - 1.0,
        "continuous_torque": gearhead["rated_torque_mNm"] / needed - given.once(gearhead_share),
        "speed": speed_margin(given, motor, gearhead["ratio"], total, (lasting or 1.0) * asked),
        "duty": heat_margin(
            given, motor, head, HEAT_SPARE * needed, HEAT_SPARE * given["loads.peak_torque_Nm"] * 1e3 / (2 * total)
        ),
        "backdrive": backdrive_margin(
            given, turns_back_Nm(motor, head, total, 2), 2 * total * given.once(_lost_at_input_Nm)
        ),
        # A motor wider than its gearhead has no room behind the shelf.
        "drives_apart": 1.0 - motor["diameter_mm"] / (gearhead["diameter_mm"] + 1.0),
    }


def _most_grip_Nmm(given: BevelKnown, shaft_mm: float) -> float:
    """Torque that a collar with the strongest screw of the catalogue holds on a shaft, with the thinnest journal."""
    wall = given.wall_mm("support")
    journal = shaft_mm + 2 * given.wall_mm("input_pulleys")
    screw = given.screw(COLLAR_SCREWS[-1])
    hinge = journal / 2
    return FRICTION * clamp_force_N(screw.thread_mm) * (1 + (hinge + wall + screw.clearance_mm / 2) / hinge) * shaft_mm


def _direct(given: BevelKnown) -> list[tuple[float, str, Callable[[], Margins]]]:
    """Motors on their own shaft: mass, name, function that computes their margins."""
    return [
        (motor["mass_g"], name, partial(_motor_margins, given, motor, face, geared=False))
        for name, (motor, face) in given.motors_with_faces().items()
        if "servo" not in motor
    ]


@rule(
    "drive.motor",
    "the lightest motor that, with its gearhead, holds half the peak torque and the preload's bias",
    "motor_torque_back",
)
def _motor(given: BevelKnown) -> Found:
    if given.get("drive.gearhead") == NO_GEARHEAD:
        return first((name, margins) for _, name, margins in sorted(_direct(given), key=itemgetter(0, 1)))
    geared = with_partner(given, "motors", ("gearheads", "drive.gearhead"), partial(_motor_margins, given))
    if given.get("loads.backdrive_Nm") is None or given.has("drive.gearhead") or geared.rounding == LIGHTEST:
        return geared
    # A motor on its own shaft turns back most easily.
    return first((name, margins) for _, name, margins in sorted(_direct(given), key=itemgetter(0, 1)))


@rule("drive.gearhead", "the lightest gearhead that holds the input's torque", "gearhead_maximum")
def _gearhead(given: BevelKnown) -> Found:
    motor = given.entry("motors", "drive.motor")
    if given.get("loads.backdrive_Nm") is not None and given["drive.motor"] in given.motors_with_faces():
        return Found(NO_GEARHEAD, "backdrive")
    return lightest(given, "gearheads", lambda head: _motor_margins(given, motor, head))


def _stud_needed_mm(given: BevelKnown, entry: Entry) -> float:
    """Least length of the stud, mm: through both nuts at the start, and up to the sleeve with the terminal drawn in."""
    fixed = entry["swage_length_mm"] + entry["lug_thickness_mm"] + 2 * entry["nut_height_mm"]
    needed = max(take_up_mm(given), take_up_with_mm(given, entry))
    return float(fixed + TAKE_UP_SPARE * needed + END_ROOM_MM + THREAD_OUT_PITCHES * entry["pitch_mm"])


def _led(play_mm: float) -> float:
    """Margin of a spring's play round its stud."""
    return min(play_mm - LEAST_PLAY_MM, MOST_PLAY_MM - play_mm)


@rule("drum.tensioner", "the shortest that holds the largest tension and fits the rope", "stud_stress")
def tensioner(given: BevelKnown) -> Found:
    tension, d, ends = _tension_N(given), given.d_mm, given.termination
    bore = None if given.spring is None else float(given.spring["inside_mm"])
    steels = given.entries("materials")

    def margins(entry: Entry) -> Margins:
        strength = steels[entry["material"]]["yield_MPa"] * entry["stress_area_mm2"]
        return {
            "stud_stress": strength / (STUD_SAFETY * STUD_SPARE * tension) - 1.0,
            "sleeve_fits": min(
                entry["swage_diameter_mm"] / (ends.sleeve_ratio * d) - 1.0,
                (entry["swage_length_mm"] - SWAGE_FLOOR_MM) / (ends.grip_ratio * d) - 1.0,
            ),
            "take_up": entry["stud_length_mm"] / _stud_needed_mm(given, entry) - 1.0,
            **({} if bore is None else {"spring_fits": _led(bore - entry["thread_mm"])}),
        }

    return ordered(given.entries("tensioners"), "stud_length_mm", margins)


def _smallest_input_mm(given: BevelKnown) -> float:
    if given.has("transmission.drum_radii_mm") and given.has("transmission.ratios.input_to_guide"):
        return min(given.input_mm)
    return given.first_drum_mm / given.total_ratio


def _journal_margin(given: BevelKnown) -> Callable[[Entry], float]:
    """Margin of the smallest input pulley's neck inside its stop's bend, by the bearing that its journal carries."""
    smallest = _smallest_input_mm(given)
    neck = neck_mm(given.d_mm, given.termination, given.wall_mm("input_pulleys"), smallest)
    return lambda bearing: (neck - SHOULDER_MM - bearing["bore_mm"] / 2) / smallest


@rule(
    "input_pulleys.lower_bearing",
    "the lightest that fits journal and gearhead's shaft, carries the cables' load and leaves access to the "
    "gearhead's screws",
    "bore_wall",
)
def lower(given: BevelKnown) -> Found:
    head = given.entry("gearheads", "drive.gearhead")
    wall, screw = given.wall_mm("input_pulleys"), given.screw(head["screw"])
    key = screw.key_mm / sqrt(3.0) + 0.15
    circle = head["bolt_circle_mm"] / 2
    preload, journal = given["rope.preload_N"], _journal_margin(given)

    def margins(load_factor: float, bearing: Entry) -> Margins:
        seat = bearing["outer_diameter_mm"] / 2
        return {
            "bore_wall": (bearing["bore_mm"] - head["shaft_diameter_mm"]) / (2 * wall) - 1.0,
            "key_access": max(seat - circle - key, circle - key - seat - HOLE_WEB_MM) / seat,
            "bearing_shoulders": journal(bearing),
            "input_bearings": bearing["static_rating_N"] / (load_factor * preload) - 1.0,
        }

    return careful(INPUT_PRELOADS, lambda factor: lightest(given, "bearings", partial(margins, factor)))


def _upper_margins(given: BevelKnown, load_factor: float) -> Callable[[Entry, Entry], Margins]:
    screws, journal = given.entries("screws"), _journal_margin(given)
    load = load_factor * given["rope.preload_N"]
    wall = given.wall_mm("support")
    thickest = max(DOWEL_LENGTHS_MM) - DOWEL_MM - wall
    # With motors above, encoder and bearing are in the shelf that also holds the guide's axle.
    above, axle = given.motors_above, given.screw(AXLE_SCREW).thread_mm + 2 * wall

    def margins(bearing: Entry, encoder: Entry) -> Margins:
        screw = screws[encoder["screw"]]
        head = screw["head_diameter_mm"] / 2 + 0.1
        plate = rounded_up(bearing["width_mm"] + wall + PLATE_SPARE_MM, 0.1)
        if above:
            plate = max(plate, axle)
        web = (encoder["bolt_circle_mm"] - bearing["outer_diameter_mm"]) / 2 - head
        return {
            "encoder_fit": -abs(encoder["bore_mm"] - bearing["bore_mm"]) + FIT_MM,
            "hole_webs": web / HOLE_WEB_MM - 1.0,
            "top_plate": 1.0 - bearing["width_mm"] / thickest,
            "engagement": screw["length_mm"] - (plate - screw["head_height_mm"] - 0.2) - screw["thread_mm"],
            "bearing_shoulders": journal(bearing),
            "input_bearings": bearing["static_rating_N"] / load - 1.0,
        }

    return margins


@rule("input_pulleys.upper_bearing", "the lightest that fits an encoder and carries the cables' load", "input_bearings")
def upper(given: BevelKnown) -> Found:
    partner = ("encoders", "drive.encoder")
    return careful(
        INPUT_PRELOADS, lambda factor: with_partner(given, "bearings", partner, _upper_margins(given, factor))
    )


@rule("drive.encoder", "the lightest that fits the upper journal", "encoder_fit")
def _encoder(given: BevelKnown) -> Found:
    bearing = given.entry("bearings", "input_pulleys.upper_bearing")
    margins = _upper_margins(given, INPUT_PRELOADS[-1])
    return lightest(given, "encoders", lambda entry: margins(bearing, entry))


@rule(
    "input_pulleys.collar_screw",
    "the smallest whose clamp holds the input's torque on the gearhead's shaft",
    "collar_grip",
)
def collar_screw(given: BevelKnown) -> Found:
    """The smallest screw whose clamp holds the input's torque on the gearhead's shaft."""
    needed = _input_torque_Nm(given) * 1e3
    journal = given.entry("bearings", "input_pulleys.lower_bearing")["bore_mm"]
    wall, shaft = given.wall_mm("support"), given.gearhead.shaft_diameter_mm
    for name in COLLAR_SCREWS:
        if (
            grip_Nmm(collar(given, journal, wall, name, 0.0), given.screw(name), shaft)
            >= GRIP_SPARE * CLAMP_SAFETY * needed
        ):
            return Found(name, "collar_grip", "next screw of the catalogue")
    return Found(COLLAR_SCREWS[-1], "collar_grip", "the largest screw")


def _payload_margins(given: BevelKnown, bearing: Entry, load_N: float) -> Margins:
    """Drum's bearing and shaft under the payload too, the bearings as near to each other as they may be."""
    payload, bore = given.payload, bearing["bore_mm"]
    apart, before = 2.0 * bearing["width_mm"] + SPRING_HEIGHT_MM, FACE_BORES * bore
    bent_Nmm = payload.across_N * before + payload.tilt_Nm * 1e3
    bears_MPa = given.entry("materials", "drum.shaft_material")["yield_MPa"] / STRESS_SAFETY
    margins = {"drum_bearings": bearing["static_rating_N"] / (load_N + payload.across_N + bent_Nmm / apart) - 1.0}
    if payload != NO_PAYLOAD:
        # With half its diameter as its bore.
        margins["shaft_stress"] = bears_MPa * pi / 32.0 * bore**3 * (1.0 - 0.5**4) / (SHAFT_SPARE * bent_Nmm) - 1.0
    return margins


def _drum_margins(given: BevelKnown, load_factor: float) -> Callable[[Entry, Entry], Margins]:
    screws, load = given.entries("screws"), load_factor * _tension_N(given)
    shaft = given.first_drum_mm / (SMALL_DRUM_SHAFTS if _is_small(given) else DRUM_SHAFTS)

    def margins(bearing: Entry, ring: Entry) -> Margins:
        thread = screws[ring["screw"]]["thread_mm"] / 2
        seat = bearing["outer_diameter_mm"] / 2
        return {
            "encoder_fit": -abs(ring["bore_mm"] - bearing["bore_mm"]) + FIT_MM,
            "encoder_screws": (ring["bolt_circle_mm"] / 2 - thread - seat) / HOLE_WEB_MM - 1.0,
            "drum_sweep": bearing["bore_mm"] / shaft - 1.0,
            **_payload_margins(given, bearing, load),
        }

    return margins


def _is_small(given: BevelKnown) -> bool:
    """Whether boss and hub of the drum use space that the stop slot and the motor shelf need."""
    pull_N = given["loads.peak_torque_Nm"] * 1e3 / given.first_drum_mm
    return bool(given.first_drum_mm < SMALL_DRUM_MM) and bool(pull_N > HARD_PULL_N)


def _by_boss(bearing: Entry, ring: Entry) -> float:
    """The boss ends round the screws of the drum's encoder."""
    return float(ring["bolt_circle_mm"])


@rule(
    "drum.bearing",
    "the lightest with a bore for the drum's shaft and an encoder that carries the cables' load; in a small drum "
    "that pulls hard the one with the smallest boss",
    "drum_bearings",
)
def drum_bearing(given: BevelKnown) -> Found:
    partner, order = ("encoders", "drive.drum_encoder"), _by_boss if _is_small(given) else by_mass
    return careful(
        DRUM_TENSIONS, lambda factor: with_partner(given, "bearings", partner, _drum_margins(given, factor), order)
    )


@rule("drive.drum_encoder", "the lightest that fits the drum's shaft", "encoder_fit")
def drum_encoder(given: BevelKnown) -> Found:
    bearing, margins = given.entry("bearings", "drum.bearing"), _drum_margins(given, DRUM_TENSIONS[-1])
    by = "bolt_circle_mm" if _is_small(given) else "mass_g"
    return ordered(given.entries("encoders"), by, lambda entry: margins(bearing, entry))


@rule("guide.bearing", "the lightest that fits into the guide and carries the cables' load", "guide_bearings")
def guide_bearing(given: BevelKnown) -> Found:
    tension = GUIDE_TENSIONS * _tension_N(given)
    room = None
    if given.has("transmission.drum_radii_mm") and given.has("transmission.ratios.guide_to_drum"):
        room = 2 * (given.guide_mm[0] - given.d_mm / 2 - given.wall_mm("guide"))

    def margins(bearing: Entry) -> Margins:
        found = {"guide_bearings": bearing["static_rating_N"] / tension - 1.0}
        # The axle bends under the bearings' load with a lever of about their bore.
        strength = given.entry("materials", "guide.axle_material")["yield_MPa"] / STRESS_SAFETY
        found["axle_stress"] = 0.1 * bearing["bore_mm"] ** 2 * strength / tension - 1.0
        if room is not None:
            found["guide_wall"] = room / bearing["outer_diameter_mm"] - 1.0
        return found

    return lightest(given, "bearings", margins)


DRIVES = (_motor, _gearhead)
PARTS = (lower, upper, collar_screw, _encoder, drum_bearing, drum_encoder, guide_bearing)
