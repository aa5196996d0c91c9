"""The rig compared with the analytic model. Only this file imports both."""

from __future__ import annotations

import importlib.util
import sys
from dataclasses import replace

import numpy as np
import pytest

from mbcdm_cad.layouts.loader import layout_of, load_design
from mbcdm_cad.layouts.turns import turns_of
from mbcdm_cad.model.analysis import reversal_swing_mrad
from mbcdm_cad.model.equilibrium import solve_equilibrium
from mbcdm_cad.model.hysteresis import simulate
from mbcdm_cad.model.stiffness import drum_backlash
from mbcdm_cad.rig.bench import bench_of
from mbcdm_cad.rig.experiment import Physics


@pytest.fixture(scope="module")
def comparison(project):
    spec = importlib.util.spec_from_file_location("rig_against_model", project / "benchmarks" / "rig_against_model.py")
    module = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = module
    spec.loader.exec_module(module)
    yield module
    del sys.modules[spec.name]


@pytest.fixture(scope="module")
def drive(comparison, project):
    return comparison.stiff_rope(load_design(project / "params" / "mbcdm.yaml").drive)


def test_they_agree_where_the_model_s_assumptions_hold(comparison, drive):
    rows = comparison.agreement(drive) + comparison.winding(drive)
    assert len(rows) == 9
    for row in rows:
        assert abs(row.difference) <= row.tolerance, row


def test_the_figures_are_those_known_from_elsewhere(comparison, drive):
    """Backlash, swing and drive limits checked by hand-made discretisations before this code was written."""
    rows = {row.name: row.rig for row in comparison.agreement(drive)}
    known = [145.95, 291.9, None, None, 3.747, 3.194]
    for (name, found), expected in zip(rows.items(), known, strict=True):
        assert expected is None or found == pytest.approx(expected, rel=1e-3), name


def test_they_part_by_as_much_as_is_known(comparison, drive):
    short, long, guide = comparison.parting(drive)
    assert short.rig == pytest.approx(167.3, abs=0.3), short
    assert long.rig == pytest.approx(396.0, abs=1.0), long
    assert guide.difference == pytest.approx(0.08, abs=0.005), guide
    soft = comparison.winding(drive)[2]
    assert soft.rig == pytest.approx(163.9, abs=1.0), soft


def test_finer_pieces_come_nearer(comparison, drive):
    errors = [abs(comparison.agreement(drive, piece)[0].difference) for piece in (0.08, 0.02, 0.005)]
    assert errors[0] > 4 * errors[1] > 4 * errors[2], errors


def test_they_agree_on_one_cable_that_friction_holds_on_its_input(comparison, project):
    """Plain capstan drive, each side a cable from the middle of the input: first loading, and the swing back."""
    plain = comparison.stiff_rope(load_design(project / "params" / "siso_spur.yaml").drive)
    load = np.concatenate([np.linspace(0.0, 2.15, 200), np.linspace(2.15, -2.15, 400)])
    found, _ = comparison.held(plain, load, piece_rad=0.02)
    d = layout_of(plain).si
    assert found[199] == pytest.approx(float(solve_equilibrium(d, 2.15).drum_angle_rad), rel=1e-3)
    model = simulate(d, np.zeros((1, load.size)), load).drum_angle_rad
    assert found[-1] - found[199] == pytest.approx(model[-1] - model[199], rel=1e-3)


def test_slip_on_the_guide_is_one_choice_of_the_design(comparison, drive):
    """Declared as counted, model, time series and rig turn alike; without it they agree on the smaller turn."""
    counted = replace(drive, guide_slips=True)
    load = np.concatenate([np.linspace(0.0, 0.91, 200), np.linspace(0.91, -0.91, 400)])
    turns = {}
    for name, one in (("none", drive), ("counted", counted)):
        d = layout_of(one).si
        slips = layout_of(one).slips_on_passed
        found, _ = comparison.held(one, load, piece_rad=0.01, passed_slip=slips)
        assert found[199] == pytest.approx(float(solve_equilibrium(d, 0.91).drum_angle_rad), rel=2e-3)
        swing = float(drum_backlash(d, 0.91).reversal_swing_rad)
        assert abs(found[-1] - found[199]) == pytest.approx(swing, rel=2e-3)
        model = simulate(d, np.zeros((2, load.size)), load).drum_angle_rad
        assert abs(model[-1] - model[199]) == pytest.approx(swing, rel=1e-6)
        assert turns_of(layout_of(one)).cables.swing_mrad == pytest.approx(swing * 1e3, rel=1e-9)
        assert reversal_swing_mrad(layout_of(one)) == pytest.approx(swing * 1e3, rel=1e-9)
        turns[name] = swing
    assert turns["counted"] / turns["none"] - 1.0 == pytest.approx(0.08, abs=0.01), turns
    physics = Physics()
    for one, slips in ((drive, False), (counted, True)):
        bench = bench_of(one, np.arange(3.0), np.zeros(3), np.zeros((2, 3)), np.random.default_rng(1), physics)
        assert bench.passed_slip is slips and not bench.unseen_slip
