"""The analysis: complete, convertible to JSON, dependent on all its parameters, fast to import.

Backlash and torque with an interval, from the sigmas of the design file.
"""

import json
import subprocess
import sys
import time
from dataclasses import replace
from functools import cache
from itertools import pairwise
from math import sqrt
from typing import Any

import numpy as np
import pytest
import yaml
from hypothesis import given, settings
from hypothesis import strategies as st

from mbcdm_cad.design.bought import without_gearhead
from mbcdm_cad.design.drive import Drive
from mbcdm_cad.layouts.loader import layout_of, load_design, load_text, reference_data
from mbcdm_cad.model import capability, stiffness
from mbcdm_cad.model.analysis import analyse
from mbcdm_cad.model.equilibrium import bearing_loads, solve_equilibrium
from mbcdm_cad.model.figures import Analysis
from mbcdm_cad.model.sensitivity import intervals
from mbcdm_cad.model.si import ModelError
from mbcdm_cad.model.tolerance import BEYOND_THREE_SIGMA, Contribution, StackUp, stack_data, tightest
from mbcdm_cad.report.analysis_report import analyse_design
from mbcdm_cad.routes.route import two_bearing_reactions_N
from tests.support.reference import PARAMS, REFERENCE
from tests.unit.model.paper_case import paper_drive


@cache
def reference() -> Drive:
    return load_design(REFERENCE).drive


@pytest.fixture(scope="module")
def drive() -> Drive:
    return reference()


def test_conversion_to_si(drive: Drive) -> None:
    d = layout_of(drive).si
    assert d.drum_radius_m == pytest.approx([54e-3, 57.6e-3, 61.2e-3, 64.8e-3])
    assert d.input_radius_m == pytest.approx([6e-3, 6.4e-3, 6.8e-3, 7.2e-3])
    assert d.sigma.tolist() == [-1.0, 1.0, 1.0, -1.0]
    assert float(d.axial_stiffness_N) == pytest.approx(drive.cable.axial_stiffness_N, rel=1e-12)


def test_cable_on_an_unknown_input_is_refused(drive: Drive) -> None:
    lost = replace(drive.cables[0], input_name="middle")
    with pytest.raises(ModelError, match="cable_1: runs from input 'middle'"):
        _ = layout_of(replace(drive, cables=(lost, *drive.cables[1:]))).si


def test_analysis_survives_json(drive: Drive) -> None:
    figures = analyse(layout_of(drive)).to_dict()
    again = json.loads(json.dumps(figures, allow_nan=False))
    assert again == figures
    assert again["cables"][0]["high_tension_N"] > again["cables"][0]["preload_N"]


def test_one_e_in_all_places(drive: Drive) -> None:
    """Twice the modulus: half of every turn, the same tensions and limits, the same implied modulus."""
    stiff = replace(drive, cable=replace(drive.cable, modulus_GPa=2 * drive.cable.modulus_GPa))
    one, two = analyse(layout_of(drive)), analyse(layout_of(stiff))
    assert two.test[0].turn_mrad == pytest.approx(one.test[0].turn_mrad / 2, rel=1e-12)
    assert two.reversal_swing_mrad == pytest.approx(one.reversal_swing_mrad / 2, rel=1e-12)
    assert two.test[0].tension_N == pytest.approx(one.test[0].tension_N, rel=1e-9)
    assert two.peak_torque_Nm == pytest.approx(one.peak_torque_Nm, rel=1e-9)
    assert two.implied_modulus[0].modulus_GPa == pytest.approx(one.implied_modulus[0].modulus_GPa, rel=1e-12)
    assert f"E = {stiff.cable.modulus_GPa:g} GPa" in two.notes[0]


def test_e_is_called_calibrated_at_the_papers_test_alone(drive: Drive) -> None:
    assert "is calibrated: the paper" in analyse(layout_of(drive)).notes[0]
    other = analyse(layout_of(replace(drive, loads=replace(drive.loads, test_torque_Nm=2.0)))).notes[0]
    assert "not measured on this rope" in other and "the paper" not in other, other


