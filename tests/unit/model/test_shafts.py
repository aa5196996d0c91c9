"""Bending and torsion of shafts against closed forms, and the give of ball bearings."""

from __future__ import annotations

from math import pi

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mbcdm_cad.model.structure.causes import (
    URAD_NM,
    Acting,
    Section,
    ball_bearing_N_mm,
    bearing_urad_Nm,
    bending_urad_Nm,
    torsion_urad_Nm,
)
from mbcdm_cad.model.structure.drum_sector import Isotropic

Z = np.array([0.0, 0.0, 1.0])
STEEL_MPA = 210e3
STEEL = Isotropic(STEEL_MPA, 0.3)
# Share of a full circle that carries a force across evenly (Cowper 1966, Poisson's ratio 0.3).
ROUND = 0.886
NONE = np.zeros(3)


def along_x(force_N: float) -> np.ndarray:
    return np.array([force_N, 0.0, 0.0])


def test_a_beam_on_two_supports_bends_as_tables_say() -> None:
    # Point load in the middle: F L^3 / (48 E I) at the load, so that twice the energy is F times that.
    force, length, radius = 10.0, 60.0, 4.0
    acting = [Acting(length / 2, along_x(force), NONE)]
    acting += [Acting(at, along_x(-force / 2), NONE) for at in (0.0, length)]
    found = bending_urad_Nm(Z, acting, [Section(0.0, length, radius)], STEEL)
    table = force**2 * length**3 / (48.0 * STEEL_MPA * pi / 4.0 * radius**4) * URAD_NM
    # Timoshenko's shear: half the force on either side.
    table += force**2 * length / (4.0 * STEEL.shear_MPa * ROUND * pi * radius**2) * URAD_NM
    assert found == pytest.approx(table, rel=1e-4)


def test_an_overhung_load_bends_span_and_overhang() -> None:
    # F a^2 (L + a) / (3 E I) at the load, a beyond the support.
    force, span, overhang, radius, bore = 16.7, 10.0, 4.0, 4.0, 2.0
    acting = [
        Acting(span + overhang, along_x(force), NONE),
        Acting(span, along_x(-force * (span + overhang) / span), NONE),
        Acting(0.0, along_x(force * overhang / span), NONE),
    ]
    found = bending_urad_Nm(Z, acting, [Section(0.0, span + overhang, radius, bore)], STEEL)
    second = pi / 4.0 * (radius**4 - bore**4)
    table = force**2 * overhang**2 * (span + overhang) / (3.0 * STEEL_MPA * second) * URAD_NM
    # Of a tube of twice its bore 0.620 of the area (Cowper 1966).
    area = 0.620 * pi * (radius**2 - bore**2)
    shear = force**2 * (overhang + (overhang / span) ** 2 * span) / (STEEL.shear_MPa * area)
    table += shear * URAD_NM
    assert found == pytest.approx(table, rel=2e-3)


def test_a_couple_at_one_support_bends_the_span() -> None:
    # C L / (3 E I) at the couple.
    couple, length, radius = 100.0, 30.0, 3.0
    reaction = couple / length
    # About y: a force along x at z adds z x F = (0, z Fx, 0).
    acting = [Acting(0.0, along_x(reaction), np.array([0.0, couple, 0.0])), Acting(length, along_x(-reaction), NONE)]
    found = bending_urad_Nm(Z, acting, [Section(0.0, length, radius)], STEEL)
    table = couple**2 * length / (3.0 * STEEL_MPA * pi / 4.0 * radius**4) * URAD_NM
    table += reaction**2 * length / (STEEL.shear_MPa * ROUND * pi * radius**2) * URAD_NM
    assert found == pytest.approx(table, rel=1e-4)


def test_steps_of_a_shaft_twist_in_series() -> None:
    steps = [Section(0.0, 5.0, 3.0, 1.5), Section(5.0, 12.0, 4.0)]
    polar = [pi / 2.0 * (3.0**4 - 1.5**4), pi / 2.0 * 4.0**4]
    # Inside the thicker step the thin one twists on, over an eighth of its diameter where they are far from alike.
    inside = 6.0 / 8.0 * (1.0 - 0.75**2.6)
    table = 50.0**2 * ((5.0 + inside) / polar[0] + 7.0 / polar[1]) / 80e3 * URAD_NM
    assert torsion_urad_Nm(50.0, steps, 80e3) == pytest.approx(table)
    held = 50.0**2 * 6.0 / 8.0 / polar[0] / 80e3 * URAD_NM
    assert torsion_urad_Nm(50.0, steps, 80e3, collar=True) == pytest.approx(table + held)


def test_a_shaft_without_a_wall_is_refused() -> None:
    with pytest.raises(ValueError, match="bore of radius 3 mm"):
        torsion_urad_Nm(1.0, [Section(0.0, 1.0, 3.0, 3.0)], 80e3)


def test_a_bearing_of_8_by_16_is_as_stiff_as_such_bearings_are() -> None:
    # A ball of 2 mm gives by 6 to 7 um under 90 N (Hertz, steel on steel in a groove): 618/8 under 200 N has about
    # 45 N/um. The factor of two each way covers the balls that catalogues do not give.
    stiffness = ball_bearing_N_mm(8.0, 16.0, 200.0)
    assert 22e3 < stiffness < 90e3, f"{stiffness:.4g} N/mm"


@given(st.floats(1.0, 2000.0), st.floats(1.05, 5.0), st.floats(0.0, 200.0))
def test_a_bearing_stiffens_under_load_and_preload(radial: float, more: float, axial: float) -> None:
    base = ball_bearing_N_mm(8.0, 16.0, radial, axial)
    assert ball_bearing_N_mm(8.0, 16.0, radial * more, axial) >= base
    assert ball_bearing_N_mm(8.0, 16.0, radial, axial * more) >= base


@given(st.floats(0.1, 100.0), st.floats(1e3, 1e6))
def test_the_turn_by_a_bearing_is_force_times_give(reaction: float, stiffness: float) -> None:
    give_mm = reaction / stiffness
    # Reciprocity: the drum turns by force (per N m) times displacement (per N m).
    assert bearing_urad_Nm(reaction, stiffness) == pytest.approx(reaction * give_mm * 1e-3 * 1e6)
