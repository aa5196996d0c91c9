"""What the sizing rules of siso_spur read; the first rules: names, limits, radii, rope, preload and turns."""

from collections.abc import Mapping
from dataclasses import replace
from functools import partial
from math import degrees, inf, log
from typing import Any

from mbcdm_cad.checks.input_pulley import SHOULDER_MM
from mbcdm_cad.checks.ratios import ANCHOR_RATIO
from mbcdm_cad.design.bought import Gearhead
from mbcdm_cad.design.paths import at
from mbcdm_cad.design.rules import Broken
from mbcdm_cad.design.sized import SizingError
from mbcdm_cad.layouts import head_basis, head_parts
from mbcdm_cad.layouts.base import Layout
from mbcdm_cad.layouts.common_rules import least_bend_ratio, ropes_to_choose
from mbcdm_cad.layouts.siso_spur.drive import MOST_SECTOR_TRAVEL_DEG, PITCH_SPREAD
from mbcdm_cad.layouts.siso_spur.first_stage import of_data
from mbcdm_cad.layouts.siso_spur.layout import SpurLayout
from mbcdm_cad.layouts.siso_spur.schema import MOST_TURNS, REFERENCE
from mbcdm_cad.layouts.trial_sizing import TrialKnown, whole_turns
from mbcdm_cad.parts.drum_sector.dims import WHOLE_DEG
from mbcdm_cad.parts.input_pulley.dims import neck_mm, widest_bend_mm
from mbcdm_cad.sizing import Found, Rule, constant, rounded_up, rule

# Preload over the preload that an infinite wrap would need for the slip margin.
PRELOAD_SPARE = 1.35
SLIP_MARGIN = 2.0
# Preloads that are tried, over the usual one: more turns give the slip margin with less, until a cable goes slack.
PRELOAD_SHARES = (1.0, 0.95, 0.9, 0.85, 0.8, 0.75, 0.7, 0.6, 0.5, 0.4)
# Least radius of an input pulley beyond the radius of the motor's shaft, for the walls of bore and neck (estimate).
NECK_MM = 2.5
# Angle of both landings, crossed and open, before the centre distance is known, and wrap that should stick in addition.
LANDINGS_DEG, OPEN_LANDINGS_DEG, STICKING_DEG = 50.0, 280.0, 20.0
# Step of the search for the smallest input that takes the stops of anchored cables, mm.
_RADIUS_STEP_MM = 0.05


class SpurKnown(TrialKnown):
    """Adds the values of an input beside the drum."""

    layout: type[Layout] = SpurLayout
    asked: tuple[str, ...] = (
        at.travel.half_angle_deg,
        at.loads.peak_torque_Nm,
        at.transmission.drum_radius_mm,
        at.transmission.input_to_drum,
        at.transmission.parallel,
        at.rope.type,
        at.rope.preload_N,
        at.drive.motor,
        at.drive.gearhead,
    )

    # The neck between the stop slots of anchored cables can be too small for the shoulder of a bearing that fits it.
    own_checks: Mapping[str, tuple[str, ...]] = {
        # Several sectors on one shaft.
        at.drum.hub_diameter_mm: ("dowel_holes", "hub_dowels"),
        at.input_pulleys.lower_bearing: ("bearing_shoulders",),
        at.input_pulleys.upper_bearing: ("bearing_shoulders",),
        # A shaft that stands out as the output.
        at.drum.bearing: ("shaft_end_stress", "shaft_end_twist", "shaft_end_flange"),
        at.drum.shaft_bore_mm: ("shaft_end_stress", "shaft_end_twist"),
        at.drum.hub_face_y_mm: ("shaft_end_bond", "sectors_apart", "dowel_holes"),
    }

    most_sector_travel_deg = MOST_SECTOR_TRAVEL_DEG

    @property
    def whole_drum(self) -> bool:
        """Whether the file states a whole drum, or a travel that asks for one."""
        stated, half = self.peek(at.drum.sector_half_angle_deg), self.peek(at.travel.half_angle_deg)
        ends = self.peek(at.travel.from_deg), self.peek(at.travel.to_deg)
        if stated is not None:
            return bool(stated >= WHOLE_DEG)
        if half is None and None not in ends:
            half = (ends[1] - ends[0]) / 2
        return half is not None and bool(half > self.most_sector_travel_deg)

    @property
    def gearhead(self) -> Gearhead:
        """See the base class; a first cable stage takes its place."""
        return of_data(self.get).output if self.has("first_stage") else super().gearhead

    @property
    def anchored(self) -> bool:
        """Whether two cables end on each input."""
        return bool(self.get(at.transmission.cables, "continuous") == "two_anchored")

    @property
    def parallel(self) -> int:
        """Number of cables side by side."""
        return int(self.get(at.transmission.parallel, 1))

    @property
    def parallel_spread(self) -> float:
        """How far the preload of one of several parallel cables may be from the stated one, over it, at least."""
        return 0.0 if self.parallel == 1 else PITCH_SPREAD

    @property
    def half_torque_N(self) -> float:
        """See the base class; parallel cables share it."""
        return super().half_torque_N / self.parallel

    @property
    def ratio(self) -> float:
        """Drum radius over input radius."""
        if self.has(at.transmission.input_to_drum):
            return float(self[at.transmission.input_to_drum])
        return float(self[at.transmission.drum_radius_mm] / self[at.transmission.input_radius_mm])

    @property
    def has_ratio(self) -> bool:
        """See the base class; if False, the ratio follows from the motor."""
        return self.has(at.transmission.input_to_drum) or self.has(at.transmission.input_radius_mm)

    @property
    def input_mm(self) -> float:
        """Pitch radius of the input."""
        return float(self[at.transmission.drum_radius_mm]) / self.ratio

    @property
    def drum_mm(self) -> float:
        """Pitch radius of the drum."""
        return float(self[at.transmission.drum_radius_mm])