def test_shafts_turn_as_the_ratios_say(drive: Drive) -> None:
    for turns in analyse(layout_of(drive)).shaft_turns:
        angles = tuple(turns.turned_deg[name] for name in ("drum", "guide", "input", "motor"))
        assert angles == pytest.approx((35.0, -210.0, 315.0, 315.0 * 76.0)), turns
    odd = replace(drive.cables[1], guide_radius_mm=9.61)
    missed = analyse(layout_of(replace(drive, cables=(drive.cables[0], odd, *drive.cables[2:])))).shaft_turns
    assert missed[1].turned_deg["guide"] == pytest.approx(-35.0 * 57.6 / 9.61) and missed[0].turned_deg[
        "guide"
    ] == pytest.approx(-210.0)


def test_bearings_know_all_loads(drive: Drive) -> None:
    loads = [case.load_Nm for case in analyse(layout_of(drive)).bearings]
    assert loads == [0.0, drive.loads.peak_torque_Nm, -drive.loads.peak_torque_Nm]


def test_wraps_are_heard(drive: Drive) -> None:
    free = analyse(layout_of(drive))
    tied = analyse(layout_of(drive), wraps_rad=(np.full(4, 9.0), np.full(4, 0.43)))
    assert abs(tied.peak[0].turn_mrad) < abs(free.peak[0].turn_mrad), "an anchor within the slip zone stiffens"

    def slack(figures: Analysis) -> list[float]:
        return [limit.torque_Nm for limit in figures.limits if limit.cause == "slack"]

    assert slack(tied) == pytest.approx([20.83, 21.17], rel=1e-3), "the wraps that are given"
    assert slack(free) == pytest.approx([18.74, 18.77], rel=1e-3), "those at the ends of the travel"


def test_import_brings_neither_scipy_nor_cad() -> None:
    heavy = ("scipy", "matplotlib", "cadquery", "OCP", "numba")
    code = f"import sys, mbcdm_cad.model; print([m for m in {heavy} if m in sys.modules])"
    out = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert out.stdout.strip() == "[]", out.stdout


factors = st.floats(0.3, 3.0)


@pytest.mark.filterwarnings("error")
@settings(max_examples=75)
@given(
    st.lists(st.tuples(factors, factors, factors, st.floats(0.5, 2000.0)), min_size=4, max_size=4),
    st.floats(10.0, 200.0),
    st.floats(1e-3, 1.0),
    st.floats(1e-3, 300.0),
    st.floats(1.0, 120.0),
)
def test_any_drive_has_figures_or_a_reason(
    changes: list[tuple[float, float, float, float]], distance: float, friction: float, peak: float, travel: float
) -> None:
    """No warning, no traceback, no long search, however far radii are from Eq. (1) and loads from the preload."""
    base = reference()
    cables = tuple(
        replace(
            run,
            input_radius_mm=run.input_radius_mm * a,
            guide_radius_mm=run.guide_radius_mm * b,
            drum_radius_mm=run.drum_radius_mm * c,
            preload_N=preload,
        )
        for run, (a, b, c, preload) in zip(base.cables, changes, strict=True)
    )
    odd = replace(
        base,
        cables=cables,
        centre_distance_mm=distance,
        friction_coefficient=friction,
        half_travel_deg=travel,
        loads=replace(base.loads, peak_torque_Nm=peak),
    )
    if max(run.guide_radius_mm + run.input_radius_mm for run in cables) >= distance:
        with pytest.raises(ModelError, match="free span"):
            analyse(layout_of(odd))
        return
    start = time.process_time()
    figures = analyse(layout_of(odd))
    taken = time.process_time() - start
    assert taken < 20.0, f"{taken:.2f} s of processor time"
    json.dumps(figures.to_dict(), allow_nan=False)
    pulls = zip(cables, figures.peak[0].tension_N, strict=True)
    carried = sum(run.sense * tension * run.drum_radius_mm * 1e-3 for run, tension in pulls)
    assert carried == pytest.approx(peak, rel=1e-6, abs=1e-6), f"{carried} N m carried of {peak}"


NEED = capability.Requirements(0.91, np.radians(35.0), 0.2204, 0.81e-3, 106.0, 0.87e-3)


def design(**rope: Any) -> Any:
    data = reference_data()
    data["rope"] |= rope
    return load_text(yaml.safe_dump(data)).drive


def test_no_sigma_no_interval() -> None:
    assert analyse(layout_of(design())).intervals == ()
    assert "intervals" not in analyse_design(design()).text()


