"""Sizing rules that layouts share: shelves of the inputs, and the drum without its width."""

from collections.abc import Iterable
from contextlib import suppress
from dataclasses import replace
from math import inf
from typing import Any

from mbcdm_cad.checks.fixings import STRESS_SAFETY, lasting_MPa, stalled_Nm
from mbcdm_cad.design.paths import at
from mbcdm_cad.design.sized import NOT_USED
from mbcdm_cad.layouts.base import NoFigureError
from mbcdm_cad.layouts.common_rules import STOP_PINS_MM
from mbcdm_cad.layouts.sector import SectorLayout
from mbcdm_cad.layouts.structure import drum_structure_of
from mbcdm_cad.layouts.trial_sizing import SHAFT_BORE, SHAFT_BORE_SHARE, TrialKnown
from mbcdm_cad.model.structure.causes import urad_Nm
from mbcdm_cad.model.structure.drum_sector import least_hub_mm
from mbcdm_cad.parts.drum_sector.dims import WHOLE_DEG, joint_load, joints
from mbcdm_cad.parts.drum_sector.part import DrumSector
from mbcdm_cad.parts.fits import SHEAR_SHARE
from mbcdm_cad.sizing import Found, Rule, rounded_up, rule

# Walls of a milled part and of a printed one, mm (estimate: the modulus of filament is about twenty times smaller).
SIDE_MM, WEB_MM = (4.0, 6.0), (2.0, 4.0)
# What a web must gain by it to be full: strength where it does not bear its stress with windows, mass times turn of the
# drum where it does (a choice).
CLOSED_GAIN = 1.3
# Peak torque from which the stress of a metal web is computed: hubs for less leave far more than it needs (estimate).
STRESSED_NM = 10.0
# The same of a whole drum, whose wide rim bends the web (estimate).
WHOLE_NM = 5.0
# Fields that a pulley on the motor's shaft does not use; a shelf is at least so high, and the first space is tried.
UNUSED, LEAST_SHELF_MM, COUPLING_MM = NOT_USED + "the motor's shaft carries the pulley", 3.0, 5.0
# Engaged thread of a face's screws, in diameters.
ENGAGED = 1.25
# Angle of the sector beyond the travel, before the limits of the wraps are known, and the widest that is tried first
# (estimate).
SECTOR_SPARE_DEG, WIDEST_DEG = 15.0, 174.0


def either(given: TrialKnown, part: str, values: tuple[float, float]) -> float:
    """The first value for a milled part, the second for a printed one."""
    return values[1] if given.printed(part) else values[0]


@rule(
    at.support.motor_shelf_mm,
    "thickness that leaves enough engagement for the screws of motor or gearhead, less where a motor's shaft is short",
    "engagement",
)
def motor_shelf(given: TrialKnown) -> Found:
    """Screw length minus the needed thread, mm; at least what wall and pilot need."""
    gear = given.gearhead
    if given.servo is not None:
        return Found(LEAST_SHELF_MM, NOT_USED + "a servo's ears lie on the plate")
    screw = given.screw(gear.screw)
    # The shelf of a pulley on the motor's shaft is part of the plate, which the cables tilt: as thick as screws allow.
    spare = 0.0 if given.overhung else 0.75 * screw.thread_mm
    needs = {
        "walls": given.wall_mm("support"),
        "engagement": screw.length_mm - ENGAGED * screw.thread_mm - spare,
        "pilot_room": gear.pilot_height_mm + 0.5,
    }
    driver = max(needs, key=lambda name: needs[name])
    usual = rounded_up(min(needs[driver], screw.length_mm - screw.thread_mm), 0.1)
    if not gear.absent and not given.has("stage.kind") and not given.overhung:
        return Found(usual, driver, "up to 0.1")
    # The shaft of a motor ends soon behind its face: a thinner shelf leaves the collar more of it.
    grip = "motor_shaft_grip" if given.overhung else "shaft_grip"
    found = given.moved(at.support.motor_shelf_mm, usual, -0.1, (grip, "walls", "bought_depth"))
    return Found(found.value, found.driver or driver, found.rounding)


def _shelf(given: TrialKnown, field: str, bearing: str, checks: tuple[str, ...]) -> Found:
    """Shelf of a bearing of the input."""
    if given.overhung:
        return Found(LEAST_SHELF_MM, UNUSED)
    width = given.entry("bearings", f"input_pulleys.{bearing}")["width_mm"]
    return given.moved(f"support.{field}", max(width + given.wall_mm("support"), LEAST_SHELF_MM), 0.1, checks)


