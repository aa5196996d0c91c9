"""The analysis: complete, convertible to JSON, dependent on all its parameters, fast to import."""

from __future__ import annotations

import json
import subprocess
import sys
import time
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mbcdm_cad.design.drive import Drive
from mbcdm_cad.layouts.loader import load_design
from mbcdm_cad.model.analysis import analyse
from mbcdm_cad.model.figures import Analysis
from mbcdm_cad.model.si import ModelError, to_si

REFERENCE = Path(__file__).parents[3] / "params" / "mbcdm.yaml"


@cache
def reference() -> Drive:
    return load_design(REFERENCE).drive


@pytest.fixture(scope="module")
def drive() -> Drive:
    return reference()


def test_conversion_to_si(drive: Drive) -> None:
    d = to_si(drive)
    assert d.drum_radius_m == pytest.approx([54e-3, 57.6e-3, 61.2e-3, 64.8e-3])
    assert d.input_radius_m == pytest.approx([6e-3, 6.4e-3, 6.8e-3, 7.2e-3])
    assert d.sigma.tolist() == [-1.0, 1.0, 1.0, -1.0]
    assert float(d.axial_stiffness_N) == pytest.approx(drive.cable.axial_stiffness_N, rel=1e-12)


def test_cable_on_an_unknown_input_is_refused(drive: Drive) -> None:
    lost = replace(drive.cables[0], input_name="middle")
    with pytest.raises(ModelError, match="cable_1: runs from input 'middle'"):
        to_si(replace(drive, cables=(lost, *drive.cables[1:])))


def test_analysis_survives_json(drive: Drive) -> None:
    figures = analyse(drive).to_dict()
    again = json.loads(json.dumps(figures, allow_nan=False))
    assert again == figures
    assert again["cables"][0]["high_tension_N"] > again["cables"][0]["preload_N"]


def test_one_e_in_all_places(drive: Drive) -> None:
    """Twice the modulus: half of every turn, the same tensions and limits, the same implied modulus."""
    stiff = replace(drive, cable=replace(drive.cable, modulus_GPa=2 * drive.cable.modulus_GPa))
    one, two = analyse(drive), analyse(stiff)
    assert two.test[0].turn_mrad == pytest.approx(one.test[0].turn_mrad / 2, rel=1e-12)
    assert two.reversal_swing_mrad == pytest.approx(one.reversal_swing_mrad / 2, rel=1e-12)
    assert two.test[0].tension_N == pytest.approx(one.test[0].tension_N, rel=1e-9)
    assert two.peak_torque_Nm == pytest.approx(one.peak_torque_Nm, rel=1e-9)
    assert two.implied_modulus[0].modulus_GPa == pytest.approx(one.implied_modulus[0].modulus_GPa, rel=1e-12)
    assert f"E = {stiff.cable.modulus_GPa:g} GPa" in two.notes[0]


def test_e_is_called_calibrated_at_the_papers_test_alone(drive: Drive) -> None:
    assert "is calibrated: the paper" in analyse(drive).notes[0]
    other = analyse(replace(drive, loads=replace(drive.loads, test_torque_Nm=2.0))).notes[0]
    assert "not measured on this rope" in other and "the paper" not in other, other


def test_shafts_turn_as_the_ratios_say(drive: Drive) -> None:
    for turns in analyse(drive).shaft_turns:
        angles = tuple(turns.turned_deg[name] for name in ("drum", "guide", "input", "motor"))
        assert angles == pytest.approx((35.0, -210.0, 315.0, 315.0 * 76.0)), turns
    odd = replace(drive.cables[1], guide_radius_mm=9.61)
    missed = analyse(replace(drive, cables=(drive.cables[0], odd, *drive.cables[2:]))).shaft_turns
    assert missed[1].turned_deg["guide"] == pytest.approx(-35.0 * 57.6 / 9.61) and missed[0].turned_deg[
        "guide"
    ] == pytest.approx(-210.0)


def test_bearings_know_all_loads(drive: Drive) -> None:
    loads = [case.load_Nm for case in analyse(drive).bearings]
    assert loads == [0.0, drive.loads.peak_torque_Nm, -drive.loads.peak_torque_Nm]


def test_wraps_are_heard(drive: Drive) -> None:
    free = analyse(drive)
    tied = analyse(drive, wraps_rad=(np.full(4, 9.0), np.full(4, 0.43)))
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
            analyse(odd)
        return
    start = time.process_time()
    figures = analyse(odd)
    taken = time.process_time() - start
    assert taken < 20.0, f"{taken:.2f} s of processor time"
    json.dumps(figures.to_dict(), allow_nan=False)
    pulls = zip(cables, figures.peak[0].tension_N, strict=True)
    carried = sum(run.sense * tension * run.drum_radius_mm * 1e-3 for run, tension in pulls)
    assert carried == pytest.approx(peak, rel=1e-6, abs=1e-6), f"{carried} N m carried of {peak}"