def test_backlash_goes_as_one_over_the_modulus() -> None:
    """Relative sigma of every backlash is that of E; no torque depends on it."""
    found = {x.name: x for x in analyse(layout_of(design(modulus_GPa={"value": 54.0, "sigma": 0.54}))).intervals}
    for name in ("turn", "reversal_swing", "backlash_cable_1", "backlash_cable_4"):
        share = found[name].sigma / found[name].value
        assert share == pytest.approx(0.01, rel=0.03), f"{name}: {share:.4f} of its value"
        low, high = (found[name].low / found[name].value, found[name].high / found[name].value)
        assert (low, high) == (pytest.approx(1 / 1.0196, abs=1e-3), pytest.approx(1 / 0.9804, abs=1e-3))
    for name in ("peak_torque_plus", "peak_torque_minus"):
        assert found[name].sigma < 1e-9, f"{name} moves by {found[name].sigma:.3g} N m"


def test_the_middle_is_the_figure_without_sigmas() -> None:
    a = analyse(layout_of(design(preload_N={"value": 70.0, "sigma": 2.0})))
    middle = {x.name: x.value for x in a.intervals}
    assert middle["turn"] == pytest.approx(abs(a.test[0].turn_mrad), rel=1e-9)
    assert middle["reversal_swing"] == pytest.approx(a.reversal_swing_mrad, rel=1e-9)
    assert (middle["peak_torque_plus"], middle["peak_torque_minus"]) == pytest.approx(a.peak_torque_Nm, rel=1e-9)
    assert middle["backlash_cable_2"] == pytest.approx(a.cables[1].backlash_mrad, rel=1e-9)


def test_small_sigmas_agree_with_linear_theory() -> None:
    d = paper_drive()
    sigma = {
        "preload_N": [0.1, 0.2, 0.0, 0.1],
        "drum_radius_m": 5e-5,
        "input_radius_m": 5e-6,
        "guide_radius_m": 5e-6,
        "friction_coefficient": 3e-4,
        "area_m2": 1e-9,
        "centre_distance_m": 2e-5,
        "load_Nm": 1e-3,
    }
    for name, x in intervals(d, NEED, sigma, draws=40_000).items():
        assert x.sigma == pytest.approx(x.linear_sigma, rel=0.03), f"{name}: {x.sigma:.4g}, linear {x.linear_sigma:.4g}"


def test_each_cable_is_drawn_on_its_own() -> None:
    """One cable's preload moves its own backlash and no other's."""
    found = intervals(paper_drive(), NEED, {"preload_N": [0.0, 2.0, 0.0, 0.0]}, draws=2000)
    spread = [found[f"backlash_cable_{k}_rad"].sigma for k in range(1, 5)]
    assert spread[1] > 1e-6, spread
    assert max(spread[0], *spread[2:]) < 1e-15, spread


def test_text_and_json_carry_the_intervals() -> None:
    found = analyse_design(design(preload_N={"value": 70.0, "sigma": 3.0}))
    listed = found.to_dict()["intervals"]
    assert [x["name"] for x in listed][-1] == "peak_torque_minus"
    for x in listed:
        assert x["low"] < x["value"] < x["high"], x
        row = next(line.split() for line in found.text().splitlines() if line.split()[:1] == [x["name"]])
        assert {f"{x['low']:.4g}", f"{x['high']:.4g}"} <= set(row), row


def test_too_wide_is_said_with_what_to_do() -> None:
    with pytest.raises(ModelError, match="lower those of centre distance, radii or friction"):
        intervals(paper_drive(), NEED, {"centre_distance_m": 11e-3}, draws=2000)
    with pytest.raises(ModelError, match="no such parameter"):
        intervals(paper_drive(), NEED, {"colour": 1.0})
    with pytest.raises(ModelError, match="is below 0"):
        intervals(paper_drive(), NEED, {"preload_N": [1.0, -1.0, 0.0, 0.0]})


# Stack-ups compared with closed forms.


def _stack(*shifts: float, margin: float = 1.0) -> StackUp:
    return StackUp("gap", margin, tuple(Contribution(f"part {k}", shift) for k, shift in enumerate(shifts)))


def test_three_and_four_make_five_and_seven() -> None:
    stack = StackUp("gap", 6.0, (Contribution("a", 1.5, -2.0), Contribution("b", 4.0)))
    assert (stack.rss, stack.worst_case, stack.spare) == (5.0, 7.0, 1.0)
    assert stack.costliest.name == "b"
    assert [c["name"] for c in stack_data(stack)["contributions"]] == ["b", "a"]


