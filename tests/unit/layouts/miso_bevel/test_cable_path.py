"""Cables of the reference and of random designs: figures, tangency by independent construction, smooth joints."""

from dataclasses import asdict, replace
from itertools import pairwise
from math import asin, atan2, cos, degrees, hypot, pi, radians, sin, sqrt, tau

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from mbcdm_cad.layouts.bevel_transfer import TravelFigures, terminal_gap_mm
from mbcdm_cad.layouts.miso_bevel.cable_path import (
    axial_walk_mm,
    cable_path,
    fleet_angle_deg,
    guide_landing_walk_mm,
    stop_of,
    winding,
)
from mbcdm_cad.layouts.miso_bevel.drive import BevelDrive, BevelRun
from mbcdm_cad.layouts.miso_bevel.layout import BevelLayout
from mbcdm_cad.layouts.miso_bevel.path_figures import path_figures, plan
from mbcdm_cad.layouts.miso_bevel.stack import band
from mbcdm_cad.model.tensioning import balanced_tension_N
from mbcdm_cad.routes.curves import Arc, Helix, Line
from tests.support.sliced_cables import self_clearance_mm

from .designs import drives, mirrored, reference

# name, landing on the guide, wrap on the guide, sense there, free span, fleet angle: derived from Table 2, p = 0.87.
ROUTING = [
    ("cable_1", 115.7, 25.7, -1, 31.18, 1.40),
    ("cable_2", 242.5, 207.5, +1, 30.68, 1.42),
    ("cable_3", 60.6, 29.4, +1, 30.14, 1.45),
    ("cable_4", 301.3, 211.3, -1, 29.55, 1.48),
]


@pytest.mark.parametrize(("name", "landing", "wrap", "sense", "span", "fleet"), ROUTING)
def test_routing_as_derived_from_the_tables(
    drive: BevelDrive, name: str, landing: float, wrap: float, sense: int, span: float, fleet: float
) -> None:
    cable = next(c for c in drive.cables if c.name == name)
    w = winding(drive, cable)
    assert degrees(w.guide_landing_rad) == pytest.approx(landing, abs=0.06)
    assert degrees(w.guide_wrap_rad) == pytest.approx(wrap, abs=0.06)
    assert w.guide_sense == sense
    assert w.free_span_mm == pytest.approx(span, abs=0.006)
    assert fleet_angle_deg(drive, cable) == pytest.approx(fleet, abs=0.006)


