"""Radii, and the cables on the input: load that friction holds, wrap that stays on it, axial walk of the turns.

Friction holds T_h / T_l <= e^(mu theta) over the whole wrap theta; if both sides are linear and equal, this is a
difference of 2 T_pre tanh(mu theta / 2) (derived). Above it the cable slips through. Below it each end of the wrap
creeps over the slip angle of its side. If a part in the middle sticks and stays on the input over the whole travel,
this creep does not accumulate. If the travel unwinds that part, the cable moves on a little in every cycle.
"""

from collections.abc import Iterator
from itertools import pairwise
from math import asin, ceil, cos, degrees, hypot, inf, log, sin, tau
from operator import attrgetter

import numpy as np

from mbcdm_cad.checks import geometry, input_pulley, terminals
from mbcdm_cad.checks.comparison import Comparison, Family, Findings, at_least, at_most, check, check_for, noted
from mbcdm_cad.checks.design_variables import down, up
from mbcdm_cad.checks.ratios import BENDING, SURFACE_TOLERANCE_MM, anchor_bend, surface_radius
from mbcdm_cad.checks.transfer import MORE_WRAP, SLIPS, WRAPS, stack_check, transmission_error, wrap_under_turn
from mbcdm_cad.design.paths import at
from mbcdm_cad.layouts.base import NoFigureError
from mbcdm_cad.layouts.siso_spur.cable_path import ON_INPUT
from mbcdm_cad.layouts.siso_spur.layout import SpurLayout
from mbcdm_cad.layouts.siso_spur.pulley import without_bearings
from mbcdm_cad.model.capability import torque_at_slip_Nm
from mbcdm_cad.model.si import ModelError
from mbcdm_cad.model.tolerance import Contribution, StackUp, tightest
from mbcdm_cad.parts.drum_sector.dims import WHOLE_DEG
from mbcdm_cad.parts.drum_sector.sizes import pocket_end_rad
from mbcdm_cad.parts.input_pulley.dims import GROOVE_LEAD, GROOVE_RADIUS
from mbcdm_cad.parts.making import axial_play_mm, body_accuracy, land_band_mm, rope_band_mm


@check(
    "Surfaces are cut half a cable inside the pitch radii",
    "derived from paper Table 2, which gives pitch radii",
    advice="the layout cuts at r - d/2; this fails only if that is changed",
)
def cut_at_pitch(s: SpurLayout) -> Findings:
    """The layout cuts every surface at the pitch radius less d/2."""
    drive = s.drive
    cut = [("input pulley", s.inputs[0].lower_surface_radius - drive.input_radius_mm)]
    cut += [(f"drum, {land.step}", land.surface_radius_mm - drive.drum_radius_mm) for land in s.drum.lands]
    for name, off in cut:
        yield at_most(
            f"surface of {name} from pitch radius less d/2", abs(off + s.flank_mm), SURFACE_TOLERANCE_MM, "mm"
        )


_IS_ANCHORED = attrgetter("anchored")
_RADII = (surface_radius, cut_at_pitch, *BENDING, anchor_bend.but(applies=_IS_ANCHORED))
_STOPS = (
    input_pulley.dead_turns.but(
        adjust=(*up(at.transmission.turns), *down(at.transmission.input_to_drum, at.travel.half_angle_deg))
    ),
    *input_pulley.STOPS,
)
PULLEY_FITS = (*(check.but(applies=_IS_ANCHORED) for check in _STOPS), *input_pulley.COUPLING)


# Largest fleet angle on a smooth pulley (rope makers); from a groove the cable leaves in line with it.
SMOOTH_FLEET_DEG = 1.5
# Least crest between two grooves, in rope diameters: a thinner one would be a burr that cuts the rope (estimate).
GROOVE_CREST = 0.05
# Least land beyond the cable's flank at the ends of its walk (estimate).
LAND_EDGE_MM = 0.3
# Pieces of a path on which a span runs that is not fixed to them: the turns on the input, wraps on idlers.
_WOUND = (ON_INPUT[0], "idler")


_LESS = (*up(at.rope.preload_N), *down(at.loads.peak_torque_Nm))
_LEAD = (*up(at.rope.helix_lead_mm), *down("rope diameter_mm"))


