"""Rules of the drum sector, its hub and shaft."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress
from dataclasses import replace
from functools import partial
from math import asin, atan2, degrees, hypot, pi, sqrt

from mbcdm_cad.checks.comparison import Comparison
from mbcdm_cad.checks.drum_sector import HUB_DIAMETERS, RIM_WALLS, SPIGOT_MM
from mbcdm_cad.checks.fixings import STRESS_SAFETY, at_stop_Nm, lasting_MPa, stop_pin
from mbcdm_cad.checks.terminals import LUG_SAFETY, terminal_angles
from mbcdm_cad.checks.transfer import EDGE_BREAK_MM, LEAST_WRAP_DEG, wrap_left
from mbcdm_cad.design.blocks import NO_PAYLOAD
from mbcdm_cad.design.bought import Material
from mbcdm_cad.layouts.base import NoFigureError
from mbcdm_cad.layouts.bevel_transfer import terminals_clear
from mbcdm_cad.layouts.common_rules import STOP_PINS_MM
from mbcdm_cad.layouts.miso_bevel.layout import BevelLayout
from mbcdm_cad.layouts.miso_bevel.pulleys import STOP_PIN_WALL_MM
from mbcdm_cad.layouts.miso_bevel.sizing.known import LATER, BevelKnown
from mbcdm_cad.layouts.miso_bevel.sizing.radii import take_up_mm
from mbcdm_cad.layouts.structure import drum_structure_of
from mbcdm_cad.model.structure.drum_sector import least_hub_mm
from mbcdm_cad.parts.drum_sector.dims import (
    SCREWS,
    SET_SCREW_ANGLES_DEG,
    InsertOf,
    PayloadJoint,
    circle_radius_mm,
    joint_load,
    joints,
    lug_root_mm,
    payload_joint,
)
from mbcdm_cad.parts.drum_sector.sizes import (
    FLAT_PLAY_MM,
    HUB_SCREW,
    MIN_FLOOR_MM,
    SECTOR_MARGIN_DEG,
    SLOT_WALLS,
    STOP_SLOT_PLAY_MM,
    SWAGE_START_MM,
)
from mbcdm_cad.parts.fits import SHEAR_SHARE
from mbcdm_cad.sizing.rule import Found, Rule, largest, rounded_down, rounded_up, rule

# Height of the hub over its set screws, so that they never project.
SCREW_LIP_MM = 1.0
# Web in multiples of the thinnest wall, and as a share of the outermost radius, to be stiff enough (estimate).
WEB_WALLS, WEB_SHARE = 2.5, 1.0 / 27.0
# Diameter of the hub over the radius of step 1: hub and web beside it give most where the hub is narrow (a choice).
HUB_SHARE = 0.42
# Screws of the payload where four need too wide a hub; six would come nearer to the set screws than five or eight.
MORE_SCREWS = (5, 8)
# Bore of the shaft over its diameter, and the wall round it that remains.
BORE_SHARE, BORE_WALL_MM = 0.7, 1.25
# Stress of the web beside the hub over that of even shear over half a turn there (estimate; a check computes it).
WEB_STRESS = 1.6
# Web of plastic over what a trial asks, with the first of these stop pins that holds; the pin's own rule comes later.
WEB_SPARE, PLASTIC_STOP_PINS_MM = 1.1, tuple(size for size in STOP_PINS_MM if size >= 5.0)
# Rim under the deepest pocket as a share of the radius of step 1 (estimate; the limit of the check is lower).
RIM_SHARE = 0.08
# Wrap left at the end of travel over the limit of its check: reserve for the slip zone at small loads (estimate).
WRAP_SPARE_DEG = 6.0
# Reserve of the gap between terminal and guide over the running clearance.
GUIDE_SPARE_MM = 0.3
THINNEST_STOP_PIN_MM = STOP_PINS_MM[0]
WIDEST_DEG = 170.0
# Strength of the lug over the limit of its check.
LUG_SPARE = 1.1


def _load_Nm(given: BevelKnown) -> float:
    """Peak torque, or that of both motors stalled at the stop."""
    input_Nm = given.entry("motors", "drive.motor")["rated_torque_mNm"] * 1e-3 * given.gearhead.ratio
    return at_stop_Nm(float(given["loads.peak_torque_Nm"]), float(input_Nm), given.total_ratio, 2)


@rule(
    "drum.web_thickness_mm",
    "a multiple of the least wall of the material, larger for a larger drum and for a larger torque",
    "web_in_rim",
)
def web(given: BevelKnown) -> Found:
    bears_MPa, load_Nmm = lasting_MPa(_material(given)) / STRESS_SAFETY, 1e3 * _load_Nm(given)
    stop = given.shelf_bottom_mm + STOP_PIN_WALL_MM
    needs = {
        "web_in_rim": WEB_WALLS * given.wall_mm("drum"),
        "stiffness": WEB_SHARE * max(given.drum_mm),
        "drum_stress": WEB_STRESS * sqrt(3.0) * load_Nmm / (pi * (given["drum.hub_diameter_mm"] / 2) ** 2 * bears_MPa),
        "stop pin": load_Nmm / (stop * THINNEST_STOP_PIN_MM * bears_MPa),
    }
    found = largest(needs, 0.1)
    return _stressed_web(given, found, load_Nmm * 1e-3, bears_MPa) if _material(given).printed else found


def _stressed_web(given: BevelKnown, usual: Found, load_Nm: float, bears_MPa: float) -> Found:
    """The web, thicker where the stress beside the stop's slot asks for it; stress falls as the thickness grows."""
    found = usual
    with suppress(NoFigureError, ValueError):
        # A thicker web lies elsewhere between the cables, which bend it: its stress is computed once more.
        for _ in range(2):
            face_mm = _face_over_web(given, found.value).value
            places = {
                "drum__rim_inner_radius_mm": _rim_inner(given).value,
                "drum__sector_half_angle_deg": _sector(given).value,
                "drum__outer_face_y_mm": face_mm,
                # The hub is at least so long; a longer one has a longer root, which bears more.
                "drum__hub_face_y_mm": face_mm,
                "drum__web_thickness_mm": found.value,
            }
            for pin_mm in PLASTIC_STOP_PINS_MM:
                trial = BevelLayout(given.trial(**{**LATER, **places, "drum__stop_pin_mm": pin_mm}))
                if stop_pin(trial).holds:
                    break
            stress = drum_structure_of(trial).stress_MPa(load_Nm)
            needed = rounded_up(WEB_SPARE * found.value * stress / bears_MPa, 0.1)
            if needed <= found.value:
                break
            found = Found(needed, "drum_stress", "up to 0.1")
    return found