def crossing_tangent(drive: BevelDrive, cable: BevelRun) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Points of tangency on pulley and guide, by the centre of similitude: every crossed tangent passes through it."""
    pulley = np.array([cable.input_side * drive.centre_distance_mm, 0.0])
    r_m, r_g = cable.input_radius_mm, cable.guide_radius_mm
    cross = pulley * r_g / (r_g + r_m)
    half = asin(r_g / float(np.linalg.norm(cross)))
    best = None
    for sign in (1, -1):
        line = pulley / np.linalg.norm(pulley)
        line = np.array([[cos(half), -sign * sin(half)], [sign * sin(half), cos(half)]]) @ line
        on_guide = cross - line * sqrt(float(cross @ cross) - r_g**2)
        on_pulley = cross + line * sqrt(float((pulley - cross) @ (pulley - cross)) - r_m**2)
        # Followed towards the drum the cable ends at the guide's +y point, moving towards drum_side.
        turn = on_guide[0] * -line[1] - on_guide[1] * -line[0]
        if np.sign(turn) == -cable.drum_side:
            best = on_pulley, on_guide
    assert best is not None
    return best


def test_tangent_points_by_the_centre_of_similitude(drive: BevelDrive, dims: BevelLayout) -> None:
    for path in dims.cable_paths(0.0):
        on_pulley, on_guide = crossing_tangent(drive, path.cable)
        contact = path.piece("helix").points(np.array([1.0]))[0][:2]
        landing = path.piece("guide").points(np.array([0.0]))[0][:2]
        assert np.abs(contact - on_pulley).max() < 1e-12, f"{path.cable.name}: {contact} against {on_pulley}"
        assert np.abs(landing - on_guide).max() < 1e-12, f"{path.cable.name}: {landing} against {on_guide}"


def test_transfer_points_lie_on_one_line_through_the_apex(drive: BevelDrive, dims: BevelLayout) -> None:
    """(0, r_g, r_o), reached and left along x."""
    for path in dims.cable_paths(0.3):
        guide, drum = path.piece("guide"), path.piece("drum")
        transfer = guide.points(np.array([1.0]))[0]
        c = path.cable
        assert transfer == pytest.approx((0.0, c.guide_radius_mm, c.drum_radius_mm), abs=1e-12)
        assert guide.tangent(1.0) == pytest.approx((c.drum_side, 0.0, 0.0), abs=1e-12)
        assert drum.points(np.array([0.0]))[0] == pytest.approx(transfer, abs=1e-12)
        ratio = c.drum_radius_mm / c.guide_radius_mm
        assert ratio == pytest.approx(drive.cables[0].drum_radius_mm / drive.cables[0].guide_radius_mm, rel=1e-12)


@pytest.mark.parametrize("angle_deg", [-35.0, -12.5, 0.0, 20.0, 35.0])
def test_no_gap_and_no_kink_at_any_joint(dims: BevelLayout, angle_deg: float) -> None:
    for path in dims.cable_paths(radians(angle_deg)):
        for (before, a), (after, b) in pairwise(path.pieces):
            gap = np.abs(a.points(np.array([1.0]))[0] - b.points(np.array([0.0]))[0]).max()
            kink = np.linalg.norm(a.tangent(1.0) - b.tangent(0.0))
            assert gap < 1e-12, f"{path.cable.name}, {before} to {after}: gap {gap:.3g} mm"
            assert kink < 1e-9, f"{path.cable.name}, {before} to {after}: kink {kink:.3g} rad"


def test_tension_turns_the_drum_by_sigma(dims: BevelLayout) -> None:
    """Moment about Y of a pull along the cable, from the drum back to the guide, at the transfer."""
    for path in dims.cable_paths(0.0):
        drum = path.piece("drum")
        at, pull = drum.points(np.array([0.0]))[0], -drum.tangent(0.0)
        assert np.sign(np.cross(at, pull)[1]) == path.cable.sense, path.cable.name


@pytest.mark.parametrize("angle_deg", [-35.0, -17.0, 0.0, 35.0])
def test_piece_ends_follow_the_drum_and_the_pulley(drive: BevelDrive, dims: BevelLayout, angle_deg: float) -> None:
    """In the pulley's own frame the winding is one fixed helix; the drum's wrap ends at the moving anchor."""
    theta = radians(angle_deg)
    centred = {p.cable.name: p for p in dims.cable_paths(0.0)}
    anchors = {t.cable_name: t for t in dims.drum.tensioners}
    for path in dims.cable_paths(theta):
        c, helix, rest = path.cable, path.piece("helix"), centred[path.cable.name].piece("helix")
        assert isinstance(helix, Helix) and isinstance(rest, Helix)
        turn = theta * c.drum_radius_mm / c.input_radius_mm
        assert helix.angle_start - turn == pytest.approx(rest.angle_start, abs=1e-12)
        assert helix.z_start == pytest.approx(rest.z_start, abs=1e-12)
        climb = (helix.z_end - helix.z_start) / (helix.angle_end - helix.angle_start)
        assert climb == pytest.approx((rest.z_end - rest.z_start) / (rest.angle_end - rest.angle_start), rel=1e-12)
        drum = path.piece("drum")
        assert isinstance(drum, Arc)
        assert drum.angle_end == pytest.approx(anchors[c.name].anchor_rad + c.drum_side * theta, abs=1e-14)


def test_dead_turns_are_left_at_the_unwound_end(drive: BevelDrive, dims: BevelLayout) -> None:
    half = radians(drive.half_travel_deg)
    for side in (-half, half):
        for path in dims.cable_paths(side):
            helix = path.piece("helix")
            assert isinstance(helix, Helix)
            turns = abs(helix.angle_end - helix.angle_start) / tau
            live = 2 * half * path.cable.drum_radius_mm / path.cable.input_radius_mm / tau
            assert live == pytest.approx(1.75, abs=1e-12)
            unwound = path.cable.drum_side * side > 0
            assert turns == pytest.approx(drive.dead_turns + (0.0 if unwound else live), abs=1e-12)


def chords(path_points: NDArray[np.float64]) -> float:
    return float(np.linalg.norm(np.diff(path_points, axis=0), axis=1).sum())


@pytest.mark.parametrize("angle_deg", [-35.0, 0.0, 35.0])
def test_length_is_that_of_fine_chords(dims: BevelLayout, angle_deg: float) -> None:
    for path in dims.cable_paths(radians(angle_deg)):
        fine, coarse = chords(path.sample(0.002)), chords(path.sample(0.004))
        limit = fine + (fine - coarse) / 3
        assert abs(path.length_mm - limit) < 1e-7, f"{path.cable.name}: {path.length_mm} against {limit} mm"


def span_length(span: float, helix_slope: float, rise: float, blend: float) -> float:
    """Span developed into its plane: the slope runs evenly from the helix's to the chord's and on to zero."""
    slope = (rise - helix_slope * blend / 2) / (span - blend)
    x, w = np.polynomial.legendre.leggauss(40)
    f = (x + 1) / 2

    def parabola(first: float, last: float) -> float:
        return float(blend * np.sum(w / 2 * np.hypot(1.0, first + (last - first) * f)))

    return parabola(helix_slope, slope) + (span - 2 * blend) * hypot(1.0, slope) + parabola(slope, 0.0)


def test_a_cable_keeps_its_length_but_for_the_helix_and_the_fleet_angle(drive: BevelDrive, dims: BevelLayout) -> None:
    """What the drum takes up the pulley gives, r_o theta; a helix takes a hair more, and so does the span's slope."""
    centred = {p.cable.name: p.length_mm for p in dims.cable_paths(0.0)}
    lead, worst = drive.helix_lead_mm, 0.0
    for theta in np.linspace(-1, 1, 9) * radians(drive.half_travel_deg):
        for path in dims.cable_paths(float(theta)):
            c = path.cable
            unrolled = c.drum_side * theta * c.drum_radius_mm
            r, w = c.input_radius_mm, winding(drive, c)
            per_arc = hypot(r, lead / tau) / r
            spans = [
                span_length(w.free_span_mm, -lead / (tau * r), -angle / r * lead / tau, 2.5 * drive.cable.diameter_mm)
                for angle in (unrolled, 0.0)
            ]
            expected = unrolled * (1 - per_arc) + spans[0] - spans[1]
            change = path.length_mm - centred[c.name]
            worst = max(worst, abs(change))
            assert abs(change - expected) < 1e-9, (
                f"{c.name} at {theta:.3f} rad: {change:.6f}, expected {expected:.6f} mm"
            )
    assert 0.015 < worst < 0.025, f"over the travel a cable strains by {worst:.4f} mm; 0.019 by hand"