def test_monte_carlo_of_one_and_of_two_parts_is_the_closed_form() -> None:
    """One uniform part reaches (1 - 2p) t; the sum of two equal ones has its quantile at 2t - t sqrt(8p)."""
    p = BEYOND_THREE_SIGMA
    assert _stack(2.0).monte_carlo() == pytest.approx(2.0 * (1 - 2 * p), rel=1e-3)
    assert _stack(1.0, 1.0).monte_carlo() == pytest.approx(2.0 - sqrt(8 * p), rel=5e-3)
    assert _stack(1.0, 1.0).monte_carlo() == _stack(1.0, 1.0).monte_carlo(), "not seeded"


def test_monte_carlo_of_many_parts_is_the_normal_law() -> None:
    many = _stack(*np.full(60, 0.1))
    assert many.monte_carlo() == pytest.approx(3.0 * many.rss / sqrt(3.0), rel=0.02)


@settings(max_examples=30)
@given(st.lists(st.floats(1e-4, 1.0), min_size=1, max_size=8))
def test_the_worst_case_is_never_under_the_others(shifts: list[float]) -> None:
    stack = _stack(*shifts)
    assert max(shifts) <= stack.rss * (1 + 1e-12)
    assert stack.rss <= stack.worst_case * (1 + 1e-12)
    assert stack.monte_carlo(2000) <= stack.worst_case * (1 + 1e-12)


def test_the_tightest_has_the_least_left() -> None:
    assert tightest([_stack(0.1, margin=1.0), _stack(0.5, margin=1.2)]).margin == 1.2
    assert stack_data(StackUp("ratio", float("inf"), ()))["margin"] is None


WRAPS = {"input_wrap_rad": np.full(4, 9.0), "drum_wrap_rad": np.full(4, 0.43)}


@given(st.floats(0.05, 0.6), st.sampled_from([1, -1]))
def test_at_its_limit_an_input_carries_exactly_its_rating(rating: float, direction: int) -> None:
    d = paper_drive()
    loads = capability.torque_at_input_limit_Nm(d, rating, direction)
    for i in range(2):
        torque = solve_equilibrium(d, direction * loads[i]).input_torque_Nm(d)[i]
        assert direction * float(torque) == pytest.approx(rating, rel=1e-10), f"input {i} at {loads[i]} N m"


def test_bias_above_the_rating_leaves_nothing() -> None:
    assert capability.torque_at_input_limit_Nm(paper_drive(), 0.027, 1)[0] == 0.0


def test_strength_limit() -> None:
    d = paper_drive()
    limit = capability.torque_at_tension_limit_Nm(d, 106.0, 1)
    assert np.isinf(limit[[0, 3]]).all()
    for j in (1, 2):
        assert solve_equilibrium(d, limit[j]).tension_N[j] == pytest.approx(106.0, rel=1e-10)


def test_slack_limit() -> None:
    """A hundredth of the preload is left; shorter wraps leave it at a smaller load, and the shortest pose counts."""
    endless, d = capability.torque_at_slack_Nm(paper_drive(), 1), paper_drive(**WRAPS)
    first = float(capability.torque_at_slack_Nm(d, 1).min())
    share = solve_equilibrium(d, first).tension_N / d.preload_N
    assert float(np.min(share)) == pytest.approx(0.01, rel=1e-6)
    assert first < float(endless.min()), (first, endless)
    ends = [{name: scale * np.asarray(wrap) for name, wrap in WRAPS.items()} for scale in (1.0, 0.5)]
    shortest = float(capability.torque_at_slack_Nm(paper_drive(**ends[1]), 1).min())
    assert float(capability.torque_at_slack_Nm(paper_drive(), 1, ends).min()) == pytest.approx(shortest, rel=1e-12)


def test_slack_limit_without_friction() -> None:
    """Frictionless and alike: each of four cables gives up 0.99 of its 70 N at M = 4 x 69.3 N x mean r_o."""
    d = paper_drive(**WRAPS, friction_coefficient=0.0)
    radius = np.full(4, 59.4e-3)
    even = d.with_(drum_radius_m=radius, input_radius_m=radius / 9, guide_radius_m=radius / 6)
    assert float(capability.torque_at_slack_Nm(even, 1).min()) == pytest.approx(0.99 * 4 * 70 * 59.4e-3, rel=1e-10)


