"""Free spans between input pulleys and guide; and gaps against the sum of the tolerances of the parts.

A gap smaller than this sum may vanish in a built drive. Contributions are closed formulas, lengths in mm; with the
nominal margin they make a :class:`~mbcdm_cad.model.tolerance.StackUp`. Parts are assumed to be made to the fits of
:mod:`mbcdm_cad.parts.fits` and to the design's block ``making``. Run-out counts half its reading on each radius, play
half its size to either side; the drum's bearings have no play, because a spring presses them apart.
"""

from collections.abc import Iterator
from math import ceil, cos, hypot, radians, sin, sqrt, tan, tau

import numpy as np

from mbcdm_cad.checks.comparison import Comparison, Findings, at_least, at_most, check, noted, worst
from mbcdm_cad.checks.design_variables import down, up
from mbcdm_cad.checks.geometry import CABLE_GAP_MM
from mbcdm_cad.checks.input_pulley import dead_turns
from mbcdm_cad.checks.run import rounded
from mbcdm_cad.checks.transfer import Stacks, TransferStacks, ratio_contributions, transmission_error
from mbcdm_cad.design.paths import at
from mbcdm_cad.layouts.bevel_transfer import toleranced, transfer_stacks
from mbcdm_cad.layouts.miso_bevel.cable_path import BLEND_DIAMETERS, fleet_angle_deg, guide_landing_walk_mm, winding
from mbcdm_cad.layouts.miso_bevel.drive import BevelDrive, BevelRun
from mbcdm_cad.layouts.miso_bevel.layout import BevelLayout
from mbcdm_cad.layouts.miso_bevel.stack import band, smallest_lead_mm
from mbcdm_cad.model.tolerance import Contribution, StackUp, tightest
from mbcdm_cad.parts.drum_sector.design import END_PLAY_MM
from mbcdm_cad.parts.making import axial_play_mm, body_accuracy, land_band_mm, rope_band_mm

# Least crest between two grooves, in rope diameters: a thinner one is a sharp edge that cuts the rope (estimate).
GROOVE_CREST = 0.05
# Newton steps to the point of a turn that is nearest to the span; five are enough to converge.
_NEWTON_STEPS = 6


_SHORTER_WALK = (*up(at.transmission.centre_distance_mm), *down(at.rope.helix_lead_mm, at.travel.half_angle_deg))


@check(
    "Centre distance leaves a free span",
    "paper Eq. (11)",
    *up(at.transmission.centre_distance_mm),
    *down("all radii of transmission", "rope diameter_mm"),
)
def centre_distance(s: BevelLayout) -> Findings:
    """L is larger than r_g + r_m, so that a straight span exists, with room for the curved transitions at both ends."""
    blends = 2 * BLEND_DIAMETERS * s.drive.cable.diameter_mm

    def reach(c: BevelRun) -> float:
        return float(np.hypot(c.guide_radius_mm + c.input_radius_mm, blends))

    for c in s.steps:
        yield (
            f"centre distance for {c.name}",
            s.drive.centre_distance_mm,
            reach(c),
            f"r_g + r_m {c.guide_radius_mm + c.input_radius_mm:.4g} mm and a free span of {blends:.4g} mm",
        )


@check(
    "Guide and input pulleys clear each other",
    at.clearances.running_mm,
    *up(at.transmission.centre_distance_mm),
    *down("all radii of transmission"),
)
def pulley_gap(s: BevelLayout) -> Findings:
    """Gap between guide and input pulleys with their cables, at any height."""
    d = s.drive.cable.diameter_mm
    guide, pulley = max(c.guide_radius_mm for c in s.steps), max(c.input_radius_mm for c in s.steps)
    what = "gap between guide and input pulley, cables on both"
    yield (what, s.drive.centre_distance_mm - guide - pulley - d, s.drive.clearances.running_mm)


def _grooves(s: BevelLayout) -> str:
    """Advice to use grooved pulleys, if they alone are enough."""
    if s.drive.input_pulleys.grooved:
        return ""
    angle, limit = max(fleet_angle_deg(s.drive, c) for c in s.steps), s.drive.limits.fleet_angle_grooved_max_deg
    return f"set input_pulleys.surface: grooved, which allows {limit:g} deg" if angle <= limit else ""


@check(
    "Fleet angle on the input pulleys",
    "limits.fleet_angle_max_deg; usual limit for smooth drums; for grooved: limits.fleet_angle_grooved_max_deg",
    *_SHORTER_WALK,
    advice=_grooves,
)
def fleet_angle(s: BevelLayout) -> Comparison:
    """Largest fleet angle at both ends of the travel."""
    s.levels  # noqa: B018 - without levels there is no winding
    limit = s.drive.fleet_angle_max_deg
    return worst(at_most(f"fleet angle of {c.name}", fleet_angle_deg(s.drive, c), limit, "deg") for c in s.steps)


