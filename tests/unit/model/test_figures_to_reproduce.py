"""The figures fixed in the project's model notes: mu = 0.15, T_pre = 70 N, A = 0.3117 mm^2, E = 60 GPa."""

from __future__ import annotations

import numpy as np
import pytest
from paper_case import paper_drive

from mbcdm_cad.model import equations
from mbcdm_cad.model.capability import balanced_preload_N, input_bias_Nm, torque_at_input_limit_Nm
from mbcdm_cad.model.equations import pair_mismatch_m
from mbcdm_cad.model.equilibrium import bearing_loads, solve_equilibrium
from mbcdm_cad.model.stiffness import cable_backlash, drum_backlash, implied_modulus_Pa, mean_radii
from mbcdm_cad.model.wrap import slip_angle_rad

TEST_LOAD = 0.91
DESIGN_LOAD = 2 * 2.9e-3 * 76 * 9  # 3.967 N m, the sum behind the paper's 3.9
INPUT_RATING = 2.9e-3 * 76


def close(actual: object, expected: object, digits: float) -> None:
    difference = float(np.max(np.abs(np.asarray(actual) - np.asarray(expected))))
    assert difference <= digits, f"got {actual}, expected {expected}: differs by {difference:.3g} > {digits:.3g}"


def test_backlash_of_each_cable() -> None:
    figures = cable_backlash(paper_drive(), TEST_LOAD)
    close(figures.backlash_simplified_rad * 1e3, [0.18288, 0.15872, 0.13870, 0.12190], 5.1e-6)
    close(figures.backlash_rad * 1e3, [0.18033, 0.15665, 0.13699, 0.12049], 5.1e-6)


def test_tensions_of_cable_1() -> None:
    figures = cable_backlash(paper_drive(), TEST_LOAD)
    simplified = (figures.high_simplified_N[0], figures.low_simplified_N[0])
    close(simplified, (74.297, 65.872), 5.1e-4)
    close((figures.high_N[0], figures.low_N[0]), (74.250, 65.824), 5.1e-4)


def test_drum_turn_with_all_cables() -> None:
    drum = drum_backlash(paper_drive(), TEST_LOAD)
    close(drum.first_loading_rad * 1e3, 0.14595, 1.0e-5)
    close(drum.reversal_swing_rad * 1e3, 0.2919, 5.1e-5)


def test_cost_of_the_simplification() -> None:
    """Dropping kappa costs at most about 1.4 % at the test load and 2.8 % at 3.97 N m; means are 1.3 and 2.5 %."""
    error = cable_backlash(paper_drive(), np.array([TEST_LOAD, DESIGN_LOAD])).simplification_error
    close(error.mean(axis=0), [0.0129, 0.0253], 1e-4)
    close(error.max(axis=0), [0.0142, 0.0278], 1e-4)


def test_kappa_carries_72_percent_of_eq_20() -> None:
    mean = mean_radii(paper_drive())
    whole = cable_backlash(mean, TEST_LOAD).backlash_simplified_rad[0]
    high = cable_backlash(mean, TEST_LOAD).high_simplified_N[0]
    free = (high - 70.0) * mean.free_span_m[0] / mean.axial_stiffness_N / mean.drum_radius_m[0]
    close(free / whole, 0.72, 0.01)


def test_modulus_under_each_reading() -> None:
    d = paper_drive()

    def implied(theta_mrad: float, reading: str) -> float:
        return implied_modulus_Pa(d, theta_mrad * 1e-3, TEST_LOAD, reading) / 1e9  # type: ignore[arg-type]

    close(implied(0.33, "reversal"), 54.0, 0.1)
    close(implied(0.33, "single"), 27.0, 0.1)
    spread = [implied(0.33 * (1 + sign * equations.BACKLASH_ERROR), "reversal") for sign in (1, -1)]
    close(spread, [49.0, 60.0], 0.5)


def test_the_modulus_does_reproduce_the_measurement() -> None:
    d = paper_drive()
    for reading in ("reversal", "single"):
        modulus = implied_modulus_Pa(d, 0.33e-3, TEST_LOAD, reading, "all_cables")
        drum = drum_backlash(d.with_(modulus_Pa=modulus), TEST_LOAD)
        got = drum.reversal_swing_rad if reading == "reversal" else drum.first_loading_rad
        close(got, 0.33e-3, 1e-15)


