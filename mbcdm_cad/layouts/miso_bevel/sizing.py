"""Sizing rules of miso_bevel, in the order of the drive; many evaluate checks on a trial drive (trial_sizing)."""

from collections.abc import Iterator, Mapping
from contextlib import suppress
from dataclasses import replace
from math import asin, degrees, hypot, pi, radians, sqrt, tan
from typing import Any

from mbcdm_cad.checks.design_variables import ALL_RADII
from mbcdm_cad.checks.geometry import CABLE_GAP_MM
from mbcdm_cad.checks.terminals import TERMINAL_GAP_MM
from mbcdm_cad.design.bought import NO_GEARHEAD
from mbcdm_cad.design.paths import at
from mbcdm_cad.design.rules import Broken
from mbcdm_cad.design.sized import Freedom, SizingError
from mbcdm_cad.layouts import common_rules, head_basis, head_dims
from mbcdm_cad.layouts.base import NoFigureError
from mbcdm_cad.layouts.bevel_sizing import GUESSES, RADII, TransferKnown, land_edge, outer_face, transfer_gap
from mbcdm_cad.layouts.head_parts import PARTS, by_mass
from mbcdm_cad.layouts.miso_bevel.checks.spans import straight_span_distance_mm
from mbcdm_cad.layouts.miso_bevel.design_file import MOST_SETBACK, REFERENCE
from mbcdm_cad.layouts.miso_bevel.layout import BevelLayout
from mbcdm_cad.layouts.miso_bevel.support import HEAD_ROOM_MM
from mbcdm_cad.layouts.open_ratio import SizingRules
from mbcdm_cad.layouts.stiff_sizing import SHARED, bearing, walls
from mbcdm_cad.parts.drum_sector.dims import SCREWS
from mbcdm_cad.parts.fits import MOUNT_SCREWS
from mbcdm_cad.sizing import Found, Rule, constant, rounded_down, rounded_up, rule

STEPS = 4
RATIO, TO_DRUM = at.transmission.ratio, "transmission.ratios.guide_to_drum"
DISTANCE, SETBACK = at.transmission.centre_distance_mm, at.transmission.input_setback_mm
# What a trial moves in place of radii and ratio: the step from one drum radius to the next, and the guide's step 1.
STEP, GUIDE = "transmission.step_mm", "transmission.guide_radius_mm"
# Least guide that a file may have, over the input and over the drum.
LEAST_OVER_INPUT, LEAST_OVER_DRUM = 0.2, 0.02
# Mean radius of the drum over that of step 1, before the steps are known (estimate).
MEAN_OVER_FIRST = 1.1
# Largest share of an input in the peak torque over half of it: the cables of inner steps are shorter, hence stiffer
# (estimate; the checks measure it).
UNEVEN = 1.07
# The same of a cable, before its step is known; and strength of a swaged end over the rope's (estimates).
MOST_UNEVEN, SWAGED_SHARE = 1.25, 0.9
# Gap between a cable and the flank of the land above it, beyond the land's edge, for tolerances (estimate).
FLANK_GAP_MM = 0.045
# Preloads that are tried over the usual one, which is twice what keeps the cables taut (a choice).
PRELOAD_SHARES = (0.9, 0.8, 0.7, 0.6, 0.5)
# Numbers of the payload's screws over the usual one that are tried.
MORE_SCREWS = (5, 8)
# Walls of a milled part and of a printed one, mm (estimate).
BACK_MM, RIB_MM = (4.0, 7.0), (4.0, 8.0)
# Free span over that at which the walk makes the limit of the fleet angle, so that rounding does not shorten it; and
# what a lead that just clears the turn before it is raised by, as a share of the rope's diameter (tolerances).
SPAN_SPARE, LEAD_SPARE = 1.01, 0.008
# The widest sector that is tried first; steps of a gearhead's turn (choices).
WIDEST_DEG, TURN_STEP_DEG = 170.0, 15.0


