"""Winding history: cable that is wound on keeps its tension. Checked by a second implementation and by figures."""

from __future__ import annotations

from math import pi
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import sympy as sp
from hypothesis import given
from hypothesis import strategies as st
from paper_case import paper_drive

from mbcdm_cad.layouts.loader import layout_of, load_design
from mbcdm_cad.model.analysis import pair_mismatch
from mbcdm_cad.model.equations import eq1_residuals, shaft_angles, transmission_error
from mbcdm_cad.model.equilibrium import solve_equilibrium, tension_of_stretch
from mbcdm_cad.model.hysteresis import simulate
from mbcdm_cad.model.profiles import simulate_profiles
from mbcdm_cad.model.si import DriveSI, ModelError
from mbcdm_cad.model.stiffness import drum_backlash
from mbcdm_cad.model.wrap import excess_minus_log, slack_stretch_m, stretch_after_reversal, stretch_first_loading
from mbcdm_cad.routes import Floats
from tests.support.clip_grid import simulate_on_grid


def brake(amplitude_rad: float, per_cycle: int = 400, cycles: int = 3) -> tuple[Any, Any, Any]:
    """Drum angle wanted, input angles, and a load of 0.91 N m against the motion."""
    phase = 2 * np.pi * np.arange(1, cycles * per_cycle + 1) / per_cycle
    drum = amplitude_rad * np.sin(phase)
    speed = np.cos(phase)
    return drum, np.tile(9 * drum, (2, 1)), 0.91 * np.where(speed >= 0, 1.0, -1.0)


@pytest.mark.parametrize(("amplitude", "extreme"), [(0.05, 167.5e-6), (0.6, 398.2e-6)])
def test_extremes_of_the_transmission_error(amplitude: float, extreme: float) -> None:
    """12 to 15 % above the 145.9 urad without winding at +-50 mrad, nearly three times it at +-0.6 rad."""
    drum, angle, load = brake(amplitude)
    routes = (
        simulate_on_grid(paper_drive(), angle, load, winding=True, cell_rad=4e-3),
        simulate(paper_drive(), angle, load, winding=True),
    )
    for answer in routes:
        error = (answer.drum_angle_rad - drum)[400:]
        assert error.max() == pytest.approx(extreme, rel=3e-3), f"+{error.max() * 1e6:.2f} urad"
        assert error.min() == pytest.approx(-extreme, rel=3e-3), f"{error.min() * 1e6:.2f} urad"
    still = simulate(paper_drive(), angle, load).drum_angle_rad - drum
    assert np.abs(still).max() == pytest.approx(145.96e-6, rel=1e-3)


def test_short_travel_has_no_history() -> None:
    drum, angle, load = brake(1e-5)
    error = simulate_on_grid(paper_drive(), angle, load, winding=True, cell_rad=1e-3).drum_angle_rad - drum
    still = simulate(paper_drive(), angle, load).drum_angle_rad - drum
    worst = np.abs(error - still).max()
    assert worst < 3e-8, f"differs by {worst:.3g} rad over a travel of 10 urad"


def test_halving_the_cell_changes_little() -> None:
    _, angle, load = brake(0.05)
    fine, coarse = (
        simulate_on_grid(paper_drive(), angle, load, winding=True, cell_rad=cell).drum_angle_rad
        for cell in (2e-3, 8e-3)
    )
    worst = np.abs(fine - coarse)[400:].max()
    assert worst < 1e-7, f"drum angle moves by {worst:.3g} rad"


class PlainWrap:
    """Cable on a pulley as a list of (length, tension) from the anchor outwards; slow, and with no shared code."""

    def __init__(self, radius: float, wrap: float, preload: float, cell: float) -> None:
        self.radius, self.cell = radius, cell
        self.length = np.full(round(wrap / cell), cell)
        self.tension = np.full(self.length.size, preload)

    def after(self, wind: float, end: float) -> tuple[Any, Any]:
        """Lengths and tensions if ``wind`` rad are wound on (off if negative) and the end tension is ``end``."""
        length, tension = self.length.copy(), self.tension.copy()
        if wind > 0:
            length, tension = np.append(length, wind), np.append(tension, end)
        while wind < 0:
            cut = min(-wind, length[-1])
            length[-1] -= cut
            wind += cut
            if length[-1] <= 1e-15:
                length, tension = length[:-1], tension[:-1]
        distance = np.cumsum(length[::-1])[::-1] - 0.5 * length
        return length, np.clip(tension, end * np.exp(-0.15 * distance), end * np.exp(0.15 * distance))


