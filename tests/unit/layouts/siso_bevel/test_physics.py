"""Equilibrium, symmetry and loads of the drive without a guide, each computed independently."""

from dataclasses import replace
from math import exp, radians, sqrt

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mbcdm_cad.layouts.registry import layout_of
from mbcdm_cad.layouts.siso_bevel.cable_path import transfer_stretch_mm
from mbcdm_cad.layouts.siso_bevel.design_file import DirectDrive
from mbcdm_cad.model.equilibrium import bearing_loads, solve_equilibrium
from tests.support.sliced_cables import by_bisection, contact_point_m


def balanced(drive: DirectDrive) -> DirectDrive:
    """Preloads T ~ 1/r with the mean of the file: the unloaded drum stays at zero."""
    first, second = (c.drum_radius_mm for c in drive.cables)
    mean = sum(c.preload_N for c in drive.cables) / 2
    share = 2.0 * mean / (1.0 / first + 1.0 / second)
    return replace(drive, cables=tuple(replace(c, preload_N=share / c.drum_radius_mm) for c in drive.cables))


def test_equilibrium_is_that_of_cables_summed_up_in_slices(drive: DirectDrive) -> None:
    even = balanced(drive)
    at = solve_equilibrium(layout_of(even).si, 0.98)
    angle, tensions = by_bisection(even, transfer_stretch_mm(even) * 1e-3, 0.98)
    assert float(at.drum_angle_rad) == pytest.approx(angle, rel=1e-4)
    assert at.tension_N == pytest.approx(tensions, rel=1e-5)


@settings(max_examples=30, deadline=None)
@given(load=st.floats(0.05, 1.5))
def test_both_senses_are_alike_with_equal_radii_and_preloads(drive: DirectDrive, load: float) -> None:
    first = drive.cables[0]
    alike = tuple(replace(first, name=c.name, drum_side=c.drum_side, step=c.step) for c in drive.cables)
    d = layout_of(replace(drive, cables=alike)).si
    one, other = (solve_equilibrium(d, way * load) for way in (1.0, -1.0))
    assert float(one.drum_angle_rad) == pytest.approx(-float(other.drum_angle_rad), rel=1e-9)
    assert one.tension_N == pytest.approx(other.tension_N[::-1], rel=1e-9)


def test_input_holds_the_load_over_the_ratio(drive: DirectDrive) -> None:
    d = layout_of(drive).si
    for load in (0.3, -0.8):
        torque = float(solve_equilibrium(d, load).input_torque_Nm(d)[0])
        assert torque == pytest.approx(load / 4.5, rel=1e-9)


def test_cables_touch_both_pulleys_at_the_transfer_point(drive: DirectDrive) -> None:
    routes = layout_of(drive).si.routes
    for route, run in zip(routes.cables, drive.cables, strict=True):
        wanted = np.array([0.0, run.input_radius_mm, run.drum_radius_mm]) * 1e-3
        for wrap in route.wraps:
            found = contact_point_m(routes.body(wrap.body), wrap, route.spans[0].direction)
            assert found == pytest.approx(wanted, abs=1e-15), f"{run.name} on {wrap.body}: {found}"


def test_input_is_pulled_by_the_difference_of_the_tensions_alone(drive: DirectDrive) -> None:
    """What spares the bearings: the cables leave to opposite sides."""
    d = layout_of(drive).si
    tension = np.array([80.0, 65.0])
    loads = bearing_loads(d, tension)
    pull = drive.cables[0].drum_side * 80.0 + drive.cables[1].drum_side * 65.0
    assert loads.inputs[0].force_N == pytest.approx([pull, 0.0, 0.0])
    assert loads.drum.force_N == pytest.approx([-pull, 0.0, 0.0])


def test_stretch_across_the_transfer_is_that_of_a_beam_under_tension(drive: DirectDrive) -> None:
    """49 wires of d/9 bend by E pi d^4 / 64 each; a pulled beam needs sqrt(EI/T) on either side."""
    wire = drive.cable.diameter_mm / 9.0
    bending = 49 * drive.material("stainless").youngs_modulus_GPa * 1e3 * np.pi / 64.0 * wire**4
    assert transfer_stretch_mm(drive) == pytest.approx(2.0 * sqrt(bending / 70.0), rel=1e-6)


def test_limited_wraps_at_the_end_of_travel_turn_the_drum_less(drive: DirectDrive) -> None:
    """With an anchor nearer than the slip zone reaches, less rope can stretch."""
    even = layout_of(balanced(drive)).si
    short = even.with_(input_wrap_rad=[radians(18.0)] * 2, drum_wrap_rad=[radians(20.0)] * 2)
    assert exp(0.15 * radians(20.0)) < 1.06
    turned = [abs(float(solve_equilibrium(d, 0.98).drum_angle_rad)) for d in (even, short)]
    assert turned[1] < turned[0], turned
