"""Rules of dimensions: frame and drum, each as small as the checks that it serves allow."""

from __future__ import annotations

from mbcdm_cad.configurations.siso_spur.sizing.known import SpurKnown
from mbcdm_cad.sizing.rule import Found, Rule, rounded_up

# Walls of a milled part and of a printed one, mm (estimate: filament is some twenty times as soft).
PLATE_MM, BRIDGE_MM, SIDE_MM, WEB_MM = (5.0, 8.0), (4.0, 7.0), (4.0, 6.0), (2.0, 4.0)
# Engaged thread of a face's screws, in diameters.
ENGAGED = 1.25
# Beyond the travel, before the wraps' own limits are known.
SECTOR_SPARE_DEG = 15.0
# Bore of the drum's shaft over its bearings'.
SHAFT_BORE_SHARE = 0.5


def _either(given: SpurKnown, part: str, values: tuple[float, float]) -> float:
    return values[1] if given.printed(part) else values[0]


def _motor_shelf(given: SpurKnown) -> Found:
    """What the screws leave beyond the thread that they need; no thinner than wall and pilot ask for."""
    gear = given.gearhead
    screw = given.screw(gear.screw)
    needs = {
        "walls": given.wall_mm("support"),
        "engagement": screw.length_mm - ENGAGED * screw.thread_mm - 0.75 * screw.thread_mm,
        "pilot_room": gear.pilot_height_mm + 0.5,
    }
    driver = max(needs, key=lambda name: needs[name])
    return Found(rounded_up(min(needs[driver], screw.length_mm - screw.thread_mm), 0.1), driver, "up to 0.1")


def _bearing_shelf(given: SpurKnown) -> Found:
    width = given.entry("bearings", "input_pulleys.lower_bearing")["width_mm"]
    start = max(width + given.wall_mm("support"), 3.0)
    return given.moved("support.bearing_shelf_mm", start, 0.1, ("bearing_seats", "walls"))


def _encoder_shelf(given: SpurKnown) -> Found:
    width = given.entry("bearings", "input_pulleys.upper_bearing")["width_mm"]
    start = max(width + given.wall_mm("support"), 3.0)
    return given.moved("support.encoder_shelf_mm", start, 0.1, ("encoder_shelf",))


def _coupling_space(given: SpurKnown) -> Found:
    return given.moved("support.coupling_space_mm", 5.0, 0.1, ("coupling_height", "collar_space"))


def _plate(given: SpurKnown) -> Found:
    return given.moved("support.plate_mm", _either(given, "support", PLATE_MM), 0.1, ("flange",))


def _side_wall(given: SpurKnown) -> float:
    return max(_either(given, "support", SIDE_MM), 2 * given.wall_mm("support"))


def _bridge(given: SpurKnown) -> float:
    return max(_either(given, "support", BRIDGE_MM), given.wall_mm("support"))


def _centre_distance(given: SpurKnown) -> Found:
    start = given["transmission.drum_radius_mm"] + given.input_mm + 2 * given.d_mm
    checks = ("free_span", "drum_and_input", "land_spacing", "input_room", "walls", "mounts", "bodies_behind")
    return given.moved("transmission.centre_distance_mm", start, 0.5, checks)


def _back(given: SpurKnown) -> Found:
    return given.moved("support.back_y_mm", -10.0, -0.5, ("drum_bearing_spacing", "boss"))


def _shaft_bore(given: SpurKnown) -> Found:
    bore = given.entry("bearings", "drum.bearing")["bore_mm"]
    return given.moved("drum.shaft_bore_mm", SHAFT_BORE_SHARE * bore, -0.5, ("shaft_wall", "shaft_twist"))


def _web(given: SpurKnown) -> float:
    return _either(given, "drum", WEB_MM)


def _hub(given: SpurKnown) -> Found:
    start = given.entry("bearings", "drum.bearing")["bore_mm"] + 4.0
    return given.moved("drum.hub_diameter_mm", start, 0.5, ("hub_walls", "hub_spigot", "hub_set_screws", "engagement"))


def _rim(given: SpurKnown) -> Found:
    start = given["transmission.drum_radius_mm"] - 2 * given.d_mm
    return given.moved("drum.rim_inner_radius_mm", start, -0.5, ("rim_height", "pocket_corners"))


def _outer_face(given: SpurKnown) -> Found:
    checks = ("rim_width", "outer_face", "terminals_apart", "lands_intact", "lug_stress", "web_in_rim")
    return given.moved("drum.outer_face_y_mm", 2.0, 0.1, checks)


def _hub_face(given: SpurKnown) -> Found:
    return given.moved("drum.hub_face_y_mm", given["drum.outer_face_y_mm"], 0.1, ("hub_length",))


def _sector(given: SpurKnown) -> Found:
    start = min(given["travel.half_angle_deg"] + SECTOR_SPARE_DEG, 174.0)
    return given.moved("drum.sector_half_angle_deg", start, 1.0, ("wrap_left", "terminal_clears_input", "stop_slot"))


def _stop_pin(given: SpurKnown) -> Found:
    return given.first("drum.stop_pin_mm", (3.0, 4.0, 5.0, 6.0, 8.0, 10.0), ("stop_pin",))


FRAME = (
    Rule("support.motor_shelf_mm", "as thick as the face's screws leave it", "engagement", _motor_shelf),
    Rule("support.side_wall_mm", "stiff, and wide enough for its material", "walls", _side_wall),
    Rule("support.bridge_mm", "stiff, and thick enough for its material", "walls", _bridge),
    Rule("support.bearing_shelf_mm", "the bearing next to the motor and a shoulder", "bearing_seats", _bearing_shelf),
    Rule("support.encoder_shelf_mm", "bearing, shoulder and sunk screw heads", "encoder_shelf", _encoder_shelf),
    Rule(
        "support.coupling_space_mm",
        "room for the collar on its way in, for the face's screws and their key",
        "coupling_height",
        _coupling_space,
    ),
    Rule("support.plate_mm", "stiff, and thick enough for the motor head's screws", "flange", _plate),
)
DISTANCE = (
    Rule(
        "transmission.centre_distance_mm",
        "as short as span, bearings, screws and motor allow",
        "input_room",
        _centre_distance,
    ),
)
DRUM = (
    Rule("drum.web_thickness_mm", "stiff enough for its material", "web_in_rim", _web),
    Rule("drum.shaft_bore_mm", "half the bearings' bore, as far as the wall allows", "shaft_wall", _shaft_bore),
    Rule("drum.hub_diameter_mm", "walls round shaft, set screws and payload threads", "hub_walls", _hub),
    Rule("drum.sector_half_angle_deg", "the travel and the wrap that must stay", "wrap_left", _sector),
    Rule("drum.stop_pin_mm", "the thinnest pin that holds the stalled motor", "stop_pin", _stop_pin),
    Rule("drum.rim_inner_radius_mm", "as thin a rim as the terminals' pockets allow", "rim_height", _rim),
    Rule("drum.outer_face_y_mm", "as narrow as cable and terminals allow", "outer_face", _outer_face),
    Rule("drum.hub_face_y_mm", "set screws and payload threads before the web", "hub_length", _hub_face),
)
BACK = (Rule("support.back_y_mm", "the drum's bearings stand apart", "drum_bearing_spacing", _back),)