def test_walk_is_the_lead_times_the_turns(drive: BevelDrive) -> None:
    """p i_c theta / 2 pi: 0.87 x 9 x 35/360 = 0.761 mm, opposite at both ends, outward where the cable is wound on."""
    for c in drive.cables:
        end = radians(drive.half_travel_deg)
        walk = axial_walk_mm(drive, c, -c.drum_side * end)
        assert walk == pytest.approx(0.87 * 9 * 35 / 360, rel=1e-12)
        assert axial_walk_mm(drive, c, c.drum_side * end) == -walk


def test_band_on_the_input_pulley(drive: BevelDrive) -> None:
    """-1.17 mm inward, +2.04 mm outward of the step plane."""
    for c in drive.cables:
        outward, limits = winding(drive, c).outward, band(drive, c)
        edges = sorted(outward * (z - c.drum_radius_mm) for z in (limits.low_mm, limits.high_mm))
        assert edges == pytest.approx([-1.17, 2.04], abs=0.006), f"{c.name}: {edges}"


def lag(drive: BevelDrive, cable: BevelRun, steps: int) -> float:
    """dz/ds = (w - z)/L_free integrated by small steps over one sweep that draws cable onto the drum."""
    w = winding(drive, cable)
    amplitude = axial_walk_mm(drive, cable, -cable.drum_side * radians(drive.half_travel_deg))
    stroke = 2 * cable.drum_radius_mm * radians(drive.half_travel_deg)
    z, worst, ds = 0.0, 0.0, stroke / steps
    for k in range(steps):
        target = amplitude * (1 - 2 * (k + 0.5) / steps)
        z += (target - z) * ds / w.free_span_mm
        worst = max(worst, abs(z))
    return worst


def test_landing_point_walks_with_the_span_as_space_constant(drive: BevelDrive) -> None:
    figures = [guide_landing_walk_mm(drive, c) for c in drive.cables]
    assert min(figures) > 0.22 and max(figures) < 0.29, f"{figures}; mechanism: 0.22 to 0.28 mm"
    for c, figure in zip(drive.cables, figures, strict=True):
        assert figure == pytest.approx(lag(drive, c, 20000), abs=2e-4), c.name


