"""Several inputs round one drum: each behaves as the plain drive under its share, and the drum is in equilibrium."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mbcdm_cad.checks.bearings import input_reactions
from mbcdm_cad.checks.run import run_check
from mbcdm_cad.layouts.miso_spur.checks import load_shares, load_sharing
from mbcdm_cad.layouts.miso_spur.layout import RoundDrumLayout
from mbcdm_cad.layouts.registry import layout_of
from mbcdm_cad.layouts.siso_spur.drive import SpurDrive
from mbcdm_cad.model.capability import torque_at_slip_Nm
from mbcdm_cad.model.equilibrium import bearing_loads, solve_equilibrium
from mbcdm_cad.model.stiffness import drum_backlash, sticking_stiffness_Nm_rad
from tests.support.sliced_cables import by_bisection, contact_point_m

Made = Callable[[int], SpurDrive]


@settings(max_examples=25, deadline=None)
@given(count=st.integers(2, 4), load=st.floats(-2.5, 2.5))
def test_each_input_is_the_plain_drive_with_its_share(with_inputs: Made, count: int, load: float) -> None:
    """n inputs under n M turn as far as (a) under M, at its tensions; stiffness and torque at slip are n times its."""
    drive = with_inputs(count)
    one, all_ = layout_of(drive.unit(0)).si, layout_of(drive).si
    alone, together = solve_equilibrium(one, load), solve_equilibrium(all_, count * load)
    assert float(together.drum_angle_rad) == pytest.approx(float(alone.drum_angle_rad), rel=1e-9, abs=1e-15)
    assert together.tension_N.reshape(count, 2) == pytest.approx(np.tile(alone.tension_N, (count, 1)), rel=1e-9)
    assert float(sticking_stiffness_Nm_rad(all_)) == pytest.approx(count * float(sticking_stiffness_Nm_rad(one)))
    assert torque_at_slip_Nm(all_, 1) == pytest.approx([count * float(torque_at_slip_Nm(one, 1)[0])] * count)


def test_equilibrium_is_that_of_cables_summed_up_in_slices(drive: SpurDrive) -> None:
    at = solve_equilibrium(layout_of(drive).si, 4.3)
    angle, tensions = by_bisection(drive, drive.free_span_mm * 1e-3, 4.3)
    assert float(at.drum_angle_rad) == pytest.approx(angle, rel=1e-4)
    assert at.tension_N[:2] == pytest.approx(tensions, rel=1e-5)
    assert at.tension_N[2:] == pytest.approx(tensions, rel=1e-5)


@settings(max_examples=20, deadline=None)
@given(load=st.floats(0.1, 6.0), preload=st.floats(40.0, 120.0))
def test_both_senses_are_alike_whatever_one_input_is_drawn_to(drive: SpurDrive, load: float, preload: float) -> None:
    """Turned about the line of centres, the drive is itself with its sides exchanged."""
    cables = tuple(replace(c, preload_N=preload if c.input_name == "lower" else c.preload_N) for c in drive.cables)
    d = layout_of(replace(drive, cables=cables)).si
    one, other = (solve_equilibrium(d, way * load) for way in (1.0, -1.0))
    assert float(one.drum_angle_rad) == pytest.approx(-float(other.drum_angle_rad), rel=1e-9)
    assert one.tension_N == pytest.approx(other.tension_N[[1, 0, 3, 2]], rel=1e-9)


@pytest.mark.parametrize("count", [2, 3, 4])
def test_pulls_on_the_drum_cancel_at_any_load(with_inputs: Made, count: int) -> None:
    """Equal forces evenly round an axis have no sum; in planes one pitch apart they leave a couple, but for four."""
    drive = with_inputs(count)
    d = layout_of(drive).si
    for load in (0.0, 1.0 * count):
        loads = bearing_loads(d, solve_equilibrium(d, load).tension_N)
        assert loads.drum.force_N == pytest.approx([0.0] * 3, abs=1e-9)
        pulls = np.array([body.force_N for body in loads.inputs])
        assert np.linalg.norm(pulls, axis=1) == pytest.approx([np.linalg.norm(pulls[0])] * count)
        # What the drum feels of each is the opposite of what its input feels, at the level of its sector.
        if load == 0.0:
            couple = sum(
                np.cross([0.0, level * 1e-3, 0.0], -pull) for level, pull in zip(drive.levels_mm, pulls, strict=True)
            )
            assert loads.drum.moment_Nm == pytest.approx(couple, abs=1e-9)
            assert np.linalg.norm(couple) > 0.1


def test_spans_touch_both_pulleys_where_the_path_does(with_inputs: Made) -> None:
    d = layout_of(with_inputs(3)).si
    for route in d.routes.cables:
        ends = [contact_point_m(d.routes.body(w.body), w, route.spans[0].direction) for w in route.wraps]
        across = (ends[1] - ends[0]) * np.array([1.0, 0.0, 1.0])
        assert np.linalg.norm(across) == pytest.approx(route.spans[0].length_m, rel=1e-12)
        assert across / np.linalg.norm(across) == pytest.approx(route.spans[0].direction, abs=1e-12)


def test_routes_lie_where_the_drawn_cables_do(dims: RoundDrumLayout) -> None:
    """Contact points on the input, from the routes in m and from the drawn path in mm."""
    d = layout_of(dims.drive).si
    for path, first in zip(dims.cable_paths(0.0), range(0, d.n_cables, 2), strict=True):
        ends = path.piece("wound").points(np.array([0.0, 1.0]))
        for end, j in zip(ends, (first, first + 1), strict=True):
            route = d.routes.cables[j]
            wrap = route.wraps[0]
            point = contact_point_m(d.routes.body(wrap.body), wrap, route.spans[0].direction)
            assert point * 1e3 == pytest.approx(end, abs=1e-9), route.cable


@settings(max_examples=8, deadline=None)
@given(slack=st.floats(40.0, 110.0), load=st.floats(0.2, 3.0))
def test_shares_follow_the_stiffness_of_the_cables_alone(drive: SpurDrive, slack: float, load: float) -> None:
    """The torque of an input is that of the plain drive turned as far, so a slacker cable, whose wraps slip further,
    takes less."""
    cables = tuple(replace(c, preload_N=slack if c.input_name == "lower" else c.preload_N) for c in drive.cables)
    uneven = replace(drive, cables=cables)
    at = solve_equilibrium(layout_of(uneven).si, load)
    taken = []
    for k in range(2):
        own = at.tension_N[2 * k : 2 * k + 2]
        # Bisected for the load that turns this input's own drive as far.
        low, high = 0.0, load
        unit = layout_of(uneven.unit(k)).si
        for _ in range(60):
            middle = (low + high) / 2
            further = abs(float(solve_equilibrium(unit, middle).drum_angle_rad)) > abs(float(at.drum_angle_rad))
            low, high = (low, middle) if further else (middle, high)
        taken.append(low)
        assert own == pytest.approx(solve_equilibrium(unit, low).tension_N, rel=1e-6)
    assert sum(taken) == pytest.approx(load, rel=1e-6)
    assert (taken[1] < taken[0]) == (slack < 70.0) or abs(slack - 70.0) < 1.0


def test_check_of_sharing_warns_of_one_slack_cable(drive: SpurDrive) -> None:
    even = RoundDrumLayout(drive)
    assert load_shares(even) == pytest.approx(np.full((2, 2), 0.5))
    assert run_check(load_sharing, even).status == "pass"
    cables = tuple(replace(c, preload_N=35.0 if c.input_name == "lower" else 70.0) for c in drive.cables)
    uneven = RoundDrumLayout(replace(drive, cables=cables))
    shares = load_shares(uneven)
    assert shares[0, 0] > 0.55 and shares.sum(axis=1) == pytest.approx([1.0, 1.0]), shares
    assert run_check(load_sharing, uneven).status == "warn"


def test_backlash_is_that_of_the_plain_drive_at_the_share(drive: SpurDrive) -> None:
    found, alone = drum_backlash(layout_of(drive).si, 1.24), drum_backlash(layout_of(drive.unit(1)).si, 0.62)
    assert float(found.first_loading_rad) == pytest.approx(float(alone.first_loading_rad), rel=1e-9)
    assert float(found.reversal_swing_rad) == pytest.approx(float(alone.reversal_swing_rad), rel=1e-9)


def test_drum_is_as_heavy_as_its_sectors(with_inputs: Made) -> None:
    three = with_inputs(3)
    one = layout_of(three.unit(0)).inertias_kg_m2
    found = layout_of(three).inertias_kg_m2
    assert found["drum"] == pytest.approx(3 * one["drum"], rel=0.02), "hubs between sectors are shorter"
    assert set(found) == {"drum", "input_a", "input_b", "input_c"}


def test_bearings_of_each_pulley_carry_by_their_levers(drive: SpurDrive) -> None:
    """The second pulley's cable lies a pitch further from the plate, so that its far bearing carries more."""
    s = RoundDrumLayout(drive)
    bearings, upper_shares = drive.bearings, []
    for k, (_, near, far) in enumerate(input_reactions(s)):
        v = s.levels_of(k)
        low = v.bearing_shelf_top_z - bearings.input_lower.width_mm / 2
        high = v.top_plate_bottom_z + bearings.input_upper.width_mm / 2
        upper_shares.append(far / (near + far))
        assert upper_shares[-1] == pytest.approx((drive.levels_mm[k] - low) / (high - low), abs=0.05)
    assert upper_shares[1] > upper_shares[0] + 0.05, upper_shares
