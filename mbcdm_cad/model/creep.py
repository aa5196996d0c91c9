"""Creep of fibre ropes between fixed ends: how the preload falls, and how long until it has fallen to a limit.

Strain of a rope under the tension T, as a share s = T / F of its breaking load:

    log time      c s log10(1 + t / t0)          c: strain a decade, extrapolated to the breaking load
    steady        r (s / 0.3)^n exp(Q/R (1/293 K - 1/K)) t     r: strain a year at 0.3 F and 20 degrees C

The ends are fixed, so the creep strain reduces the elastic strain: dT = -EA (strain of creep). Springs at the ends give
way with the rope, by (1 + EA c / L) of it, c their give: dT is that much smaller. Time runs from the end
of bedding in, t0 = one hour. Limits: one tension along the whole rope, no varying load and no recovery; a rope that
moves often loses less.
"""

from bisect import bisect_left
from dataclasses import dataclass
from math import expm1, log, log1p

from mbcdm_cad.design.bought import CableSpec

HOUR_S, DAY_S, YEAR_S = 3600.0, 86400.0, 365.25 * 86400.0
START_S = HOUR_S
# Load and temperature that the catalogue's steady rate refers to.
REFERENCE_SHARE, REFERENCE_K = 0.3, 293.15
_ZERO_C, _GAS_J_MOL_K = 273.15, 8.314462618
_LN10 = log(10.0)
# Steps of the integration in ln(1 + t/t0), and how far it goes.
_STEPS, _LONGEST_S = 400, 100.0 * YEAR_S
# Times and temperatures for which the remaining preload is printed.
TOLD_DAYS = (1.0, 30.0, 365.25, 3652.5)
TOLD_C = (20.0, 40.0)


@dataclass(frozen=True)
class PreloadLeft:
    """Preload over time at one temperature: shares of the first preload that are left after :data:`TOLD_DAYS`."""

    temperature_C: float
    days: tuple[float, ...]
    share: tuple[float, ...]


@dataclass(frozen=True)
class Relaxation:
    """Tension of a rope between fixed ends over time, from :data:`START_S` after tensioning; N and s."""

    time_s: tuple[float, ...]
    tension_N: tuple[float, ...]

    def at_N(self, time_s: float) -> float:
        """Tension after a time. Raises ``ValueError`` beyond a hundred years."""
        if not 0.0 <= time_s <= self.time_s[-1] * (1.0 + 1e-9):
            raise ValueError(f"{time_s:g} s is outside of 0 to {self.time_s[-1]:g} s")
        k = min(max(bisect_left(self.time_s, time_s), 1), len(self.time_s) - 1)
        low, high = log1p(self.time_s[k - 1] / START_S), log1p(self.time_s[k] / START_S)
        share = (log1p(time_s / START_S) - low) / (high - low)
        return self.tension_N[k - 1] + share * (self.tension_N[k] - self.tension_N[k - 1])

    def time_until_s(self, tension_N: float) -> float:
        """Time after which the tension has fallen to ``tension_N``; inf where it has not in a hundred years."""
        if tension_N >= self.tension_N[0]:
            return 0.0
        for k in range(1, len(self.tension_N)):
            if self.tension_N[k] <= tension_N:
                share = (self.tension_N[k - 1] - tension_N) / (self.tension_N[k - 1] - self.tension_N[k])
                low, high = log1p(self.time_s[k - 1] / START_S), log1p(self.time_s[k] / START_S)
                return START_S * expm1(low + share * (high - low))
        return float("inf")


def creeps(rope: CableSpec) -> bool:
    """Whether the catalogue has any creep of the rope."""
    return rope.creep_per_decade > 0.0 or rope.creep_per_year > 0.0


def creep_a_decade(rope: CableSpec) -> float:
    """Creep strain for each decade of time over the elastic strain that the same tension causes."""
    return float(rope.creep_per_decade * rope.axial_stiffness_N / rope.breaking_load_N)


def steady_rate_per_s(rope: CableSpec, tension_N: float, temperature_C: float) -> float:
    """Steady strain rate under a tension at a temperature, 1/s."""
    from_reference = 1.0 / REFERENCE_K - 1.0 / (temperature_C + _ZERO_C)
    warmer = expm1(rope.creep_activation_kJ_mol * 1e3 / _GAS_J_MOL_K * from_reference) + 1.0
    share = max(tension_N, 0.0) / rope.breaking_load_N / REFERENCE_SHARE
    return float(rope.creep_per_year / YEAR_S * share**rope.creep_load_exponent * warmer)


def relaxation(rope: CableSpec, preload_N: float, temperature_C: float, softer: float = 1.0) -> Relaxation:
    """The tension of a rope that was tensioned to ``preload_N`` and left, over a hundred years (Runge-Kutta, order 4).

    ``softer``: give of the rope with the springs at its ends over that of the rope alone. Raises ``ValueError`` for a
    preload that is not above zero.
    """
    if not preload_N > 0.0:
        raise ValueError(f"a preload of {preload_N:g} N cannot creep; give it > 0")
    stiffness, log_part = rope.axial_stiffness_N / softer, rope.creep_per_decade / _LN10 / rope.breaking_load_N

    def slope(x: float, tension_N: float) -> float:
        """dT/dx with x = ln(1 + t/t0)."""
        since = START_S * (expm1(x) + 1.0)
        return -stiffness * (log_part * tension_N + steady_rate_per_s(rope, tension_N, temperature_C) * since)

    times, tensions = [0.0], [preload_N]
    last = log1p(_LONGEST_S / START_S)
    step = last / _STEPS
    for k in range(_STEPS):
        x, tension = k * step, tensions[-1]
        a = slope(x, tension)
        b = slope(x + step / 2, tension + step / 2 * a)
        c = slope(x + step / 2, tension + step / 2 * b)
        d = slope(x + step, tension + step * c)
        tensions.append(max(tension + step / 6 * (a + 2 * b + 2 * c + d), 0.0))
        times.append(START_S * expm1(x + step))
    return Relaxation(tuple(times), tuple(tensions))


def preload_left(rope: CableSpec, preload_N: float, softer: float = 1.0) -> tuple[PreloadLeft, ...]:
    """Shares of the preload that are left over time, by temperature; nothing for a rope that does not creep.

    ``softer`` as in :func:`relaxation`.
    """
    if not creeps(rope):
        return ()
    found = []
    for temperature in TOLD_C:
        over_time = relaxation(rope, preload_N, temperature, softer)
        shares = tuple(over_time.at_N(day * DAY_S) / preload_N for day in TOLD_DAYS)
        found.append(PreloadLeft(temperature, TOLD_DAYS, shares))
    return tuple(found)
