"""Whole runs of the dynamic rig: laws for any cables."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from benchmarks.studies.paper_experiments import reversal_swings_rad
from mbcdm_cad.layouts.loader import load_design
from mbcdm_cad.rig.dynamic.rig import DynamicRig, EncoderSpec, rig_of
from mbcdm_cad.rig.dynamic.run import DynamicRun, run_dynamic
from mbcdm_cad.rig.dynamic.train import LoadSpec, sine, standstill

DRIVE = load_design(Path(__file__).parents[3] / "params" / "mbcdm.yaml").drive


def quiet(rig: DynamicRig) -> DynamicRig:
    """The rig with encoders without counts or noise."""
    none = EncoderSpec(0.0)
    return replace(rig, encoders=(none, none), drum_encoder=none, torque_noise_Nm=0.0)


def missing_J(run: DynamicRun) -> float:
    """Energy that the account does not find."""
    e = run.energy_J
    spent = sum(e[name] for name in ("load", "rotor_friction", "pulley_friction", "drum_friction", "viscous", "cables"))
    return e["motor"] - spent - e["stored"]


def test_energy_balance_of_a_braked_run() -> None:
    run = run_dynamic(quiet(rig_of(DRIVE)), sine(0.05, 0.5, 2, 1000.0), brake_Nm=0.91)
    through = run.energy_J["motor"]
    assert abs(missing_J(run)) < 2e-3 * through, f"{missing_J(run):.3e} J of {through:.3e} J missing"
    # A brake of 0.91 N m over what the drum travelled.
    travelled = np.abs(np.diff(run.drum_rad)).sum()
    assert run.energy_J["drum_friction"] == pytest.approx(0.91 * travelled, rel=5e-3)


def test_friction_of_the_bearings_by_speed_and_load_takes_the_energy_of_its_law() -> None:
    """The law once more, over the logged motion; the load drives the drum in every other half sweep."""
    law = LoadSpec(0.0, 1.0, 1e-3, 0.0, 0.0, 0.02, 0.2, 0.02, 0.1, 0.2, 0.1)
    reference = sine(0.05, 0.5, 2, 1000.0)
    run = run_dynamic(quiet(rig_of(DRIVE, law)), reference, 0.5 * np.ones(reference.shape[0]), log_rate_Hz=1000.0)
    w = np.gradient(run.drum_rad, run.time_s)
    limit = 0.02 + 0.02 * np.exp(-np.abs(w) / 0.1) + 0.5 * np.where(w > 0.0, 0.2, 0.1)
    expected = float(np.sum(limit * np.abs(w)) * (run.time_s[1] - run.time_s[0]))
    assert run.energy_J["drum_friction"] == pytest.approx(expected, rel=0.01)
    assert abs(missing_J(run)) < 2e-3 * run.energy_J["motor"]


def test_same_seed_same_run() -> None:
    rig = rig_of(DRIVE)
    rig = replace(rig, encoders=tuple(replace(e, noise_rad=1e-5) for e in rig.encoders))
    reference = sine(0.01, 1.0, 1, 1000.0)
    first, again, other = (run_dynamic(rig, reference, brake_Nm=0.3, seed=s) for s in (3, 3, 4))
    for name in ("drum_rad", "measured_input_rad", "measured_torque_Nm", "tension_N"):
        assert getattr(first, name).tobytes() == getattr(again, name).tobytes(), name
        assert getattr(first, name).tobytes() != getattr(other, name).tobytes(), name


def test_measured_angles_are_whole_counts_and_the_delay_shifts_them() -> None:
    rig = rig_of(DRIVE)
    reference = sine(0.05, 0.5, 1, 1000.0)
    run = run_dynamic(rig, reference, log_rate_Hz=1000.0)
    counts = run.measured_input_rad / rig.encoders[0].resolution_rad
    assert np.abs(counts - np.round(counts)).max() < 1e-6
    assert np.abs(run.measured_input_rad - run.input_rad).max() <= rig.encoders[0].resolution_rad * 0.501
    late = replace(quiet(rig), encoders=(EncoderSpec(0.0, delay_s=0.004),) * 2)
    run = run_dynamic(late, reference, log_rate_Hz=1000.0)
    shift = np.abs(run.measured_input_rad[:, 4:] - run.input_rad[:, :-4]).max()
    assert shift == 0.0, f"readings 4 ms old differ by {shift:.3g} rad from the angles 4 ms ago"


def test_loops_hold_the_inputs_on_average() -> None:
    run = run_dynamic(rig_of(DRIVE), sine(0.05, 0.1, 1.5, 1000.0), brake_Nm=0.91)
    error = run.input_rad[:, 500:] - 9.0 * run.reference_rad[500:]
    assert np.abs(error).mean() < 2e-3, f"inputs are off by {np.abs(error).mean():.2e} rad on average"


def test_sensor_reads_the_brake_while_the_drum_turns() -> None:
    load = LoadSpec(bearing_drag_Nm=0.05)
    run = run_dynamic(quiet(rig_of(DRIVE, load)), sine(0.05, 0.1, 0.5, 1000.0), brake_Nm=0.5)
    turning = (run.time_s > 1.0) & (run.time_s < 2.0)
    assert run.torque_Nm[turning] == pytest.approx(0.5, abs=1e-6), "bearing drag is behind the sensor"


def test_inertia_plate_is_felt_as_torque() -> None:
    plate = 2e-3
    reference = sine(0.05, 1.0, 3, 1000.0)
    run = run_dynamic(quiet(rig_of(DRIVE, LoadSpec(inertia_kg_m2=plate))), reference, log_rate_Hz=1000.0)
    wave = np.exp(2j * np.pi * run.time_s[1000:])  # whole turns of the 1 Hz line
    torque, angle = (abs(np.vdot(wave, x[1000:])) * 2 / wave.size for x in (run.torque_Nm, run.drum_rad))
    assert torque == pytest.approx(plate * (2 * np.pi) ** 2 * angle, rel=0.01), "torque is plate times acceleration"


@pytest.mark.slow
def test_a_brake_with_a_higher_static_level_sticks_and_slips() -> None:
    def jumps(ratio: float) -> float:
        load = LoadSpec(inertia_kg_m2=1e-3, static_ratio=ratio, static_speed_rad_s=5e-3)
        run = run_dynamic(quiet(rig_of(DRIVE, load)), sine(0.002, 0.05, 1, 1000.0), brake_Nm=0.91, log_rate_Hz=1000.0)
        speed = np.abs(np.diff(run.drum_rad)) * 1000.0
        return float(speed[2000:].max())

    smooth, rough = jumps(1.0), jumps(1.3)
    assert rough > 3.0 * smooth, f"fastest {smooth:.2e} rad/s with one level, {rough:.2e} rad/s with 1.3 at standstill"


def test_lash_adds_to_what_rotor_and_pulley_turn_against_each_other() -> None:
    def twist(lash: float) -> float:
        rig = quiet(rig_of(DRIVE))
        rig = replace(rig, gearheads=tuple(replace(g, lash_rad=lash) for g in rig.gearheads))
        run = run_dynamic(rig, sine(0.02, 0.2, 2, 1000.0), brake_Nm=0.91, log_rate_Hz=1000.0)
        turned = (run.rotor_rad - run.input_rad)[1, 2000:]
        torque = run.torque_Nm[2000:]
        return float(np.median(turned[torque > 0.9]) - np.median(turned[torque < -0.9]))

    tight, loose = twist(0.0), twist(0.02)
    assert loose - tight == pytest.approx(0.02, rel=0.05), f"twists {tight:.5f} and {loose:.5f} rad"


@pytest.mark.slow
def test_a_longer_step_converges_to_the_same_run() -> None:
    def swing(step_s: float) -> float:
        rig = replace(quiet(rig_of(DRIVE)), step_s=step_s)
        return float(np.mean(reversal_swings_rad(run_dynamic(rig, sine(0.02, 0.2, 2, 1000.0), brake_Nm=0.91), DRIVE)))

    coarse, usual, fine = swing(5e-4), swing(1e-4), swing(5e-5)
    assert abs(usual - fine) < 2e-7, f"swings {coarse:.7f}, {usual:.7f}, {fine:.7f} rad at 500, 100, 50 us"
    assert abs(coarse - fine) < 2e-6, f"swings {coarse:.7f}, {usual:.7f}, {fine:.7f} rad at 500, 100, 50 us"


def test_reference_s_speed_and_acceleration_are_its_derivatives() -> None:
    reference = sine(0.1, 0.5, 1, 10000.0)
    for order in (1, 2):
        slope = np.gradient(reference[:, order - 1], 1e-4)[1:-1]
        error = np.abs(slope - reference[1:-1, order]).max() / np.abs(slope).max()
        assert error < 1e-3, f"derivative {order} differs by {error:.2e} of its size"
    assert reference[0] == pytest.approx([0.0, 0.0, 0.0]), "it does not start from rest"


def test_rates_that_do_not_divide_are_refused() -> None:
    with pytest.raises(ValueError, match="log_rate_Hz"):
        run_dynamic(rig_of(DRIVE), standstill(0.01, 1000.0), log_rate_Hz=300.0)
    with pytest.raises(ValueError, match="step_s"):
        run_dynamic(replace(rig_of(DRIVE), step_s=3e-4), standstill(0.01, 1000.0))
