"""Drift with time or temperature: warming, and settling of a rope."""

from dataclasses import replace

import numpy as np
from scipy.signal import lfilter

from mbcdm_cad.loop.effect import Effect, Effects, Parameter, elapsed_s
from mbcdm_cad.loop.prepare.setup import DriveSI, Floats, Prepared, Setup
from mbcdm_cad.measurement.schema import CREEP

COOL = "let the rig cool and run again: warming goes back, settling does not"


def _warmed(setup: Setup, constant_s: float = 0.0) -> Floats:
    """Warming since the run began, K (n,), of the thermometer or of a part behind it."""
    assert setup.p.temperature_C is not None
    if constant_s:
        return lagged(setup.p.temperature_C, setup.p.time_s, constant_s)
    return np.asarray(setup.p.temperature_C - setup.p.temperature_C[0])


def lagged(temperature_C: Floats, time_s: Floats, constant_s: float) -> Floats:
    """Warming, K (n,), of a part that follows a temperature by a first-order lag and begins at it.

    T' = (T_measured - T) / constant, exact for a temperature that is linear between even samples.
    """
    even = np.linspace(float(time_s[0]), float(time_s[-1]), time_s.size)
    warmed = np.interp(even, time_s, temperature_C - temperature_C[0])
    share = float(even[1] - even[0]) / constant_s
    kept = float(np.exp(-share))
    now = 1.0 - (1.0 - kept) / share
    return np.asarray(np.interp(time_s, even, lfilter([now, 1.0 - kept - now], [1.0, -kept], warmed)))


def _times(setup: Setup, _: Floats) -> list[list[float]]:
    duration = float(elapsed_s(setup)[-1])
    return [[0.0, duration * share] for share in (0.02, 0.1, 0.4)]


def offer(d: DriveSI | None, p: Prepared) -> Effects:
    """Always; by temperature where it was measured."""
    duration = float(p.time_s[-1] - p.time_s[0])
    warming = ("thermal_drift", "temperature of rope, frame or encoder mount", "warm motors, sun, draught", COOL)
    if p.temperature_C is not None and np.ptp(p.temperature_C) > 0.0:
        at_once = Effect(
            warming[0],
            "with the temperature",
            *warming[1:],
            (Parameter("turn_rad_K", 1e-6),),
            lambda s, v, _: s.with_added(v[0] * _warmed(s)),
            hangs_on="temperature",
            plain="the output reading drifts with the temperature, by {turn_rad_K}",
        )
        yield at_once
        if p.run.kind != CREEP:  # readings at rest are too few to tell a lag
            constant = Parameter("time_constant_s", 0.01 * duration, 0.01 * duration, duration, role="place")
            yield replace(
                at_once,
                form="behind the temperature",
                physics="temperature of rope, frame or encoder mount, which follows the thermometer's by a lag",
                parameters=(*at_once.parameters, constant),
                apply=lambda s, v, _: s.with_added(v[0] * _warmed(s, v[1])),
                starts=_times,
                plain="the output reading drifts with the temperature of a part that warms later, by {turn_rad_K}",
            )
    else:
        yield Effect(
            warming[0],
            "with time",
            *warming[1:],
            (
                Parameter("turn_rad", 1e-5),
                Parameter("time_constant_s", 0.01 * duration, 0.02 * duration, duration, role="place"),
            ),
            lambda s, v, _: s.with_added(v[0] * (1.0 - np.exp(-elapsed_s(s) / v[1]))),
            starts=_times,
            hangs_on="time",
            plain="the output reading drifts as something warms, by {turn_rad} in the end",
        )
    yield Effect(
        warming[0],
        "evenly with time",
        "the reading drifts at one rate, also while the drive rests: a slow warming, or a sensor that drifts",
        "temperature and supply of the output encoder, warm motors",
        "let the drive rest in mid-run: a drift in time goes on, a walk with the path stands still",
        (Parameter("rate_rad_s", 1e-5 / duration),),
        lambda s, v, _: s.with_added(v[0] * elapsed_s(s)),
        hangs_on="time",
        plain="the output reading drifts by {rate_rad_s}",
    )
    if p.run.kind == CREEP:  # the laws of creep under a load stand in its place
        return
    yield Effect(
        "creep",
        "settling of the rope",
        "strands bed in: log(1 + t/t0)",
        "preload again after some hours of running",
        COOL,
        (
            Parameter("amplitude_rad", 1e-5),
            Parameter("t0_s", 0.002 * duration, 1e-3 * duration, duration, role="place"),
        ),
        lambda s, v, _: s.with_added(v[0] * np.log1p(elapsed_s(s) / v[1])),
        starts=_times,
        hangs_on="time",
        plain="a rope settles: the output reading creeps by {amplitude_rad} for each e-fold of time",
    )
