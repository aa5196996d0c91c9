"""Errors of the torque sensor: gain, zero, lag, sign, hysteresis, cross talk. Within its class no effect of the drive.

A class of 1 % allows 1 % of gain and a zero of 1 % of the range. What lies within it is a nuisance of every fit
(:mod:`mbcdm_cad.loop.search.problem`) and never named. A gain beyond the class looks like another stiffness of the
whole drive, so only the others are candidates of the search.
"""

from collections.abc import Callable, Iterator
from dataclasses import replace

import numpy as np

from mbcdm_cad.loop.effect import Effect, Figure, Parameter, length
from mbcdm_cad.loop.prepare.prepared import played
from mbcdm_cad.loop.prepare.setup import DriveSI, Floats, Prepared, Setup, Simulator
from mbcdm_cad.measurement.run import TorqueClass
from mbcdm_cad.measurement.schema import MOTION

SENSOR = "an error of the torque sensor"
LOOK = "torque sensor and amplifier: "
# What weights at rest show, or the drum turned by hand, and no run is planned for.
UNPLANNED = ("load_hysteresis", "load_crosstalk")
# Bounds of the search: a zero of this share of the largest load, a lag in s; half a width and an amplitude as shares.
MOST_ZERO, MOST_LAG_S, MOST_WIDTH, MOST_WAVE = 0.5, 0.5, 0.12, 0.3
# Cross talk has so many waves a turn of the output; the step in which its beginning is looked for.
WAVES, WAVE_STEP = (1.0, 12.0), 0.25
# A load rises or falls where it moves by more than twice this share of the largest.
DEAD = 0.01
# A reading that rests leaves the load open: it turns back as a power of the time, up to this one.
STEEPEST = 1e4


def _late(setup: Setup, values: Floats, _: Simulator) -> Setup:
    t = setup.p.time_s
    return replace(setup, load_Nm=np.interp(t + values[0], t, setup.load))


def _lagging(setup: Setup, values: Floats, _: Simulator) -> Setup:
    dead = DEAD * float(np.abs(setup.load).max())
    return replace(setup, load_Nm=setup.load + values[0] * _sides(setup.load, setup.p.time_s, float(values[0]), dead))


def _sides(load: Floats, time_s: Floats, half: float, dead: float) -> Floats:
    """Share of half a width by which the true load is above a reading that follows it within that width, (n,).

    1 where the reading rises, -1 where it falls. While it rests the load goes from one side to the other: with the
    power of the time that ends at the rate at which the reading goes on: a sine keeps its crest, a step stays
    a step.
    """
    moves = np.diff(played(load, dead))
    at = np.flatnonzero(moves) + 1
    if not at.size:
        return np.zeros_like(load)
    way = np.sign(moves[at - 1])
    sides = np.interp(np.arange(load.size), at, way)
    for k in np.flatnonzero(np.diff(way)):
        first, last = at[k], at[k + 1]
        gone = np.abs(load[last:] - load[last - 1]) > 2.0 * dead
        on = last + int(np.argmax(gone))
        rate = abs(load[on] - load[last - 1]) / max(time_s[on] - time_s[last - 1], 1e-9)
        rest_s = time_s[last] - time_s[first]
        power = float(np.clip(rate * rest_s / max(2.0 * abs(half), 1e-12), 1.0, STEEPEST))
        x = (time_s[first : last + 1] - time_s[first]) / max(rest_s, 1e-9)
        sides[first : last + 1] = way[k] * (1.0 - 2.0 * x**power)
    return sides


def _crossed(setup: Setup, values: Floats, _: Simulator) -> Setup:
    phase = values[2] * setup.drum_rad
    return replace(setup, load_Nm=setup.load - values[0] * np.cos(phase) - values[1] * np.sin(phase))


def _waves(setup: Setup, residual: Floats) -> list[list[float]]:
    """The number of waves a turn that explains most of the residual, without a size: that is a linear step."""
    angle, y = setup.drum_rad[setup.p.used], residual[setup.p.used]

    def left(waves: float) -> float:
        columns = np.column_stack([np.ones_like(angle), angle, np.cos(waves * angle), np.sin(waves * angle)])
        rest = y - columns @ np.linalg.solve(columns.T @ columns + 1e-9 * np.eye(4), columns.T @ y)
        return float(rest @ rest)

    return [[0.0, 0.0, float(min(np.arange(WAVES[0] + WAVE_STEP, WAVES[1], WAVE_STEP), key=left))]]


def gain(most: float) -> Effect:
    """A gain within ``most``, a share."""
    return Effect(
        "load_gain",
        "gain of the torque sensor",
        "the true load is a share larger than the sensor shows",
        LOOK + "calibrate it with a known weight on an arm",
        "a known weight on an arm of known length",
        (Parameter("share", 0.005, -most, most),),
        lambda s, v, _: replace(s, load_Nm=s.load * (1.0 + v[0])),
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
        lambda s, v, _: replace(s, load_Nm=s.load - v[0]),
        hangs_on=SENSOR,
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
        plain="the load is read {lag_s} later than the angles",
    )
    return late, replace(
        late,
        form="low-pass of the torque sensor",
        physics="the amplifier of the torque sensor smooths the load: a low-pass of first order",
        apply=lambda s, v, _: replace(s, load_Nm=s.load + v[0] * np.gradient(s.load, s.p.time_s)),
        plain="the amplifier of the torque sensor lags by {lag_s}",
    )


