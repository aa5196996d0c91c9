"""Values and geometric checks that no other test covers, compared with figures computed by hand or independently."""

from dataclasses import replace
from math import asin, cos, degrees, hypot, pi, radians, sin, sqrt, tau

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mbcdm_cad.checks.bearings import drum_reactions_N
from mbcdm_cad.checks.comparison import CheckResult
from mbcdm_cad.checks.geometry import Ring, corner_gap, inside_rounded_rectangle, polygon_gap, web_between
from mbcdm_cad.checks.motors import saturation_Nm
from mbcdm_cad.checks.ratios import ratio_if_cut_as_surface, strength_efficiency
from mbcdm_cad.checks.run import run_check
from mbcdm_cad.checks.size import envelope_check, interference_check, mass_check
from mbcdm_cad.checks.strength import balanced_preloads, rated_input_Nm
from mbcdm_cad.design.blocks import Waiver
from mbcdm_cad.design.drive import Drive
from mbcdm_cad.layouts.miso_bevel.checks import CHECKS, Upright, ring_gap
from mbcdm_cad.layouts.miso_bevel.checks.spans import straight_span_clearance_mm
from mbcdm_cad.layouts.miso_bevel.checks.transmission import guide_forces_N
from mbcdm_cad.layouts.miso_bevel.layout import BevelLayout
from tests.support.sliced_cables import self_clearance_mm
from tests.unit.checks.designs import put, reference, scaled, with_cable

BY_ID = {check.id: check for check in CHECKS}


def result(name: str, drive: Drive) -> CheckResult:
    return run_check(BY_ID[name], BevelLayout(drive))


class TestPitchCone:
    def test_reference_lies_on_it(self, drive: Drive) -> None:
        found = result("pitch_line", drive)
        assert found.status == "pass" and found.actual is not None and found.actual < 1e-12, found

    @pytest.mark.parametrize(("off_mm", "status"), [(0.00098, "pass"), (0.00104, "fail")])
    def test_a_step_off_the_line_by_a_thousandth(self, off_mm: float, status: str, drive: Drive) -> None:
        # Cut square to the pitch line, a step's offset along y counts with the cosine of the line's angle, 0.986.
        moved = with_cable(drive, 2, guide_radius_mm=10.2 + off_mm)
        found = result("pitch_line", moved)
        assert found.status == status, found
        assert found.actual == pytest.approx(off_mm * 64.8 / hypot(10.8, 64.8), rel=1e-9), found

    def test_each_row_of_eq_1_sees_its_own_cables_only(self, drive: Drive) -> None:
        rows = ("eq1_guide_drum", "eq1_first_input", "eq1_second_input")
        second_input = with_cable(drive, 3, input_radius_mm=7.3)
        assert [result(row, second_input).status for row in rows] == ["pass", "pass", "fail"]
        first_input = with_cable(drive, 0, input_radius_mm=6.1)
        assert [result(row, first_input).status for row in rows] == ["pass", "fail", "pass"]
        # As printed, the third row would pair 6.8, 7.2 with 9.0, 9.6 and call the paper's own Table 2 wrong.
        assert pytest.approx(7.2 / 9.6) != 6.8 / 9.0 and result("eq1_second_input", drive).status == "pass"

    def test_inputs_that_turn_the_drum_differently(self, drive: Drive) -> None:
        uneven = scaled("input_radius_mm", (2, 3))(drive, 1.02)
        found = result("equal_total_ratio", uneven)
        assert found.status == "fail" and found.actual == pytest.approx(1 - 1 / 1.02, rel=1e-9), found
        assert result("eq1_second_input", uneven).status == "pass"


class TestLandWidth:
    @pytest.mark.parametrize(("d", "status"), [(0.8999, "pass"), (0.9, "pass"), (0.9001, "fail")])
    def test_border_in_cable_diameter(self, d: float, status: str, drive: Drive) -> None:
        # 0.6 = d/2 + 0.15 at d = 0.9.
        found = result("land_width", put(drive, "cable.diameter_mm", d))
        assert found.status == status and found.margin == pytest.approx(0.45 - d / 2, abs=1e-12), found

    def test_flank_gap_of_the_reference(self, drive: Drive) -> None:
        found = result("land_width", drive)
        assert found.margin == pytest.approx(0.045, abs=1e-12), found
        assert "flank gap 0.045 mm" in found.message, found.message

    def test_gaps_at_the_transfer(self, drive: Drive) -> None:
        assert result("bodies_clear", drive).actual == pytest.approx(0.155, abs=1e-12)
        widest = result("transfer_gap", drive)
        assert widest.actual == pytest.approx(0.255, abs=1e-12) and widest.limit == pytest.approx(0.405), widest