def _web_start(given: BevelKnown) -> float:
    return float(given.drum_inner_mm + 3 * given["clearances.running_mm"])


def _floor_under_pockets(given: BevelKnown) -> float:
    """Least outer face, mm, with which no pocket below an outer cable goes through the whole rim."""
    guide, drum = given.guide_mm, given.drum_mm
    floor = given.nut_mm + given["clearances.running_mm"] + MIN_FLOOR_MM
    reach = given.nut_pocket_mm + given.d_mm / 2 + MIN_FLOOR_MM
    tip = given.entry("tensioners", "drum.tensioner")["stud_length_mm"] + given.spring_free_mm + take_up_mm(given) + 1.5
    # Steps 1 and 4 run to one side, 2 and 3 to the other; those too close are staggered instead.
    passed = [guide[k] for k, other in ((0, 3), (1, 2)) if drum[other] - drum[k] > reach + tip**2 / (2 * drum[k])]
    return float(max(passed, default=0.0) + floor)


@rule("drum.outer_face_y_mm", "least distance that covers the last cable's flank, the nuts and the lugs", "outer_face")
def outer_face(given: BevelKnown) -> Found:
    return _face_over_web(given, given["drum.web_thickness_mm"])


def _face_over_web(given: BevelKnown, web_mm: float) -> Found:
    spec = given.entry("tensioners", "drum.tensioner")
    strength = given.entry("materials", "drum.material")["yield_MPa"]
    last = max(given.guide_mm)
    hole = spec["clearance_mm"] / 2
    lug_end = terminal_mm(given)[0] - given.spring_free_mm - 2 * spec["nut_height_mm"]
    outer, flat = max(given.drum_mm), spec["swage_flats_mm"] / 2 + FLAT_PLAY_MM
    root = lug_root_mm(flat, outer - given.d_mm / 2, outer, lug_end)
    lug = LUG_SPARE * LUG_SAFETY * 6 * given.highest_tension_N * root / (strength * spec["lug_thickness_mm"] ** 2)
    needs = {
        "outermost_land": last + given.d_mm / 2 + EDGE_BREAK_MM,
        "outer_face": last + max(given.nut_mm, hole + given.wall_mm("drum")),
        "web_in_rim": _web_start(given) + web_mm,
        "lug_stress": last + hole + lug,
        "lands_intact": _floor_under_pockets(given),
    }
    return largest(needs, 0.5)


