"""Errors of the torque sensor: gain, zero, lag and sign. Within the sensor's class they are no effect of the drive.

A class of 1 % allows 1 % of gain and a zero of 1 % of the range. What lies within it is never named: the judge tries it
in place of every effect of the load (:mod:`mbcdm_cad.loop.search.class_of_sensor`). A gain beyond the class looks like
another stiffness of the whole drive, so only zero, lag and sign are candidates of the search.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from mbcdm_cad.loop.effect import Effect, Parameter
from mbcdm_cad.loop.prepare.prepared import Prepared
from mbcdm_cad.loop.prepare.setup import Setup, Simulator
from mbcdm_cad.measurement.run import KNOWN_LOAD, TorqueClass
from mbcdm_cad.model.si import DriveSI
from mbcdm_cad.routes import Floats

SENSOR = "an error of the torque sensor"
LOOK = "torque sensor and amplifier: "
# Bounds of the search: a zero of this share of the largest load, a lag in s.
MOST_ZERO, MOST_LAG_S = 0.5, 0.5


def _gain(setup: Setup, values: Floats, _: Simulator) -> Setup:
    return replace(setup, load_Nm=setup.load * (1.0 + values[0]))


def _zero(setup: Setup, values: Floats, _: Simulator) -> Setup:
    return replace(setup, load_Nm=setup.load - values[0])


def _late(setup: Setup, values: Floats, _: Simulator) -> Setup:
    t = setup.p.time_s
    return replace(setup, load_Nm=np.interp(t + values[0], t, setup.load))


def _filtered(setup: Setup, values: Floats, _: Simulator) -> Setup:
    return replace(setup, load_Nm=setup.load + values[0] * np.gradient(setup.load, setup.p.time_s))


def _reversed(setup: Setup, values: Floats, _: Simulator) -> Setup:
    return setup.with_added(values[0] * setup.load)


def gain(most: float) -> Effect:
    """A gain within ``most``, a share."""
    return Effect(
        "load_gain",
        "gain of the torque sensor",
        "the true load is a share larger than the sensor shows",
        LOOK + "calibrate it with a known weight on an arm",
        "a known weight on an arm of known length",
        (Parameter("share", 0.005, -most, most),),
        _gain,
        hangs_on=SENSOR,
        plain="the load is {share} {way_share} than the torque sensor shows",
    )


def zero(most_Nm: float) -> Effect:
    """A zero within ``most_Nm``."""
    return Effect(
        "load_zero",
        "zero of the torque sensor",
        "the torque sensor shows a torque where there is none",
        LOOK + "read it with the drum free, and give the figure as zero of load_torque",
        "a run without a load: its zero stays, a play then floats",
        (Parameter("zero_Nm", 0.01 * most_Nm, -most_Nm, most_Nm),),
        _zero,
        hangs_on=SENSOR,
        generic=True,
        plain="the torque sensor shows {zero_Nm} without a load",
    )


def lag(most_s: float) -> tuple[Effect, Effect]:
    """A lag within ``most_s``: a delay, and a low-pass of first order."""
    late = Effect(
        "load_lag",
        "delay of the torque sensor",
        "the load is read later than the angles",
        LOOK + "filter, time stamps of the logger",
        "load steps at rest: a late load shows as a spike of the angle at each flank",
        (Parameter("lag_s", 1e-3, 0.0, most_s),),
        _late,
        hangs_on=SENSOR,
        generic=True,
        plain="the load is read {lag_s} later than the angles",
    )
    return late, replace(
        late,
        form="low-pass of the torque sensor",
        physics="the amplifier of the torque sensor smooths the load: a low-pass of first order",
        apply=_filtered,
        plain="the amplifier of the torque sensor lags by {lag_s}",
    )


def within_class(runs: tuple[Prepared, ...]) -> list[Effect]:
    """Gain, zero and lag within the class of the torque sensor; empty for runs without a load."""
    loads = [p.run.load_Nm for p in runs]
    most = max((float(np.abs(load).max()) for load in loads if load is not None), default=0.0)
    if any(load is None for load in loads) or most == 0.0:
        return []
    allowed: TorqueClass = runs[0].run.sensors.torque_class
    found = [gain(allowed.share), zero(allowed.zero * most)]
    return [*found, lag(allowed.lag_s)[1]] if allowed.lag_s else found


# Standard deviations of the design's figures within which a part is as the design says.
PRIOR_SIGMAS = 2.0


def within_prior(runs: tuple[Prepared, ...]) -> list[Effect]:
    """Give and friction of the parts within what the design's figures are known to; empty where none is counted."""
    parts = runs[0].run.parts
    if parts is None or any(p.run.parts != parts for p in runs):
        return []
    found = []
    if give := PRIOR_SIGMAS * parts.give_sigma_rad_Nm:
        found.append(_of_parts("structure", (Parameter("compliance_rad_Nm", 1e-6, -give, give),), _given))
    if parts.friction_Nm:
        most = parts.friction_factor**PRIOR_SIGMAS
        bounds = parts.friction_Nm * (1.0 / most - 1.0), parts.friction_Nm * (most - 1.0)
        found.append(_of_parts("losses", (Parameter("torque_Nm", 0.01, *bounds),), _rubbed))
    return found


def _given(setup: Setup, values: Floats, _: Simulator) -> Setup:
    return setup.with_added(-values[0] * setup.borne)


def _rubbed(setup: Setup, values: Floats, _: Simulator) -> Setup:
    return setup.with_rubbed(values[0] * setup.p.sense)


def _of_parts(name: str, parameters: tuple[Parameter, ...], apply: Callable[..., Setup]) -> Effect:
    what = f"the {name} within the uncertainty of the design's figures"
    return Effect(name, "figure of the design", what, "", "", parameters, apply, hangs_on="the design's figures")


def offer(d: DriveSI | None, p: Prepared) -> list[Effect]:
    """With a torque sensor: zero, lag, and the sign where the stiffness is not known (else it is refused before).

    A weight on an arm has none of them.
    """
    if p.load_Nm is None or not np.ptp(p.load_Nm) or p.run.sensors.torque_class.what == KNOWN_LOAD:
        return []
    most = MOST_ZERO * float(np.abs(p.load_Nm).max())
    found = [zero(most), *lag(MOST_LAG_S)]
    if d is None:
        found.append(
            Effect(
                "load_sign",
                "sign of the load",
                "the output moves against the load, as no compliance does: the sign of the torque is reversed",
                "set scale: -1 on load_torque, which is positive where it opposes positive rotation",
                "push the output by hand and read the sign",
                (Parameter("compliance_rad_Nm", 1e-6, 0.0),),
                _reversed,
                hangs_on=SENSOR,
                generic=True,
                plain="the sign of the load is reversed: the output moves against it by {compliance_rad_Nm}",
            )
        )
    return found