class TestPitchAgainstSurfaceRadii:
    def test_ratios_if_table_2_were_cut_as_surfaces(self, drive: Drive) -> None:
        ratios = [ratio_if_cut_as_surface(BevelLayout(drive), c) for c in drive.cables]
        assert ratios == pytest.approx([8.494, 8.524, 8.550, 8.574], abs=5e-4), ratios
        message = result("surface_radius", drive).message
        assert "8.494/8.524/8.55/8.574 instead of 9/9/9/9" in message, message

    def test_surface_radii_entered_as_pitch_radii_are_recognised(self, drive: Drive) -> None:
        surfaces = drive
        for k, c in enumerate(drive.cables):
            less = {f: getattr(c, f) - 0.405 for f in ("input_radius_mm", "guide_radius_mm", "drum_radius_mm")}
            surfaces = with_cable(surfaces, k, **less)
        for row in ("eq1_guide_drum", "eq1_first_input", "eq1_second_input"):
            found = result(row, surfaces)
            assert found.status == "fail" and "look like surface radii" in found.remedy, found

    def test_remedy_for_other_radii_satisfies_eq_1(self, drive: Drive) -> None:
        found = result("eq1_guide_drum", with_cable(drive, 1, guide_radius_mm=9.7))
        assert "guide_radii_mm: [9, 9.6, 10.2, 10.8] and input_radii_mm: [6, 6.4, 6.8, 7.2]" in found.remedy, found

    def test_a_layout_that_cuts_at_the_pitch_radius_fails(self, drive: Drive) -> None:
        lay = BevelLayout(drive)
        radii = (lay.guide.surface_radii[0] + 0.001, *lay.guide.surface_radii[1:])
        wrong = lay.with_dimensions(guide=replace(lay.guide, surface_radii=radii))
        found = run_check(BY_ID["cut_at_pitch"], wrong)
        assert found.status == "fail" and found.actual == pytest.approx(0.001, rel=1e-6), found


class TestPreloadBiasAndPeakTorque:
    def test_bias_of_equal_preloads_is_the_difference_of_radii(self, drive: Drive) -> None:
        found = result("preload_bias", drive)
        rated = 2.9e-3 * 76
        assert found.actual == pytest.approx(70.0 * 0.4e-3 / rated, rel=1e-9), found
        assert "left +28 mN m, right -28 mN m" in found.message, found.message

    def test_preloads_as_one_over_radius_leave_none(self, drive: Drive) -> None:
        balanced = drive
        for k, preload in enumerate((72.25806451612904, 67.74193548387098, 72.0, 68.0)):
            balanced = with_cable(balanced, k, preload_N=preload)
        assert result("preload_bias", balanced).actual == pytest.approx(0.0, abs=1e-12)
        both = [
            saturation_Nm(BevelLayout(balanced), rated_input_Nm(BevelLayout(balanced)), sign)[0] for sign in (1, -1)
        ]
        assert both == pytest.approx([3.69, 3.66], abs=0.005), both
        measured = put(balanced, "loads.peak_torque_Nm", 3.3)
        assert result("motor_torque_forward", measured).status == "pass"
        assert result("motor_torque_back", measured).status == "pass"
        assert "cable_1 72.26, cable_2 67.74, cable_3 72, cable_4 68 N" in balanced_preloads(BevelLayout(drive))

    def test_directions_differ(self, drive: Drive) -> None:
        forward, back = result("motor_torque_forward", drive), result("motor_torque_back", drive)
        assert forward.actual == pytest.approx(3.747, abs=1e-3) and "left input" in forward.message, forward
        assert back.actual == pytest.approx(3.194, abs=1e-3) and "right input" in back.message, back

    @pytest.mark.parametrize(
        ("peak", "forward", "back"), [(3.193, "pass", "pass"), (3.195, "pass", "fail"), (3.748, "fail", "fail")]
    )
    def test_borders_in_peak_torque(self, peak: float, forward: str, back: str, drive: Drive) -> None:
        loaded = put(drive, "loads.peak_torque_Nm", peak)
        found = result("motor_torque_forward", loaded), result("motor_torque_back", loaded)
        assert tuple(f.status for f in found) == (forward, back), found
        if back == "fail":
            assert "T ~ 1/r" in found[1].remedy, found[1].remedy

    def test_at_the_border_the_input_carries_its_rating(self, drive: Drive) -> None:
        loads = BevelLayout(put(drive, "loads.peak_torque_Nm", 3.193720531803108)).loads
        assert loads.input_torque_Nm[2][1] == pytest.approx(-2.9e-3 * 76, rel=1e-6), loads.input_torque_Nm[2]


