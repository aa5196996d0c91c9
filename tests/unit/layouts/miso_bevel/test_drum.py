"""Lands, terminals, stop and windows of the drum: inside the sector, apart from each other, at their dimensions."""

from dataclasses import replace
from itertools import combinations
from math import atan2, cos, degrees, hypot, radians, sin

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mbcdm_cad.layouts.miso_bevel.drive import BevelDrive
from mbcdm_cad.layouts.miso_bevel.layout import BevelLayout
from mbcdm_cad.layouts.miso_bevel.pulleys import terminal_way
from mbcdm_cad.layouts.miso_bevel.stack import stack
from mbcdm_cad.parts.drum_sector.sizes import half_width_mm, lands, tensioners
from mbcdm_cad.parts.terminal import Tensioner

from .designs import drives, reference


def test_lands_are_cut_at_half_a_cable_under_the_pitch_radius(drive: BevelDrive, dims: BevelLayout) -> None:
    surfaces = [land.surface_radius_mm for land in dims.drum.lands]
    assert surfaces == pytest.approx([53.595, 57.195, 60.795, 64.395], abs=1e-12)
    for before, after in zip(dims.drum.lands[:-1], dims.drum.lands[1:], strict=True):
        assert before.y_end == after.y_start


def test_contact_lines_lie_on_their_lands(drive: BevelDrive, dims: BevelLayout) -> None:
    """Edge 0.15 mm behind the contact line, flank 0.045 mm clear of the next wall: 0.6 - 0.405 in all."""
    for cable, land in zip(drive.cables, dims.drum.lands, strict=True):
        assert cable.guide_radius_mm - land.y_start >= 0.15 - 1e-12
    for cable, land in zip(drive.cables[:-1], dims.drum.lands[1:], strict=True):
        gap = land.y_start - cable.guide_radius_mm - drive.cable.diameter_mm / 2
        assert gap == pytest.approx(0.045, abs=1e-12), f"{cable.name}: flank gap {gap:.4f} mm"


@settings(max_examples=50, deadline=None)
@given(drives())
def test_land_widths_add_up_to_the_rim(drive: BevelDrive) -> None:
    levels = stack(drive)
    rims = lands(drive, levels)
    width = sum(land.y_end - land.y_start for land in rims)
    assert width == pytest.approx(levels.drum_outer_y - levels.drum_inner_y, rel=1e-12, abs=1e-12)


def angle_of(t: Tensioner, s: float, n: float) -> float:
    x, z = t.at(s, n)
    return atan2(t.side * x, z)


def test_terminals_stay_inside_the_sector_and_its_width(drive: BevelDrive, dims: BevelLayout) -> None:
    half = radians(drive.drum.sector_half_angle_deg)
    nut = drive.tensioner.nut_across_flats_mm / 3**0.5
    width = half_width_mm(drive)
    assert 2 * width == pytest.approx(drive.targets.envelope_mm[0], abs=drive.targets.envelope_tolerance_mm)
    for t in dims.drum.tensioners:
        assert angle_of(t, t.tip, 0.0) < half, (
            f"{t.cable_name}: stud ends at {degrees(angle_of(t, t.tip, 0.0)):.2f} deg"
        )
        for s in (t.lug_end, t.nuts_end):
            x, _ = t.at(s, nut)
            assert abs(x) <= width, f"{t.cable_name}: nut at |x| = {abs(x):.3f} mm, sector ends at {width:.3f}"


def test_terminal_lies_on_the_tangent_at_the_anchor(dims: BevelLayout) -> None:
    for t in dims.drum.tensioners:
        for s in (0.0, t.swage_start, t.tip):
            x, z = t.at(s)
            assert hypot(x, z) == pytest.approx(hypot(t.radius_mm, s), rel=1e-12)
        x, z = t.at(0.0, 1.0)
        assert (x, z) == pytest.approx(
            (t.side * (t.radius_mm + 1) * sin(t.anchor_rad), (t.radius_mm + 1) * cos(t.anchor_rad)), rel=1e-12
        )


def test_terminal_is_swage_gap_lug_two_nuts_and_a_stud_that_passes_them(drive: BevelDrive, dims: BevelLayout) -> None:
    spec = drive.tensioner
    for t in dims.drum.tensioners:
        assert t.swage_end - t.swage_start == pytest.approx(spec.swage_length_mm)
        assert t.lug_end - t.lug_start == pytest.approx(spec.lug_thickness_mm)
        assert t.nuts_end - t.lug_end == pytest.approx(2 * spec.nut_height_mm)
        assert t.slack_start < t.swage_start < t.cable_end < t.swage_end < t.last_end < t.lug_start < t.nuts_end
        assert t.nuts_end < t.tip - t.drawn_in < t.tip < t.last_tip


def test_cable_is_still_on_the_drum_at_both_ends_of_travel(drive: BevelDrive, dims: BevelLayout) -> None:
    for t in dims.drum.tensioners:
        left = degrees(t.anchor_rad) - drive.half_travel_deg
        assert left > 18.0, f"{t.cable_name}: {left:.1f} deg of wrap at the end of travel"


