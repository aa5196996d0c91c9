"""The dynamic rig compared with the quasi-static equilibrium and the analytic model."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from benchmarks.studies.paper_experiments import first_saturated_Nm, given_way_Nm
from mbcdm_cad.layouts.loader import layout_of, load_design
from mbcdm_cad.model.capability import torque_at_input_limit_Nm
from mbcdm_cad.model.hysteresis import simulate
from mbcdm_cad.rig import quasistatic
from mbcdm_cad.rig.chain import chains
from mbcdm_cad.rig.dynamic.rig import DynamicRig, EncoderSpec, rig_of
from mbcdm_cad.rig.dynamic.run import run_dynamic
from mbcdm_cad.rig.dynamic.train import sine, standstill

DRIVE = load_design(Path(__file__).parents[3] / "params" / "mbcdm.yaml").drive


def ideal(**changes: object) -> DynamicRig:
    """Lossless motors and gearheads, encoders without counts: what the analytic model assumes."""
    rig = rig_of(DRIVE, ideal_gearhead=True)
    none = EncoderSpec(0.0)
    motors = tuple(replace(m, coulomb_Nm=0.0, viscous_Nms=0.0) for m in rig.motors)
    changed = replace(rig, motors=motors, encoders=(none, none), drum_encoder=none, torque_noise_Nm=0.0)
    return replace(changed, **changes)  # type: ignore[arg-type]


def ramp(rig: DynamicRig, sign: float) -> tuple[float, float]:
    """Load at which the first input is at its limit, and at which the drum is off by 20 mrad, N m."""
    slope, rate = 0.2, rig.loops[0].rate_Hz
    reference = standstill(4.4 / slope, rate)
    run = run_dynamic(rig, reference, sign * slope / rate * np.arange(reference.shape[0], dtype=float))
    return first_saturated_Nm(run, [loop.torque_limit_Nm for loop in rig.loops]), given_way_Nm(run)


@pytest.mark.parametrize(("sign", "known_Nm"), [(1.0, 3.747), (-1.0, 3.194)])
@pytest.mark.slow
def test_drive_limit_both_ways(sign: float, known_Nm: float) -> None:
    """The first input saturates where the analytic model says; the drum holds on until both do, at 3.967 N m."""
    limit = DRIVE.motor.rated_torque_mNm * 1e-3 * DRIVE.gearhead.ratio
    expected = float(torque_at_input_limit_Nm(layout_of(DRIVE).si, limit, int(sign)).min())
    first, gives_way = ramp(ideal(), sign)
    assert expected == pytest.approx(known_Nm, abs=2e-3)
    assert first == pytest.approx(expected, rel=0.01), f"rig {first:.4f} N m, model {expected:.4f} N m"
    assert gives_way == pytest.approx(2.0 * limit * 9.0, rel=0.03), f"{gives_way:.3f} N m with the ramp's lag"


def test_braked_run_is_the_analytic_model_where_its_assumptions_hold() -> None:
    """Wraps that stand still: the drum stands where the model puts it at the same input angles and load."""
    rig = ideal(transport=False)
    run = run_dynamic(rig, sine(0.05, 0.2, 2, 1000.0), brake_Nm=0.91)
    model = simulate(layout_of(DRIVE).si, run.input_rad, run.torque_Nm)
    still = np.abs(np.gradient(run.torque_Nm, run.time_s)) < 1.0
    error = np.abs(run.drum_rad - model.drum_angle_rad)[still].max()
    size = np.abs(model.drum_angle_rad - run.input_rad.mean(axis=0) / 9.0)[still].max()
    assert error < 0.005 * size, f"{error * 1e6:.3f} urad of {size * 1e6:.1f} urad beside the model"


@pytest.mark.parametrize("passed_slip", [False, True])
def test_slow_run_is_the_quasi_static_rig(passed_slip: bool) -> None:
    """The same chains in balance at each sample: drum and tensions agree where nothing accelerates."""
    rig = ideal(passed_slip=passed_slip)
    run = run_dynamic(rig, sine(0.05, 0.1, 1, 1000.0), brake_Nm=0.91, log_rate_Hz=200.0)
    n, cables = run.time_s.size, rig.cables
    pulleys, drum, tension = np.empty((2, n)), np.empty(n), np.empty((4, n))
    none = np.zeros((4, n))
    held = np.array([[np.inf, 0.0], [np.inf, 0.0]])
    state = chains(cables, passed_slip=passed_slip)
    of = np.array([c.input_index for c in cables])
    angle = np.ascontiguousarray(run.input_rad)
    course = quasistatic.QuasistaticCourse(
        of,
        held,
        angle,
        none,
        none,
        run.drum_rad,
        run.torque_Nm,
        np.zeros((4, 3, 0)),
        np.zeros((0, 2), dtype=np.int64),
        np.zeros(4),
        np.zeros(run.drum_rad.size),
    )
    failed = quasistatic.run(state, course, pulleys, drum, tension)
    assert failed < 0
    still = np.abs(np.gradient(run.torque_Nm, run.time_s)) < 1.0
    error = np.abs(run.drum_rad - drum)[still].max()
    pull = np.abs(run.tension_N - tension)[:, still].max()
    assert error < 1.5e-6, f"drum differs by {error * 1e6:.3f} urad"
    assert pull < 0.1, f"tensions differ by {pull:.3f} N"


def test_carried_rope_widens_the_loop() -> None:
    """What the model leaves out on purpose: about an eighth more at +-50 mrad under 0.91 N m."""
    widths = []
    for transport in (False, True):
        run = run_dynamic(ideal(transport=transport), sine(0.05, 0.2, 2, 1000.0), brake_Nm=0.91)
        error = (run.drum_rad - run.input_rad.mean(axis=0) / 9.0)[500:]
        widths.append(float(np.ptp(error)))
    assert 1.08 < widths[1] / widths[0] < 1.20, f"widths {widths} rad"


@pytest.mark.slow
def test_shorter_pieces_change_little() -> None:
    swings = []
    for piece_rad in (0.04, 0.02, 0.01):
        run = run_dynamic(ideal(piece_rad=piece_rad), sine(0.05, 0.2, 2, 1000.0), brake_Nm=0.91)
        swings.append(float(np.ptp((run.drum_rad - run.input_rad.mean(axis=0) / 9.0)[500:])))
    assert abs(swings[1] - swings[2]) < 0.01 * swings[2], f"widths {swings} rad at pieces of 40, 20, 10 mrad"


def test_eccentric_guide_turns_the_drum_and_keeps_the_energy_balance() -> None:
    """A path that depends on the angles must pull on the pulleys too: without that, energy would not balance."""
    rig = ideal(paths=(lambda inputs, drum: np.outer([-1e-5, 1e-5, 1e-5, -1e-5], np.sin(6.0 * drum)),))
    run = run_dynamic(rig, sine(0.2, 0.5, 2, 1000.0), brake_Nm=0.2)
    plain = run_dynamic(ideal(), sine(0.2, 0.5, 2, 1000.0), brake_Nm=0.2)
    turned, still = (r.drum_rad - r.input_rad.mean(axis=0) / 9.0 for r in (run, plain))
    shift = np.abs(turned - still)
    e = run.energy_J
    spent = sum(e[name] for name in ("load", "rotor_friction", "pulley_friction", "drum_friction", "viscous", "cables"))
    missing = e["motor"] - spent - e["stored"]
    assert shift.max() > 5e-5, f"the path moved the drum by {shift.max():.2e} rad only"
    assert abs(missing) < 5e-3 * e["motor"], f"{missing:.2e} J of {e['motor']:.2e} J missing"