def _rim_inner(given: BevelKnown) -> Found:
    first, wall = min(given.drum_mm), given.wall_mm("drum")
    most = first - max(given.nut_pocket_mm, given.d_mm / 2) - RIM_WALLS * wall
    wanted = rounded_down(min(first - given.nut_pocket_mm - RIM_SHARE * first, most), 0.5)
    slot = given.shelf_bottom_mm + STOP_PIN_WALL_MM + _stop_slot_mm(given) + SLOT_WALLS * wall
    if slot <= wanted:
        return Found(wanted, "rim_height", "down to 0.5")
    return Found(min(rounded_up(slot, 0.1), rounded_down(most, 0.1)), "stop_slot", "up to 0.1")


def _stop_slot_mm(given: BevelKnown) -> float:
    """Distance from the inner side of the stop pin to the outer edge of its slot, mm: the pin and half its play."""
    return float(given.get("drum.stop_pin_mm", THINNEST_STOP_PIN_MM)) + STOP_SLOT_PLAY_MM / 2


def _shaft_radius(given: BevelKnown) -> float:
    return float(given.entry("bearings", "drum.bearing")["bore_mm"] / 2)


def _insert_of(given: BevelKnown) -> InsertOf:
    return lambda thread_mm: given.insert("drum", thread_mm)


def _material(given: BevelKnown) -> Material:
    return Material(name=given["drum.material"], **given.entry("materials", "drum.material"))


def _joints(given: BevelKnown) -> tuple[PayloadJoint, ...]:
    return joints(_material(given), _insert_of(given), given.get("drum.output_screws", SCREWS))


def _joint(given: BevelKnown) -> tuple[PayloadJoint, float]:
    """The payload's joint and the radius of its screws' circle, mm."""
    hub, shaft = given["drum.hub_diameter_mm"] / 2, _shaft_radius(given)
    circle = circle_radius_mm(given.get("drum.output_circle_mm"), hub, shaft)
    load = joint_load(given["loads.peak_torque_Nm"], given.payload)
    return payload_joint(_joints(given), load, circle, hub, shaft, given.wall_mm("drum")), circle


def _payload_hub_mm(given: BevelKnown, screws: int) -> float:
    """Least diameter of a hub whose payload is held by so many screws, mm."""
    load = joint_load(given["loads.peak_torque_Nm"], given.payload)
    shaft, wall = _shaft_radius(given), given.wall_mm("drum")
    return 2 * min(j.least_hub_mm(load, shaft, wall) for j in joints(_material(given), _insert_of(given), screws))


def _crowded(given: BevelKnown, screws: int = SCREWS) -> bool:
    """Whether the hub for so many screws leaves no wall inside the stop pin's slot; a stated hub is left alone."""
    if given.has("drum.hub_diameter_mm") or given.has("drum.output_circle_mm"):
        return False
    slot = given.shelf_bottom_mm + STOP_PIN_WALL_MM - STOP_SLOT_PLAY_MM / 2
    room = slot - SLOT_WALLS * given.wall_mm("drum")
    return rounded_up(_payload_hub_mm(given, screws), 0.5) > 2 * room


@rule(
    "drum.output_screws",
    "more than four, because the hub for four leaves no wall inside the stop pin's slot",
    "stop_slot",
    _crowded,
)
def output_screws(given: BevelKnown) -> Found:
    fewest = next((n for n in MORE_SCREWS if not _crowded(given, n)), MORE_SCREWS[-1])
    return Found(fewest, "stop_slot", f"the least of {', '.join(map(str, MORE_SCREWS))} that leaves the wall")