@pytest.mark.slow
def test_against_a_plain_implementation() -> None:
    """One input pair, few samples, everything by nested bisection on explicit lists."""
    d = paper_drive()
    # Four cables alike in pairs by symmetry of a one-cable-each-way drive: use mean radii so one pair tells all.
    alike = d.with_(
        input_radius_m=np.full(4, 6.6e-3), guide_radius_m=np.full(4, 9.9e-3), drum_radius_m=np.full(4, 59.4e-3)
    )
    drum, angle, load = brake(0.01, per_cycle=20, cycles=1)
    fast = simulate_on_grid(alike, angle, load, winding=True, cell_rad=8e-3).drum_angle_rad - drum
    # The knots take each step straight, so they get the same sub-steps under the same load.
    ends = np.concatenate([[0.0], angle[0]])
    parts_of = np.maximum(1, np.ceil(np.abs(np.diff(ends)) / 16e-3).astype(int))
    fine = np.concatenate([np.linspace(a, b, n + 1)[1:] for a, b, n in zip(ends, ends[1:], parts_of, strict=False)])
    knots = simulate(alike, np.tile(fine, (2, 1)), np.repeat(load, parts_of), winding=True).drum_angle_rad
    closed = knots[np.cumsum(parts_of) - 1] - drum
    span, stiffness = float(alike.free_span_m[0]), float(alike.axial_stiffness_N)
    wraps = {s: (PlainWrap(6.6e-3, 1.2, 70.0, 8e-3), PlainWrap(59.4e-3, 1.2, 70.0, 8e-3)) for s in (1, -1)}
    theta, inner, plain = 0.0, 0.0, []
    for k in range(load.size):
        start, parts = theta, int(parts_of[k])
        for target in np.linspace(inner, angle[0, k], parts + 1)[1:]:

            def tension(
                sigma: int, turned: float, at: float = target, was: float = inner, base: float = start
            ) -> float:
                wanted = sigma * (6.6e-3 * at - 59.4e-3 * turned)
                low, high = 20.0, 200.0
                for _ in range(44):
                    middle = 0.5 * (low + high)
                    total = (middle - 70.0) * span
                    for wrap, wind in zip(wraps[sigma], (sigma * (at - was), -sigma * (turned - base)), strict=True):
                        length, values = wrap.after(wind, middle)
                        total += wrap.radius * float(length @ (values - 70.0))
                    low, high = (middle, high) if total / stiffness < wanted else (low, middle)
                return 0.5 * (low + high)

            low, high = target / 9 - 4e-4, target / 9 + 4e-4
            for _ in range(36):
                theta = 0.5 * (low + high)
                torque = 2 * 59.4e-3 * (tension(1, theta) - tension(-1, theta))
                low, high = (theta, high) if torque > load[k] else (low, theta)
            for sigma in (1, -1):
                end = tension(sigma, theta)
                for wrap, wind in zip(wraps[sigma], (sigma * (target - inner), -sigma * (theta - start)), strict=True):
                    wrap.length, wrap.tension = wrap.after(wind, end)
            inner, start = float(target), theta
        plain.append(theta - drum[k])
    for name, answer in (("the grid", fast), ("the knots", closed)):
        worst = np.abs(np.array(plain) - answer).max()
        assert worst < 3e-7, f"differs from {name} by {worst:.3g} rad, of {np.abs(fast).max():.3g}"


def test_wraps_too_short_for_the_travel_are_refused() -> None:
    _, angle, load = brake(2.0)
    with pytest.raises(ModelError, match="winds off up to 18 rad of an input"):
        simulate_on_grid(paper_drive(), angle, load, winding=True)


# Angles of the rigid chain and Eq. (1), (2).


def test_one_radian_of_the_drum() -> None:
    angles = shaft_angles(paper_drive(), "drum", 1.0, gear_ratio=76.0)
    assert float(angles["guide"]) == pytest.approx(-6.0)
    assert float(angles["input"]) == pytest.approx(9.0)
    assert float(angles["motor"]) == pytest.approx(684.0)


