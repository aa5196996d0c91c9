"""The load that the cables carry, known or from the motors' currents, and what parts besides the cables do to a run.

The rotor, seen at the gearhead's output (ratio N, efficiency e, speed w of the input):

    N k_t I - N^2 J_r dw/dt = s + sgn(w) (N c + (1/e - 1) |s|)

with c the friction of the motor and s what the gearhead carries to the pulley. The drum's load is the sum of s over the
inputs times their turns for one of the drum: what the cables carry, with the inertia and the friction of the drum and
of the load in it. Friction between gearhead and cables is in it too; the loop has a form for that.
Source: derived; the loss is that of a gearhead whose friction grows with the torque carried.
"""

from contextlib import suppress
from dataclasses import replace
from math import exp, hypot, inf, pi, radians, sqrt

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline
from scipy.signal import savgol_filter

from mbcdm_cad.design.blocks import STANDARD_GRAVITY_M_S2
from mbcdm_cad.design.drive import Drive
from mbcdm_cad.layouts.base import NoFigureError
from mbcdm_cad.layouts.lumped import axis_friction
from mbcdm_cad.layouts.registry import layout_of
from mbcdm_cad.layouts.structure import input_play_rad, structure_of
from mbcdm_cad.measurement.run import BesideSensor, PartsSeen, Run, TorqueClass, half_sweeps, smoothed
from mbcdm_cad.measurement.schema import MOTION, CountedParts, MotorBlock, Pendulum
from mbcdm_cad.model import losses
from mbcdm_cad.model.structure.causes import Cause, sigma_urad_Nm, urad_Nm
from mbcdm_cad.routes import Floats

# The acceleration is that of a curve of fifth order over this share of the motion's period (2 pi times angle over
# speed, RMS): long against noise, and 0.1 % wrong for a sine.
SHARE_OF_PERIOD, ORDER = 0.25, 5
LEAST_SAMPLES = 9


def pendulum_load_Nm(arm: Pendulum, output_rad: Floats, time_s: Floats) -> Floats:
    """Torque of a weight on an arm and of its inertia, N m (n,), > 0 where it opposes positive rotation.

    m g a sin(angle - vertical) + (J + m a^2) times the acceleration, from the measured output (n,) rad at ``time_s``.
    """
    lever = 1e-3 * arm.arm_mm
    weight = arm.mass_kg * STANDARD_GRAVITY_M_S2 * lever * np.sin(output_rad - radians(arm.vertical_deg))
    inertia = arm.inertia_kg_m2 + arm.mass_kg * lever**2
    return np.asarray(weight + inertia * motion_of(output_rad, time_s)[1])