@check(
    "Turns on the input pulley lie side by side",
    "derived: lead > d; grooves: rope makers",
    *up(at.rope.helix_lead_mm),
    *down("rope diameter_mm"),
)
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


@check(
    "Free span clears its own last turn",
    "derived: straight span, no credit for the rope's stiffness",
    *up(at.rope.helix_lead_mm, at.transmission.centre_distance_mm),
    *down(at.travel.half_angle_deg),
)
def self_clearance(s: BevelLayout) -> Findings:
    """Gap between the free span and the turn that was wound just before it, with the cable fully wound on."""
    s.levels  # noqa: B018 - without levels there is no winding
    for c in s.steps:
        yield f"{c.name} from its own last turn, fully wound", straight_span_clearance_mm(s.drive, c), 0.0


@check(
    "Axial walk fits the steps of the input pulleys",
    "derived; 0.1 mm: estimate",
    *down(at.rope.helix_lead_mm, at.travel.half_angle_deg),
    *up("all radii of transmission"),
)
def input_walk(s: BevelLayout) -> Findings:
    """The two cables of an input pulley walk along it over the travel without reaching the wall between their steps."""
    s.levels  # noqa: B018 - without levels there are no bands
    for name in s.drive.input_names:
        low, high = (c for c in s.steps if c.input_name == name)
        bands = [band(s.drive, c) for c in (low, high)]
        what = f"{name} input pulley: flanks of {low.name} and {high.name} from the wall between them"
        yield (what, (bands[1].low_mm - bands[0].high_mm) / 2, CABLE_GAP_MM)


def guide_wall_gaps_mm(s: BevelLayout) -> list[tuple[BevelRun, float]]:
    """Gap of each cable's flank to the nearer wall of its step of the guide, at its widest walk."""
    walls, found = s.guide.walls_z, []
    for k, c in enumerate(s.steps):
        reach = guide_landing_walk_mm(s.drive, c) + s.flank_mm
        below = c.drum_radius_mm - reach - walls[k - 1] if k > 0 else np.inf
        above = walls[k] - c.drum_radius_mm - reach if k < len(walls) else np.inf
        found.append((c, float(min(below, above))))
    return found


@check(
    "Landing point's walk fits the steps of the guide",
    "derived; 0.1 mm: estimate",
    *down(at.rope.helix_lead_mm, at.travel.half_angle_deg),
    *up("all radii of transmission"),
)
def guide_walk(s: BevelLayout) -> Findings:
    """The landing point on the guide moves with the walk on the input and does not reach the walls of its step."""
    for c, gap in s.once("guide_walls", guide_wall_gaps_mm):
        yield f"{c.name} on the guide from its walls", gap, CABLE_GAP_MM


@check(
    "Every cable wraps the guide",
    "derived from the figure-eight span; a degree: estimate",
    *down("all radii of transmission"),
    *up(at.transmission.centre_distance_mm),
    unit="deg",
)
def guide_wrap(s: BevelLayout) -> Findings:
    """Every cable lands on the guide before the transfer point, and less than a turn before it."""
    s.levels  # noqa: B018 - without levels there is no winding
    for c in s.steps:
        yield f"wrap of {c.name} on the guide", np.degrees(winding(s.drive, c).guide_wrap_rad), 1.0


@check(
    "Crests between the grooves",
    "0.05 d: estimate",
    *up(at.rope.helix_lead_mm),
    *down(at.rope.helix_lead_mm, at.travel.half_angle_deg),
)
def groove_walls(s: BevelLayout) -> Findings:
    """Width of the crest between neighbouring grooves of an input pulley, and from the last groove to the next step."""
    grooved = [(p, groove) for p in s.inputs for groove in p.grooves]
    if not grooved:
        yield noted("no grooves: crest", 0.0, "mm")
        return
    limit = GROOVE_CREST * s.drive.cable.diameter_mm
    for p, groove in grooved:
        yield f"crest between grooves of {groove.cable_name}", groove.lead - 2 * groove.half_width, limit
        to_wall = abs(p.wall_z - groove.end_z) - groove.half_width
        yield f"groove of {groove.cable_name} from the step beside it", to_wall, limit


SPANS = (
    centre_distance,
    pulley_gap,
    guide_wrap,
    fleet_angle,
    helix_lead,
    groove_walls,
    self_clearance,
    input_walk,
    guide_walk,
    dead_turns.but(adjust=up(at.rope.dead_turns)),
)