@rule(
    "drum.hub_diameter_mm",
    "least diameter for shaft, set screws, torsion and payload's screws, or a share of the radius, for stiffness",
    "hub_walls",
)
def hub_diameter(given: BevelKnown) -> Found:
    shaft = _shaft_radius(given)
    bears_MPa = lasting_MPa(_material(given)) * SHEAR_SHARE / STRESS_SAFETY
    spigot = given.entry("bearings", "drum.bearing")["inner_shoulder_mm"] / 2
    circle_mm = given.get("drum.output_circle_mm")
    payload = _payload_hub_mm(given, given.get("drum.output_screws", SCREWS))
    if circle_mm is not None:
        payload = circle_mm + min(joint.hole_mm for joint in _joints(given)) + 2 * given.wall_mm("drum")
    needs = {
        "hub_walls": 2 * (shaft + given.screw(HUB_SCREW).length_mm + SCREW_LIP_MM),
        "payload_screws": payload,
        "hub_spigot": 2 * (spigot + SPIGOT_MM),
        "stiffness": HUB_SHARE * given.first_drum_mm,
        "drum_stress": 2 * least_hub_mm(shaft, _load_Nm(given), bears_MPa),
    }
    return largest(needs, 0.5)


@rule(
    "drum.hub_face_y_mm",
    "least length for shaft, set screws and payload's threads; the front of the box if one is stated",
    "hub_length",
)
def hub_face(given: BevelKnown) -> Found:
    start = given.drum_inner_mm - 3 * given["clearances.running_mm"] + 0.5
    screw, wall = given.screw(HUB_SCREW).thread_mm, given.wall_mm("drum")
    end = _web_start(given) + given["drum.web_thickness_mm"]
    joint, circle = _joint(given)
    behind = joint.behind_mm(circle, SET_SCREW_ANGLES_DEG, screw, wall)
    needs = {
        "hub_length": start + HUB_DIAMETERS * 2 * _shaft_radius(given),
        "payload's threads": end + joint.depth_mm,
        "set screws": end + screw + 2 * wall,
        "set screws behind the payload's holes": end + wall + screw / 2 + behind,
        "outer_face": given["drum.outer_face_y_mm"],
    }
    box = given.get("targets.envelope_mm")
    if box is not None:
        needs["targets.envelope_mm"] = box[2] + given["support.back_y_mm"]
    return largest(needs, 0.1)


@rule(
    "drum.shaft_bore_mm",
    "0.7 of the shaft's diameter, or less for its wall; half of it under a payload: lighter, and bends little",
    "shaft_wall",
)
def shaft_bore(given: BevelKnown) -> float:
    across = 2 * _shaft_radius(given)
    if given.payload != NO_PAYLOAD:
        return across / 2
    return max(rounded_down(min(BORE_SHARE * across, across - 2 * BORE_WALL_MM), 0.5), across / 2)


def terminal_mm(given: BevelKnown) -> tuple[float, float]:
    """(end of the nuts, tip) of a terminal drawn in completely, mm from the point where its cable leaves the land."""
    spec = given.entry("tensioners", "drum.tensioner")
    travel = take_up_mm(given)
    lug_end = SWAGE_START_MM + spec["swage_length_mm"] + travel + 0.5 + spec["lug_thickness_mm"]
    stack = given.spring_free_mm
    return lug_end + stack + 2 * spec["nut_height_mm"], SWAGE_START_MM + spec["stud_length_mm"] + stack + travel


def _wrap_clear_of_guide_deg(given: BevelKnown) -> float:
    """Least remaining wrap at which a terminal clears the guide, deg: across sin w + along cos w = reach."""
    reach = max(given.guide_mm) + given.d_mm / 2 + given["clearances.running_mm"] + GUIDE_SPARE_MM
    across = given.drum_mm[0] - given.nut_pocket_mm
    return degrees(asin(min(reach / hypot(across, SWAGE_START_MM), 1.0)) - atan2(SWAGE_START_MM, across))


