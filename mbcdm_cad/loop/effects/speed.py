"""Effects of the speed: bearing friction by its sign, a late sensor or a viscous drag by its magnitude."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy.interpolate import CubicHermiteSpline

from mbcdm_cad.loop.effect import Effect, Parameter, Words
from mbcdm_cad.loop.prepare.prepared import Prepared
from mbcdm_cad.loop.prepare.setup import Setup, Simulator
from mbcdm_cad.model.si import DriveSI
from mbcdm_cad.routes import Floats


def _bearing(setup: Setup, values: Floats, _: Simulator) -> Setup:
    return replace(setup, load_Nm=setup.load + values[0] * setup.p.sense)


def _in_the_torque(setup: Setup, values: Floats, _: Simulator) -> Setup:
    return replace(setup, load_Nm=setup.load - values[0] * setup.p.sense)


def _not_measured(setup: Setup, values: Floats, _: Simulator) -> Setup:
    return replace(setup, load_Nm=values[0] * setup.p.sense)


def _hysteresis(setup: Setup, values: Floats, _: Simulator) -> Setup:
    return setup.with_added(-values[0] * setup.p.sense)


def _late(setup: Setup, values: Floats, _: Simulator) -> Setup:
    t, drum = setup.p.time_s, setup.drum_rad
    # A chord between two samples would cut the corners of the motion by more than the noise of a good encoder.
    curve = CubicHermiteSpline(t, drum, np.gradient(drum, t))
    return setup.with_added(curve(t - values[0]) - drum)


def _viscous(setup: Setup, values: Floats, _: Simulator) -> Setup:
    return replace(setup, load_Nm=setup.load + values[0] * setup.p.speed_rad_s)


def offer(d: DriveSI | None, p: Prepared) -> list[Effect]:
    """Delay always; friction through the cables' stiffness where it is known, else as a shift with the sense.

    Without a torque column a friction is no more than a torque that was not measured.
    """
    late = Effect(
        "delay",
        "late sensor",
        "the output is read later than the input: an error in proportion to speed",
        "filter of the output encoder, time stamps of the logger",
        "an output sensor of known latency, or none of its filters",
        (Parameter("delay_s", 1e-5),),
        _late,
        hangs_on="speed",
        generic=True,
        plain="the output is read {delay_s} later than the input",
        reversed_words=Words(
            "the input is read later than the output: an error in proportion to speed",
            "filter of the input encoders, polling of the motor's drive, time stamps of the logger",
            "the input is read {delay_s} later than the output",
        ),
    )
    bias = "a constant bias torque: friction keeps to the speed, lash and the cables to the torque"
    if d is not None and p.load_Nm is None:
        load = Effect(
            "friction",
            "torque that was not measured",
            "a load or a friction against the motion, through the cables",
            "brake, bearings and seals of the drum",
            "log the load's torque, or run without a load",
            (Parameter("torque_Nm", 0.05, 0.0),),
            _not_measured,
            generic=True,
            unmeasured=True,
            plain="{torque_Nm} against the motion, which no sensor measured, would explain the error",
        )
        return [late, load]
    if d is None:
        shift = Effect(
            "friction",
            "shift with the sense of motion",
            "friction behind a stiffness that is not known",
            "bearings and seals between input and output",
            bias,
            (Parameter("half_width_rad", 1e-5, 0.0),),
            _hysteresis,
            generic=True,
            plain="friction holds the output back by {half_width_rad} in both directions",
        )
        return [late, shift]
    bearing = Effect(
        "friction",
        "bearing torque",
        "a torque against the motion that the sensor does not see",
        "drum bearings and seals: turn the drum by hand with the cables off",
        bias,
        (Parameter("torque_Nm", 0.01, 0.0),),
        _bearing,
        generic=True,
        plain="the bearings hold back {torque_Nm} that the torque sensor does not see",
    )
    expected = p.run.parts.friction_Nm if p.run.parts is not None else 0.0
    if expected:
        bearing = replace(
            bearing,
            physics="a torque against the motion besides the losses that the design states",
            parameters=(Parameter("torque_Nm", 0.01, -expected),),
            plain="cables and bearings hold back {torque_Nm} more than the design's losses",
            reversed_words=Words(
                "cables and bearings rub less than the design's losses say",
                "lubrication and run-in of cables and bearings",
                "cables and bearings hold back less than the design's losses, by {torque_Nm}",
            ),
        )
    inside = replace(
        bearing,
        parameters=(Parameter("torque_Nm", 0.01, 0.0),),
        reversed_words=None,
        form="friction in the measured torque",
        physics="the torque was taken before a friction, as from the motor's current: the drum bears less than it says",
        where_to_look="friction of motor, gearhead and seals before the drum: current of the motor without a load",
        apply=_in_the_torque,
        plain="the measured torque contains {torque_Nm} of friction that the drum does not bear",
    )
    viscous = Effect(
        "delay",
        "viscous drag",
        "a torque in proportion to speed, through the stiffness",
        "grease of the bearings",
        "the same motion with a filter-free sensor",
        (Parameter("drag_Nm_s", 0.05, 0.0),),
        _viscous,
        hangs_on="speed",
        generic=True,
        plain="something drags in proportion to the speed, with {drag_Nm_s}",
    )
    return [late, viscous, bearing, inside]