def test_limits_are_complete_and_ordered() -> None:
    limits = capability.torque_limits(paper_drive(), {"motor": 0.2204, "gearhead": 0.1}, 106.0)
    assert [limit.cause for limit in limits] == ["motor", "gearhead", "strength", "slack"] * 2
    assert [limit.direction for limit in limits] == [1] * 4 + [-1] * 4
    assert [limits[0].limiting, limits[4].limiting] == ["left", "right"]


@given(st.lists(st.floats(30, 110), min_size=4, max_size=4))
def test_balanced_preload_keeps_each_pairs_mean(preload: list[float]) -> None:
    d = paper_drive(preload_N=preload)
    even = capability.balanced_preload_N(d)
    assert even[:2].mean() == pytest.approx(np.mean(preload[:2]), rel=1e-12)
    assert even[0] * 6.0 == pytest.approx(even[1] * 6.4, rel=1e-12)
    assert even[2] * 6.8 == pytest.approx(even[3] * 7.2, rel=1e-12)


def test_torque_to_weight_of_the_paper() -> None:
    assert capability.torque_to_weight_Nm_kg(3.3, 342.0) == pytest.approx(9.649, abs=5e-4)


@pytest.mark.parametrize("load", [0.0, 0.3, 0.91, -2.0, 3.3])
def test_tangent_stiffness_against_finite_differences(load: float) -> None:
    d = paper_drive()
    step = 1e-5 if load else 1e-8
    high, low = (float(solve_equilibrium(d, load + sign * step).drum_angle_rad) for sign in (1, -1))
    difference = -2 * step / (high - low)
    tangent = float(stiffness.tangent_stiffness_Nm_rad(d, load))
    assert tangent == pytest.approx(difference, rel=1e-5), f"tangent {tangent:.6g}, differences {difference:.6g}"


def test_stiffness_falls_with_load_and_secant_lies_above_tangent() -> None:
    d = paper_drive()
    load = np.array([0.0, 0.5, 1.5, 3.0])
    tangent, secant = stiffness.tangent_stiffness_Nm_rad(d, load), stiffness.secant_stiffness_Nm_rad(d, load)
    assert (np.diff(tangent) < 0).all() and (secant[1:] > tangent[1:]).all(), (tangent, secant)
    assert secant[0] == pytest.approx(float(stiffness.sticking_stiffness_Nm_rad(d)))


def test_torsional_modes() -> None:
    d = paper_drive()
    inertia = 1e-4
    locked = stiffness.torsional_modes_Hz(d, stiffness.TurningInertias(inertia))
    assert locked == pytest.approx([np.sqrt(float(stiffness.sticking_stiffness_Nm_rad(d)) / inertia) / (2 * np.pi)])
    free = stiffness.torsional_modes_Hz(d, stiffness.TurningInertias(inertia, pulleys=[2e-6, 2e-6]))
    assert free[0] == 0.0 and len(free) == 3
    heavy = stiffness.torsional_modes_Hz(d, stiffness.TurningInertias(inertia, pulleys=1e3))
    assert heavy[-1] == pytest.approx(locked[0], rel=1e-6), "very heavy inputs act as locked"
    assert free[-1] > locked[0], "free inputs raise the drum's own mode"


def test_two_masses_on_two_springs_have_the_modes_of_the_textbook() -> None:
    """Wall, spring, drum, spring, payload: 2 w^2 = a + b +- sqrt((a + b)^2 - 4 k1 k2 / (J1 J2))."""
    d, drum, payload = paper_drive(), 1.2e-4, 7e-4
    chain = stiffness.Chain(before_drum=4e-5, in_drum=1e-4)
    k1, k2 = 1.0 / (1.0 / float(stiffness.sticking_stiffness_Nm_rad(d)) + chain.before_drum), 1.0 / chain.in_drum
    middle = (k1 + k2) / drum + k2 / payload
    root = np.sqrt(middle**2 - 4.0 * k1 * k2 / (drum * payload))
    expected = np.sqrt(np.array([middle - root, middle + root]) / 2.0) / (2.0 * np.pi)
    found = stiffness.torsional_modes_Hz(d, stiffness.TurningInertias(drum, payload), chain)
    assert found == pytest.approx(expected, rel=1e-9), (found, expected)


