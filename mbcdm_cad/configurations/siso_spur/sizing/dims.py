"""Rules of dimensions: frame and drum, each as small as the checks that it serves allow."""

from __future__ import annotations

from mbcdm_cad.configurations.head_dims import (
    bearing_shelf,
    coupling_space,
    either,
    encoder_shelf,
    hub,
    hub_face,
    motor_shelf,
    rim,
    shaft_bore,
    side_wall,
    stop_pin,
    web,
)
from mbcdm_cad.configurations.siso_spur.sizing.known import SpurKnown
from mbcdm_cad.sizing.rule import Found, Rule

# Walls of a milled part and of a printed one, mm (estimate: filament is some twenty times as soft).
PLATE_MM, BRIDGE_MM = (5.0, 8.0), (4.0, 7.0)
# Beyond the travel, before the wraps' own limits are known.
SECTOR_SPARE_DEG = 15.0


def _plate(given: SpurKnown) -> Found:
    return given.moved("support.plate_mm", either(given, "support", PLATE_MM), 0.1, ("flange",))


def _bridge(given: SpurKnown) -> float:
    return max(either(given, "support", BRIDGE_MM), given.wall_mm("support"))


def _centre_distance(given: SpurKnown) -> Found:
    start = given["transmission.drum_radius_mm"] + given.input_mm + 2 * given.d_mm
    checks = ("free_span", "drum_and_input", "land_spacing", "input_room", "walls", "mounts", "bodies_behind")
    return given.moved("transmission.centre_distance_mm", start, 0.5, checks)


def _back(given: SpurKnown) -> Found:
    return given.moved("support.back_y_mm", -10.0, -0.5, ("drum_bearing_spacing", "boss"))


def _outer_face(given: SpurKnown) -> Found:
    checks = ("rim_width", "outer_face", "terminals_apart", "lands_intact", "lug_stress", "web_in_rim")
    return given.moved("drum.outer_face_y_mm", 2.0, 0.1, checks)


def _sector(given: SpurKnown) -> Found:
    start = min(given["travel.half_angle_deg"] + SECTOR_SPARE_DEG, 174.0)
    return given.moved("drum.sector_half_angle_deg", start, 1.0, ("wrap_left", "terminal_clears_input", "stop_slot"))


FRAME = (
    Rule("support.motor_shelf_mm", "as thick as the face's screws leave it", "engagement", motor_shelf),
    Rule("support.side_wall_mm", "stiff, and wide enough for its material", "walls", side_wall),
    Rule("support.bridge_mm", "stiff, and thick enough for its material", "walls", _bridge),
    Rule("support.bearing_shelf_mm", "the bearing next to the motor and a shoulder", "bearing_seats", bearing_shelf),
    Rule("support.encoder_shelf_mm", "bearing, shoulder and sunk screw heads", "encoder_shelf", encoder_shelf),
    Rule(
        "support.coupling_space_mm",
        "room for the collar on its way in, for the face's screws and their key",
        "coupling_height",
        coupling_space,
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
    Rule("drum.web_thickness_mm", "stiff enough for its material", "web_in_rim", web),
    Rule("drum.shaft_bore_mm", "half the bearings' bore, as far as the wall allows", "shaft_wall", shaft_bore),
    Rule("drum.hub_diameter_mm", "walls round shaft, set screws and payload threads", "hub_walls", hub),
    Rule("drum.sector_half_angle_deg", "the travel and the wrap that must stay", "wrap_left", _sector),
    Rule("drum.stop_pin_mm", "the thinnest pin that holds the stalled motor", "stop_pin", stop_pin),
    Rule("drum.rim_inner_radius_mm", "as thin a rim as the terminals' pockets allow", "rim_height", rim),
    Rule("drum.outer_face_y_mm", "as narrow as cable and terminals allow", "outer_face", _outer_face),
    Rule("drum.hub_face_y_mm", "set screws and payload threads before the web", "hub_length", hub_face),
)
BACK = (Rule("support.back_y_mm", "the drum's bearings stand apart", "drum_bearing_spacing", _back),)
