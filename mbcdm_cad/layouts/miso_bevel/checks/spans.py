"""Free spans between input pulleys and guide: distance, fleet angle, and gap between a span and its last turn."""

from __future__ import annotations

from math import cos, hypot, radians, sin, sqrt, tan, tau

import numpy as np

from mbcdm_cad.checks.cable_gaps import CABLE_GAP_MM
from mbcdm_cad.checks.comparison import Check, Comparison, at_least, at_most, noted, worst
from mbcdm_cad.checks.design_variables import down, up
from mbcdm_cad.checks.input_pulley import dead_turns_check
from mbcdm_cad.layouts.miso_bevel.cable_path import BLEND_DIAMETERS, fleet_angle_deg, guide_landing_walk_mm, winding
from mbcdm_cad.layouts.miso_bevel.drive import BevelDrive, BevelRun
from mbcdm_cad.layouts.miso_bevel.layout import BevelLayout
from mbcdm_cad.layouts.miso_bevel.pulleys import smallest_lead_mm
from mbcdm_cad.layouts.miso_bevel.stack import band, outward_of

# Least crest between two grooves, in rope diameters: a thinner one is a sharp edge that cuts the rope (estimate).
GROOVE_CREST = 0.05
# Newton steps to the point of a turn that is nearest to the span; five are enough to converge.
_NEWTON_STEPS = 6


def centre_distance(s: BevelLayout) -> Comparison:
    """L is larger than r_g + r_m, so that a straight span exists, with room for the curved transitions at both ends."""
    blends = 2 * BLEND_DIAMETERS * s.drive.cable.diameter_mm

    def reach(c: BevelRun) -> float:
        return float(np.hypot(c.guide_radius_mm + c.input_radius_mm, blends))

    return worst(
        at_least(
            f"centre distance for {c.name}",
            s.drive.centre_distance_mm,
            reach(c),
            "mm",
            f"r_g + r_m {c.guide_radius_mm + c.input_radius_mm:.4g} mm and a free span of {blends:.4g} mm",
        )
        for c in s.steps
    )


def pulley_gap(s: BevelLayout) -> Comparison:
    """Gap between guide and input pulleys with their cables, at any height."""
    d = s.drive.cable.diameter_mm
    guide, pulley = max(c.guide_radius_mm for c in s.steps), max(c.input_radius_mm for c in s.steps)
    return at_least(
        "gap between guide and input pulley, cables on both",
        s.drive.centre_distance_mm - guide - pulley - d,
        s.drive.clearances.running_mm,
        "mm",
    )


def fleet_angle(s: BevelLayout) -> Comparison:
    """Largest fleet angle at both ends of the travel."""
    s.levels  # noqa: B018 - without levels there is no winding
    limit = s.drive.fleet_angle_max_deg
    return worst(at_most(f"fleet angle of {c.name}", fleet_angle_deg(s.drive, c), limit, "deg") for c in s.steps)


def helix_lead(s: BevelLayout) -> Comparison:
    """The lead is larger than the cable's diameter, or than 2.065 groove radii if the turns lie in a groove."""
    return at_least("lead of the helix on the input pulleys", s.drive.helix_lead_mm, smallest_lead_mm(s.drive), "mm")


def straight_span_clearance_mm(drive: BevelDrive, cable: BevelRun) -> float:
    """Centre-line distance less d between the straight free span and its own previous turn, fully wound, mm.

    The span leaves helix and pulley at the contact point along the tangent and rises by the fleet angle over the
    previous turn. The rope's bending stiffness, which bends it away at first, is neglected. Negative: they overlap. For
    each angle of the previous turn the nearest point of the span is known in closed form; Newton's method finds the
    angle.
    """
    slope = tan(radians(fleet_angle_deg(drive, cable)))
    distance = straight_span_distance_mm(cable.input_radius_mm, drive.helix_lead_mm, slope)
    return distance - drive.cable.diameter_mm