def _sector(given: BevelKnown) -> Found:
    """Half angle of the sector, deg: for the travel, the terminals behind the anchors, and staggered neighbours."""
    box = given.get("targets.envelope_mm")
    outer = max(given.drum_mm) - given.d_mm / 2
    nuts_end, tip = terminal_mm(given)
    nuts = 2 * given.entry("tensioners", "drum.tensioner")["nut_height_mm"]
    lug_end = nuts_end - given.spring_free_mm - nuts
    clear = _wrap_clear_of_guide_deg(given)
    wrap = max(LEAST_WRAP_DEG + WRAP_SPARE_DEG, clear)
    driver = "terminal_clears_guide" if clear >= wrap else "wrap_left"
    half = float(given["travel.half_angle_deg"])
    radii = sorted(given.drum_mm)
    # The inner of two neighbours on one side is further out by the outer one's lug.
    staggered = half + wrap + 0.3 + degrees(atan2(lug_end, radii[2])) + degrees(atan2(tip, radii[1]))
    single = half + wrap + degrees(atan2(tip, radii[0]))
    slot = half + float(given["travel.stop_clearance_deg"])
    stop = degrees(
        (
            (float(given.get("drum.stop_pin_mm", THINNEST_STOP_PIN_MM)) + STOP_SLOT_PLAY_MM) / 2
            + SLOT_WALLS * given.wall_mm("drum")
        )
        / (0.25 * radii[0])
    )
    needs = {driver: max(staggered, single) + SECTOR_MARGIN_DEG, "stop_slot": slot + stop}
    stated = [float(c["terminal_angle_deg"]) for c in given["cables"] if c.get("terminal_angle_deg") is not None]
    if stated:
        needs["terminal_angles"] = max(stated) + degrees(atan2(tip, radii[0])) + SECTOR_MARGIN_DEG
    if box is not None and box[0] < 2 * outer:
        # A sector wider than the target box would exceed it: the box takes precedence, and the checks show the effect.
        return Found(round(degrees(asin(box[0] / 2 / outer)), 1), "targets.envelope_mm", "to 0.1")
    driver = max(needs, key=lambda name: needs[name])
    angle = min(rounded_up(needs[driver], 0.5), WIDEST_DEG)
    if not _holds(given, angle, wrap_left, partial(terminals_clear, "guide")):
        # The outermost two terminals of a side are staggered too.
        angle = min(angle + rounded_up(degrees(atan2(tip, radii[0])), 0.5), WIDEST_DEG)
    while stated and angle < WIDEST_DEG and not _holds(given, angle, terminal_angles):
        driver, angle = "terminal_angles", angle + 0.5
    return Found(angle, driver, "up to 0.5")


def _holds(given: BevelKnown, angle_deg: float, *checks: Callable[[BevelLayout], Comparison]) -> bool:
    """Whether these checks hold with a sector of this half angle, or have no figure there."""
    try:
        trial = BevelLayout(given.trial(**{**LATER, "drum__sector_half_angle_deg": angle_deg}))
        return all(check(trial).holds for check in checks)
    except NoFigureError:
        return True


def _windows_cost(given: BevelKnown) -> bool:
    """Whether a thin stop pin leaves windows beside which a web of plastic, judged without them, bears too little."""
    if not _material(given).printed or given["drum.stop_pin_mm"] >= PLASTIC_STOP_PINS_MM[0]:
        return False
    with suppress(NoFigureError, ValueError):
        drive = given.trial()
        judged = replace(drive, drum=replace(drive.drum, stop_pin_mm=PLASTIC_STOP_PINS_MM[0]))
        layout = BevelLayout(drive)
        if layout.drum.windows and not BevelLayout(judged).drum.windows:
            return drum_structure_of(layout).stress_MPa(_load_Nm(given)) > lasting_MPa(_material(given)) / STRESS_SAFETY
    return False


HUB = (
    # Where it does not apply, the schema's own value stays.
    output_screws,
    hub_diameter,
)
WEB = (web, outer_face)
# The stop pin of the drum is in a slot between hub and rim.
DRUM = (
    Rule("drum.rim_inner_radius_mm", "least height of the rim under the deepest pocket", "rim_height", _rim_inner),
    shaft_bore,
    Rule(
        "drum.sector_half_angle_deg",
        "least angle for the travel, the wrap left and the terminals; larger if a box is stated",
        "wrap_left",
        _sector,
    ),
)
# The box is measured from the frame's back, so this rule comes after that of the back.
WINDOWS = (
    Rule(
        "drum.windows",
        "none, because the web does not bear the stress beside them",
        "drum_stress",
        lambda given: "none",
        applies=_windows_cost,
    ),
)
