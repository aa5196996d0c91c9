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
from math import inf, sqrt

import numpy as np

from mbcdm_cad.design.drive import Drive
from mbcdm_cad.measurement.known_load import motion_of
from mbcdm_cad.measurement.run import KNOWN_LOAD, Run, StatedMotors, TorqueClass, smoothed
from mbcdm_cad.routes import Floats

# Below this share of its RMS the sense of the speed is not sharp.
STANDSTILL_SHARE = 0.1
# Slower than this share of the RMS speed the friction hides the load: nothing is fitted there.
SLOW_SHARE = 0.3
# What the fit of a known weight may leave, as a share of the weight's load, both RMS; without noise, by a mean over s.
REST_SHARE, REST_S = 0.05, 0.2


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

    Where the load is known too, a weight on an arm, it gives the torque constant.
    """
    weight = run.load_Nm if run.sensors.torque_class.what == KNOWN_LOAD else None
    if run.current_A is None or run.motor is None or (run.load_Nm is not None and weight is None):
        return run
    figures = run.motor if drive is None else figures_of(run.motor, drive)
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
    speed = motion_of(run.output_rad, run.time_s)[0]
    sense = np.sign(speed)
    table = np.stack([weight_Nm, sense, sense * np.abs(weight_Nm), speed, np.ones_like(speed)], axis=1)
    moving = np.abs(speed) > SLOW_SHARE * float(np.std(speed))
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