def straight_span_distance_mm(radius_mm: float, lead_mm: float, slope: float) -> float:
    """Distance of the centre lines of a straight span that rises by ``slope`` and of the turn wound before it, mm."""
    lean = 1.0 + slope**2
    fall = -lead_mm / tau
    # At an angle of the turn, the distance squared is x^2 + w^2 / lean, with x outwards and w along the pulley's axis.
    # It has one minimum, a little behind the contact; as long as x grows with the square of the angle it lies here.
    angle = (2.0 * lead_mm * -_slant(fall, slope, radius_mm, 1.0) / (lean * radius_mm**2)) ** (1 / 3)
    for _ in range(_NEWTON_STEPS):
        sine, cosine = sin(angle), cos(angle)
        x, w = radius_mm * (1.0 - cosine), lead_mm + fall * angle - slope * radius_mm * sine
        rate = _slant(fall, slope, radius_mm, cosine)
        first = x * radius_mm * sine + w * rate / lean
        second = radius_mm * (radius_mm * sine**2 + x * cosine) + (rate**2 + w * slope * radius_mm * sine) / lean
        angle = angle - first / second
    w = lead_mm + fall * angle - slope * radius_mm * sin(angle)
    return hypot(radius_mm * (1.0 - cos(angle)), w / sqrt(lean))


def _slant(fall_mm: float, slope: float, radius_mm: float, cosine: float) -> float:
    """Rate at which the turn moves away from the span along the pulley's axis, mm/rad."""
    return fall_mm - slope * radius_mm * cosine


def self_clearance(s: BevelLayout) -> Comparison:
    """Gap between the free span and the turn that was wound just before it, with the cable fully wound on."""
    s.levels  # noqa: B018 - without levels there is no winding
    return worst(
        at_least(f"{c.name} from its own last turn, fully wound", straight_span_clearance_mm(s.drive, c), 0.0, "mm")
        for c in s.steps
    )


def input_walk(s: BevelLayout) -> Comparison:
    """The two cables of an input pulley walk along it over the travel without reaching the wall between their steps."""
    s.levels  # noqa: B018 - without levels there are no bands
    found = []
    for name in s.drive.input_names:
        low, high = (c for c in s.steps if c.input_name == name)
        bands = [band(s.drive, c, outward_of(s.drive, c)) for c in (low, high)]
        found.append(
            at_least(
                f"{name} input pulley: flanks of {low.name} and {high.name} from the wall between them",
                (bands[1].low_mm - bands[0].high_mm) / 2,
                CABLE_GAP_MM,
                "mm",
            )
        )
    return worst(found)


def guide_wall_gaps_mm(s: BevelLayout) -> list[tuple[BevelRun, float]]:
    """Gap of each cable's flank to the nearer wall of its step of the guide, at its widest walk."""
    walls, found = s.guide.walls_z, []
    for k, c in enumerate(s.steps):
        reach = guide_landing_walk_mm(s.drive, c) + s.flank_mm
        below = c.drum_radius_mm - reach - walls[k - 1] if k > 0 else np.inf
        above = walls[k] - c.drum_radius_mm - reach if k < len(walls) else np.inf
        found.append((c, float(min(below, above))))
    return found


def guide_walk(s: BevelLayout) -> Comparison:
    """The landing point on the guide moves with the walk on the input and does not reach the walls of its step."""
    return worst(
        at_least(f"{c.name} on the guide from its walls", gap, CABLE_GAP_MM, "mm")
        for c, gap in s.once("guide_walls", guide_wall_gaps_mm)
    )


def landing_angle(s: BevelLayout) -> Comparison:
    """Every cable lands on the guide before the transfer point, and less than a turn before it."""
    s.levels  # noqa: B018 - without levels there is no winding
    return worst(
        at_least(f"wrap of {c.name} on the guide", np.degrees(winding(s.drive, c).guide_wrap_rad), 1.0, "deg")
        for c in s.steps
    )