class BevelKnown(TransferKnown):
    """Adds the radii of drum, guide and inputs."""

    layout = BevelLayout
    asked = (
        *(at.travel.half_angle_deg, at.loads.peak_torque_Nm, at.rope.type, at.rope.preload_N),
        *(at.drive.motor, at.drive.gearhead, RADII, TO_DRUM, DISTANCE),
    )
    encoder_checks = ("encoder_fit", "hole_webs", "engagement")
    own_checks: Mapping[str, tuple[str, ...]] = {
        at.input_pulleys.lower_bearing: ("bearing_shoulders",),
        at.input_pulleys.upper_bearing: ("bearing_shoulders",),
        at.support.coupling_space_mm: ("screwdriver", "envelope_z"),
    }

    def _whole(self, field: str, value: Any) -> dict[str, Any]:
        """See the base class; ratios follow each other, and inputs that are set back stand far enough apart."""
        if field == STEP:
            return super()._whole(RADII, self.radii_mm(value))
        if field == GUIDE:
            field, value = TO_DRUM, self.to_drum(value)
        block = dict(self._filled.get("transmission") or {})
        if field == TO_DRUM:
            if not self.has(RADII):
                block["drum_radii_mm"] = self.radii_mm(self.least_step_mm(value))
            block["ratios"] = {"guide_to_drum": value, "input_to_guide": round(self.ratio / value, 9)}
            if not self.has(DISTANCE):
                beside = block["drum_radii_mm"][-1] * (1.0 / value + 1.0 / self.ratio) + 2.0 * self.d_mm
                block["centre_distance_mm"] = max(block["centre_distance_mm"], rounded_up(beside, 0.1))
            return super()._whole("transmission", block)
        if field == at.input_pulleys.surface and not self.has(at.rope.helix_lead_mm):
            fleet = self.get(at.limits.fleet_angle_grooved_max_deg, 2.0) if value == "grooved" else self.fleet_deg
            return {
                **super()._whole(field, value),
                "rope": {**self._filled["rope"], "helix_lead_mm": self.lead_mm(fleet)},
            }
        if field == SETBACK and not self.has(DISTANCE):
            apart = max(block.get("centre_distance_mm", 0.0), value / MOST_SETBACK)
            return super()._whole("transmission", {**block, "input_setback_mm": value, "centre_distance_mm": apart})
        return super()._whole(field, value)

    def radii_mm(self, step_mm: float) -> list[float]:
        """Pitch radii of the drum with equal steps."""
        return [round(self.drum_mm + k * step_mm, 6) for k in range(STEPS)]

    def to_drum(self, guide_mm: float) -> float:
        """Ratio of guide and drum, at which the guide's step 1 has at least this radius."""
        return rounded_down(self.drum_mm / guide_mm, 0.01)

    def least_step_mm(self, to_drum: float) -> float:
        """Least step of the drum for the walk on the inputs, terminals and lands, as far as they are known, mm."""
        d, drum = self.d_mm, self.filled("drum")
        end = self.entries("tensioners")[drum["tensioner"]]
        nut, corner = end["nut_across_flats_mm"] / sqrt(3.0), self.entry("materials", at.drum.material)
        pocket = nut + self[at.clearances.running_mm] + corner["min_internal_radius_mm"]
        return rounded_up(
            max(
                d + 2 * (self.walk_mm(self.lead_mm(self.fleet_deg)) + CABLE_GAP_MM),
                pocket - d / 2 + TERMINAL_GAP_MM,
                nut + end["swage_diameter_mm"] / 2 + TERMINAL_GAP_MM,
                to_drum * (d / 2 + self[at.clearances.land_edge_mm] + FLANK_GAP_MM),
            ),
            0.1,
        )

    @property
    def least_rope_mm(self) -> float:
        """See the base class; 0 where a stated distance leaves no room for the guide that such a rope asks for."""
        return 0.0 if self.has(DISTANCE) and self.has_missed("guide_wall") else super().least_rope_mm

    @property
    def states_lands(self) -> bool:
        """See the base class."""
        return self.has(RADII) and (self.has(TO_DRUM) or not _needs_ratios(self))

    @property
    def half_torque_N(self) -> float:
        """See the base class; the mean radius is a little larger than the first."""
        return float(self[at.loads.peak_torque_Nm]) * 1e3 / (STEPS * MEAN_OVER_FIRST * self.drum_mm)

    @property
    def input_peak_Nm(self) -> float:
        """See the base class; the cables of an input, on neighbouring steps, turn it by their preload too."""
        step = self.drum_radii_mm[1] - self.drum_radii_mm[0]
        return UNEVEN * super().input_peak_Nm + float(self[at.rope.preload_N]) * step * 1e-3

    @property
    def ratio(self) -> float:
        """Drum radius over input radius."""
        both = [self.get(f"transmission.ratios.{name}") for name in ("input_to_guide", "guide_to_drum")]
        if None not in both:
            return float(both[0] * both[1])
        if self.has(at.transmission.input_radii_mm):
            return self.drum_mm / float(self[at.transmission.input_radii_mm][0])
        return float(self[RATIO])

    @property
    def drum_radii_mm(self) -> list[float]:
        """Pitch radii of the drum; of a trial as long as they are open."""
        return list(self.get(RADII) or self.filled("transmission")["drum_radii_mm"])

    @property
    def before_drum_mm(self) -> list[float]:
        """Pitch radii of the guide."""
        stated = self.get(at.transmission.guide_radii_mm)
        return stated or [radius / self[TO_DRUM] for radius in self.drum_radii_mm]

    @property
    def across_mm(self) -> float:
        """Guide and input pulley beside each other."""
        return max(self.before_drum_mm) + max(self.drum_radii_mm) / self.ratio

    @property
    def fleet_deg(self) -> float:
        """Largest fleet angle on the inputs' surface."""
        if self.get(at.input_pulleys.surface) == "grooved":
            return float(self.get(at.limits.fleet_angle_grooved_max_deg, 2.0))
        return float(self[at.limits.fleet_angle_max_deg])

    def lead_mm(self, fleet_deg: float) -> float:
        """Least lead, mm, at which a straight span that rises by an angle clears its last turn by a rope's diameter.

        The distance grows by nearly as much as the lead, so that a few secant steps are enough.
        """
        radius, slope, lead = max(self.drum_radii_mm) / self.ratio, tan(radians(fleet_deg)), 1.05 * self.d_mm
        for _ in range(3):
            lead += self.d_mm * (1.0 + LEAD_SPARE) - straight_span_distance_mm(radius, lead, slope)
        return rounded_up(lead, 0.01)

    def with_tolerances(self, check: str) -> tuple[str, ...]:
        """A check of stacked tolerances; none for files that reckon as the paper does, which keep its lead."""
        return (check,) if head_basis.counts_losses(self) else ()

    def walk_mm(self, lead_mm: float) -> float:
        """How far a cable walks along its input pulley from the centred drum to the end of travel."""
        return lead_mm * self.ratio * radians(self[at.travel.half_angle_deg]) / (2 * pi)


