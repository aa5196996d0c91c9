"""Motors without a gearhead: torque, loss, speed, drum torque over speed, compared with energy and equilibrium."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mbcdm_cad.design.bought import without_gearhead
from mbcdm_cad.design.drive import Drive
from mbcdm_cad.layouts.loader import load_design
from mbcdm_cad.model.analysis import analyse
from mbcdm_cad.model.capability import MotorFigures, input_ratings_Nm, motor_figures, torque_at_input_limit_Nm
from mbcdm_cad.model.equilibrium import solve_equilibrium
from mbcdm_cad.model.si import to_si

PARAMS = Path(__file__).parents[3] / "params"
REFERENCE: Drive = load_design(PARAMS / "siso_spur.yaml").drive
FACE = {
    "radial_load_N": 80.0,
    "shaft_diameter_mm": 3.0,
    "shaft_length_mm": 12.0,
    "pilot_diameter_mm": 6.0,
    "pilot_height_mm": 1.0,
    "bolt_circle_mm": 8.4,
    "screw": "M2x6",
    "screw_count": 2,
}


def brushless(drive: Drive, constant_mNm_A: float = 95.5, ohms: float = 0.19, volts: float = 36.0) -> Drive:
    """The drive with a motor of 8 A continuous and 20 A peak instead of motor and gearhead."""
    motor = replace(
        drive.motor,
        rated_torque_mNm=8.0 * constant_mNm_A,
        torque_constant_mNm_A=constant_mNm_A,
        resistance_ohm=ohms,
        continuous_current_A=8.0,
        peak_current_A=20.0,
        voltage_V=volts,
        rotor_inertia_g_cm2=1200.0,
        **FACE,
    )
    return replace(drive, motor=motor, gearhead=without_gearhead(motor), bus_voltage_V=volts)


@pytest.fixture(scope="module")
def spur() -> Drive:
    return REFERENCE


def _figures(drive: Drive) -> MotorFigures:
    found = motor_figures(drive, to_si(drive), 0.3, np.inf)
    assert found is not None
    return found


def test_a_motor_without_electrical_values_has_no_figures(spur: Drive) -> None:
    assert analyse(replace(spur, motor=replace(spur.motor, torque_constant_mNm_A=None))).motor is None


@settings(max_examples=15, deadline=None)
@given(st.floats(10.0, 300.0), st.floats(0.02, 2.0), st.floats(12.0, 60.0))
def test_what_the_supply_gives_is_work_and_heat(constant: float, ohms: float, volts: float) -> None:
    """At the highest speed of a torque: V I = M w + P_copper, as long as the voltage drives that current at all."""
    drive = brushless(REFERENCE, constant, ohms, volts)
    f, ratio = _figures(drive), float(to_si(drive).total_ratio[0])
    speed = np.radians(f.at_peak_load_drum_speed_deg_s) * ratio
    supplied = volts * f.at_peak_load_current_A
    if f.at_peak_load_drum_speed_deg_s > 0.0:
        assert supplied == pytest.approx(0.3 * speed + f.at_peak_load_loss_W, rel=1e-9), f
    assert f.continuous_loss_W == pytest.approx(64.0 * ohms) and f.peak_loss_W == pytest.approx(400.0 * ohms)


def test_standing_the_drum_holds_what_loads_an_input_by_the_motors_torque(spur: Drive) -> None:
    f, d = _figures(brushless(spur)), to_si(spur)
    held = f.curve[0].continuous_Nm
    torque = max(abs(float(solve_equilibrium(d, way * held).input_torque_Nm(d)[0])) for way in (1, -1))
    assert torque == pytest.approx(8.0 * 0.0955, rel=1e-9), f"{held} N m at the drum load the input by {torque}"


def test_torque_over_speed_falls_to_nothing_at_no_load(spur: Drive) -> None:
    curve = _figures(brushless(spur)).curve
    for name in ("continuous_Nm", "peak_Nm"):
        torque = [getattr(point, name) for point in curve]
        assert all(a >= b - 1e-12 for a, b in pairwise(torque)), torque
    assert curve[0].peak_Nm > curve[0].continuous_Nm > 1.0 and curve[-1].peak_Nm == 0.0
    assert curve[-1].drum_speed_deg_s == pytest.approx(np.degrees(36.0 / 0.0955) / to_si(spur).total_ratio[0])


def test_a_lower_voltage_moves_the_knee_and_leaves_the_torque(spur: Drive) -> None:
    high, low = _figures(brushless(spur)), _figures(brushless(spur, volts=18.0))
    assert low.curve[0] == high.curve[0]
    assert low.drum_no_load_speed_deg_s == pytest.approx(high.drum_no_load_speed_deg_s / 2)


def test_a_rotor_counts_the_ratio_squared(spur: Drive) -> None:
    drive = brushless(spur)
    f, ratio = _figures(drive), float(to_si(drive).total_ratio[0])
    assert f.reflected_inertia_kg_m2 == pytest.approx(1200e-7 * ratio**2)


def test_ratings_without_a_gearhead(spur: Drive) -> None:
    ratings = input_ratings_Nm(brushless(spur))
    assert ratings == pytest.approx({"motor_alone": 0.764, "motor_alone_peak": 1.91})
    a, d = analyse(brushless(spur)), to_si(spur)
    rated = min(float(torque_at_input_limit_Nm(d, 0.764, way)[0]) for way in (1, -1))
    others = [x.torque_Nm for x in a.limits if x.cause in ("slip", "strength", "slack")]
    assert min(a.peak_torque_Nm) == pytest.approx(min(rated, *others))
    assert a.motor is not None and a.motor.curve[0].peak_Nm == pytest.approx(min(others))