@check(
    "Centre distance leaves a free span",
    "paper Eq. (11)",
    *up(at.transmission.centre_distance_mm),
    *down("all radii of transmission"),
)
def free_span(s: SpurLayout) -> Comparison:
    """Centre distance compared with the sum of the pitch radii."""
    drive = s.drive
    reach = drive.drum_radius_mm + drive.input_radius_mm
    return at_least("centre distance over r_o + r_i", drive.centre_distance_mm - reach, geometry.CABLE_GAP_MM, "mm")


def _turns_that_hold(s: SpurLayout) -> str:
    """Remedy: the number of turns with which both checks of the wrap pass."""
    try:
        short = max(0.0, -input_sticks(s).margin)
        tension = max(float(np.max(t)) / max(float(np.min(t)), 1e-9) for t in (s.loads.peak_forward, s.loads.peak_back))
    except NoFigureError:
        return ""
    # Tensions at the slip margin, for linear sides.
    share = (tension - 1.0) / (tension + 1.0) * s.drive.limits.slip_margin_min
    if share >= 1.0:
        return "raise rope.preload_N: at this margin one side would be slack for any number of turns"
    wrap = log((1.0 + share) / (1.0 - share)) / s.drive.friction_coefficient
    more = max(short / 360.0, (wrap - s.drive.wrap_rad) / tau)
    return f"raise transmission.turns to {s.drive.turns + max(1, ceil(more))}"


_continuous_check = check_for(lambda drive: not drive.anchored)


@_continuous_check(
    "Friction holds the cable on the input",
    "T_h/T_l <= e^(mu theta); limits.slip_margin_min",
    *_LESS,
    advice=_turns_that_hold,
)
def input_slip(s: SpurLayout) -> Comparison:
    """Drum torque at which the cable slips on the input over the peak torque: lowest of all directions and ends.

    It depends on the wraps of the pose: a short wrap on the drum stretches less, so that the slackened side loses more
    tension.
    """
    drive, si = s.drive, s.loads.si
    ends = s.wraps_at_ends_rad
    try:
        holds = min(float(torque_at_slip_Nm(si, way, ends).min()) for way in (1, -1))
    except ModelError as error:
        raise NoFigureError(f"the model has no answer: {error}") from None
    peak = drive.loads.peak_torque_Nm
    theta, mu = drive.wrap_rad, drive.friction_coefficient
    note = (
        f"wrap {degrees(theta):.0f} deg, T_h/T_l up to {np.exp(min(mu * theta, 30.0)):.3g}; "
        f"{2 * drive.cables[0].preload_N * np.tanh(mu * theta / 2):.4g} N by 2 T_pre tanh(mu theta/2)"
    )
    what = f"cable slips on the input at {holds:.4g} N m of the drum, over the peak of {peak:g}"
    return at_least(what, holds / peak, drive.limits.slip_margin_min, "times", note)


def _slip_angles_deg(s: SpurLayout) -> float:
    """Sum of the slip angles at both ends of a wrap at peak torque, for the worst direction and cable."""
    preload, most = s.loads.si.preload_N, 0.0
    for tension in (s.loads.peak_forward, s.loads.peak_back):
        ratio = np.abs(np.log(np.maximum(tension, 1e-9) / preload))
        of_cables = [ratio[list(sides)].sum() for sides in s.loads.si.through_sides]
        most = max(most, float(max(of_cables)) / s.drive.friction_coefficient)
    return degrees(most)


@_continuous_check(
    "Part of the cable never leaves the input",
    "derived: otherwise the cable creeps on in every cycle",
    *down(at.travel.half_angle_deg),
    *up(at.rope.preload_N),
    advice=_turns_that_hold,
    warn=True,
)
def input_sticks(s: SpurLayout) -> Comparison:
    """Part of the wrap that neither creeps at peak torque nor leaves the input over the travel."""
    drive, creeping = s.drive, _slip_angles_deg(s)
    wrap, travel = degrees(drive.wrap_rad), degrees(drive.input_travel_rad)
    note = f"wrap {wrap:.0f}, less {travel:.0f} that the travel unwinds and {creeping:.0f} that creeps at peak torque"
    return at_least("wrap that sticks on the input over the whole travel", wrap - travel - creeping, 0.0, "deg", note)