def motion_of(angle_rad: Floats, time_s: Floats) -> tuple[Floats, Floats, float]:
    """Speed and acceleration of a measured angle, (n,): curves over a quarter of the motion's period, on even times;
    and the standard deviation of the faster speed that these leave out, as of a servo that hunts."""
    n = time_s.size
    even = np.linspace(float(time_s[0]), float(time_s[-1]), n)
    step = float(even[1] - even[0])
    # A chord between uneven samples would bend at each of them.
    angle = CubicSpline(time_s, angle_rad)(even)
    quiet = savgol_filter(angle, min(LEAST_SAMPLES, n - 1 + n % 2), ORDER, deriv=1, delta=step)
    period = 2.0 * pi * float(np.std(angle)) / max(float(np.std(quiet)), 1e-30)
    width = int(np.clip(SHARE_OF_PERIOD * period / step, LEAST_SAMPLES, n // 2)) // 2 * 2 + 1
    smooth, bent = (savgol_filter(angle, width, ORDER, deriv=order, delta=step) for order in (1, 2))
    # By the median, to which the turns of a triangle do not matter.
    faster = 1.4826 * float(np.median(np.abs(quiet - smooth)))
    return np.interp(time_s, even, smooth), np.interp(time_s, even, bent), faster


# Below this share of its RMS, and of the standard deviations of a faster one, the sense of the speed is not sharp.
STANDSTILL_SHARE, OPEN_SENSE = 0.1, 3.0
# Slower than this share of the RMS speed the friction hides the load: nothing is fitted there.
SLOW_SHARE = 0.3
# What the fit of a known weight may leave, as a share of the weight's load, both RMS; without noise, by a mean over s.
REST_SHARE, REST_S = 0.05, 0.2
# Weight from which the currents' gain is used beside a sensor's, and the share of the sensor's torque that must not go
# with the motion for a gain to be told from losses.
LEAST_USED, LEAST_TOLD = 0.1, 0.2


def motors_load_Nm(
    figures: MotorBlock, current_A: Floats, input_rad: Floats, time_s: Floats, turns_per_drum: Floats
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
        speed, acceleration, faster = motion_of(angle, time_s)
        sense = np.sign(speed)
        shaft = ratio * (k * current - figures.friction_Nm * sense) - ratio**2 * rotor * acceleration
        loss = (1.0 / efficiency - 1.0) * sense
        # Forward the loss is on top of what is carried, backward it helps to hold.
        carried = shaft / (1.0 + loss * np.sign(shaft))
        # A sense that is wrong turns the loss round: one such sample would be the largest load of the run.
        usual = float(np.std(speed))
        moving = np.abs(speed) > float(np.clip(OPEN_SENSE * faster, STANDSTILL_SHARE * usual, usual))
        load = load + turns * np.interp(time_s, time_s[moving], carried[moving])
    return load


def with_motors_load(run: Run, drive: Drive | None, turns_per_drum: Floats) -> Run:
    """The run with the load of its motors' currents, unchanged without them; its angles are behind the gearhead.

    Where the load is known too, a weight on an arm, it gives the torque constant; a torque sensor stays the load.
    """
    weight = run.load_Nm if run.sensors.torque_class.of_known else None
    done = run.load_Nm is not None and run.sensors.torque_class.of_currents
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


def beside_weight(run: Run, figures: MotorBlock, turns_per_drum: Floats, weight_Nm: Floats) -> tuple[Floats, float]:
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
        known = figures.model_copy(update={"torque_constant_Nm_A": constant})
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
    run: Run, figures: MotorBlock, turns_per_drum: Floats, measured_Nm: Floats, drive: Drive | None
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


def figures_of(given: MotorBlock, drive: Drive) -> MotorBlock:
    """The figures with those of the design's motor and gearhead in place of what is not given.

    The torque constant stays None where the catalogue does not have it.
    """
    motor, constant = drive.motor, drive.motor.torque_constant_mNm_A
    of_design = {
        "torque_constant_Nm_A": None if constant is None else 1e-3 * constant,
        "gear_ratio": drive.reduction.ratio,
        "efficiency": drive.reduction.efficiency,
        "rotor_inertia_kg_m2": 1e-7 * motor.rotor_inertia_g_cm2,
    }
    return given.model_copy(update={name: v for name, v in of_design.items() if getattr(given, name) is None})


def parts_seen(drive: Drive, counted: CountedParts, motor_side: bool) -> PartsSeen:
    """Give, friction and play of a drive's parts between the encoders of a run.

    ``motor_side``: whether the inputs' encoders sit before the gearheads. A part without a figure counts as rigid.
    """
    causes: tuple[Cause, ...] = ()
    if counted.structure:
        with suppress(NoFigureError):
            if (structure := structure_of(layout_of(drive))) is not None:
                causes = structure.causes if motor_side else structure.at_payload
    seen = [cause for cause in causes if counted.output_at == "payload" or cause.at_encoder]
    give, sigma = 1e-6 * urad_Nm(seen), 1e-6 * sigma_urad_Nm(seen)
    torque, spread = drum_friction_Nm(drive) if counted.losses else (0.0, 0.0)
    play = input_play_rad(drive, motors_held=True) if counted.structure and motor_side else 0.0
    return PartsSeen(give, sigma, torque, exp(spread / torque) if torque else 1.0, play)


def drum_friction_Nm(drive: Drive) -> tuple[float, float]:
    """Friction at the drum between the inputs and the load, with its standard deviation.

    Cables that bend on drum and passed bodies, and the bearings of these, under the preload. What rubs at the inputs
    their encoders do not see.
    """
    train = layout_of(drive).losses
    tension = np.array([cable.preload_N for cable in drive.cables])
    shares = sum((bend.share for bend in train.rope if not bend.on_input), np.zeros(tension.size))
    rope = float((shares * tension * train.d.drum_radius_m).sum())
    pairs = [pair for pair in train.bearings if pair.input_index is None]
    bearings = float(sum(abs(pair.turns) * pair.torque_Nm(tension) for pair in pairs))
    of_rope = losses.FIBRE_SIGMA if train.fibre else losses.ROPE_SIGMA
    return rope + bearings, hypot(rope * of_rope, bearings * losses.BEARING_SIGMA)