@rule(at.support.bearing_shelf_mm, "least height for the bearing next to the motor and a shoulder", "bearing_seats")
def bearing_shelf(given: TrialKnown) -> Found:
    """Shelf of the bearing next to the motor."""
    return _shelf(given, "bearing_shelf_mm", "lower_bearing", ("bearing_seats", "walls"))


@rule(at.support.encoder_shelf_mm, "least height for bearing, shoulder and sunk screw heads", "encoder_shelf")
def encoder_shelf(given: TrialKnown) -> Found:
    """Shelf of the bearing next to the encoder."""
    return _shelf(given, "encoder_shelf_mm", "upper_bearing", ("encoder_shelf",))


@rule(
    at.support.coupling_space_mm,
    "least space to insert the collar, the screws of the motor or gearhead and their key",
    "coupling_height",
)
def coupling_space(given: TrialKnown) -> Found:
    """Space between the shelves of motor and bearing."""
    if given.overhung:
        return Found(COUPLING_MM, UNUSED)
    return given.moved(at.support.coupling_space_mm, COUPLING_MM, 0.1, ("coupling_height", "collar_space"))


def side_wall(given: TrialKnown) -> float:
    """Walls beside the motor head."""
    return max(either(given, "support", SIDE_MM), 2 * given.wall_mm("support"))


@rule(at.drum.shaft_bore_mm, "half the bearings' bore, or less for the wall of the shaft", "shaft_wall")
def shaft_bore(given: TrialKnown) -> Found:
    """Bore of the drum's shaft."""
    bore = given.entry("bearings", at.drum.bearing)["bore_mm"]
    return given.moved(SHAFT_BORE, SHAFT_BORE_SHARE * bore, -0.5, ("shaft_wall", "shaft_stress", "shaft_twist"))


@rule(at.drum.web_thickness_mm, "usual thickness for its material, more where plastic is stressed", "web_in_rim")
def web(given: TrialKnown) -> Found | float:
    """Web of the drum; one of plastic, in a wide whole drum, or with much torque, is as thick as its stress asks.

    The stress of most metal webs is far from the limit, and to compute it takes longer than all other rules of a drum.
    """
    usual = either(given, "drum", WEB_MM)
    if not given.printed("drum") and given[at.loads.peak_torque_Nm] < (WHOLE_NM if given.whole_drum else STRESSED_NM):
        return usual
    field = at.drum.web_thickness_mm
    if not given.drives.passes:
        return usual  # the rest of the drum is guessed yet, and its stress takes longest of all checks
    return given.moved(field, usual, 0.5, ("drum_stress",))


def _windows_cost(given: TrialKnown) -> bool:
    """Whether windows cost more than they save: a thicker web for the stress beside them, or much of its stiffness."""
    usual = either(given, "drum", WEB_MM)
    stated = given.get(at.drum.web_thickness_mm) is not None
    if stated or (not given.printed("drum") and given[at.loads.peak_torque_Nm] < STRESSED_NM):
        return False

    def block(windows: str) -> dict[str, Any]:
        return {**given.filled("drum"), "web_thickness_mm": usual, "windows": windows}

    def strength(windows: str) -> float:
        return STRESS_SAFETY + given.margins("drum", block(windows), ("drum_stress",))["drum_stress"][0]

    def mass_times_turn(windows: str) -> float:
        trial = given.trial("drum", block(windows))
        assert isinstance(trial, SectorLayout)
        thread = trial.drive.screw(trial.drum.set_screw).thread_mm
        return urad_Nm(drum_structure_of(trial).causes) * DrumSector(trial.drum, thread).volume_mm3()

    # Before the first pass, what is guessed says nothing about the stress.
    field, held = at.drum.windows, given.drives.held
    if given.drives.passes and field not in held and (outer := strength("outer")) > -inf:
        closed = outer < STRESS_SAFETY and strength("none") > CLOSED_GAIN * max(outer, 0.0)
        with suppress(NoFigureError, ValueError):
            closed = closed or mass_times_turn("outer") > CLOSED_GAIN * mass_times_turn("none")
        held[field] = float(closed)
    return bool(held.get(field, given.guesses.get(field) == "none"))