def straight_span_clearance(drive: BevelDrive, cable: BevelRun) -> float:
    """Self-clearance at the wound end of a span that leaves the helix with a kink, by brute force."""
    r, lead, w = cable.input_radius_mm, drive.helix_lead_mm, winding(drive, cable)
    walk = axial_walk_mm(drive, cable, -cable.drum_side * radians(drive.half_travel_deg))
    a = np.linspace(0.5 * pi, 3.0 * pi, 20001)
    turn = np.stack([r * np.cos(a), r * np.sin(a), lead * a / tau], axis=1)
    s = np.linspace(0.0, 6.0, 301)
    span = np.stack([np.full_like(s, r), -s, s * walk / w.free_span_mm], axis=1)
    gaps = [np.linalg.norm(turn - p, axis=1).min() for p in span]
    return float(min(gaps)) - drive.cable.diameter_mm


def test_self_clearance_at_the_wound_end(drive: BevelDrive) -> None:
    """0.009 mm for a span that kinks; the rope's stiffness rounds the kink and leaves more."""
    kinked = [straight_span_clearance(drive, c) for c in drive.cables]
    assert min(kinked) == pytest.approx(0.009, abs=0.003), f"{kinked}"
    for c, least in zip(drive.cables, kinked, strict=True):
        rounded = self_clearance_mm(drive, c, -c.drum_side * radians(drive.half_travel_deg))
        assert least < rounded < drive.helix_lead_mm - drive.cable.diameter_mm, f"{c.name}: {rounded} mm"


def test_the_stop_sits_inside_the_land(drive: BevelDrive) -> None:
    """Bend tangent to the land, chord inside it by stop and wall; the stop ends on the chord where it is said to."""
    for c in drive.cables:
        g, d = stop_of(drive, c), drive.cable.diameter_mm
        assert g.bend_radius_mm + g.stop_radius_mm < c.input_radius_mm - d / 2 - 0.5
        corner = hypot(g.chord_offset_mm + g.stop_radius_mm, g.stop_start_mm)
        assert corner < c.input_radius_mm - d / 2 - 0.4, f"{c.name}: stop's corner at {corner:.3f} mm"
        path = cable_path(drive, c, 1.0, 3.0, 0.0)
        chord, bend = path.piece("chord"), path.piece("bend")
        assert isinstance(chord, Line) and isinstance(bend, Arc)
        axis = np.array([c.input_side * drive.centre_distance_mm, 0.0])
        # The chord runs at the bend's radius (in plan, less the slope's cosine) past the pulley's axis.
        start, along = np.array(chord.start[:2]) - axis, chord.tangent(0.0)[:2]
        distance = abs(start[0] * along[1] - start[1] * along[0]) / np.linalg.norm(along)
        assert distance == pytest.approx(g.chord_offset_mm, abs=1e-12)
        assert start @ along == pytest.approx(g.stop_end_mm, abs=1e-9)


def test_pulleys_that_overlap_are_refused_with_a_sentence(drive: BevelDrive) -> None:
    with pytest.raises(ValueError, match=r"centre distance 18.0 mm must exceed r_g \+ r_m = 18.0 mm for cable_4"):
        winding(replace(drive, centre_distance_mm=18.0), drive.cables[3])


@pytest.fixture(scope="module")
def figures(dims: BevelLayout) -> TravelFigures:
    return path_figures(dims)


def test_tangent_points_lie_on_their_pulleys(drive: BevelDrive, figures: TravelFigures) -> None:
    for run, c in zip(drive.cables, figures.cables, strict=True):
        x, y, _ = c.input_contact_mm
        assert hypot(x - run.input_side * drive.centre_distance_mm, y) == pytest.approx(run.input_radius_mm)
        assert hypot(*c.guide_landing_mm[:2]) == pytest.approx(run.guide_radius_mm)
        assert c.transfer_mm == pytest.approx((0.0, run.guide_radius_mm, run.drum_radius_mm), abs=1e-9)
        assert hypot(c.drum_leaving_mm[0], c.drum_leaving_mm[2]) == pytest.approx(run.drum_radius_mm)
        plan = np.subtract(c.guide_landing_mm, c.input_contact_mm)[:2]
        assert float(np.linalg.norm(plan)) == pytest.approx(c.free_span_mm), (
            f"{c.name}: the span's plan view is Eq. (11)"
        )


