"""Effects in proportion to the speed: a late sensor, a viscous drag."""

import numpy as np
from scipy.interpolate import CubicHermiteSpline

from mbcdm_cad.loop.effect import Effect, Effects, Parameter, Words
from mbcdm_cad.loop.prepare.setup import DriveSI, Floats, Prepared, Setup, Simulator


def _late(setup: Setup, values: Floats, _: Simulator) -> Setup:
    t, drum = setup.p.time_s, setup.drum_rad
    # A chord between two samples would cut the corners of the motion by more than the noise of a good encoder.
    curve = CubicHermiteSpline(t, drum, np.gradient(drum, t))
    return setup.with_added(curve(t - values[0]) - drum)


def offer(d: DriveSI | None, p: Prepared) -> Effects:
    """A late sensor always; a drag through the cables' stiffness where it is known and the load was measured."""
    yield Effect(
        "delay",
        "late sensor",
        "the output is read later than the input: an error in proportion to speed",
        "filter of the output encoder, time stamps of the logger",
        "an output sensor of known latency, or none of its filters",
        (Parameter("delay_s", 1e-5),),
        _late,
        hangs_on="speed",
        plain="the output is read {delay_s} later than the input",
        reversed_words=Words(
            "the input is read later than the output: an error in proportion to speed",
            "filter of the input encoders, polling of the motor's drive, time stamps of the logger",
            "the input is read {delay_s} later than the output",
        ),
    )
    if d is None or p.load_Nm is None:
        return
    yield Effect(
        "delay",
        "viscous drag",
        "a torque in proportion to speed, through the stiffness",
        "grease of the bearings",
        "the same motion with a filter-free sensor",
        (Parameter("drag_Nm_s", 0.05, 0.0),),
        lambda s, v, _: s.with_rubbed(v[0] * s.p.speed_rad_s),
        hangs_on="speed",
        plain="something drags in proportion to the speed, with {drag_Nm_s}",
    )