@rule(
    at.drum.hub_diameter_mm,
    "least diameter for the walls round shaft and set screws, its torsion and the payload's screws",
    "hub_walls",
)
def hub(given: TrialKnown) -> Found:
    """Diameter of the drum's hub, not less than its torsion asks at the peak torque or with stalled motors."""
    bore, field = given.entry("bearings", at.drum.bearing)["bore_mm"], at.drum.hub_diameter_mm
    usual, twisted, screwed = bore + 4.0, 0.0, 0.0
    with suppress(NoFigureError, ValueError):
        trial = given.trial(field, usual)
        assert isinstance(trial, SectorLayout)
        bears_MPa = lasting_MPa(trial.drive.drum_material) * SHEAR_SHARE / STRESS_SAFETY
        twisted = rounded_up(2.0 * least_hub_mm(bore / 2.0, stalled_Nm(trial), bears_MPa), 0.5)
        if given.printed("drum") and given.get(at.printing.threads) == "inserts":
            # Larger inserts come only with larger hubs: a search that starts small ends between two of them.
            screwed = 2.0 * payload_hub_mm(trial)
    checks = ("hub_walls", "hub_spigot", "hub_set_screws", "engagement", "payload_screws")
    found = given.moved(field, max(usual, twisted, screwed), 0.5, checks)
    return replace(found, driver="drum_stress") if found.value == twisted > usual else found


def payload_hub_mm(layout: SectorLayout) -> float:
    """Least radius of a hub with which the payload's screws hold, with walls round them."""
    drive = layout.drive
    material, load = drive.drum_material, joint_load(drive.loads.peak_torque_Nm, drive.loads.carried)
    shaft = drive.bearings.drum.bore_mm / 2.0
    found = joints(material, lambda thread_mm: drive.insert(material, thread_mm), drive.drum.output_screws)
    return min(joint.least_hub_mm(load, shaft, material.min_wall_mm) for joint in found)


@rule(at.drum.rim_inner_radius_mm, "the thinnest rim that the terminals' pockets allow", "rim_height")
def rim(given: TrialKnown) -> Found:
    """Inner radius of the drum's rim."""
    start = given.drum_mm - 2 * given.d_mm
    return given.moved(at.drum.rim_inner_radius_mm, start, -0.5, ("rim_height", "pocket_corners"))


@rule(at.drum.stop_pin_mm, "the thinnest pin that holds the stalled motor", "stop_pin")
def stop_pin(given: TrialKnown) -> Found:
    """Diameter of the stop pin; after two passes no thinner again, for a thinner web goes with a thicker pin."""
    field, held = at.drum.stop_pin_mm, given.drives.held
    found = given.first(field, [pin for pin in STOP_PINS_MM if pin >= held.get(field, 0.0)], ("stop_pin",))
    if given.drives.passes:
        held[field] = found.value
    return found


@rule(at.drum.hub_face_y_mm, "least length for set screws and payload threads", "hub_length")
def hub_face(given: TrialKnown) -> Found:
    """Face of the drum's hub."""
    return given.moved(at.drum.hub_face_y_mm, given[at.drum.outer_face_y_mm], 0.1, ("hub_length",))


@rule(at.drum.sector_half_angle_deg, "least angle for the travel and the wrap that must remain", "wrap_left")
def sector(given: TrialKnown) -> Found:
    """Half angle of the drum's sector."""
    if given[at.travel.half_angle_deg] > given.most_sector_travel_deg:
        return Found(WHOLE_DEG, "wrap_under_turn", "a whole drum")
    start = min(given[at.travel.half_angle_deg] + SECTOR_SPARE_DEG, WIDEST_DEG)
    checks = ("wrap_left", "terminal_clears_input", "stop_slot", "terminal_angles")
    return given.moved(at.drum.sector_half_angle_deg, start, 1.0, checks)


WINDOWS = Rule(
    at.drum.windows,
    "none where a web of usual thickness does not bear the stress beside them, or would turn much less without them",
    "drum_stress",
    lambda given: "none",
    applies=_windows_cost,
)


def drum_rules(outer_face: Rule) -> tuple[Rule, ...]:
    """Rules of a drum sector, of which layouts have that of its outer face of their own."""
    return (shaft_bore, hub, WINDOWS, web, sector, stop_pin, rim, outer_face, hub_face)


def mount_screw(screws: Iterable[str], *checks: str) -> Rule:
    """Rule of the mounting screws, of those of a layout, with ``checks`` that they must pass besides."""
    field, own = at.support.mount_screw, ("mounting_screws", *checks)
    text = "the thinnest that holds the peak torque by friction"
    return Rule(field, text, own[0], lambda given: given.first(field, screws, own))