def _needs_ratios(given: BevelKnown) -> bool:
    return not given.has(at.transmission.guide_radii_mm)


def _rope(given: BevelKnown) -> Found:
    """The thinnest with a swaged end, or the thickest that the inputs may bend, whose preload is less then.

    The cable that bears most has more than its share of the peak torque.
    """
    tension_N, share = (
        (head_basis.PRELOAD_FACTOR + MOST_UNEVEN) * given.half_torque_N,
        common_rules.end_share(given, SWAGED_SHARE),
    )
    needed_N, ropes = given[at.limits.tension_safety_factor] * tension_N / share, common_rules.ropes_to_choose(given)
    strong = next((one for one in ropes if one[2] >= needed_N), ropes[-1])
    most_mm = 2.0 * given.drum_mm / given.ratio / given.get(at.limits.bend_ratio_min, common_rules.LEAST_WIRE_RATIO)
    bent = [name for d_mm, name, _ in ropes if d_mm <= most_mm]
    if strong[0] <= most_mm or not bent:
        return Found(strong[1], "tension", "next size of the catalogue")
    return Found(bent[-1], "bend_ratio", "next smaller size of the catalogue")


@rule(at.rope.preload_N, "twice what keeps the cables taut at peak torque, less where the ends hold less", "no_slack")
def preload(given: BevelKnown) -> Found:
    usual = head_basis.taut_preload(given)
    less = [float(f"{usual.value * share:.2g}") for share in PRELOAD_SHARES]
    found = given.first(at.rope.preload_N, [usual.value, *less], ("cable_ends", "tension"))
    return usual if found.value == usual.value else found