SHAFTS = ("drum", "guide", "input", "motor")


@given(st.sampled_from(SHAFTS), st.floats(-50, 50), st.integers(0, 3))
def test_every_angle_from_any(shaft: str, angle: float, cable: int) -> None:
    d = paper_drive()
    there = shaft_angles(d, shaft, angle, cable, 76.0)
    assert float(there[shaft]) == pytest.approx(angle, rel=1e-12, abs=1e-15)
    for other in SHAFTS:
        back = shaft_angles(d, other, there[other], cable, 76.0)
        assert float(back["drum"]) == pytest.approx(float(there["drum"]), rel=1e-12, abs=1e-15)


def test_unknown_shaft_is_refused() -> None:
    with pytest.raises(ModelError, match="use one of drum, guide, input, motor"):
        shaft_angles(paper_drive(), "wheel", 1.0)


def test_transmission_error_of_a_perfect_drive_is_zero() -> None:
    assert transmission_error(0.1, 0.9, 9.0) == pytest.approx(0.0, abs=1e-17)
    assert transmission_error(0.1002, 0.9, 9.0) == pytest.approx(2e-4)


@pytest.mark.parametrize("field", ["input_radius_m", "guide_radius_m", "drum_radius_m"])
@pytest.mark.parametrize("cable", [0, 1, 2, 3])
def test_eq1_residual_shows_a_wrong_radius(field: str, cable: int) -> None:
    d = paper_drive()
    radii = d.value(field).copy()
    radii[cable] *= 1.001
    residuals = eq1_residuals(d.with_(**{field: radii}))
    assert 4e-4 < residuals.worst < 1.1e-3, f"{field}[{cable}] + 0.1 %: worst residual {residuals.worst:.3g}"


def test_mismatch_in_newtons() -> None:
    """0.19 mm between two cables of one input is shared with the rest of the drive, and costs tens of newtons."""
    d = paper_drive()
    half = 0.405e-3
    wrong = d.with_(input_radius_m=d.input_radius_m + half, drum_radius_m=d.drum_radius_m + half)
    millimetres, newtons = pair_mismatch(wrong, np.radians(50.0))
    assert millimetres[0] == pytest.approx(0.176, abs=0.01)
    assert newtons > 20.0, f"largest change of tension {newtons:.3g} N"
    right_mm, right_N = pair_mismatch(d, np.radians(50.0))
    assert max(right_mm) < 1e-12 and right_N < 1e-9, f"{right_mm} mm, {right_N} N where Eq. (1) holds"


# The stretch law of one cable compared with numerical integration of the clipped profile, and its limits.


FINITE = {"input_wrap_rad": np.full(4, 9.0), "drum_wrap_rad": np.full(4, 0.43)}
GUIDE = {"passed_wrap_rad": [np.radians([25.7, 207.5, 29.4, 211.3])]}


def integrated(d: Any, end: np.ndarray, old: Any, cells: int = 40001) -> np.ndarray:
    """Stretch by Simpson's rule over both wraps of the profile ``old`` (a function of s) clipped to the end tension."""
    total = (end - d.preload_N) * d.free_span_m
    # Two zones creep in from the ends of the guide's wrap, up to its middle.
    wraps = ((d.input_radius_m, d.input_wrap_rad), (d.drum_radius_m, d.drum_wrap_rad))
    for radius, wrap in (*wraps, (2 * d.passed_radii_m[0], d.passed_wrap_rad[0] / 2)):
        for j in range(4):
            s = np.linspace(0.0, min(wrap[j], 6.0), cells)
            bound = np.exp(d.friction_coefficient * s)
            profile = np.clip(old(s, j), end[j] / bound, end[j] * bound) - d.preload_N[j]
            weights = np.ones(cells)
            weights[1:-1:2], weights[2:-1:2] = 4.0, 2.0
            total[j] += radius[j] * (weights @ profile) * (s[1] - s[0]) / 3.0
    return np.asarray(total / d.axial_stiffness_N)