def test_wraps_turn_as_the_ratios_say(drive: BevelDrive, figures: TravelFigures) -> None:
    travel = figures.drum_angle_deg[-1] - figures.drum_angle_deg[0]
    assert travel == pytest.approx(2 * drive.half_travel_deg)
    for run, c in zip(drive.cables, figures.cables, strict=True):
        assert c.drum_wrap_deg[-1] - c.drum_wrap_deg[0] == pytest.approx(run.drum_side * travel)
        turned = c.input_wrap_deg[-1] - c.input_wrap_deg[0]
        assert turned == pytest.approx(-run.drum_side * travel * run.drum_radius_mm / run.input_radius_mm)
        assert min(c.input_wrap_deg) == pytest.approx(360 * drive.dead_turns)


def test_walk_and_fleet_angle_along_the_travel(drive: BevelDrive, figures: TravelFigures) -> None:
    for run, c in zip(drive.cables, figures.cables, strict=True):
        turned = np.array(figures.drum_angle_deg) * run.drum_radius_mm / run.input_radius_mm / 360
        assert np.abs(c.axial_walk_mm) == pytest.approx(np.abs(turned) * drive.helix_lead_mm)
        slope = [degrees(atan2(walk, c.free_span_mm)) for walk in c.axial_walk_mm]
        assert c.fleet_angle_deg == pytest.approx(slope)


def test_lengths_change_by_helix_and_fleet_angle(drive: BevelDrive, figures: TravelFigures) -> None:
    """What is odd in the angle is the helix longer than its circle; what is even, the slanted span: walk^2/2L.

    The short parabolas that join the slopes add some per cent.
    """
    for run, c in zip(drive.cables, figures.cables, strict=True):
        odd = (c.length_um[-1] - c.length_um[0]) / 2
        even = (c.length_um[-1] + c.length_um[0]) / 2
        turned = run.drum_radius_mm / run.input_radius_mm * radians(drive.half_travel_deg)
        longer = hypot(run.input_radius_mm, drive.helix_lead_mm / tau) - run.input_radius_mm
        assert odd == pytest.approx(-run.drum_side * turned * longer * 1e3, rel=0.1), f"{c.name}: {odd:.3f} um"
        slanted = max(c.axial_walk_mm) ** 2 / (2 * c.free_span_mm) * 1e3
        assert even == pytest.approx(slanted, rel=0.15), f"{c.name}: {even:.3f} um, {slanted:.3f} by the slant"


def test_usable_travel_ends_at_the_nearest_limit(figures: TravelFigures) -> None:
    for limits, end in ((figures.limits_positive, 1), (figures.limits_negative, 0)):
        angles = [abs(limit.angle_deg) for limit in limits]
        assert angles == sorted(angles) and abs(figures.usable_deg[end]) == angles[0]
    assert figures.limits_positive[0].cause == figures.limits_negative[0].cause == "hard stop"
    assert figures.usable_deg == pytest.approx((-35.25, 35.25))


def test_another_limit_takes_over_when_it_is_drawn_in(drive: BevelDrive) -> None:
    strict = replace(drive, limits=replace(drive.limits, fleet_angle_max_deg=1.0))
    shorter = path_figures(BevelLayout(strict))
    assert shorter.limits_positive[0].cause == "fleet angle of cable_4 reaches 1 deg"
    ends = shorter.usable_deg
    assert ends == pytest.approx((-23.7, 23.7), abs=0.1), ends