def test_load_share_and_input_torques() -> None:
    d = paper_drive()
    at = solve_equilibrium(d, np.array([TEST_LOAD, 3.3]))
    close(at.load_share(d, np.array([TEST_LOAD, 3.3]))[0], [0.448, 0.461], 5.1e-4)
    close(at.input_torque_Nm(d)[:, 0] * 1e3, [73.3, 27.8], 0.051)


def test_drive_limits_both_ways() -> None:
    d = paper_drive()
    equal = [torque_at_input_limit_Nm(d, INPUT_RATING, way).min() for way in (1, -1)]
    close(equal, [3.747, 3.194], 5.1e-4)
    even = d.with_(preload_N=balanced_preload_N(d))
    close([torque_at_input_limit_Nm(even, INPUT_RATING, way).min() for way in (1, -1)], [3.69, 3.66], 5.1e-3)


def test_preload_bias_on_the_inputs() -> None:
    d = paper_drive()
    close(input_bias_Nm(d) * 1e3, [28.0, -28.0], 1e-9)
    close(input_bias_Nm(d.with_(preload_N=balanced_preload_N(d))), [0.0, 0.0], 1e-14)


def test_slip_angles_of_the_inner_step() -> None:
    """23, 86 and 105 degrees for the 54 mm step at 0.91, 3.3 and 3.97 N m by (17); a little more by exact (14)."""
    low = cable_backlash(paper_drive(), np.array([0.91, 3.3, DESIGN_LOAD])).low_N[0]
    close(np.degrees(slip_angle_rad(low, 70.0, 0.15)), [23.5, 88.4, 107.2], 0.06)
    simplified = cable_backlash(paper_drive(), np.array([0.91, 3.3, DESIGN_LOAD])).low_simplified_N[0]
    close(np.degrees(slip_angle_rad(simplified, 70.0, 0.15)), [23.2, 86.4, 104.6], 0.06)


def test_free_spans() -> None:
    close(paper_drive().free_span_m * 1e3, [31.18, 30.68, 30.14, 29.55], 5.1e-3)


def test_mismatch_if_the_table_were_surface_radii() -> None:
    half = 0.405e-3
    d = paper_drive()
    wrong = d.with_(input_radius_m=d.input_radius_m + half, drum_radius_m=d.drum_radius_m + half)
    close(wrong.total_ratio, [8.494, 8.524, 8.550, 8.574], 5.1e-4)
    close(abs(pair_mismatch_m(wrong, np.radians(450.0))[0]) * 1e3, 0.19, 5.1e-3)


def test_bearing_loads_at_preload() -> None:
    d = paper_drive()
    loads = bearing_loads(d, d.preload_N)
    close([np.linalg.norm(load.force_N) for load in loads.inputs], [125.2, 120.8], 0.06)
    close(np.linalg.norm(loads.bodies["guide"].force_N), 5.97, 0.01)
    close(np.linalg.norm(loads.bodies["guide"].moment_Nm), 0.917, 0.001)


@pytest.mark.parametrize(
    ("name", "low", "high", "falls"),
    [
        ("preload_N", 40.0, 110.0, True),
        ("friction_coefficient", 0.05, 0.5, True),
        ("modulus_Pa", 30e9, 120e9, True),
        ("centre_distance_m", 30e-3, 60e-3, False),
    ],
)
def test_fig_5_trends(name: str, low: float, high: float, falls: bool) -> None:
    values = np.linspace(low, high, 15)
    turns = []
    for value in values:
        change = np.full(4, value) if name == "preload_N" else value
        turns.append(float(drum_backlash(paper_drive(**{name: change}), TEST_LOAD).first_loading_rad))
    steps = np.diff(turns)
    assert (steps < 0).all() if falls else (steps > 0).all(), f"{name}: {turns}"


def test_fig_5_rises_with_load_and_flattens_with_friction() -> None:
    d = paper_drive()
    turns = [float(drum_backlash(d, load).first_loading_rad) for load in np.linspace(0.1, 3.9, 12)]
    assert (np.diff(turns) > 0).all(), turns
    friction = np.array([0.05, 0.10, 0.30, 0.35])
    theta = [float(drum_backlash(paper_drive(friction_coefficient=mu), TEST_LOAD).first_loading_rad) for mu in friction]
    steep, flat = theta[0] - theta[1], theta[2] - theta[3]
    assert steep > 15 * flat, f"falls by {steep:.3g} rad from 0.05 to 0.10, by {flat:.3g} from 0.30 to 0.35"