@rule(RADII, "equal steps, the least for the lands, the walk on the inputs and the terminals", "input_walk")
def drum_radii(given: BevelKnown) -> Found:
    start = given.least_step_mm(given[TO_DRUM] if given.has(TO_DRUM) else 0.0)
    checks = ("radii_rise", "land_width", "input_walk", "terminals_apart", "lands_intact", "stop_pocket_floor")
    found = given.moved(STEP, start, 0.1, (*checks, *given.with_tolerances("flank_stack")))
    return Found(given.radii_mm(found.value), found.driver, f"steps {found.rounding}")


@rule(
    TO_DRUM,
    "the smallest guide with its bearing, for front walls and inputs behind the drum",
    "guide_wall",
    _needs_ratios,
)
def guide_to_drum(given: BevelKnown) -> Found:
    if given.has("transmission.ratios.input_to_guide"):
        return Found(given[RATIO] / given["transmission.ratios.input_to_guide"], RATIO)
    bend_mm = given[at.limits.bend_ratio_min] * given.d_mm / 2
    start = max(bend_mm, given.drum_mm * max(LEAST_OVER_INPUT / given.ratio, LEAST_OVER_DRUM))
    # Steps of the drum that are open follow the guide's; a larger guide makes room for stated ones.
    lands = ("land_width",) if given.has(RADII) else ()
    # The drum's steps grow as the guide gets smaller, and with them what their preloads ask of a stated motor.
    stated = ("motor_torque_back",) if given.has(at.drive.motor) else ()
    # A guide about as large as the drum leaves no way to the terminals: there the inputs are set back instead.
    behind = () if given.has_missed("terminal_clears_guide") else ("front_wall", "drum_sweep")
    checks = ("guide_wall", "bend_ratio", *behind, "guide_length", *lands, *stated)
    found = given.moved(GUIDE, start, 0.1, checks)
    if given.has(DISTANCE):
        # What else needs a larger guide, a setback of the inputs may do.
        radii = given.radii_mm(given.least_step_mm(0.0))
        room = given[DISTANCE] * radii[0] / radii[-1] - radii[0] / given.ratio
        most = given.moved(GUIDE, max(room, start), -0.1, ("centre_distance", "pulley_gap"))
        found = most if "no value" in found.rounding or most.value < found.value else found
    return Found(given.to_drum(found.value), found.driver or "bend_ratio", "down to 0.01")


@rule("transmission.ratios.input_to_guide", "the total ratio over that of guide and drum", RATIO, _needs_ratios)
def input_to_guide(given: BevelKnown) -> float:
    return float(round(given[RATIO] / given[TO_DRUM], 9))


@rule(at.input_pulleys.surface, "smooth, or grooved where only grooves allow the fleet angle", "fleet_angle")
def surface(given: BevelKnown) -> Found:
    if not given.has(DISTANCE):
        return Found("smooth", "centre distance follows")
    across, distance = given.across_mm, given[DISTANCE]
    if given.drives.passes and distance <= across:
        what, remedy = "too short for guide and input pulley beside each other", "raise it, lower the drum's radius"
        limit = f"over {across:.4g} mm, their radii"
        raise SizingError(
            Broken(
                tuple(DISTANCE.split(".")),
                what,
                f"{distance:.4g} mm",
                limit,
                f"{remedy}, or leave it out",
                may_move=True,
            )
        )
    return given.first(at.input_pulleys.surface, ("smooth", "grooved"), ("fleet_angle",))


def _crowded_below(given: BevelKnown) -> bool:
    """Whether the stated centre distance leaves space for motors above only."""
    if not given.has(DISTANCE):
        return False
    below, above = (given.margins(at.drive.motor_side, s, ("drives_apart",)) for s in ("below", "above"))
    return below["drives_apart"][0] < 0.0 <= above["drives_apart"][0]