@check("Turns lie side by side", "rope makers' tables for grooves", *_LEAD)
def helix_lead(s: SpurLayout) -> Comparison:
    """The lead is larger than the cable's diameter, or than 2.065 groove radii if the turns lie in a groove."""
    d = s.drive.cable.diameter_mm
    least = GROOVE_LEAD * GROOVE_RADIUS * d if s.drive.input_pulleys.grooved else d
    return at_least("lead of the helix on the input", s.drive.helix_lead_mm, least, "mm")


@check("Crests between the grooves", "0.05 d: estimate", *_LEAD, none=noted("no groove: crest", 0.0, "mm"))
def groove_crest(s: SpurLayout) -> Findings:
    """Crest between neighbouring turns of a groove, and between the grooves of two cables."""
    grooves = s.inputs[0].grooves
    limit = GROOVE_CREST * s.drive.cable.diameter_mm
    for g in grooves:
        yield "crest between turns", g.lead - 2 * g.half_width, limit
    for low, high in pairwise(grooves):
        between = min(high.start_z, high.end_z) - max(low.start_z, low.end_z) - low.half_width - high.half_width
        yield f"crest between {low.cable_name} and {high.cable_name}", between, limit


@check(
    "Walk of the cable stays on the input",
    "derived: lead x ratio x travel / 360 deg; 0.3 mm: estimate",
    *down(at.travel.half_angle_deg),
)
def input_walk(s: SpurLayout) -> Comparison:
    """The walk of both spans stays on the input's land."""
    pulley, drive = s.inputs[0], s.drive
    reach = (drive.dead_end_mm if drive.anchored else drive.leave_mm + drive.walk_mm / 2) + s.flank_mm
    room = min(pulley.land_top_z - drive.band_mm, -pulley.land_bottom_z) - reach
    note = f"{drive.helix_lead_mm:g} x {drive.total_ratio:.4g} x travel / 360 deg = {drive.walk_mm:.3g} mm of walk"
    return at_least("land of the input beyond the cable at the ends of its walk", room, LAND_EDGE_MM, "mm", note)


@_continuous_check(
    "Gap between both sides on the drum",
    "derived: N leads and the spans' slope; 0.1 mm: estimate",
    *up(at.transmission.turns, at.transmission.centre_distance_mm),
    *down(at.travel.half_angle_deg),
)
def land_spacing(s: SpurLayout) -> Comparison:
    """Gap along y between the parts of the drum that both sides use over the travel."""
    gap = 2 * (s.drive.land_mm - s.drive.walk_mm / 2) - s.drive.cable.diameter_mm
    return at_least("gap of the two sides on the drum, walk included", gap, geometry.CABLE_GAP_MM, "mm")


@check("The cable lies within the rim", at.clearances.land_edge_mm, *up(at.drum.outer_face_y_mm))
def rim_width(s: SpurLayout) -> Findings:
    """The cable's outermost planes lie inside the rim's faces."""
    lands, edge = s.drum.lands, s.drive.clearances.land_edge_mm
    plane = s.drive.on_drum_mm + s.flank_mm
    yield "rim's inner face beyond the cable", -plane - lands[0].y_start, edge
    yield "rim's outer face beyond the cable", lands[-1].y_end - plane, edge


@check(
    "Fleet angle at the input",
    "1.5 deg: rope makers",
    *down(at.rope.helix_lead_mm),
    *up("all radii of transmission"),
    advice="set input_pulleys.surface: grooved",
)
def fleet_angle(s: SpurLayout) -> Findings:
    """Spans against the turns on the input, and against the wraps on idlers: measured on the cable's path."""
    grooved = s.drive.input_pulleys.grooved
    for angle, path in ((angle, path) for angle, paths in s.extreme_paths for path in paths):
        joints = [(one, two, 0.0) for one, two in pairwise(path.pieces)]
        joints += [(two, one, 1.0) for one, two in pairwise(path.pieces)]
        for (free, span), (wound, wrap), end in joints:
            if not (free.startswith("span") and wound.startswith(_WOUND)):
                continue
            along = span.tangent(0.5)
            # By the sine, which is exact where both run the same way.
            off = asin(min(1.0, float(np.linalg.norm(np.cross(along, wrap.tangent(end))))))
            # On a smooth input only friction holds the turns at their helix angle.
            turned = off if grooved or wound != ON_INPUT[0] else float(np.arcsin(abs(along[1])))
            yield at_most(
                f"fleet angle with the drum at {degrees(angle):+.3g} deg", degrees(turned), SMOOTH_FLEET_DEG, "deg"
            )