def groove_walls(s: BevelLayout) -> Comparison:
    """Width of the crest between neighbouring grooves of an input pulley, and from the last groove to the next step."""
    grooved = [(p, groove) for p in s.inputs for groove in p.grooves]
    if not grooved:
        return noted("no grooves: crest", 0.0, "mm")
    limit = GROOVE_CREST * s.drive.cable.diameter_mm
    found = []
    for p, groove in grooved:
        found.append(
            at_least(f"crest between grooves of {groove.cable_name}", groove.lead - 2 * groove.half_width, limit, "mm")
        )
        to_wall = abs(p.wall_z - groove.end_z) - groove.half_width
        found.append(at_least(f"groove of {groove.cable_name} from the step beside it", to_wall, limit, "mm"))
    return worst(found)


def _grooves(s: BevelLayout) -> str:
    """Advice to use grooved pulleys, if they alone are enough."""
    if s.drive.input_pulleys.grooved:
        return ""
    angle, limit = max(fleet_angle_deg(s.drive, c) for c in s.steps), s.drive.limits.fleet_angle_grooved_max_deg
    return f"set input_pulleys.surface: grooved, which allows {limit:g} deg" if angle <= limit else ""


_SHORTER_WALK = (up("transmission.centre_distance_mm"), down("rope.helix_lead_mm"), down("travel.half_angle_deg"))
CHECKS = (
    Check(
        "centre_distance",
        "Centre distance leaves a free span",
        "paper Eq. (11)",
        centre_distance,
        adjust=(up("transmission.centre_distance_mm"), down("all radii of transmission"), down("rope diameter_mm")),
    ),
    Check(
        "pulley_gap",
        "Guide and input pulleys clear each other",
        "clearances.running_mm",
        pulley_gap,
        adjust=(up("transmission.centre_distance_mm"), down("all radii of transmission")),
    ),
    Check(
        "guide_wrap",
        "Every cable wraps the guide",
        "derived from the figure-eight span; a degree: estimate",
        landing_angle,
        adjust=(down("all radii of transmission"), up("transmission.centre_distance_mm")),
    ),
    Check(
        "fleet_angle",
        "Fleet angle on the input pulleys",
        "limits.fleet_angle_max_deg; usual limit for smooth drums; for grooved: limits.fleet_angle_grooved_max_deg",
        fleet_angle,
        adjust=_SHORTER_WALK,
        advice=_grooves,
    ),
    Check(
        "helix_lead",
        "Turns on the input pulley lie side by side",
        "derived: lead > d; grooves: rope makers",
        helix_lead,
        adjust=(up("rope.helix_lead_mm"), down("rope diameter_mm")),
    ),
    Check(
        "groove_walls",
        "Crests between the grooves",
        "0.05 d: estimate",
        groove_walls,
        adjust=(up("rope.helix_lead_mm"), down("rope.helix_lead_mm"), down("travel.half_angle_deg")),
    ),
    Check(
        "self_clearance",
        "Free span clears its own last turn",
        "derived: straight span, no credit for the rope's stiffness",
        self_clearance,
        adjust=(up("rope.helix_lead_mm"), up("transmission.centre_distance_mm"), down("travel.half_angle_deg")),
    ),
    Check(
        "input_walk",
        "Axial walk fits the steps of the input pulleys",
        "derived; 0.1 mm: estimate",
        input_walk,
        adjust=(down("rope.helix_lead_mm"), down("travel.half_angle_deg"), up("all radii of transmission")),
    ),
    Check(
        "guide_walk",
        "Landing point's walk fits the steps of the guide",
        "derived; 0.1 mm: estimate",
        guide_walk,
        adjust=(down("rope.helix_lead_mm"), down("travel.half_angle_deg"), up("all radii of transmission")),
    ),
    dead_turns_check((up("rope.dead_turns"),)),
)
