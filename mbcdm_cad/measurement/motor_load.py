"""The load that the cables carry, from the motors' currents: torque constant, rotor's inertia, losses of the gearhead.

The rotor, seen at the gearhead's output (ratio N, efficiency e, speed w of the input):

    N k_t I - N^2 J_r dw/dt = s + sgn(w) (N c + (1/e - 1) |s|)

with c the friction of the motor and s what the gearhead carries to the pulley. The drum's load is the sum of s over the
inputs times their turns for one of the drum: what the cables carry, with the inertia and the friction of the drum and
of the load in it. Friction between gearhead and cables is in it too; the loop has a form for that.
Source: derived; the loss is that of a gearhead whose friction grows with the torque carried.
"""

from __future__ import annotations

from dataclasses import replace
from math import hypot, inf, sqrt

import numpy as np
from numpy.typing import NDArray

from mbcdm_cad.design.drive import Drive
from mbcdm_cad.layouts.lumped import axis_friction
from mbcdm_cad.measurement.known_load import motion_of
from mbcdm_cad.measurement.run import (
    KNOWN_LOAD,
    MOTORS_CURRENT,
    BesideSensor,
    Run,
    StatedMotors,
    TorqueClass,
    half_sweeps,
    smoothed,
)
from mbcdm_cad.measurement.schema import MOTION
from mbcdm_cad.routes import Floats

# Below this share of its RMS the sense of the speed is not sharp.
STANDSTILL_SHARE = 0.1
# Slower than this share of the RMS speed the friction hides the load: nothing is fitted there.
SLOW_SHARE = 0.3
# What the fit of a known weight may leave, as a share of the weight's load, both RMS; without noise, by a mean over s.
REST_SHARE, REST_S = 0.05, 0.2
# Weight from which the currents' gain is used beside a sensor's, and the share of the sensor's torque that must not go
# with the motion for a gain to be told from losses.
LEAST_USED, LEAST_TOLD = 0.1, 0.2


def motors_load_Nm(
    figures: StatedMotors, current_A: Floats, input_rad: Floats, time_s: Floats, turns_per_drum: Floats
) -> Floats:
    """Load on the drum, N m (n,), > 0 where it opposes positive rotation.

    ``current_A`` and ``input_rad`` (n_inputs, n) are positive in the sense that drives the drum positive, the angles
    behind the gearhead; ``turns_per_drum`` (n_inputs,). All figures must be given.
    """
    k, ratio, efficiency = figures.torque_constant_Nm_A, figures.gear_ratio, figures.efficiency
    rotor = figures.rotor_inertia_kg_m2
    assert k is not None and ratio is not None and efficiency is not None and rotor is not None
    load = np.zeros_like(time_s)
    for current, angle, turns in zip(current_A, input_rad, turns_per_drum, strict=True):
        speed, acceleration = motion_of(angle, time_s)
        sense = np.sign(speed)
        shaft = ratio * (k * current - figures.friction_Nm * sense) - ratio**2 * rotor * acceleration
        loss = (1.0 / efficiency - 1.0) * sense
        # Forward the loss is on top of what is carried, backward it helps to hold.
        carried = shaft / (1.0 + loss * np.sign(shaft))
        moving = np.abs(speed) > STANDSTILL_SHARE * float(np.std(speed))
        load = load + turns * np.interp(time_s, time_s[moving], carried[moving])
    return load


def with_motors_load(run: Run, drive: Drive | None, turns_per_drum: Floats) -> Run:
    """The run with the load of its motors' currents, unchanged without them; its angles are behind the gearhead.

    Where the load is known too, a weight on an arm, it gives the torque constant; a torque sensor stays the load.
    """
    weight = run.load_Nm if run.sensors.torque_class.what == KNOWN_LOAD else None
    done = run.load_Nm is not None and run.sensors.torque_class.what == MOTORS_CURRENT
    if run.current_A is None or run.motor is None or run.kind != MOTION or done or run.beside is not None:
        return run
    figures = run.motor if drive is None else figures_of(run.motor, drive)
    if run.load_Nm is not None and weight is None:
        return beside_sensor(run, figures, turns_per_drum, run.load_Nm, drive)
    if weight is None:
        load = motors_load_Nm(figures, run.current_A, run.input_rad, run.time_s, turns_per_drum)
        return replace(run, load_Nm=load)
    found, sigma = beside_weight(run, figures, turns_per_drum, weight)
    return replace(run, load_Nm=found, sensors=replace(run.sensors, torque_class=TorqueClass.of_motors(sigma)))