_GUIDE = TransferStacks("guide", "axle in the frame")
# Least gain of the self-clearance for a longer lead: the span also leaves more steeply (derived, rounded down).
LEAD_GAIN = 0.85


def own_turn(s: BevelLayout) -> list[StackUp]:
    """Leaving span over its own last turn."""
    s.levels  # noqa: B018 - without levels there is no winding
    return [StackUp(f"{c.name} from its own last turn, mm", *last_turn_gap(s.drive, c)) for c in s.steps]


def flank_gap(s: BevelLayout) -> list[StackUp]:
    """Flanks on the drum from the wall of the next land."""
    lands = s.drum.lands
    return [
        StackUp(
            f"flank of {c.name} on the drum from the next land's wall, mm",
            above.y_start - c.guide_radius_mm - s.flank_mm,
            _GUIDE.contributions(s.drive, c, 1.0),
        )
        for c, above in zip(s.steps[:-1], lands[1:], strict=True)
    ]


def guide_gap(s: BevelLayout) -> list[StackUp]:
    """Cables on the guide from the walls of their steps."""
    return [
        StackUp(f"{c.name} on the guide from its walls, mm", gap, guide_wall_contributions(s.drive, c))
        for c, gap in s.once("guide_walls", guide_wall_gaps_mm)
    ]


_STACKS: tuple[Stacks, ...] = (own_turn, _GUIDE.gap, _GUIDE.bodies_clear, _GUIDE.land_edge, flank_gap, guide_gap)


def stacks(s: BevelLayout) -> Iterator[StackUp]:
    """The tightest stack of each gap, and that of each ratio, whose margin is the mismatch that a pair may have."""
    for of in _STACKS:
        yield tightest(of(s))
    yield tightest(
        StackUp(f"total ratio of {c.name}, relative", np.inf, ratio_contributions(s.drive, c)) for c in s.steps
    )


def _tighter(s: BevelLayout, found: Comparison) -> str:
    """The preload that is larger by what the loosest cable lacks."""
    most = max(c.preload_N for c in s.drive.cables)
    return (
        f"raise rope.preload_N to about {rounded(most * (1.0 - found.limit + found.actual), ceil)}, or turn the "
        "lands of the input pulleys to a closer fit"
    )


@check(
    "Cables of one input agree with tolerances",
    "root sum of squares of the radii's fits; no cable slack at the peak torque",
    advice_on=_tighter,
    warn=True,
)
def pair_mismatch_stack(s: BevelLayout) -> Comparison:
    """Tension that radii within their tolerances may cause in a pair of cables over the travel, from the model."""
    from mbcdm_cad.model.equilibrium import solve_equilibrium

    pairs = [[c for c in s.steps if c.input_name == name] for name in s.drive.input_names]
    found = [StackUp("", 0.0, pair_path_contributions(s.drive, (pair[0], pair[1]))) for pair in pairs]
    si, idle = s.loads.si, s.loads.idle
    # One pair at a time has an error: half its RSS on each of its cables, both longer or both shorter.
    path = np.array(
        [
            [stack.rss / 2e3 if c in pair else 0.0 for pair, stack in zip(pairs, found, strict=True)]
            for c in s.drive.cables
        ]
    )
    moved = solve_equilibrium(si, np.zeros(len(pairs)), path_m=path).tension_N
    change = np.abs(moved - idle[:, None]).max(axis=1)
    k = int(np.argmax(change / [c.preload_N for c in s.drive.cables]))
    cable = s.drive.cables[k]
    stack = found[s.drive.input_names.index(cable.input_name)]
    peak, left = s.drive.loads.peak_torque_Nm, []
    for angle in (s.half_travel_rad, -s.half_travel_rad):
        on_input, on_drum = s.wraps_rad(angle)
        wound = si.with_(input_wrap_rad=on_input, drum_wrap_rad=on_drum)
        left.append(solve_equilibrium(wound, np.array([peak, -peak])).tension_N.min(axis=1))
    spare = float((np.min(left, axis=0) / si.preload_N).min())
    return at_most(
        f"by radii within their tolerances (RSS {stack.rss:.3g} mm, worst case {stack.worst_case:.3g} mm) "
        f"{cable.name} changes by {change[k]:.3g} N over the travel:",
        change[k] / cable.preload_N,
        spare,
        "of T_pre",
        f"what the peak torque leaves in the loosest cable; largest share: {stack.costliest.name}",
    )