@rule(
    at.drive.motor_side,
    "above, for the drives have no space beside the drum's bearings",
    "drives_apart",
    _crowded_below,
)
def motor_side(given: BevelKnown) -> str:
    return "above"


@rule(
    at.rope.helix_lead_mm, "the least at which a span clears the turn before it, also with tolerances", "self_clearance"
)
def lead(given: BevelKnown) -> Found:
    checks = ("self_clearance", "helix_lead", "groove_walls", *given.with_tolerances("self_clearance_stack"))
    return given.moved(at.rope.helix_lead_mm, given.lead_mm(given.fleet_deg), 0.01, checks)


@rule(DISTANCE, "the shortest span within the fleet angle, with space for pulleys and drives", "fleet_angle")
def centre_distance(given: BevelKnown) -> Found:
    span = SPAN_SPARE * given.walk_mm(given[at.rope.helix_lead_mm]) / tan(radians(given.fleet_deg))
    setback = given.filled("transmission").get("input_setback_mm", 0.0)
    start = max(hypot(given.across_mm, span), given.across_mm + given.d_mm, setback / MOST_SETBACK)
    return given.moved(DISTANCE, start, 0.1, ("centre_distance", "pulley_gap", "fleet_angle", "drives_apart"))


@rule(at.guide.bearing, "the lightest that fits into the guide and carries the cables", "guide_bearings")
def guide_bearing(given: BevelKnown) -> Found:
    return given.first(at.guide.bearing, by_mass(given, "bearings"), ("guide_bearings", "axle_stress", "guide_wall"))


def _height(field: str, text: str, driver: str, *checks: str) -> Rule:
    """A height of the frame, the least for its checks, of which the first is its driver."""

    def value(given: BevelKnown) -> Found:
        start = max(head_dims.LEAST_SHELF_MM, given.wall_mm("support"))
        return given.moved(f"support.{field}", start, 0.1, (driver, *checks))

    return Rule(f"support.{field}", text, driver, value)


def _usual(given: BevelKnown, usual: tuple[float, float]) -> float:
    return max(head_dims.either(given, "support", usual), given.wall_mm("support"))


@rule(
    at.support.motor_shelf_mm, "as thick as the gearhead's screws and shaft allow: it carries the drives", "engagement"
)
def motor_shelf(given: BevelKnown) -> Found:
    screw = given.screw(given.gearhead.screw)
    checks = ("engagement", "shaft_grip", "walls", "bought_depth")
    return given.moved(at.support.motor_shelf_mm, screw.length_mm - screw.thread_mm, -0.1, checks)


@rule(at.support.side_wall_mm, "walls beside the sunk heads of the top plate's screws", "side_wall")
def side_wall(given: BevelKnown) -> Found:
    return given.moved(at.support.side_wall_mm, _usual(given, head_dims.SIDE_MM), 0.1, ("side_wall", "wall_holes"))


@rule(at.support.back_plate_mm, "usual thickness for its material", "walls")
def back_plate(given: BevelKnown) -> Found:
    found = given.moved(at.support.back_plate_mm, _usual(given, BACK_MM), 0.1, ("walls", "head_seats"))
    if not given.has(at.support.back_y_mm):
        return found
    return given.moved(at.support.back_plate_mm, found.value, -0.1, ("walls", "collar_space", "pocket_depth"))


@rule(at.support.rib_mm, "usual thickness, less for the mounting screws", "mounts")
def rib(given: BevelKnown) -> Found:
    usual = most = _usual(given, RIB_MM)
    with suppress(NoFigureError, ValueError):
        trial = given.trial(at.support.rib_mm, usual)
        assert isinstance(trial, BevelLayout)
        # A thicker rib would leave the column no pocket for a mounting screw's head.
        room = trial.frame.boss.radius - trial.frame.mount_head_radius - HEAD_ROOM_MM
        most = max(room, given.wall_mm("support"))
    return given.moved(at.support.rib_mm, min(usual, most), -0.1, ("mounts", "walls"))


