"""Winding history: cable that is wound on keeps its tension. Checked by a second implementation and by figures."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from paper_case import paper_drive

from mbcdm_cad.model.analysis import pair_mismatch
from mbcdm_cad.model.equations import eq1_residuals, shaft_angles, transmission_error
from mbcdm_cad.model.hysteresis import simulate
from mbcdm_cad.model.si import ModelError
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
