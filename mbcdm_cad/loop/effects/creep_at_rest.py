"""Creep at rest under a load: laws over time, each step of the load with a course of its own (superposition).

What creeps is a rope, a printed part or a bond. The turn for 1 N m after a time t under the load:

    logarithmic   a ln(1 + t / t0)             strands that bed in, fibre ropes
    power law     a (t / 1 h)^n                plastics (Findley)
    Kelvin        a (1 - exp(-t / T))          one delay: creep that ends
    Burgers       a (1 - exp(-t / T)) + r t    and a steady flow

Limits: linear in the load, one temperature. Source of the laws: Findley, Lai, Onaran, Creep and Relaxation of Nonlinear
Viscoelastic Materials, 1976.
"""

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from math import log

import numpy as np

from mbcdm_cad.loop.effect import Effect, Figure, Parameter
from mbcdm_cad.loop.prepare.readings import under_load
from mbcdm_cad.loop.prepare.setup import DriveSI, Floats, Prepared, Setup, Simulator, give_rad_Nm
from mbcdm_cad.measurement.schema import CREEP

HOUR_S = 3600.0
# The end of the name of each form.
AT_REST = "under the load"
Law = Callable[[Floats, Floats], Floats]


def _logarithmic(v: Floats, t: Floats) -> Floats:
    return np.asarray(v[0] * np.log1p(t / v[1]))


def _power(v: Floats, t: Floats) -> Floats:
    return np.asarray(v[0] * (t / HOUR_S) ** v[1])


def _kelvin(v: Floats, t: Floats) -> Floats:
    return np.asarray(-v[0] * np.expm1(-t / v[1]))


def _burgers(v: Floats, t: Floats) -> Floats:
    return np.asarray(_kelvin(v, t) + v[2] * t)


def _apply(law: Law, setup: Setup, values: Floats, _: Simulator) -> Setup:
    return setup.with_added(under_load(setup.p, partial(law, values)))


def _from(law: Law, least: float, places: Sequence[list[float]], setup: Setup, residual: Floats) -> list[list[float]]:
    """A start for each place, with the size that fits the residual best: at size zero a place has no slope."""
    used, found = setup.p.used, []
    for place in places:
        turned = under_load(setup.p, partial(law, np.array([1.0, *place])))[used]
        turned = turned - turned.mean()
        size = float(turned @ residual[used]) / max(float(turned @ turned), 1e-300)
        found.append([max(size, least), *place])
    return found


def offer(d: DriveSI | None, p: Prepared) -> list[Effect]:
    """For readings at rest, in place of a settling without a load."""
    if p.run.kind != CREEP:
        return []
    loaded = p.load_Nm is not None and bool(p.load_Nm.any())
    unit, size = ("rad_Nm", 1e-6) if loaded else ("rad", 1e-5)
    elapsed = p.time_s[p.used] - min(0.0, float(p.run.time_s[0]))
    first, last = float(elapsed[elapsed > 0.0].min()), float(elapsed.max())
    # No part creeps less than nothing: at most what the catalogue expects of the rope may be missing.
    least = 0.0 if not loaded else -p.run.expected_creep * give_rad_Nm(d) / log(10.0)
    give = Parameter(f"give_{unit}", size, least)
    decade = Figure(f"a_decade_{unit}", lambda v: float(v[0] * log(10.0)))
    share = Figure(
        "a_decade_share", lambda v: float(v[0] * log(10.0) / give_rad_Nm(d)), "over the elastic give of the cables"
    )
    base = Effect(
        "creep",
        "logarithmic under the load",
        "something gives way under the load, ever more slowly: a ln(1 + t/t0)",
        "fibre ropes and their ends, printed parts, bonds, screws that settle",
        "take the load off and go on reading: creep goes back, warming and a drift of the sensor do not",
        (give, Parameter("t0_s", 0.1 * first, 1e-2 * first, last, role="place")),
        partial(_apply, _logarithmic),
        starts=partial(_from, _logarithmic, least, [[0.3 * first], [first], [(first * last) ** 0.5]]),
        figures=(decade, *((share,) if d is not None and loaded else ())),
        hangs_on="time",
        plain=f"under the load the output gives way by {{a_decade_{unit}}} for each decade of time",
    )
    times = [(first * last) ** 0.5, first**0.2 * last**0.8]
    constant = Parameter("time_constant_s", first, 0.5 * first, last, role="place")
    ends = replace(
        base,
        form="Kelvin under the load",
        physics="something gives way under the load and comes to an end: one delay",
        parameters=(replace(give, low=0.0), constant),
        apply=partial(_apply, _kelvin),
        starts=partial(_from, _kelvin, 0.0, [[time] for time in times]),
        figures=(),
        plain=f"under the load the output gives way by {{give_{unit}}} in the end",
    )
    rate = f"flow_{unit}_s" if not loaded else "flow_rad_Nm_s"
    return [
        base,
        replace(
            base,
            form="power law under the load",
            physics="something gives way under the load as plastics do: a power of the time",
            parameters=(replace(give, low=0.0), Parameter("exponent", 0.05, 0.02, 0.8, role="place")),
            apply=partial(_apply, _power),
            starts=partial(_from, _power, 0.0, [[0.08], [0.2], [0.4]]),
            figures=(Figure(f"after_an_hour_{unit}", lambda v: float(v[0])), Figure("exponent", lambda v: float(v[1]))),
            plain=f"under the load the output gives way by {{after_an_hour_{unit}}} in the first hour, as plastics do",
        ),
        ends,
        replace(
            ends,
            form="Burgers under the load",
            physics="something gives way under the load with one delay, and flows at a steady rate",
            parameters=(*ends.parameters, Parameter(rate, size / last, 0.0)),
            apply=partial(_apply, _burgers),
            starts=partial(_from, _burgers, 0.0, [[time, 0.0] for time in times]),
        ),
    ]
