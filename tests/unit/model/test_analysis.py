"""The analysis: complete, convertible to JSON, dependent on all its parameters, fast to import.

Backlash and torque with an interval, from the sigmas of the design file.
"""

from __future__ import annotations

import json
import subprocess
import sys
import time
from dataclasses import replace
from functools import cache
from math import sqrt
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml
from hypothesis import given, settings
from hypothesis import strategies as st
from paper_case import paper_drive

from mbcdm_cad.design.drive import Drive
from mbcdm_cad.layouts.loader import layout_of, load_design, load_text, reference_data
from mbcdm_cad.model.analysis import analyse
from mbcdm_cad.model.capability import Requirements
from mbcdm_cad.model.figures import Analysis
from mbcdm_cad.model.sensitivity import intervals
from mbcdm_cad.model.si import ModelError
from mbcdm_cad.model.tolerance import BEYOND_THREE_SIGMA, Contribution, StackUp, stack_data, tightest
from mbcdm_cad.report.analysis_report import analyse_design

REFERENCE = Path(__file__).parents[3] / "params" / "mbcdm.yaml"


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


NEED = Requirements(0.91, np.radians(35.0), 0.2204, 0.81e-3, 106.0, 0.87e-3)


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