STACKS = (
    toleranced("self_clearance", "Free span clears its own last turn", own_turn, "raise rope.helix_lead_mm", LEAD_GAIN),
    *transfer_stacks(_GUIDE),
    toleranced(
        "flank",
        "Cables on the drum clear the next land",
        flank_gap,
        "lower clearances.land_edge_mm, or widen the steps of the guide's radii,",
    ),
    toleranced(
        "guide_walk", "Cables on the guide clear its walls", guide_gap, "widen half the steps of the drum's radii"
    ),
    pair_mismatch_stack,
    transmission_error,
)


_TURN_STEPS = 12


def guide_wall_contributions(drive: BevelDrive, cable: BevelRun) -> tuple[Contribution, ...]:
    """Contributions to the gap from a cable's flank to the walls of its step of the guide, along z."""
    drum, guide, frame = (body_accuracy(drive, part) for part in ("drum", "passed", "frame"))
    return (
        Contribution("radius of the drum's land", land_band_mm(drive, cable.drum_radius_mm, "drum")),
        Contribution("run-out of the drum", drum.run_out_mm, 0.5),
        Contribution("place of the guide's shelf over the drum's axis", frame.position_mm),
        Contribution("place of the walls on the guide", guide.position_mm),
        Contribution("axial play of the guide's bearings", axial_play_mm(drive), 0.5),
        # The centre line lies half a rope over the drum's surface, the flank half a rope beside it.
        Contribution("rope's diameter", rope_band_mm(drive), 1.0),
    )


def last_turn_gap(drive: BevelDrive, cable: BevelRun) -> tuple[float, tuple[Contribution, ...]]:
    """Gap of the leaving span to the turn wound before it, fully wound, and its contributions.

    Near the contact the previous turn lies r a^2/2 inside the tangent and lead - c a above the span, a the angle back
    from the contact, c = lead/2 pi + r tan(fleet angle): D^2 = (r a^2/2)^2 + (lead - c a)^2, least where r^2 a^3 = 2 c
    (lead - c a) (derived). At the minimum the change of a has no effect to first order. Raises ``ValueError`` if there
    is no free span.
    """
    r, lead = cable.input_radius_mm, drive.helix_lead_mm
    slope, span = tan(radians(fleet_angle_deg(drive, cable))), winding(drive, cable).free_span_mm
    c = lead / tau + r * slope
    a = (2.0 * c * lead / r**2) ** (1.0 / 3.0)
    for _ in range(_TURN_STEPS):
        a -= (r**2 * a**3 - 2.0 * c * (lead - c * a)) / (3.0 * r**2 * a**2 + 2.0 * c**2)
    above = lead - c * a
    distance = ((r * a**2 / 2.0) ** 2 + above**2) ** 0.5
    per_slope = -above * r * a / distance
    per_radius = (r * a**4 / 4.0 - above * slope * a) / distance
    pulley, guide, frame = (body_accuracy(drive, part) for part in ("pulley", "passed", "frame"))
    heights = 1.0 / span
    return distance - drive.cable.diameter_mm, (
        Contribution("rope's diameter", rope_band_mm(drive), per_radius / 2.0 - 1.0),
        Contribution("radius of the input pulley", land_band_mm(drive, r, "pulley"), per_radius),
        Contribution("run-out of the input pulley", pulley.run_out_mm, per_radius / 2.0),
        Contribution("end play of the input pulley", END_PLAY_MM, per_slope * heights / 2.0),
        Contribution("height of the guide's step over the pulley's", guide.position_mm, per_slope * heights),
        Contribution("centre distance", frame.position_mm, -per_slope * slope * drive.centre_distance_mm / span**2),
    )


def pair_path_contributions(drive: BevelDrive, pair: tuple[BevelRun, BevelRun]) -> tuple[Contribution, ...]:
    """Contributions to the length by which the two cables of an input differ at the end of travel.

    A cable's path changes by theta (dr_o - i dr_m). A thicker rope changes both radii by half of its excess, and the
    ratios of the pair by different shares since their radii differ.
    """
    half, shift = radians(drive.half_travel_deg), 0.0
    found: list[Contribution] = []
    for sign, c in zip((1.0, -1.0), pair, strict=True):
        ratio = c.drum_radius_mm / c.input_radius_mm
        found += [
            Contribution(f"drum radius of {c.name}", land_band_mm(drive, c.drum_radius_mm, "drum"), half),
            Contribution(f"input radius of {c.name}", land_band_mm(drive, c.input_radius_mm, "pulley"), half * ratio),
        ]
        shift += sign * half * (1.0 - ratio) / 2.0
    return (*found, Contribution("rope's diameter", rope_band_mm(drive), shift))