def beside_weight(run: Run, figures: StatedMotors, turns_per_drum: Floats, weight_Nm: Floats) -> tuple[Floats, float]:
    """The load (n,) of motors that turn a known weight (n,), and the standard deviation of its gain, a share.

    The motors' load is fitted as that of the weight, with a friction that has the sense of the motion and may grow with
    the load or the speed, and a zero. Its factor of the weight gives the torque constant: half the class of the known
    load is its standard deviation, and it is weighed with the stated constant by theirs. Where the fit leaves little,
    it stands in place of the currents: these do not show the load where the motion turns, which is where it is extreme.
    """
    table, moving = _carried_by(run, weight_Nm)
    share, sigma = weighed(figures.torque_constant_share, 0.5 * run.sensors.torque_class.share)
    assert run.current_A is not None and figures.torque_constant_Nm_A is not None
    constant = figures.torque_constant_Nm_A
    for last in (False, False, True):
        known = replace(figures, torque_constant_Nm_A=constant)
        load = motors_load_Nm(known, run.current_A, run.input_rad, run.time_s, turns_per_drum)
        factors = np.linalg.lstsq(table[moving], load[moving], rcond=1e-9)[0]
        if factors[0] <= 0.0:
            return load, figures.torque_constant_share
        if not last:
            by_weight = constant / float(factors[0])
            constant = figures.torque_constant_Nm_A + share * (by_weight - figures.torque_constant_Nm_A)
    fitted = table @ factors
    rest = smoothed(load - fitted, REST_S, run.step_s)[moving]
    little = float(np.std(rest)) < REST_SHARE * float(np.std(weight_Nm))
    return fitted if little else load, sigma


def _carried_by(run: Run, load_Nm: Floats) -> tuple[Floats, NDArray[np.bool_]]:
    """What motors carry that turn a load (n,): the load, a friction with the sense of the motion, one that grows with
    the load and one with the speed, and a zero (n, 5); the samples at which they move (n,)."""
    speed = motion_of(run.output_rad, run.time_s)[0]
    sense = np.sign(speed)
    table = np.stack([load_Nm, sense, sense * np.abs(load_Nm), speed, np.ones_like(speed)], axis=1)
    return table, np.abs(speed) > SLOW_SHARE * float(np.std(speed))


def beside_sensor(
    run: Run, figures: StatedMotors, turns_per_drum: Floats, measured_Nm: Floats, drive: Drive | None
) -> Run:
    """The run with what its currents say beside its torque sensor.

    A gain is the same in both senses of power, a loss is not. The sensor's torque stays the load; where the torque
    constant is known well beside the sensor's class, its gain is moved towards that of the currents, by their
    standard deviations.
    """
    assert run.current_A is not None
    table, moving = _carried_by(run, measured_Nm)
    table = table[moving]
    load = motors_load_Nm(figures, run.current_A, run.input_rad, run.time_s, turns_per_drum)[moving]
    factors, square = np.linalg.lstsq(table, load, rcond=1e-9)[:2]
    rest = table[:, 1:]
    alone = table[:, 0] - rest @ np.linalg.lstsq(rest, table[:, 0], rcond=1e-9)[0]
    told = float(np.linalg.norm(alone) / (np.linalg.norm(table[:, 0]) + 1e-300))
    # What the fit leaves goes together over half sweeps: each counts once.
    halves = max(int(half_sweeps(run.output_rad).max()), 1)
    spread = float(np.sqrt(square.sum() / load.size / halves) / (np.std(alone) + 1e-300))
    gain, constant_sigma = float(factors[0]), hypot(figures.torque_constant_share, spread)
    of_design = None
    if drive is not None:
        axis = axis_friction(drive)
        of_design = axis.drum_Nm + float(np.dot(axis.inputs_Nm, np.abs(turns_per_drum)))
    speed = float(np.sqrt(np.mean(table[:, 3] ** 2)))
    given = run.sensors.torque_class
    used, sigma = weighed(0.5 * given.share, constant_sigma)
    found = BesideSensor(
        gain, constant_sigma, float(factors[1]), float(factors[2]), float(factors[3]) * speed, told, of_design
    )
    if used < LEAST_USED or told < LEAST_TOLD or gain <= 0.0:
        return replace(run, beside=found)
    sensors = replace(
        run.sensors, torque_class=replace(given, share=2.0 * sigma, gain_sigma=sigma, zero_share=given.zero)
    )
    load_Nm = measured_Nm * (1.0 + used * (gain - 1.0))
    return replace(run, load_Nm=load_Nm, sensors=sensors, beside=replace(found, used=used))


def weighed(stated: float, by_weight: float) -> tuple[float, float]:
    """How much a known weight counts beside the stated torque constant, and the standard deviation of what both say.

    Both arguments are standard deviations, shares of the constant.
    """
    if stated == 0.0 or by_weight == inf:
        return 0.0, stated
    share = stated**2 / (stated**2 + by_weight**2)
    return share, by_weight * sqrt(share)


def figures_of(given: StatedMotors, drive: Drive) -> StatedMotors:
    """The figures with those of the design's motor and gearhead in place of what is not given.

    The torque constant stays None where the catalogue does not have it.
    """
    constant = drive.motor.torque_constant_mNm_A

    def first(one: float | None, other: float | None) -> float | None:
        return other if one is None else one

    return replace(
        given,
        torque_constant_Nm_A=first(given.torque_constant_Nm_A, None if constant is None else 1e-3 * constant),
        gear_ratio=first(given.gear_ratio, drive.reduction.ratio),
        efficiency=first(given.efficiency, drive.reduction.efficiency),
        rotor_inertia_kg_m2=first(given.rotor_inertia_kg_m2, 1e-7 * drive.motor.rotor_inertia_g_cm2),
    )