def hysteresis(most_Nm: float) -> Effect:
    """A hysteresis with half a width within ``most_Nm``."""
    return Effect(
        "load_hysteresis",
        "hysteresis of the torque sensor",
        "the torque sensor shows less while the load rises than while it falls: its spring, or play in its mount",
        LOOK + "screws and clamps on both of its sides, rising and falling column of its calibration sheet",
        "weights put on and taken off one by one, with the drive at rest",
        (Parameter("half_width_Nm", 0.01 * most_Nm, 0.0, most_Nm),),
        _lagging,
        hangs_on=SENSOR,
        plain="the torque sensor stays {half_width_Nm} behind the load, whether it rises or falls",
    )


def crosstalk(most_Nm: float) -> Effect:
    """Cross talk: the sensor shows a side load or a bending, which turns with the shaft, as a torque."""
    wave = Parameter("cosine_Nm", 0.01 * most_Nm, -most_Nm, most_Nm)
    return Effect(
        "load_crosstalk",
        "cross talk of the torque sensor",
        "the torque sensor shows a torque that hangs on the angle alone: a side load that turns with the shaft",
        LOOK + "alignment of its couplings, weight that hangs on it, its axis against that of the drum",
        "turn the drum by hand without a load: the torque goes with the angle",
        (wave, replace(wave, name="sine_Nm"), Parameter("cycles_per_output_rev", 0.1, *WAVES, role="place")),
        _crossed,
        hangs_on=SENSOR,
        starts=_waves,
        figures=(Figure("amplitude_Nm", length), Figure("cycles_per_output_rev", lambda v: float(v[2]))),
        plain="the torque sensor shows {amplitude_Nm} that go with the angle, {cycles_per_output_rev} times a turn",
    )


def within_class(runs: tuple[Prepared, ...]) -> list[Effect]:
    """Gain, zero, and of motions hysteresis and lag, within the torque sensor's class; empty for runs without load."""
    loads = [p.run.load_Nm for p in runs]
    most = max((float(np.abs(load).max()) for load in loads if load is not None), default=0.0)
    if any(load is None for load in loads) or most == 0.0:
        return []
    allowed: TorqueClass = runs[0].run.sensors.torque_class
    found = [gain(allowed.share), zero(allowed.zero * most)]
    if allowed.lag_s and runs[0].run.kind == MOTION:
        found += [hysteresis(allowed.share * most), *lag(allowed.lag_s)]
    return found


# Standard deviations of the design's figures within which a part is as the design says.
PRIOR_SIGMAS = 2.0


def within_prior(runs: tuple[Prepared, ...]) -> list[Effect]:
    """Give and friction of the parts within what the design's figures are known to; empty where none is counted."""
    parts = runs[0].run.parts
    if parts is None or any(p.run.parts != parts for p in runs):
        return []
    found = []
    if give := PRIOR_SIGMAS * parts.give_sigma_rad_Nm:
        found.append(
            _of_parts(
                "structure",
                (Parameter("compliance_rad_Nm", 1e-6, -give, give),),
                lambda s, v, _: s.with_added(-v[0] * s.borne),
            )
        )
    if parts.friction_Nm:
        most = parts.friction_factor**PRIOR_SIGMAS
        bounds = parts.friction_Nm * (1.0 / most - 1.0), parts.friction_Nm * (most - 1.0)
        found.append(
            _of_parts(
                "losses", (Parameter("torque_Nm", 0.01, *bounds),), lambda s, v, _: s.with_rubbed(v[0] * s.p.sense)
            )
        )
    return found


def _of_parts(name: str, parameters: tuple[Parameter, ...], apply: Callable[..., Setup]) -> Effect:
    what = f"the {name} within the uncertainty of the design's figures"
    return Effect(name, "figure of the design", what, "", "", parameters, apply, hangs_on="the design's figures")


def offer(d: DriveSI | None, p: Prepared) -> Iterator[Effect]:
    """With a torque sensor: all but the gain; the sign where the stiffness is not known (else it is refused before).

    A weight on an arm has none of them.
    """
    if p.load_Nm is None or not np.ptp(p.load_Nm) or p.run.sensors.torque_class.of_known:
        return
    most = float(np.abs(p.load_Nm).max())
    yield zero(MOST_ZERO * most)
    if p.run.kind == MOTION:
        yield from lag(MOST_LAG_S)
    if p.run.kind == MOTION and not p.run.sensors.torque_class.of_currents:
        yield hysteresis(MOST_WIDTH * most)
        if d is not None:
            yield crosstalk(MOST_WAVE * most)
    if d is None:
        yield Effect(
            "load_sign",
            "sign of the load",
            "the output moves against the load, as no compliance does: the sign of the torque is reversed",
            "set scale: -1 on load_torque, which is positive where it opposes positive rotation",
            "push the output by hand and read the sign",
            (Parameter("compliance_rad_Nm", 1e-6, 0.0),),
            lambda s, v, _: s.with_added(v[0] * s.load),
            hangs_on=SENSOR,
            plain="the sign of the load is reversed: the output moves against it by {compliance_rad_Nm}",
        )