@pytest.mark.parametrize("limits", [{}, FINITE, GUIDE], ids=["endless", "finite", "guide"])
@pytest.mark.parametrize("end", [40.0, 69.0, 70.0, 70.001, 95.0])
def test_first_loading_against_integration(limits: dict[str, Any], end: float) -> None:
    d = paper_drive(**limits)
    tension = np.array([end, end + 0.5, end * 1.01, end])
    stretch, _ = stretch_first_loading(d, tension)
    reference = integrated(d, tension, lambda s, j: np.full_like(s, d.preload_N[j]))
    worst = np.abs(stretch - reference).max()
    assert worst < 1e-12, f"stretch differs from the integrated profile by {worst:.3g} m"


@pytest.mark.parametrize("turned", [85.0, 58.0])
@pytest.mark.parametrize("end", [50.0, 60.0, 70.0, 75.0, 84.0, 95.0])
def test_reversal_against_integration(turned: float, end: float) -> None:
    d = paper_drive()
    at, tension = np.full(4, turned), np.full(4, end)

    def old(s: np.ndarray, j: int) -> np.ndarray:
        bound = np.exp(0.15 * s)
        return np.asarray(np.clip(np.full_like(s, 70.0), turned / bound, turned * bound))

    stretch, _ = stretch_after_reversal(d, tension, at)
    worst = np.abs(stretch - integrated(d, tension, old)).max()
    assert worst < 1e-12, f"{turned} N -> {end} N: differs by {worst:.3g} m"


@given(st.floats(20.0, 200.0), st.sampled_from([{}, FINITE]))
def test_slope_is_the_derivative(tension: float, limits: dict[str, Any]) -> None:
    d = paper_drive(**limits)
    step = 1e-4
    ends = [stretch_first_loading(d, np.full(4, tension + sign * step))[0] for sign in (1, -1)]
    difference = (ends[0] - ends[1]) / (2 * step)
    slope = stretch_first_loading(d, np.full(4, tension))[1]
    worst = np.abs(difference / slope - 1).max()
    # At the preload itself the second derivative jumps, and central differences see half of that jump.
    assert worst < 2e-5, f"at {tension} N the slope is off by {worst:.3g}"


@given(st.floats(-5e-4, 2e-3), st.sampled_from([{}, FINITE]))
def test_inverse(stretch: float, limits: dict[str, Any]) -> None:
    d = paper_drive(**limits)
    wanted = np.full(4, stretch)
    tension = tension_of_stretch(d, wanted)
    back = stretch_first_loading(d, np.maximum(tension, 1e-150))[0]
    taut = tension > 0.0
    worst = np.abs(back - wanted)[taut].max(initial=0.0)
    assert worst < 1e-15, f"inverse misses by {worst:.3g} m"
    assert (wanted[~taut] <= slack_stretch_m(d)[~taut]).all()


def test_no_friction_spreads_the_tension_over_the_whole_cable() -> None:
    d = paper_drive(**FINITE, friction_coefficient=0.0)
    tension = np.array([60.0, 80.0, 70.0, 71.0])
    length = d.free_span_m + d.input_radius_m * 9.0 + d.drum_radius_m * 0.43
    stretch, slope = stretch_first_loading(d, tension)
    assert stretch == pytest.approx((tension - 70.0) * length / d.axial_stiffness_N, rel=1e-12)
    assert slope == pytest.approx(length / d.axial_stiffness_N, rel=1e-12)
    tiny = stretch_first_loading(paper_drive(**FINITE, friction_coefficient=1e-7), tension)[0]
    assert tiny == pytest.approx(stretch, rel=1e-4)


def test_no_friction_without_wraps_is_refused() -> None:
    with pytest.raises(ModelError, match="friction_coefficient 0 with unlimited wraps"):
        stretch_first_loading(paper_drive(friction_coefficient=0.0), np.full(4, 80.0))


@given(st.floats(1e-9, 1e3))
def test_excess_minus_log_keeps_its_digits(ratio: float) -> None:
    exact = sp.Rational(ratio) - 1 - sp.log(sp.Rational(ratio))
    expected = float(exact.evalf(30))
    got = float(excess_minus_log(ratio))
    assert got == pytest.approx(expected, rel=2e-9, abs=1e-300), f"u = {ratio}: {got} against {expected}"


def test_no_span_is_refused() -> None:
    with pytest.raises(ModelError, match="raise centre_distance_mm"):
        _ = paper_drive(centre_distance_m=17.9e-3).free_span_m