@rule(at.drum.sector_half_angle_deg, "travel and the wrap that must remain; larger if a box is stated", "wrap_left")
def sector(given: BevelKnown) -> Found:
    box, outer = given.get(at.targets.envelope_mm), max(given.drum_radii_mm) - given.d_mm / 2
    if box is not None and box[0] < 2 * outer:
        # A wider sector would exceed the box: it takes precedence, and the checks show the effect.
        return Found(round(degrees(asin(box[0] / 2 / outer)), 1), at.targets.envelope_mm, "to 0.1")
    start = min(given[at.travel.half_angle_deg] + head_dims.SECTOR_SPARE_DEG, WIDEST_DEG)
    checks = ("wrap_left", "terminal_clears_guide", "stop_slot", "terminal_angles", "terminals_apart")
    return given.moved(at.drum.sector_half_angle_deg, start, 0.5, checks)


@rule(SETBACK, "the least with which drum and terminals clear the drives", "drum_sweep")
def setback(given: BevelKnown) -> Found:
    return given.moved(SETBACK, 0.0, 0.1, ("drum_sweep", "front_wall"))


@rule(at.support.back_y_mm, "nearest plane behind drum bearings, pulleys, collars and stop pin", "collar_space")
def back(given: BevelKnown) -> Found:
    checks = (
        *("drum_bearing_spacing", "boss", "pocket_depth", "collar_space", "corner_radii", "drives_apart", "walls"),
        *("mounts", "wall_holes", "head_seats"),
    )
    return given.moved(at.support.back_y_mm, -8.0, -0.5, checks)


@rule(at.drum.hub_face_y_mm, "least length for set screws and payload; the front of a stated box", "hub_length")
def hub_face(given: BevelKnown) -> Found:
    box, start = given.get(at.targets.envelope_mm), float(given[at.drum.outer_face_y_mm])
    if box is not None:
        start = max(start, box[2] + given[at.support.back_y_mm])
    found = given.moved(at.drum.hub_face_y_mm, start, 0.1, ("hub_length",))
    return found if found.driver or box is None else Found(found.value, at.targets.envelope_mm, found.rounding)


@rule(
    at.drum.bearing, "the lightest that carries the drum, or a larger one for a stiffer boss and frame", "drum_bearings"
)
def drum_bearing(given: BevelKnown) -> Found:
    if given.missed_before("boss"):
        entries = given.entries("bearings")
        wide = entries[given.guesses[at.drum.bearing]]["outer_diameter_mm"]
        given.drives.refused |= {name for name in entries if entries[name]["outer_diameter_mm"] >= wide}
    found: Found = PARTS[0].value(given)
    return found


def _screws_fit(given: BevelKnown, screws: int) -> bool:
    """Whether the hub for so many of the payload's screws leaves the walls of the stop pin's slot."""
    block = {**given.filled("drum"), "output_screws": screws}
    with suppress(NoFigureError, ValueError):
        trial = given.trial("drum", block)
        assert isinstance(trial, BevelLayout)
        hub_mm = rounded_up(2.0 * head_dims.payload_hub_mm(trial), 0.5)
        return given.margins("drum", {**block, "hub_diameter_mm": hub_mm}, ("stop_slot",))["stop_slot"][0] >= 0.0
    return True


def _crowded(given: BevelKnown) -> bool:
    """Whether the hub for four screws has no room; that of a pass is judged with the other parts of the one before."""
    stated = given.has(at.drum.hub_diameter_mm) or given.has(at.drum.output_circle_mm)
    if stated or not given.drives.passes:
        return not stated and given.guesses.get(at.drum.output_screws, SCREWS) > SCREWS
    return not _screws_fit(given, SCREWS)


@rule(
    at.drum.output_screws,
    "more than four, because the hub for four leaves no wall inside the stop pin's slot",
    "stop_slot",
    _crowded,
)
def output_screws(given: BevelKnown) -> Found:
    fewest = next((count for count in MORE_SCREWS if _screws_fit(given, count)), MORE_SCREWS[-1])
    return Found(fewest, "stop_slot", f"the least of {', '.join(map(str, MORE_SCREWS))} that leaves the wall")


