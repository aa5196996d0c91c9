"""Preloads measured by ramps of an input's torque on the rig, with sensor noise and a rope that differs."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from mbcdm_cad.layouts.loader import load_design
from mbcdm_cad.model.preload_ramp import HeldDrive, SampleNoise, expected, fitted
from mbcdm_cad.model.si import DriveSI, ModelError, to_si
from mbcdm_cad.rig import chain
from mbcdm_cad.rig.cables import cables_of
from mbcdm_cad.routes import Floats

PARAMS = Path(__file__).parents[3] / "params"
INPUT_RAD, DRUM_RAD = 9.0, 2.0


def wound(name: str) -> DriveSI:
    """A reference with the wraps of the rig."""
    d = to_si(load_design(PARAMS / f"{name}.yaml").drive)
    n = d.n_cables
    return d.with_(input_wrap_rad=np.full(n, INPUT_RAD), drum_wrap_rad=np.full(n, DRUM_RAD))


def held(d: DriveSI) -> HeldDrive:
    wraps = (d.input_wrap_rad, d.drum_wrap_rad)
    return HeldDrive(d, wraps, wraps)


def ramped(name: str, index: int, angle: Floats, factors: list[float], stiffness: float, friction: float) -> Floats:
    """Torque at an input of the rig, turned sample by sample with the drum held, from fresh cables each way."""
    cables = tuple(
        replace(c, preload_N=c.preload_N * f, stiffness_N=c.stiffness_N * stiffness, friction=c.friction * friction)
        for c, f in zip(cables_of(load_design(PARAMS / f"{name}.yaml").drive), factors, strict=True)
    )
    own = [j for j, c in enumerate(cables) if c.input_index == index]
    found = np.empty(angle.size)
    for way in (angle < 0.0, angle >= 0.0):
        state = chain.chains(cables, transport=False, input_wrap_rad=INPUT_RAD, drum_wrap_rad=DRUM_RAD, piece_rad=0.01)
        order = np.flatnonzero(way)
        for k in order[np.argsort(np.abs(angle[order]))]:
            tension = {j: chain.advance(state, j, float(angle[k]), 0.0, 0.0) for j in own}
            found[k] = sum(cables[j].sigma * cables[j].input_radius_m * t for j, t in tension.items())
    return found


@pytest.mark.parametrize(("name", "index"), [("mbcdm", 0), ("mbcdm", 1), ("siso_bevel", 0)])
def test_each_preload_is_found_within_5_percent(name: str, index: int) -> None:
    d, rng = wound(name), np.random.default_rng(7)
    noise = SampleNoise(angle_rad=50e-6, torque_Nm=0.004)
    ramp = expected(held(d), index, noise)
    factors = [1.25, 0.8, 0.85, 1.15][: d.n_cables]
    angle = np.sort(
        np.concatenate([np.linspace(ramp.angle_rad[0], 0.0, 100), np.linspace(1e-6, ramp.angle_rad[-1], 100)])
    )
    torque = ramped(name, index, angle, factors, stiffness=0.93, friction=1.15)
    found = fitted(
        held(d),
        index,
        angle + noise.angle_rad * rng.standard_normal(angle.size),
        torque + noise.torque_Nm * rng.standard_normal(angle.size),
        noise,
    )
    true = d.preload_N[list(found.cables)] * np.array(factors)[list(found.cables)]
    assert found.preload_N == pytest.approx(true, rel=0.05), (found.preload_N, true, found.sigma_N)
    assert np.all(found.sigma_N < 0.05 * true), found.sigma_N


def test_the_curve_of_springs_without_friction_has_its_knee_where_a_cable_is_slack() -> None:
    """By hand: two springs EA/L; at the knee the slack one has lost its preload, the tight one gained as much r k."""
    d = wound("siso_bevel").with_(friction_coefficient=1e-9)
    length = d.free_span_m + d.input_radius_m * INPUT_RAD + d.drum_radius_m * DRUM_RAD
    k = d.axial_stiffness_N / length
    ramp = expected(held(d), 0, SampleNoise(1e-5, 1e-3))
    for knee, torque, name in zip(ramp.knee_rad, ramp.knee_Nm, ramp.slack_first, strict=True):
        j = d.cable_names.index(name)
        other = 1 - j
        by_hand = 0.95 * d.preload_N[j] / (k[j] * d.input_radius_m[j])
        assert abs(knee) == pytest.approx(float(by_hand), rel=1e-3)
        tight = d.preload_N[other] + k[other] * d.input_radius_m[other] * abs(knee)
        expected_Nm = d.input_radius_m[other] * tight - d.input_radius_m[j] * 0.05 * d.preload_N[j]
        assert abs(torque) == pytest.approx(float(expected_Nm), rel=1e-3)


def test_the_rig_and_the_model_agree_on_the_curve() -> None:
    d = wound("mbcdm")
    angle = expected(held(d), 0, SampleNoise(1e-5, 1e-3)).angle_rad[::6]
    rig = ramped("mbcdm", 0, angle, [1.0] * 4, 1.0, 1.0)
    assert held(d).torque_Nm(0, angle) == pytest.approx(rig, abs=0.01 * float(np.abs(rig).max()))


def test_a_short_log_is_refused() -> None:
    with pytest.raises(ModelError, match="at least 8 samples"):
        fitted(held(wound("mbcdm")), 0, np.zeros(5), np.zeros(5), SampleNoise(1e-5, 1e-3))
