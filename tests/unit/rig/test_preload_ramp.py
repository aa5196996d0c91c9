"""Preloads measured by ramps of an input's torque on the rig, with sensor noise and a rope that differs."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pytest

from mbcdm_cad.design.drive import Drive
from mbcdm_cad.layouts.loader import layout_of, load_design
from mbcdm_cad.layouts.lumped import friction_of
from mbcdm_cad.model.losses import Train
from mbcdm_cad.model.preload_ramp import HeldDrive, Ramp, SampleNoise, expected, fitted
from mbcdm_cad.model.si import DriveSI, ModelError
from mbcdm_cad.rig import chain
from mbcdm_cad.rig.bench import cables_of
from mbcdm_cad.rig.dynamic.train import gearhead_of
from mbcdm_cad.routes import Floats

PARAMS = Path(__file__).parents[3] / "params"
INPUT_RAD, DRUM_RAD = 9.0, 2.0


@dataclass(frozen=True)
class Built:
    """How the drive on the rig differs from its design: factors on each figure; ``seal`` friction at the shaft, N m."""

    preload: tuple[float, ...] = (1.0,) * 4
    stiffness: float = 1.0
    wraps: float = 1.0
    rope: float = 0.0
    bearings: float = 0.0
    seal_Nm: float = 0.0
    gearhead: float = 1.0
    idle: float = 1.0


def drive_of(name: str) -> Drive:
    return load_design(PARAMS / f"{name}.yaml").drive


def wound(name: str) -> DriveSI:
    """A reference with the wraps of the rig."""
    d = layout_of(drive_of(name)).si
    n = d.n_cables
    return d.with_(input_wrap_rad=np.full(n, INPUT_RAD), drum_wrap_rad=np.full(n, DRUM_RAD))


def held(d: DriveSI, train: Train | None = None, at_motor: bool = False) -> HeldDrive:
    wraps = (d.input_wrap_rad, d.drum_wrap_rad)
    return HeldDrive(d, wraps, wraps, train, at_motor)


def there_and_back(ramp: Ramp, samples: int) -> Floats:
    """Angles in the order of time: from 0 to one end and back, then to the other end and back."""
    out = [np.linspace(0.0, end, samples) for end in (ramp.angle_rad[-1], ramp.angle_rad[0])]
    return np.concatenate([np.concatenate([way, way[-2::-1]]) for way in out])


def ramped(name: str, index: int, angle: Floats, built: Built, at_motor: bool = False) -> Floats:
    """Torque at an input of the rig, turned sample by sample with the drum held; each stop starts with fresh cables.

    Friction as the rig has it: rope and bearings by :func:`friction_of`, the gearhead's as in ``rig/dynamic/train``.
    """
    drive = drive_of(name)
    parts, gear = friction_of(drive), gearhead_of(drive)
    cables = tuple(
        replace(
            c, preload_N=c.preload_N * f, stiffness_N=c.stiffness_N * built.stiffness, friction=c.friction * built.wraps
        )
        for c, f in zip(cables_of(drive), built.preload, strict=False)
    )
    own = [j for j, c in enumerate(cables) if c.input_index == index]
    found, state = np.empty(angle.size), None
    for k, now in enumerate(angle):
        before = angle[k - 1] if k else 0.0
        if state is None or (before == 0.0 and now != 0.0) or before * now < 0.0:
            state = chain.chains(
                cables, transport=False, input_wrap_rad=INPUT_RAD, drum_wrap_rad=DRUM_RAD, piece_rad=0.02
            )
        tension = {j: chain.advance(state, j, float(now), 0.0, 0.0) for j in own}
        pulled = sum(cables[j].sigma * cables[j].input_radius_m * t for j, t in tension.items())
        rubs = sum(built.rope * parts.input_share[j] * cables[j].input_radius_m * t for j, t in tension.items())
        rubs += built.bearings * parts.input_bearings_Nm[index] + built.seal_Nm
        way = float(np.sign(now - before)) or 1.0
        found[k] = pulled + way * rubs
        if at_motor:
            idle = built.idle * (parts.gear_idle_Nm + gear.ratio * parts.motor_Nm)
            found[k] += way * (built.gearhead * gear.loss_share * abs(found[k]) + idle)
    return found


@pytest.mark.parametrize("at_motor", [False, True], ids=["shaft", "motor"])
@pytest.mark.parametrize(("name", "index"), [("mbcdm", 0), ("mbcdm", 1), ("siso_bevel", 0)])
def test_each_preload_is_found_within_5_percent(name: str, index: int, at_motor: bool) -> None:
    """With noise and all losses, each of them another than the design says, read at the shaft and at the motor."""
    d, rng = wound(name), np.random.default_rng(7)
    believed = held(d, layout_of(drive_of(name)).losses.with_drive(d), at_motor)
    noise = SampleNoise(angle_rad=50e-6, torque_Nm=0.004)
    built = Built((1.25, 0.8, 0.85, 1.15), 0.93, 1.15, 1.5, 1.3, 0.004, 1.25, 1.5)
    angle = there_and_back(expected(believed, index, noise), 60)
    torque = ramped(name, index, angle, built, at_motor)
    found = fitted(
        believed,
        index,
        angle + noise.angle_rad * rng.standard_normal(angle.size),
        torque + noise.torque_Nm * rng.standard_normal(angle.size),
        noise,
    )
    true = d.preload_N[list(found.cables)] * np.array(built.preload)[list(found.cables)]
    assert found.preload_N == pytest.approx(true, rel=0.05), (found.preload_N, true, found.sigma_N)
    assert np.all(found.sigma_N < 0.05 * true), found.sigma_N


def test_friction_that_the_evaluation_leaves_out_shifts_what_it_finds() -> None:
    """The same log, read as if it were without friction, misses by more than 5 %: the test above can fail."""
    d = wound("mbcdm")
    train = layout_of(drive_of("mbcdm")).losses.with_drive(d)
    noise = SampleNoise(angle_rad=50e-6, torque_Nm=0.004)
    angle = there_and_back(expected(held(d, train), 0, noise), 60)
    torque = ramped("mbcdm", 0, angle, Built(rope=1.0, bearings=1.0), at_motor=True)
    blind = fitted(held(d), 0, angle, torque, noise)
    seeing = fitted(held(d, train, at_motor=True), 0, angle, torque, noise)
    true = d.preload_N[list(blind.cables)]
    assert np.abs(blind.preload_N / true - 1.0).max() > 0.1, blind.preload_N
    assert seeing.preload_N == pytest.approx(true, rel=0.02), seeing.preload_N


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
    rising, falling = np.sort(angle[angle >= 0.0]), np.sort(angle[angle < 0.0])[::-1]
    angle = np.concatenate([rising, falling])
    rig = ramped("mbcdm", 0, angle, Built())
    assert held(d).torque_Nm(0, angle) == pytest.approx(rig, abs=0.01 * float(np.abs(rig).max()))


def test_a_short_log_is_refused() -> None:
    with pytest.raises(ModelError, match="at least 8 samples"):
        fitted(held(wound("mbcdm")), 0, np.zeros(5), np.zeros(5), SampleNoise(1e-5, 1e-3))
