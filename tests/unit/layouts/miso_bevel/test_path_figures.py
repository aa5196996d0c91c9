"""Figures of cable paths compared with rigid-body kinematics and Pythagoras; limits of the travel."""

from dataclasses import asdict, replace
from math import atan2, degrees, hypot, pi, radians, tau

import numpy as np
import pytest

from mbcdm_cad.layouts.bevel_transfer import TravelFigures, terminal_gap_mm
from mbcdm_cad.layouts.miso_bevel.cable_path import cable_path, winding
from mbcdm_cad.layouts.miso_bevel.drive import BevelDrive
from mbcdm_cad.layouts.miso_bevel.layout import BevelLayout
from mbcdm_cad.layouts.miso_bevel.path_figures import path_figures, plan
from mbcdm_cad.model.tensioning import balanced_tension_N

from .designs import reference


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
            wound = tau * drive.dead_turns + w.reduction * (radians(drive.half_travel_deg) - w.payout * angle)
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