class TestFiguresOfTheMechanism:
    def test_largest_fleet_angle(self, drive: Drive) -> None:
        found = result("fleet_angle", drive)
        assert found.actual == pytest.approx(1.48, abs=0.005) and "cable_4" in found.message, found

    @pytest.mark.parametrize(("lead", "status"), [(0.85, "fail"), (0.86, "fail"), (0.863, "pass"), (0.87, "pass")])
    def test_window_of_leads(self, lead: float, status: str, drive: Drive) -> None:
        assert result("self_clearance", put(drive, "helix_lead_mm", lead)).status == status

    def test_straight_span_is_stricter_than_the_drawn_one(self, drive: Drive) -> None:
        for c in drive.cables:
            straight = straight_span_clearance_mm(drive, c)
            drawn = min(self_clearance_mm(drive, c, radians(a)) for a in (-35.0, 35.0))
            assert straight < drawn, (c.name, straight, drawn)

    def test_self_clearance_against_a_search_by_brute_force(self, drive: Drive) -> None:
        for c in drive.cables:
            r, p, span = c.input_radius_mm, 0.87, sqrt(34.6**2 - (c.guide_radius_mm + c.input_radius_mm) ** 2)
            walk = p * c.drum_radius_mm / r * radians(35.0) / tau
            a = np.linspace(-0.5, 1.0, 3001)
            s = np.linspace(0.0, 6.0, 3001)
            turn = np.stack([r * np.cos(a), r * np.sin(a), p * (1 - a / tau)])
            line = np.stack([np.full_like(s, r), s, s * walk / span])
            gap = np.sqrt(sum((line[k][:, None] - turn[k][None, :]) ** 2 for k in range(3)).min()) - 0.81
            assert straight_span_clearance_mm(drive, c) == pytest.approx(gap, abs=2e-6), c.name

    def test_bend_ratio_and_its_cost(self, drive: Drive) -> None:
        assert result("bend_ratio", drive).actual == pytest.approx(12.0 / 0.81)
        warned = result("bend_ratio_minimum", drive)
        assert warned.status == "warn" and "88.9% of the breaking load left; life 'relatively low'" in warned.message
        given_points = [strength_efficiency(r) for r in (10, 15, 20, 40, 5, 100)]
        assert given_points == pytest.approx([0.86, 0.89, 0.91, 0.95, 0.86, 0.95])

    def test_slip_angles(self, drive: Drive) -> None:
        # Cables alone, as the paper counts them, would slip 23.2 deg at the test torque; together the first slips less.
        assert " slips over 21.7 deg of drum" in result("wrap_slip_test", drive).message
        at_peak = result("wrap_slip_peak", put(drive, "loads.peak_torque_Nm", 3.3))
        assert " slips over 80.6 deg of drum" in at_peak.message, at_peak

    def test_wraps_that_end_never_make_the_drum_turn_further(self, drive: Drive) -> None:
        for torque in (0.5, 3.15, 8.0, 20.0, 60.0):
            found = result("wrap_slip_peak", put(drive, "loads.peak_torque_Nm", torque))
            assert found.actual < 1e-6, f"at {torque} N m the drum turns {found.actual} % further"

    def test_wraps_left(self, drive: Drive) -> None:
        left = sorted(degrees(BevelLayout(drive).smallest_wrap_rad(c)) for c in drive.cables)
        assert left[0] > 18.0 and left[-1] < 33.0, left

    def test_guide_bearings_by_moments_about_one_of_them(self, drive: Drive) -> None:
        """Forces of the four cables on the guide, summed cable by cable about the lower bearing."""
        s = BevelLayout(drive)
        g, tension = s.guide, s.loads.peak_back
        low, high = g.bottom_z + g.seat_depth / 2, g.top_z - g.seat_depth / 2
        total, moment = np.zeros(2), np.zeros(2)
        for c, pull in zip(drive.cables, tension, strict=True):
            beta = asin((c.guide_radius_mm + c.input_radius_mm) / drive.centre_distance_mm)
            to_input = np.array([c.input_side * cos(beta), c.input_side * c.drum_side * sin(beta)])
            force = pull * (to_input + np.array([c.drum_side, 0.0]))
            total, moment = total + force, moment + force * (c.drum_radius_mm - low)
        upper = moment / (high - low)
        lower = total - upper
        pair = np.linalg.norm(guide_forces_N(s)[2], axis=1)
        by_hand = [float(np.linalg.norm(lower)), float(np.linalg.norm(upper))]
        assert pair == pytest.approx(by_hand, rel=1e-9), (pair, by_hand)

    def test_drum_bearings_balance_force_and_moment(self, drive: Drive) -> None:
        s = BevelLayout(drive)
        shaft = s.drum_shaft
        rear, front = shaft.rear_bearing_y + 2.0, shaft.front_bearing_y + 2.0
        most = np.zeros(2)
        for _, tension in s.loads.states:
            pulls = [-c.drum_side * t for c, t in zip(drive.cables, tension, strict=True)]
            arms = [c.guide_radius_mm for c in drive.cables]
            on_front = sum(f * (y - rear) for f, y in zip(pulls, arms, strict=True)) / (front - rear)
            most = np.maximum(most, np.abs([sum(pulls) - on_front, on_front]))
        assert drum_reactions_N(s) == pytest.approx(tuple(most), rel=1e-9), most