def _turned(given: BevelKnown) -> tuple[float, ...]:
    """Turns of the gearheads that are tried, deg."""
    most = int(180.0 / given.gearhead.screw_count / TURN_STEP_DEG)
    return (0.0, *(sense * TURN_STEP_DEG * k for k in range(1, most + 1) for sense in (1, -1)))


_SCREWS_REACHED = ("head_seats", "key_access", "front_wall")


def _turn_helps(given: BevelKnown) -> bool:
    def holds(turn: float) -> bool:
        margins = given.margins(at.drive.gearhead_angle_deg, turn, _SCREWS_REACHED, True).values()
        return min(margin for margin, _ in margins) >= 0.0

    none, *turns = _turned(given)
    return not holds(none) and any(map(holds, turns))


@rule(
    at.drive.gearhead_angle_deg,
    "the least turn with which the heads of the gearheads' screws and their key clear the walls",
    "head_seats",
    _turn_helps,
)
def turn(given: BevelKnown) -> Found:
    return given.first(at.drive.gearhead_angle_deg, _turned(given), _SCREWS_REACHED)


NAMES = (
    common_rules.SCHEMA_VERSION,
    constant("inputs", REFERENCE.inputs, "one on each side of the guide", "the configuration"),
    constant("cables", REFERENCE.cables, "two for each input, on neighbouring steps", "the configuration"),
)
OWN = (
    constant(at.limits.fleet_angle_max_deg, 1.5, "usual limit for smooth pulleys", "fleet_angle"),
    constant(at.rope.dead_turns, 1.0, "one turn that never unwinds; its friction relieves the stop", "dead_turns"),
    constant(at.guide.material, "aluminium-7075", "light; the part is turned", "process"),
    constant(at.guide.axle_material, "steel", "made from ground bar", "process"),
)
RADII_RULES = (land_edge, transfer_gap, guide_to_drum, drum_radii, input_to_guide, surface, lead)
_SHELF = ("bearing_shelf", "walls", "hole_webs")
_PLATE = ("top_plate", "walls", "hole_webs", "engagement")
HEIGHTS = (
    _height("bearing_shelf_mm", "bearing and shoulder, and the axle's set screw", *_SHELF),
    _height("top_plate_mm", "bearing and shoulder, and the heads of screws", *_PLATE),
)
FRAME = (motor_shelf, *HEIGHTS, head_dims.coupling_space, side_wall, rib, back_plate)
DRUM = (
    output_screws,
    head_dims.shaft_bore,
    head_dims.hub,
    head_dims.WINDOWS,
    head_dims.web,
    sector,
    head_dims.stop_pin,
    head_dims.rim,
    outer_face,
)
RULES: tuple[Rule, ...] = (
    *(
        common_rules.half_travel,
        *NAMES,
        *head_basis.LIMITS,
        *OWN,
        *head_basis.METALS,
        head_basis.rope(_rope),
        *head_basis.ROPE_LIMITS,
        preload,
        *head_basis.TRAIN,
    ),
    *(*RADII_RULES, motor_side, setback, centre_distance, drum_bearing, *PARTS[1:], guide_bearing),
    *(*FRAME, head_dims.mount_screw(MOUNT_SCREWS), *DRUM, back, turn, hub_face),
)
DERIVED = tuple(
    one.field
    for one in (lead, land_edge, transfer_gap, *FRAME, *DRUM, setback, back, hub_face)
    if one not in (head_dims.WINDOWS, output_screws)
)
# A larger bearing of the drum has a wider boss, between whose walls the ribs of the column stand.
_BOSS = ("frame: column", "frame: boss", "drum's ")
STIFFENERS = (
    *(replace(one, causes=_BOSS) if one.field == at.drum.bearing else one for one in SHARED),
    bearing(at.guide.bearing, ("guide's ",)),
    *walls("back_plate", "rib", "side_wall"),
)
# A setback is changed by adding, since it is often zero: a factor of 2 means this many mm more.
SETBACK_MM = 20.0