def polar_box(t: Tensioner, s0: float, s1: float, n0: float, n1: float) -> tuple[float, float, float, float]:
    angles = [angle_of(t, s, n) for s in (s0, s1) for n in (n0, n1)]
    radii = [hypot(*t.at(s, n)) for s in (s0, s1) for n in (n0, n1)]
    return min(angles), max(angles), min(radii), max(radii)


def test_neighbours_on_one_side_do_not_share_a_place(drive: BevelDrive, dims: BevelLayout) -> None:
    """Each terminal's hardware against the other's lug, and no pocket under a cable's land before it ends."""
    nut, d = drive.tensioner.nut_across_flats_mm / 3**0.5, dims.drum
    for a, b in combinations(d.tensioners, 2):
        if a.side != b.side:
            continue
        inner, outer = sorted((a, b), key=lambda t: t.radius_mm)
        for one, other in ((inner, outer), (outer, inner)):
            lug = polar_box(one, one.lug_start, one.lug_end, -d.swage_pocket, d.lug_half_width)
            hardware = polar_box(other, other.swage_start, other.nuts_end, -nut, nut)
            apart = lug[0] > hardware[1] or hardware[0] > lug[1] or lug[2] > hardware[3] or hardware[2] > lug[3]
            assert apart, f"lug of {one.cable_name} meets the terminal of {other.cable_name}"
        pocket = polar_box(inner, inner.swage_start - 0.2, inner.tip, -d.nut_pocket, inner.pocket_top)
        lands_end = outer.anchor_rad
        reaches = pocket[3] > outer.radius_mm - drive.cable.diameter_mm / 2
        assert pocket[0] > lands_end or not reaches, f"pocket of {inner.cable_name} cuts the land of {outer.cable_name}"


@settings(max_examples=50, deadline=None)
@given(st.floats(1.0, 8.0), st.floats(50.0, 85.0), st.floats(20.0, 90.0))
def test_no_thin_wall_before_a_land_further_out(step: float, sector: float, radius: float) -> None:
    """Either the pocket opens the land's surface, or at least 1 mm is left at its thin end."""
    first = reference()
    cables = tuple(replace(c, drum_radius_mm=radius + step * k) for k, c in enumerate(first.cables))
    drive = replace(first, cables=cables, drum=replace(first.drum, sector_half_angle_deg=sector))
    surfaces = [c.drum_radius_mm - drive.cable.diameter_mm / 2 for c in cables]
    for t in tensioners(drive, terminal_way(drive)):
        left = radians(sector) - t.anchor_rad
        end = min(t.pocket_end, t.radius_mm * sin(left) / cos(left))
        for surface in surfaces:
            if surface > t.radius_mm:
                thick = surface - hypot(t.radius_mm + t.pocket_top, end)
                opened = t.radius_mm + t.pocket_top > surface
                assert opened or thick >= 1.0 - 1e-9, f"{t.cable_name}: wall of {thick:.3f} mm under {surface:.3f}"


def test_stops_engage_between_the_travel_and_half_a_degree_more(drive: BevelDrive, dims: BevelLayout) -> None:
    """The pin touches the slot's end when their centres are apart by the difference of their radii."""
    d, pin = dims.drum, dims.frame.stop_pin_radius
    play = degrees((d.stop_slot_width / 2 - pin) / d.stop_radius)
    engages = d.stop_slot_end_deg + play
    assert engages == pytest.approx(drive.half_travel_deg + drive.stop_clearance_deg, abs=1e-9)
    assert 35.0 < engages < 35.5
    assert d.stop_radius == dims.frame.stop_pin_z


def test_windows_outside_the_slot_leave_spokes_and_a_rim(drive: BevelDrive, dims: BevelLayout) -> None:
    d, half_slot = dims.drum, dims.drum.stop_slot_width / 2
    assert len(d.windows) == 2
    for w in d.windows:
        assert d.stop_radius + half_slot < w.r_inner < w.r_outer < d.rim_inner_radius - 2.0
        crosses = w.start_deg < d.stop_slot_end_deg and w.end_deg > -d.stop_slot_end_deg
        radial_gap = max(w.r_inner - d.stop_radius, d.stop_radius - w.r_outer) - half_slot
        assert not crosses or radial_gap > 1.0, f"window {w} is {radial_gap:.3f} mm from the stop's slot"
    for a, b in combinations(d.windows, 2):
        assert a.end_deg <= b.start_deg or b.end_deg <= a.start_deg or a.r_outer < b.r_inner or b.r_outer < a.r_inner


def test_shaft_stack_fills_the_boss(drive: BevelDrive, dims: BevelLayout) -> None:
    s, f, width = dims.drum_shaft, dims.frame, drive.bearings.drum.width_mm
    spring = dims.preload_spring.height
    assert s.rear_bearing_y == s.flange_end_y and f.boss.rear_seat_end_y == pytest.approx(
        s.rear_bearing_y + width + spring
    )
    assert f.boss.front_seat_start_y == s.front_bearing_y
    assert s.front_bearing_y + width == pytest.approx(dims.levels.boss_front_y)
    assert s.front_bearing_y - f.boss.rear_seat_end_y > width, "bearings closer than their own width"
    assert f.boss.shoulder_radius < f.boss.seat_radius
    assert s.flange_start_y >= f.boss.encoder_pocket_floor_y, "flange in the encoder"