@given(st.floats(0.3, 3.0))
def test_bias_is_proportional_to_the_preload(factor: float) -> None:
    more = scaled("preload_N")(reference(), factor)
    assert result("preload_bias", more).actual == pytest.approx(factor * 0.12704174, rel=1e-6)


@given(st.floats(0.5, 2.0))
def test_scaling_the_whole_transmission_keeps_every_ratio(factor: float) -> None:
    bigger = reference()
    for field in ("input_radius_mm", "guide_radius_mm", "drum_radius_mm"):
        bigger = scaled(field)(bigger, factor)
    rows = ("eq1_guide_drum", "eq1_first_input", "eq1_second_input", "equal_total_ratio", "pitch_line")
    assert [result(row, bigger).status for row in rows] == ["pass"] * 5
    assert result("land_width", bigger).actual == pytest.approx(0.6 * factor, rel=1e-12)


def test_stress_of_the_stop_pin_by_hand(drive: Drive) -> None:
    s = BevelLayout(drive)
    stall = 2 * 2.9e-3 * 76 * 9
    lever = 10.7 - s.levels.front_y
    stress = stall * 1e3 / s.drum.stop_radius * lever * 32 / (pi * 3.0**3)
    assert result("stop_pin", drive).actual == pytest.approx(355.0 / stress, rel=1e-9)


coordinate = st.floats(-10.0, 10.0)


def box(x: float, y: float, w: float, h: float, turn: float) -> np.ndarray:
    corners = np.array([(-w, -h), (w, -h), (w, h), (-w, h)]) / 2
    c, s = np.cos(turn), np.sin(turn)
    return corners @ np.array([[c, s], [-s, c]]) + (x, y)


def filled(polygon: np.ndarray, n: int = 25) -> np.ndarray:
    u, v = np.meshgrid(np.linspace(0, 1, n), np.linspace(0, 1, n))
    a, b, c, d = polygon
    return (
        np.multiply.outer(((1 - u) * (1 - v)).ravel(), a)
        + np.multiply.outer((u * (1 - v)).ravel(), b)
        + np.multiply.outer((u * v).ravel(), c)
        + np.multiply.outer(((1 - u) * v).ravel(), d)
    )


@given(coordinate, coordinate, st.floats(0.5, 5.0), st.floats(0.5, 5.0), st.floats(0.0, 3.0))
def test_polygon_gap_against_sampling(x: float, y: float, w: float, h: float, turn: float) -> None:
    first, second = box(0.0, 0.0, 3.0, 2.0, 0.3), box(x, y, w, h, turn)
    gap = polygon_gap(first, second)
    sampled = np.linalg.norm(filled(first)[:, None] - filled(second)[None], axis=2).min()
    assert gap <= sampled + 1e-9, (gap, sampled)
    # No point of either lies further than half a diagonal of its cell from a sample.
    cell = hypot(3.0, 2.0) / 48 + hypot(w, h) / 48
    assert gap >= sampled - cell - 1e-9, (gap, sampled, cell)