def test_limits_are_where_they_are_said_to_be(dims: BevelLayout, figures: TravelFigures) -> None:
    """Each kind put to the test at its own angle."""
    drive = dims.drive
    terminals = {t.cable_name: t for t in dims.drum.tensioners}
    by_name = {run.name: run for run in drive.cables}
    kinds = set()
    for limit in (*figures.limits_positive, *figures.limits_negative):
        angle = radians(limit.angle_deg)
        run = next((run for name, run in by_name.items() if name in limit.cause), None)
        if run is None:
            continue
        terminal, w = terminals[run.name], winding(drive, run)
        wrap = terminal.anchor_rad + run.drum_side * angle
        kind = limit.cause.replace(run.name, "")
        kinds.add(kind)
        if "on the drum ends" in kind:
            assert wrap == pytest.approx(0.0, abs=1e-12)
        elif "meets the guide" in kind:
            assert terminal_gap_mm(dims, terminal, wrap) == pytest.approx(drive.clearances.running_mm)
        elif "comes round" in kind:
            assert wrap + atan2(terminal.last_tip, terminal.radius_mm) == pytest.approx(tau)
        elif "dead turns" in kind:
            wound = tau * drive.dead_turns + w.reduction * (radians(drive.half_travel_deg) - run.drum_side * angle)
            assert wound == pytest.approx(0.0, abs=1e-9)
        else:
            path = cable_path(drive, run, pi, 1.0, angle)
            rise = path.piece("helix").points(np.array([1.0]))[0][2] - run.drum_radius_mm
            assert degrees(atan2(abs(rise), w.free_span_mm)) == pytest.approx(drive.limits.fleet_angle_max_deg)
    assert len(kinds) == 5, kinds


# The tensioning plan if one cable has another preload than the others.


@pytest.mark.parametrize("apart", [0, 1, 2, 3])
def test_one_cable_at_50_N_is_set_where_the_drum_comes_to_rest(apart: int) -> None:
    """The last pull leaves the tensions at which the drum balances, by an equilibrium of springs solved here."""
    drive = reference()
    cables = tuple(replace(c, preload_N=50.0 if k == apart else 70.0) for k, c in enumerate(drive.cables))
    lay = BevelLayout(replace(drive, cables=cables))
    found = plan(lay)
    length = np.array([path.length_mm for path in lay.cable_paths(0.0)])
    stiffness = drive.cable.axial_stiffness_N / length * 1e3
    lever = np.array([-c.drum_side * c.drum_radius_mm * 1e-3 for c in drive.cables])
    preload = np.array([c.preload_N for c in cables])
    # T = T0 - k l theta with the sum of l T zero.
    theta = (lever * preload).sum() / (stiffness * lever**2).sum()
    expected = preload - stiffness * lever * theta
    assert found.pulls[-1].tension_N == pytest.approx(expected, rel=0.02)
    assert abs((lever * balanced_tension_N(stiffness, lever, preload / stiffness)).sum()) < 1e-9
    assert found.cables[apart].turns_from_slack < min(
        c.turns_from_slack for k, c in enumerate(found.cables) if k != apart
    )
    text = " ".join(step.text for step in lay.assembly_order)
    assert "50" in text and "nan" not in text.lower()
    assert all(np.isfinite(v) for c in found.cables for v in (c.finished_m, c.turns_per_N)), asdict(found)


FRACTIONS = st.floats(-1.0, 1.0)
ANCHOR = 2.5  # rad, beyond any travel drawn here


def each(drive: BevelDrive, fraction: float) -> list[tuple[BevelRun, float]]:
    theta = fraction * radians(drive.half_travel_deg)
    return [(c, theta) for c in drive.cables]


@settings(max_examples=60, deadline=None)
@given(drives(), FRACTIONS)
def test_every_joint_is_smooth(drive: BevelDrive, fraction: float) -> None:
    for cable, theta in each(drive, fraction):
        pieces = cable_path(drive, cable, ANCHOR, 4.0, theta).pieces
        for (before, a), (after, b) in pairwise(pieces):
            gap = np.abs(a.points(np.array([1.0]))[0] - b.points(np.array([0.0]))[0]).max()
            kink = np.linalg.norm(a.tangent(1.0) - b.tangent(0.0))
            assert gap < 1e-10, f"{cable.name}, {before} to {after}: gap {gap:.3g} mm"
            assert kink < 1e-7, f"{cable.name}, {before} to {after}: kink {kink:.3g} rad"


@settings(max_examples=60, deadline=None)
@given(drives())
def test_tangents_cross_between_pulley_and_guide(drive: BevelDrive) -> None:
    for cable in drive.cables:
        on_pulley, on_guide = crossing_tangent(drive, cable)
        w = winding(drive, cable)
        landing = cable.guide_radius_mm * np.array([np.cos(w.guide_landing_rad), np.sin(w.guide_landing_rad)])
        assert np.abs(landing - on_guide).max() < 1e-9 * drive.centre_distance_mm
        assert abs(np.linalg.norm(on_pulley - on_guide) - w.free_span_mm) < 1e-9 * drive.centre_distance_mm
        # Round the guide in its sense, the wrap ends at the +y point and is less than a turn.
        end = w.guide_landing_rad + w.guide_sense * w.guide_wrap_rad
        assert abs((end - pi / 2 + pi) % tau - pi) < 1e-9
        assert 0 < w.guide_wrap_rad < tau