def test_rotor_pulley_and_drum_in_a_row_have_the_modes_of_three_masses() -> None:
    """Of a drive with one input, all at the drum's speed: w^2 (w^4 - p w^2 + q) = 0."""
    d = layout_of(load_design(PARAMS / "siso_spur.yaml").drive).si
    i, pulley, rotor, drum = float(d.total_ratio[0]), 3e-7, 6e-5, 2e-4
    chain = stiffness.Chain(before_inputs=3e-5)
    k, soft = float(stiffness.sticking_stiffness_Nm_rad(d)), 1.0 / chain.before_inputs
    a, b, c = rotor * i**2, pulley * i**2, drum
    p = soft * (1 / a + 1 / b) + k * (1 / b + 1 / c)
    q = soft * k * (a + b + c) / (a * b * c)
    expected = np.sqrt((p + np.array([-1.0, 1.0]) * np.sqrt(p**2 - 4.0 * q)) / 2.0) / (2.0 * np.pi)
    found = stiffness.torsional_modes_Hz(d, stiffness.TurningInertias(drum, pulleys=pulley, rotors=rotor), chain)
    assert found == pytest.approx([0.0, *expected], rel=1e-9), (found, expected)


def test_more_give_and_more_inertia_lower_every_mode() -> None:
    d = paper_drive()
    stiff, soft = stiffness.Chain(1e-5, 1e-5, 1e-5), stiffness.Chain(2e-5, 3e-5, 4e-5)
    light, heavy = (stiffness.TurningInertias(1e-4 * f, 5e-4 * f, 2e-7 * f, 4e-4 * f) for f in (1.0, 1.5))
    first, second, third = (
        stiffness.torsional_modes_Hz(d, *of) for of in ((light, stiff), (light, soft), (heavy, stiff))
    )
    assert (second[1:] < first[1:]).all() and (third[1:] < first[1:]).all(), (first, second, third)


def test_span_directions_are_tangent_to_both_pulleys() -> None:
    """Distance of the line from guide axis and input axis equals the radii, on opposite sides (figure eight)."""
    d = paper_drive()
    for j, route in enumerate(d.routes.cables):
        u, towards = np.array(route.spans[0].direction), -d.sigma[j]
        normal = np.array([u[1], -u[0]])  # the centre lies to the right of a clockwise cable
        landing = -towards * route.passed[0].radius_m * normal
        foot = landing - u[:2] * d.free_span_m[j]
        centre = np.array(d.routes.inputs[d.input_of[j]].point_m[:2])
        assert np.linalg.norm(foot - centre) == pytest.approx(d.input_radius_m[j], rel=1e-12), f"cable {j + 1}"
        assert (foot - centre) @ u[:2] == pytest.approx(0.0, abs=1e-15)


def test_bearing_reactions_balance() -> None:
    d = paper_drive()
    loads = bearing_loads(d, solve_equilibrium(d, 2.0).tension_N)
    for i in range(2):
        force, moment, at = loads.inputs[i].force_N, loads.inputs[i].moment_Nm, loads.inputs[i].height_m
        lower, upper = two_bearing_reactions_N(force, moment, at, 45e-3, 70e-3)
        up = np.array([0.0, 0.0, 1.0])
        total = force + lower + upper
        turning = moment + np.cross(at * up, force) + np.cross(45e-3 * up, lower) + np.cross(70e-3 * up, upper)
        assert np.abs(total).max() < 1e-12 and np.abs(turning).max() < 1e-12, (total, turning)


def test_drum_feels_no_net_pull_at_equal_preload() -> None:
    d = paper_drive()
    loads = bearing_loads(d, d.preload_N)
    assert np.abs(loads.drum.force_N).max() < 1e-12 and np.abs(loads.drum.moment_Nm).max() < 1e-12


def test_a_longer_path_turns_the_drum_and_balances() -> None:
    """Sticking wraps: no torque is left on the drum, and the change of stretch is the path less the drum's turn."""
    d = paper_drive()
    path = np.array([[10e-6, 0.0], [0.0, -5e-6], [3e-6, 5e-6], [0.0, 0.0]])
    angle, pull = stiffness.sticking_response(d, path)
    lever = d.sigma * d.drum_radius_m
    assert np.abs(lever @ pull).max() < 1e-9, "torque on the drum, N m"
    stretch = pull * (d.free_span_m / d.axial_stiffness_N)[:, None]
    assert stretch == pytest.approx(path - lever[:, None] * angle)
    turned, slack = stiffness.sticking_response(d, lever)
    assert turned == pytest.approx(1.0) and np.abs(slack).max() < 1e-6, "all paths as a turn of the drum makes them"