def test_corner_of_a_pocket() -> None:
    assert corner_gap(0.0, 5.0, 10.0, 0.0, 2.0) == 5.0
    assert corner_gap(9.5, 5.0, 10.0, 0.0, 2.0) == 0.5
    assert corner_gap(9.0, 1.0, 10.0, 0.0, 2.0) == pytest.approx(2.0 - sqrt(2.0))
    assert corner_gap(10.0, 0.0, 10.0, 0.0, 2.0) == pytest.approx(2.0 - 2.0 * sqrt(2.0))


def test_rounded_rectangle() -> None:
    assert inside_rounded_rectangle(0.0, 0.0, 10.0, -4.0, 6.0, 2.0) == 4.0
    assert inside_rounded_rectangle(-9.0, 0.0, 10.0, -4.0, 6.0, 2.0) == 1.0
    assert inside_rounded_rectangle(9.0, 5.0, 10.0, -4.0, 6.0, 2.0) == pytest.approx(2.0 - sqrt(2.0))
    assert inside_rounded_rectangle(10.0, 6.0, 10.0, -4.0, 6.0, 2.0) < 0.0


def test_webs_leave_out_holes_on_one_axis_and_at_other_depths() -> None:
    holes = [("a", 0.0, 0.0, 1.0, 0.0, 2.0), ("b", 0.0, 0.0, 2.0, 0.0, 1.0), ("c", 5.0, 0.0, 1.0, 1.5, 3.0)]
    assert web_between(holes) == [("a to c", 3.0)]


@given(
    st.floats(20.0, 60.0),
    st.floats(-3.0, 0.0),
    st.floats(1.0, 12.0),
    st.floats(-40.0, 40.0),
    st.floats(1.0, 40.0),
    st.floats(-2.0, 12.0),
)
def test_ring_and_upright_never_meet_where_a_gap_is_promised(
    x: float, back: float, radius: float, low: float, height: float, y: float
) -> None:
    ring, body = Ring("ring", 40.0, 50.0, y, 50.0), Upright("body", x, back, radius, low, low + height)
    if ring_gap(ring, body, 0.1) < 0.1:
        return
    angle = np.linspace(0.0, 2 * np.pi, 73)
    for share in np.linspace(0.05, 1.0, 20):
        px, py = x + share * radius * np.cos(angle), back + share * radius * np.sin(angle)
        for z in np.linspace(low, low + height, 31):
            r = np.hypot(px, z)
            inside = (py > y) & (r > 40.0) & (r < 50.0)
            assert not inside.any(), (ring, body, z)


@pytest.mark.parametrize(("mass", "status"), [(340.0, "pass"), (360.0, "pass"), (339.9, "fail"), (360.1, "fail")])
def test_mass(mass: float, status: str, drive: Drive) -> None:
    found = mass_check(drive, mass, 4.0)
    assert found.status == status and found.actual == pytest.approx(abs(mass - 350.0)), found
    assert "+- 4" in found.message and "342" in found.message, found.message


@pytest.mark.parametrize(("z", "status"), [(97.5, "pass"), (96.5, "pass"), (97.51, "fail"), (96.49, "fail")])
def test_envelope(z: float, status: str, drive: Drive) -> None:
    found = envelope_check(drive, (126.02, z, 34.8))
    assert found.status == status and found.actual == pytest.approx(abs(z - 97.0)) and "Z from" in found.message, found


def test_interference(drive: Drive) -> None:
    assert interference_check(drive, ()).status == "pass"
    found = interference_check(drive, ("a and b overlap", "c and d overlap"))
    assert found.status == "fail" and found.actual == 2.0 and "a and b overlap; c and d overlap" in found.message, found
    many = interference_check(drive, ["x"] * 9)
    assert many.message.count("x;") == 3, many.message


def test_waiver_reaches_them(drive: Drive) -> None:
    waived = replace(drive, waivers=(Waiver(check="mass", reason="a steel drum on purpose"),))
    found = mass_check(waived, 400.0, 4.0)
    assert found.status == "pass" and found.waived_reason == "a steel drum on purpose", found
