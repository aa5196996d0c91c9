"""Cables of the reference design: figures of the mechanism, tangency by independent construction, smooth joints."""

from dataclasses import replace
from itertools import pairwise
from math import asin, cos, degrees, hypot, pi, radians, sin, sqrt, tau

import numpy as np
import pytest
from numpy.typing import NDArray

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
from mbcdm_cad.layouts.miso_bevel.stack import band, outward_of
from mbcdm_cad.routes.curves import Arc, Helix, Line
from tests.support.smooth_path import self_clearance_mm

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
        outward = outward_of(drive, c)
        limits = band(drive, c, outward)
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
