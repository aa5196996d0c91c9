"""Rules of dimensions: frame and drum; each value is the smallest with which its checks pass."""

from __future__ import annotations

from mbcdm_cad.layouts.head_dims import (
    BEARING_SHELF,
    COUPLING_SPACE,
    ENCODER_SHELF,
    HUB,
    HUB_FACE,
    MOTOR_SHELF,
    RIM,
    SECTOR,
    SHAFT_BORE,
    STOP_PIN,
    WEB,
    either,
    side_wall,
    stiff_wall,
)
from mbcdm_cad.layouts.siso_spur.drive import MOUNT_BOLTS
from mbcdm_cad.layouts.siso_spur.sizing.known import SpurKnown
from mbcdm_cad.sizing.rule import Found, Rule

# Walls of a milled part and of a printed one, mm (estimate: the modulus of filament is about twenty times smaller).
PLATE_MM, BRIDGE_MM = (5.0, 8.0), (4.0, 7.0)


def _plate(given: SpurKnown) -> Found:
    return stiff_wall(given, "support.plate_mm", either(given, "support", PLATE_MM), 0.1, ("plate",), ("flange",))


def _bridge(given: SpurKnown) -> Found:
    start = max(either(given, "support", BRIDGE_MM), given.wall_mm("support"))
    return stiff_wall(given, "support.bridge_mm", start, 0.5, ("bridge",))


def _centre_distance(given: SpurKnown) -> Found:
    start = given["transmission.drum_radius_mm"] + given.input_mm + 2 * given.d_mm
    if given.has("idlers.places"):
        far = max(place["z_mm"] for place in given["idlers.places"])
        start = max(start, far + 2 * (given.input_mm + given["idlers.radius_mm"]))
    checks = (
        "free_span",
        "drum_and_input",
        "land_spacing",
        "cables_apart",
        "input_room",
        "walls",
        "mounts",
        "bodies_behind",
    )
    return given.moved("transmission.centre_distance_mm", start, 0.5, checks)


def _mount_screw(given: SpurKnown) -> Found:
    return given.first("support.mount_screw", MOUNT_BOLTS, ("mounting_screws", "mounts"))


def _back(given: SpurKnown) -> Found:
    return given.moved("support.back_y_mm", -10.0, -0.5, ("drum_bearing_spacing", "boss"))


def _outer_face(given: SpurKnown) -> Found:
    checks = ("rim_width", "outer_face", "terminals_apart", "lands_intact", "lug_stress", "web_in_rim")
    return given.moved("drum.outer_face_y_mm", 2.0, 0.1, checks)


FRAME = (
    MOTOR_SHELF,
    Rule(
        "support.side_wall_mm",
        "usual thickness for the stiffness and for making it in its material",
        "walls",
        side_wall,
    ),
    Rule(
        "support.bridge_mm",
        "usual thickness for making it in its material, more where the frame winds up",
        "frame_windup",
        _bridge,
    ),
    BEARING_SHELF,
    ENCODER_SHELF,
    COUPLING_SPACE,
    Rule(
        "support.plate_mm",
        "usual thickness, or more for the motor head's screws and where the frame winds up",
        "flange",
        _plate,
    ),
)
DISTANCE = (
    Rule(
        "transmission.centre_distance_mm",
        "the shortest that span, bearings, screws and motor allow",
        "input_room",
        _centre_distance,
    ),
)
MOUNT = (
    Rule(
        "support.mount_screw",
        "the thinnest that holds the peak torque by friction",
        "mounting_screws",
        _mount_screw,
    ),
)
DRUM = (
    WEB,
    SHAFT_BORE,
    HUB,
    SECTOR,
    STOP_PIN,
    RIM,
    Rule("drum.outer_face_y_mm", "least width for cable and terminals", "outer_face", _outer_face),
    HUB_FACE,
)
BACK = (
    Rule(
        "support.back_y_mm",
        "nearest plane with enough distance between the drum's bearings",
        "drum_bearing_spacing",
        _back,
    ),
)