@rule("cables", "two sides of each cable", "the configuration")
def cables(given: SpurKnown) -> list[dict[str, Any]]:
    """Both sides of each cable."""
    if given.parallel == 1:
        return list(REFERENCE.cables)
    return [one | {"name": f"{one['name']}_{k + 1}"} for k in range(given.parallel) for one in REFERENCE.cables]


def _input_needs_mm(given: SpurKnown, d_mm: float, bend_ratio: float) -> dict[str, float]:
    """Least radii of the input, for the limit of the bend ratio and for a neck round the shaft."""
    if given.servo is not None:
        return {"bend_ratio": bend_ratio * d_mm / 2}
    shaft = head_parts.JOURNAL_MM if given.has("stage.kind") else given.gearhead.shaft_diameter_mm
    return {"bend_ratio": bend_ratio * d_mm / 2, "bearing_shoulders": shaft / 2 + NECK_MM + d_mm / 2}


@rule(
    at.transmission.drum_radius_mm,
    "the ratio times the smallest input for rope and shaft, or more for the stop slot",
    "bend_ratio",
)
def drum_radius(given: SpurKnown) -> Found:
    """The ratio times the smallest input that keeps the limit of the bend ratio and leaves a neck round the shaft.

    With anchored cables the input must also take their stops. The drum is at least as large as the stop slot needs
    between hub and rim, whose sizes are those of the pass before.
    """
    field = at.transmission.drum_radius_mm
    on_input = _input_needs_mm(given, given.d_mm, given[at.limits.bend_ratio_min])
    if given.anchored:
        on_input["anchor_bend"] = _stops_mm(given)
    needs = {name: radius * given.ratio for name, radius in on_input.items()}
    before = given.guesses.get(field)
    if before is not None:
        missed, _ = given.margins(field, before, ("stop_slot",))["stop_slot"]
        needs["stop_slot"] = before + (-missed if -inf < missed < 0.0 else 0.0)
    driver = max(needs, key=lambda name: needs[name])
    return Found(rounded_up(needs[driver], 0.5), driver, "up to 0.5")


def _stops_mm(given: SpurKnown) -> float:
    """The smallest input with the bend radius of a stop and necks larger than the journals."""
    d, end, wall = given.d_mm, given.termination, given.wall_mm("input_pulleys")
    bearings, journals = given.entries("bearings"), []
    for field in (at.input_pulleys.lower_bearing, at.input_pulleys.upper_bearing):
        name = given.get(field, given.guesses[field])
        journals.append(float(bearings[name]["bore_mm"]) / 2 if name in bearings else 0.0)
    radius = given[at.limits.bend_ratio_min] * d / 2
    while (
        2 * widest_bend_mm(d, end, wall, radius) < ANCHOR_RATIO * d
        or neck_mm(d, end, wall, radius) < max(journals) + SHOULDER_MM
    ):
        radius += _RADIUS_STEP_MM
    return float(radius)


def _usual_preload_N(given: SpurKnown, half_torque_N: float) -> float:
    if given.anchored:
        return float(head_basis.PRELOAD_FACTOR * half_torque_N)
    margin = given.get(at.limits.slip_margin_min, SLIP_MARGIN)
    return float(PRELOAD_SPARE * margin * half_torque_N)