@settings(max_examples=60, deadline=None)
@given(drives(), FRACTIONS)
def test_cables_of_eq_1_do_not_stretch(drive: BevelDrive, fraction: float) -> None:
    """First order: nothing. Second order: the helix's slope on the length wound, and the slope of the span."""
    lead = drive.helix_lead_mm
    for cable, theta in each(drive, fraction):
        path, centred = (cable_path(drive, cable, ANCHOR, 4.0, a) for a in (theta, 0.0))
        unrolled, r = cable.drum_side * theta * cable.drum_radius_mm, cable.input_radius_mm
        span = winding(drive, cable).free_span_mm
        blend = min(2.5 * drive.cable.diameter_mm, 0.3 * span)
        spans = [span_length(span, -lead / (tau * r), -a / r * lead / tau, blend) for a in (unrolled, 0.0)]
        expected = unrolled * (1 - hypot(r, lead / tau) / r) + spans[0] - spans[1]
        change = path.length_mm - centred.length_mm
        assert abs(change - expected) < 1e-7, f"{cable.name}: {change:.9f} against {expected:.9f} mm"


@settings(max_examples=60, deadline=None)
@given(drives(), FRACTIONS, FRACTIONS)
def test_winding_is_one_helix_in_the_pulleys_frame(drive: BevelDrive, first: float, second: float) -> None:
    for cable in drive.cables:
        seen = []
        for fraction in (first, second):
            theta = fraction * radians(drive.half_travel_deg)
            helix = cable_path(drive, cable, ANCHOR, 4.0, theta).piece("helix")
            assert isinstance(helix, Helix)
            turned = theta * cable.drum_radius_mm / cable.input_radius_mm
            seen.append(
                (
                    helix.angle_start - turned,
                    helix.z_start,
                    (helix.z_end - helix.z_start) / (helix.angle_end - helix.angle_start),
                )
            )
        assert np.abs(np.subtract(*seen)).max() < 1e-9, f"{cable.name}: {seen}"


@settings(max_examples=40, deadline=None)
@given(drives())
def test_fleet_angle_is_that_of_the_steepest_span(drive: BevelDrive) -> None:
    half = radians(drive.half_travel_deg)
    for cable in drive.cables:
        span = winding(drive, cable).free_span_mm
        slopes = [abs(axial_walk_mm(drive, cable, f * half)) / span for f in np.linspace(-1, 1, 41)]
        assert abs(fleet_angle_deg(drive, cable) - degrees(atan2(max(slopes), 1.0))) < 1e-9


@settings(max_examples=40, deadline=None)
@given(drives(), FRACTIONS)
def test_the_mirror_image_is_the_mirror_image(drive: BevelDrive, fraction: float) -> None:
    """x -> -x with the drum turned the other way."""
    other = mirrored(drive)
    for (cable, theta), twin in zip(each(drive, fraction), other.cables, strict=True):
        here = cable_path(drive, cable, ANCHOR, 4.0, theta).sample(2.0)
        there = cable_path(other, twin, ANCHOR, 4.0, -theta).sample(2.0)
        assert np.abs(here * [-1, 1, 1] - there).max() < 1e-9, cable.name


@settings(max_examples=40, deadline=None)
@given(drives(), FRACTIONS)
def test_wrapped_pieces_keep_their_radius(drive: BevelDrive, fraction: float) -> None:
    for cable, theta in each(drive, fraction):
        path = cable_path(drive, cable, ANCHOR, 4.0, theta)
        drum = path.piece("drum")
        assert isinstance(drum, Arc)
        points = drum.points(np.linspace(0, 1, 9))
        assert np.abs(np.hypot(points[:, 0], points[:, 2]) - cable.drum_radius_mm).max() < 1e-9
        assert np.abs(points[:, 1] - cable.guide_radius_mm).max() < 1e-12
        around = path.piece("guide").points(np.linspace(0, 1, 9))
        assert np.abs(np.hypot(around[:, 0], around[:, 1]) - cable.guide_radius_mm).max() < 1e-9
        assert np.abs(around[:, 2] - cable.drum_radius_mm).max() < 1e-12