def turn_distance_mm(radius_mm: float, lead_mm: float) -> float:
    """Least distance between the span, straight in line with its helix, and the turn wound before it, mm."""
    slope = lead_mm / (tau * radius_mm)
    angle = np.linspace(-0.5, 0.5, 2001)
    # The span starts at the contact, (0, 0, 0), along y; the turn before it lies one lead back along the axis.
    x, y, z = radius_mm * (1 - np.cos(angle)), radius_mm * np.sin(angle), -lead_mm + slope * radius_mm * angle
    along = np.maximum((y + slope * z) / (1 + slope**2), 0.0)
    return float(np.sqrt(x**2 + (along - y) ** 2 + (slope * along - z) ** 2).min())


@check("Spans clear the turns next to them", "derived", *_LEAD)
def self_clearance(s: SpurLayout) -> Comparison:
    """Gap between each span and the turn beside it on the input."""
    gap = turn_distance_mm(s.drive.input_radius_mm, s.drive.helix_lead_mm) - s.drive.cable.diameter_mm
    return at_least("span from the turn beside it", gap, 0.0, "mm")


_WINDING = (
    free_span,
    input_slip,
    input_sticks,
    helix_lead,
    groove_crest,
    self_clearance,
    input_walk,
    fleet_angle,
    land_spacing,
    geometry.cables_apart.but(
        source="derived: the spans converge; 0.1 mm: estimate",
        adjust=down(at.transmission.centre_distance_mm),
        applies=_IS_ANCHORED,
    ),
    rim_width,
)


FAMILIES = (
    Family("Radii: surfaces that can be machined, bend ratios that the rope allows.", _RADII),
    Family(
        "Cables on the input: load that friction holds, wrap that stays on the input, axial walk of the turns.",
        _WINDING,
    ),
)


def turn_gap(s: SpurLayout) -> list[StackUp]:
    """A span and the turn beside it on the input."""
    drive = s.drive
    gap = turn_distance_mm(drive.input_radius_mm, drive.helix_lead_mm) - drive.cable.diameter_mm
    return [
        StackUp(
            "span from the turn beside it, mm",
            gap,
            (
                # Half a rope on each side of the gap: together one diameter.
                Contribution("rope's diameter", rope_band_mm(drive)),
                Contribution("lead of the groove over a turn", body_accuracy(drive, "pulley").position_mm),
            ),
        )
    ]


def rim_edge(s: SpurLayout) -> list[StackUp]:
    """The cable on the drum and the nearer face of its rim."""
    drive = s.drive
    frame, drum = body_accuracy(drive, "frame"), body_accuracy(drive, "drum")
    plane, (low, *_, high) = drive.on_drum_mm + s.flank_mm, s.drum.lands
    return [
        StackUp(
            "flank of the cable from the rim's face, mm",
            min(-plane - low.y_start, high.y_end - plane),
            (
                Contribution("place of the input's bearings along y", frame.position_mm),
                Contribution("axial play of the input", axial_play_mm(drive), 0.5),
                Contribution("place of the drum's bearings in the frame", frame.position_mm),
                Contribution("place of the rim's face on the drum", drum.position_mm),
                Contribution("rope's diameter", rope_band_mm(drive), 0.5),
            ),
        )
    ]


def stacks(s: SpurLayout) -> Iterator[StackUp]:
    """The stack of each gap and of the ratio; of several, the one with the least reserve."""
    for of in (turn_gap, rim_edge):
        yield tightest(of(s))
    r_o, r_i = s.drive.drum_radius_mm, s.drive.input_radius_mm
    yield StackUp(
        "total ratio, relative",
        inf,
        (
            Contribution("drum radius", land_band_mm(s.drive, r_o, "drum"), 1.0 / r_o),
            Contribution("input radius", land_band_mm(s.drive, r_i, "pulley"), -1.0 / r_i),
            Contribution("rope's diameter", rope_band_mm(s.drive), (1.0 / r_o - 1.0 / r_i) / 2.0),
        ),
    )


_STACKS = (
    stack_check("turn_gap", "Turns stay apart with tolerances", turn_gap, "raise rope.helix_lead_mm"),
    stack_check(
        "rim_edge", "The cable stays within the rim with tolerances", rim_edge, "raise clearances.land_edge_mm"
    ),
    transmission_error,
)