@head_basis.rope
def thinnest_rope(given: SpurKnown) -> Found:
    """The thinnest rope; if the drum's radius is open, each rope is checked on the drum that follows from it.

    On an input that bends it too sharply, the thickest that bends there, if it holds with the least preload that is
    tried.
    """

    def tension_N(d_mm: float, preload_share: float = 1.0) -> float:
        if given.has(at.transmission.drum_radius_mm):
            share = given.half_torque_N
        else:
            needs = _input_needs_mm(given, d_mm, given.get(at.limits.bend_ratio_min) or least_bend_ratio(given))
            radius = rounded_up(max(needs.values()) * given.ratio, 0.5)
            share = given.input_peak_Nm * 1e3 / (2 * radius * given.parallel)
        usual = preload_share * _usual_preload_N(given, share)
        return usual * (1.0 + given.parallel_spread) + share

    found = head_basis.thinnest_rope_by(given, tension_N)
    if given.anchored or not given.has(at.transmission.drum_radius_mm):
        return found
    least = given.get(at.limits.bend_ratio_min) or least_bend_ratio(given)
    bending = [rope for rope in ropes_to_choose(given) if rope[0] * least <= 2.0 * given.input_mm]
    if bending and found.value not in [name for _, name, _ in bending]:
        _, thickest, breaking = bending[-1]
        if head_basis.holding_N(given, partial(tension_N, preload_share=PRELOAD_SHARES[-1]), bending[-1]) <= breaking:
            return Found(thickest, "bend_ratio", "thickest that bends on the input; less preload")
    return found


@rule(
    at.rope.preload_N,
    "least preload for the slip margin at peak torque; with anchored cables twice the one that keeps them taut",
    "input_slip",
)
def least_preload(given: SpurKnown) -> Found:
    """The usual preload, or less, as long as friction still holds the cable.

    Less if the ends of a stated rope cannot carry it, or if losses count and bending so tight a rope takes too much of
    the motor's torque, or of the torque with which the drum shall be turned from its side.
    """
    driver = "no_slack" if given.anchored else "input_slip"
    wanted = _usual_preload_N(given, given.half_torque_N)
    if given.anchored:
        return head_basis.preload(given, wanted, driver)
    usual = head_basis.preload(given, wanted, driver)
    tried = sorted({float(f"{share * usual.value:.2g}") for share in PRELOAD_SHARES}, reverse=True)
    counted = ("motor_torque_forward", "motor_torque_back") if head_basis.counts_losses(given) else ()
    easy = () if given.get(at.loads.backdrive_Nm) is None else ("backdrive",)
    shaft = ("motor_shaft_load",) if given.overhung else ()
    found = given.first(at.rope.preload_N, tried, ("cable_ends", "tension", *counted, *easy, *shaft))
    return usual if found.value == usual.value else replace(found, rounding="two digits")


@rule(
    at.transmission.turns,
    "least number for the travel, the creep at both ends and the slip margin; anchored: for travel and stop",
    "input_slip",
)
def turns(given: SpurKnown) -> Found:
    """Turns for the travel, for the creep at both ends at peak torque and for a part that sticks.

    For two anchored cables, turns for the travel and for the dead turns.
    """
    if given.anchored:
        start = whole_turns(2 * given[at.travel.half_angle_deg] * given.ratio)
        return given.first(at.transmission.turns, range(start, start + 3), ("dead_turns", "cable_ends"))
    tension, share, mu = given[at.rope.preload_N], given.half_torque_N, given[at.rope.friction_coefficient]
    travel = 2 * given[at.travel.half_angle_deg] * given.ratio
    slack = max(tension - share, 0.05 * tension)
    creeping = degrees(log((tension + share) / slack)) / mu
    landings = OPEN_LANDINGS_DEG if given.get(at.transmission.spans) == "open" else LANDINGS_DEG
    start = whole_turns(travel + creeping + landings + STICKING_DEG)
    if start > MOST_TURNS:
        what, remedy = "the travel needs too many turns on the input", "lower it, or transmission.input_to_drum"
        half = ("travel", "half_angle_deg")
        raise SizingError(Broken(half, what, f"{start} turns", f"{MOST_TURNS}", remedy))
    return given.first(at.transmission.turns, range(start, min(start + 12, MOST_TURNS + 1)), ("input_slip",))


@rule(at.rope.helix_lead_mm, "the least lead with gaps between turns and crests between grooves", "helix_lead")
def lead(given: SpurKnown) -> Found:
    step = 0.05 if given.d_mm > 0.5 else 0.01
    # Beside a terminal of a whole drum lies the turn before it.
    # Up to it reaches a lug of plastic.
    lug = ("lug_stress",) if given.whole_drum and given.printed("drum") else ()
    checks = ("helix_lead", "groove_crest", "self_clearance", "turns_on_drum", *lug)
    return given.moved(at.rope.helix_lead_mm, 1.02 * given.d_mm, step, checks)


land_edge = constant(at.clearances.land_edge_mm, 0.3, "a broken edge and the run-out of the cutter", "rim_width")
NAMES = (constant("inputs", REFERENCE.inputs, "one", "the configuration"), cables)
ratio = Rule(
    at.transmission.input_to_drum,
    "the least with which the motor's continuous torque gives the peak torque",
    "motor_torque_forward",
    head_basis.needed_ratio,
    applies=lambda given: not given.has(at.transmission.input_radius_mm),
)
WINDING = (lead, turns)