def test_slip_on_the_guide_adds_about_8_percent() -> None:
    """With wraps long enough for both zones; the true wraps of 25.7 and 29.4 degrees are short and add less."""
    d = paper_drive()
    plain = float(drum_backlash(d, 0.91).first_loading_rad)
    long = float(drum_backlash(d.with_(passed_wrap_rad=[np.full(4, np.inf)]), 0.91).first_loading_rad)
    true = abs(float(solve_equilibrium(d.with_passed_slip, 0.91).drum_angle_rad))
    assert long / plain - 1 == pytest.approx(0.08, abs=0.01), f"{long / plain - 1:.2%} more"
    assert plain < true < long, f"{plain:.4g}, {true:.4g}, {long:.4g} rad"
    assert np.degrees(d.with_passed_slip.passed_wrap_rad[0]) == pytest.approx([25.7, 207.5, 29.4, 211.3], abs=0.06)


def test_closed_forms_refuse_finite_wraps() -> None:
    with pytest.raises(ModelError, match="a wrap is finite"):
        _ = paper_drive(**FINITE).slip_reach_m


@given(st.floats(0.05, 3.5), st.sampled_from([FINITE, GUIDE, {**FINITE, **GUIDE}]))
def test_a_reversal_with_wraps_that_end_is_that_of_the_time_series(load_Nm: float, limits: dict[str, object]) -> None:
    """Closed form of the profiles after a reversal, against the profiles that the series carries along."""
    d = paper_drive(**limits)
    found = drum_backlash(d, load_Nm)
    series = simulate(d, np.zeros((2, 2)), np.array([load_Nm, -load_Nm])).drum_angle_rad
    assert float(found.reversal_swing_rad) == pytest.approx(abs(series[1] - series[0]), rel=1e-7)


def test_a_wrap_longer_than_its_zones_is_an_endless_one() -> None:
    long = paper_drive(drum_wrap_rad=np.full(4, 300.0))
    for load in (0.4, 3.0):
        endless, found = drum_backlash(paper_drive(), load), drum_backlash(long, load)
        assert float(found.reversal_swing_rad) == pytest.approx(float(endless.reversal_swing_rad), rel=1e-10)


# A wrap without an anchor, compared with the same wrap anchored and with its mirror image.


TIME = np.linspace(0.0, 3.0, 241)
TURNED = 5.9 * np.sin(2 * pi * TIME)[None]
LOAD = 0.9 * np.sin(2 * pi * 0.6 * TIME) + 0.3


@pytest.fixture(scope="module")
def drive() -> DriveSI:
    """The reference of siso_spur."""
    return layout_of(load_design(Path(__file__).parents[3] / "params" / "siso_spur.yaml").drive).si


def drum_rad(drive: DriveSI, turned: Floats, load: Floats, through_rad: float | None) -> Floats:
    return simulate_profiles(drive, turned, load, None, True, through_rad).drum_angle_rad


def test_a_wrap_longer_than_travel_and_slip_acts_as_if_anchored(drive: DriveSI) -> None:
    """11.8 rad of travel and at most 3.3 of slip are less than the 18.1 of the design."""
    assert drive.through_wrap_rad is not None
    found = drum_rad(drive, TURNED, LOAD, float(drive.through_wrap_rad[0]))
    assert np.abs(found - drum_rad(drive, TURNED, LOAD, None)).max() < 1e-9


def test_a_short_wrap_lets_the_drum_creep_the_way_the_load_pushes(drive: DriveSI) -> None:
    steady = np.full_like(LOAD, 0.9)
    at_rest = [60 * n + 20 for n in range(1, 4)]
    for way in (1.0, -1.0):
        found = drum_rad(drive, TURNED, way * steady, 2 * pi) - TURNED[0] / 9.9
        crept = -way * np.diff(found[[n for n in at_rest if n < found.size]])
        assert (crept > 1e-4).all(), crept


def test_motion_and_load_turned_round_turn_the_creep_round(drive: DriveSI) -> None:
    one, other = drum_rad(drive, TURNED, LOAD, 3 * pi), drum_rad(drive, -TURNED, -LOAD, 3 * pi)
    assert np.ptp(one - drum_rad(drive, TURNED, LOAD, None)) > 1e-4
    assert np.abs(one + other).max() < 1e-9