@check("Terminals clear the input at the ends of travel", "clearances.running_mm", *MORE_WRAP)
def terminal_clears_input(s: SpurLayout) -> Findings:
    """Gap of the terminals to the input and its yoke at the end of travel where they come nearest."""
    drive, f = s.drive, s.frame
    reach = max(s.inputs[0].lower_land_radius, drive.input_radius_mm + s.flank_mm)
    if drive.whole_drum:
        yield from _come_by(s, max(reach, without_bearings(drive).hub_radius_mm) if drive.overhung else reach)
        return
    for t in s.drum.tensioners:
        turn = -t.side * s.half_travel_rad
        c, sine = cos(turn), sin(turn)
        for name, outline, _, _ in terminals.bodies_of(s, t):
            gaps = []
            for x, z in outline.tolist():
                # About Y from Z towards X, as the drum turns.
                at_x, at_z = x * c + z * sine, z * c - x * sine
                pulley = hypot(at_x, at_z - drive.centre_distance_mm) - reach
                yoke = max(abs(at_x) - f.shelf_half_width, f.shelf_bottom_z - at_z)
                gaps.append(min(pulley, yoke))
            what = f"{name} of {t.cable_name} from the input and its yoke at the end of travel"
            yield what, min(gaps), drive.clearances.running_mm


def _come_by(s: SpurLayout, reach_mm: float) -> Findings:
    """The gap of terminals that come by the input, whatever their plane; that ends ``reach_mm`` from its axis."""
    drive, f = s.drive, s.frame
    end = drive.centre_distance_mm - reach_mm
    if not drive.overhung:
        end = min(end, f.shelf_bottom_z)
    for t in s.drum.tensioners:
        for name, outline, _, _ in terminals.bodies_of(s, t):
            gap = end - float(np.hypot(*outline.T).max())
            what = f"{name} of {t.cable_name} from the input and its yoke as it comes by"
            yield what, gap, drive.clearances.running_mm


@check(
    "Turns on a whole drum lie clear of each other and of the terminals",
    "derived: lead x ratio; material: min_wall_mm",
    *up("rope.helix_lead_mm"),
    advice="choose a smaller drum.tensioner",
    applies=lambda drive: drive.whole_drum,
)
def turns_on_drum(s: SpurLayout) -> Findings:
    """Turns of a cable on a whole drum beside each other, and beside the pocket of its terminal.

    The helix on the drum has the slope of the turns on the input: its lead is theirs times the ratio. A terminal lies
    where the helix ends, a turn further than the cable beside it.
    """
    drive, d = s.drive, s.drum
    lead, wall = drive.helix_lead_mm * drive.total_ratio, drive.drum_material.min_wall_mm
    yield "lead of the helix on the drum over the cable", lead - 2 * s.flank_mm, geometry.CABLE_GAP_MM
    for t in d.tensioners:
        gap = drive.turn_beside_mm(pocket_end_rad(t)) - d.nut_pocket
        if gap < inf:
            yield f"pocket of {t.cable_name} from its turn beside it", gap, wall
        yield f"pocket of {t.cable_name} from the middle", abs(t.y_mm) - d.nut_pocket, wall / 2


@check("A drum without a stop", "derived: a pin stops it up to 165 deg", applies=lambda drive: not drive.stopped)
def no_stop(s: SpurLayout) -> Comparison:
    """Angle from the centre at which the drum must be stopped by something else."""
    end = s.drive.half_travel_deg + s.drive.stop_clearance_deg
    return noted("no stop on the drum: what it turns, or the stage behind it, must stop it before", end, "deg")


def _whole_drum(s: SpurLayout) -> str:
    return (
        "" if s.drive.anchored or s.drive.idlers else f"set drum.sector_half_angle_deg to {WHOLE_DEG:g}: a whole drum"
    )


_WRAPS = (
    *(
        check.but(applies=lambda drive: not drive.whole_drum, advice=_whole_drum) if check is wrap_under_turn else check
        for check in WRAPS
    ),
    turns_on_drum,
    no_stop,
    terminal_clears_input,
    *SLIPS,
)


ON_DRUM = (
    Family("Gaps of the winding compared with the tolerances of the parts, and the transmission error.", _STACKS),
    Family(
        "Wrap on the drum over the travel: more than zero, less than a turn, clear of the input, compared "
        "with the slip zones.",
        _WRAPS,
    ),
)