REFERENCE_DRIVE: Drive = load_design(PARAMS / "siso_spur.yaml").drive
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
    return REFERENCE_DRIVE


def _figures(drive: Drive) -> capability.MotorFigures:
    found = capability.motor_figures(layout_of(drive), layout_of(drive).si, 0.3, np.inf)
    assert found is not None
    return found


def test_a_motor_without_electrical_values_has_no_figures(spur: Drive) -> None:
    assert analyse(layout_of(replace(spur, motor=replace(spur.motor, torque_constant_mNm_A=None)))).motor is None


@settings(max_examples=15, deadline=None)
@given(st.floats(10.0, 300.0), st.floats(0.02, 2.0), st.floats(12.0, 60.0))
def test_what_the_supply_gives_is_work_and_heat(constant: float, ohms: float, volts: float) -> None:
    """At the highest speed of a torque: V I = M w + P_copper, as long as the voltage drives that current at all."""
    drive = brushless(REFERENCE_DRIVE, constant, ohms, volts)
    f, ratio = _figures(drive), float(layout_of(drive).si.total_ratio[0])
    speed = np.radians(f.at_peak_load_drum_speed_deg_s) * ratio
    supplied = volts * f.at_peak_load_current_A
    if f.at_peak_load_drum_speed_deg_s > 0.0:
        assert supplied == pytest.approx(0.3 * speed + f.at_peak_load_loss_W, rel=1e-9), f
    assert f.continuous_loss_W == pytest.approx(64.0 * ohms) and f.peak_loss_W == pytest.approx(400.0 * ohms)


def test_standing_the_drum_holds_what_loads_an_input_by_the_motors_torque(spur: Drive) -> None:
    f, d = _figures(brushless(spur)), layout_of(spur).si
    held = f.curve[0].continuous_Nm
    torque = max(abs(float(solve_equilibrium(d, way * held).input_torque_Nm(d)[0])) for way in (1, -1))
    assert torque == pytest.approx(8.0 * 0.0955, rel=1e-9), f"{held} N m at the drum load the input by {torque}"


def test_torque_over_speed_falls_to_nothing_at_no_load(spur: Drive) -> None:
    curve = _figures(brushless(spur)).curve
    for name in ("continuous_Nm", "peak_Nm"):
        torque = [getattr(point, name) for point in curve]
        assert all(a >= b - 1e-12 for a, b in pairwise(torque)), torque
    assert curve[0].peak_Nm > curve[0].continuous_Nm > 1.0 and curve[-1].peak_Nm == 0.0
    assert curve[-1].drum_speed_deg_s == pytest.approx(np.degrees(36.0 / 0.0955) / layout_of(spur).si.total_ratio[0])


def test_a_lower_voltage_moves_the_knee_and_leaves_the_torque(spur: Drive) -> None:
    high, low = _figures(brushless(spur)), _figures(brushless(spur, volts=18.0))
    assert low.curve[0] == high.curve[0]
    assert low.drum_no_load_speed_deg_s == pytest.approx(high.drum_no_load_speed_deg_s / 2)


def test_a_rotor_counts_the_ratio_squared(spur: Drive) -> None:
    drive = brushless(spur)
    f, ratio = _figures(drive), float(layout_of(drive).si.total_ratio[0])
    assert f.reflected_inertia_kg_m2 == pytest.approx(1200e-7 * ratio**2)


def test_ratings_without_a_gearhead(spur: Drive) -> None:
    ratings = capability.input_ratings_Nm(brushless(spur))
    assert ratings == pytest.approx({"motor_alone": 0.764, "motor_alone_peak": 1.91})
    a, d = analyse(layout_of(brushless(spur))), layout_of(spur).si
    rated = min(float(capability.torque_at_input_limit_Nm(d, 0.764, way)[0]) for way in (1, -1))
    others = [x.torque_Nm for x in a.limits if x.cause in ("slip", "strength", "slack")]
    assert min(a.peak_torque_Nm) == pytest.approx(min(rated, *others))
    assert a.motor is not None and a.motor.curve[0].peak_Nm == pytest.approx(min(others))