def _steps(radii: Any, factor: float) -> Any:
    """Radii of the drum with larger or smaller steps; the first radius, a requirement, does not change."""
    first = radii[0]
    return [round(first + factor * (radius - first), 3) for radius in radii]


def _total_ratio(data: Mapping[str, Any]) -> dict[str, Any]:
    ratios = data["transmission"].get("ratios") or {}
    first, second = ratios.get("input_to_guide"), ratios.get("guide_to_drum")
    return {RATIO: round(first * second, 9)} if first and second else {}


def _further_back(setback_mm: float, factor: float) -> float:
    return round(setback_mm + SETBACK_MM * (factor - 1.0), 2)


# What ``mbcdm solve`` may change besides the derived dimensions.
FREEDOMS: tuple[Freedom, ...] = (
    *common_rules.DRIVE,
    Freedom(at.guide.bearing, kind="bearings", order="outer_diameter_mm"),
    *common_rules.INPUTS,
    common_rules.SURFACE,
    *common_rules.ENCODERS,
    *common_rules.METALS,
    Freedom(DISTANCE, 0.7, 2.5),
    Freedom(RADII, 0.8, 2.5, _steps, mends=((ALL_RADII, 1),), instead=common_rules.first_radius),
    Freedom(
        TO_DRUM, 0.4, 1.5, mends=(("transmission.ratios.input_to_guide", -1), (at.transmission.guide_radii_mm, -1))
    ),
    Freedom(at.transmission.ratios, instead=_total_ratio),
    Freedom(SETBACK, 1.0, 2.0, _further_back),
    Freedom(at.drive.motor_side, words=("below", "above")),
)


def _first_guesses(given: BevelKnown) -> dict[str, Any]:
    """Values of a drive of medium size, for fields that the first pass does not know yet."""
    first = given.drum_mm
    second, direct = 1.5, given.peek(at.drive.gearhead) == NO_GEARHEAD
    ratios = {"guide_to_drum": float(given.peek(RATIO) or 6.0) / second, "input_to_guide": second}
    return {
        **{field: value for field, value in GUESSES.items() if field != at.support.encoder_shelf_mm},
        RADII: given.radii_mm(4.0),
        **({at.transmission.ratios: ratios} if _needs_ratios(given) else {}),
        DISTANCE: max(first, given.get(SETBACK, 0.0) / MOST_SETBACK),
        SETBACK: 0.0,
        at.rope.helix_lead_mm: 1.0,
        **({at.drive.motor: min(given.motors_with_faces())} if direct else {}),
        at.guide.bearing: "618/4",
        at.drum.sector_half_angle_deg: 85.0,
        at.drum.rim_inner_radius_mm: 0.8 * first,
        at.drum.outer_face_y_mm: 25.0,
        at.drum.hub_face_y_mm: 35.0,
        at.support.back_plate_mm: 5.0,
        at.support.top_plate_mm: 4.0,
        at.support.rib_mm: 6.0,
        at.support.back_y_mm: -30.0,
    }


def _missing(given: BevelKnown) -> Iterator[Broken]:
    yield from common_rules.missing_travel(given, "travel from the centre to each side")
    if not given.has(at.loads.peak_torque_Nm):
        yield common_rules.needed(at.loads.peak_torque_Nm, "add peak_torque_Nm: 3.15 (torque to hold both ways, N m)")
    if not any(given.has(field) for field in (RADII, at.transmission.drum_radius_mm)):
        yield common_rules.needed(
            at.transmission.drum_radius_mm, "add drum_radius_mm: 54.0 (drum pitch radius of step 1)"
        )
    explicit = any(given.has(f"transmission.{body}_radii_mm") for body in ("guide", "input"))
    if explicit and not given.has(RADII):
        yield common_rules.needed(RADII, "add the drum's radii, as other pulleys' are given")


def _open_ratio(given: BevelKnown) -> str:
    both = given.has(TO_DRUM) and given.has("transmission.ratios.input_to_guide")
    return "" if given.has(RATIO) or given.has(at.transmission.input_radii_mm) or both else RATIO


size = SizingRules(BevelKnown, (), RULES, STIFFENERS, _first_guesses, _missing, _open_ratio)
