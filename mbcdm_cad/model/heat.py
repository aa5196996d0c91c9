"""Temperatures of a motor's winding and housing over a cycle of torques: two nodes, solved exactly piece by piece.

    C_w dT_w/dt = P - (T_w - T_h)/R_wh        C_h dT_h/dt = (T_w - T_h)/R_wh - (T_h - T_a)/R_ha
    P = p M^2 (1 + alpha (T_w - 25))

The copper's resistance grows with its temperature, linearly, so that a piece of constant torque M is a linear system:
it has an exact solution, and the cycle that repeats is the fixed point of an affine map. The factor p is such that the
continuous torque of the catalogue leads to the winding's limit at 25 C: iron losses and the maker's way of mounting
are in it.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from math import inf, pi, sqrt

import numpy as np

from mbcdm_cad.design.bought import Motor
from mbcdm_cad.routes import Floats

# Growth of copper's resistance, 1/K; temperature at which data sheets state resistance and continuous torque, C.
COPPER_PER_K, RATED_AT_C = 0.00393, 25.0
# Estimates for a motor whose entry has no thermal figures, from eight motors of 16 to 90 mm, with the standard
# deviation of their logarithm: heat transfer of the housing over pi D L + pi D^2/2, W/(m2 K); winding to housing, K/W;
# heat capacity over mass, J/(kg K); share of the winding in it with brushes and without; limit of the winding, C.
AIR_W_M2K, AIR_SIGMA = 19.0, 0.23
WINDING_K_W, WINDING_SIGMA = 1.7, 0.31
CAPACITY_J_KGK, CAPACITY_SIGMA = 410.0, 0.14
WINDING_SHARE_DC, WINDING_SHARE_BRUSHLESS = 0.085, 0.04
LIMIT_C = 125.0
# Mounting on a metal frame halves the housing's resistance to the air (0.2 to 0.8), the heat of a gearhead at its
# flange raises it about as much (Beckhoff: 20 % less torque). They are taken to cancel; the sigma of what is left.
MOUNT_SIGMA = 0.35
# Torque that a brushless motor may hold at standstill, over its continuous torque: one phase carries the current.
STANDSTILL_SHARE = 0.7
# Above this the model has no meaning: insulation is gone, and a winding that gets hotter without end passes it.
MEANINGLESS_C = 400.0
# Pieces are cut so that none is longer than this share of the winding's time constant.
_STEP_SHARE = 0.25
# Time, in time constants of the motor, after which a temperature does not rise any more.
_SETTLED = 12.0
_MOST_CYCLES = 20000


@dataclass(frozen=True)
class Temperatures:
    """Temperatures of winding and housing, C, at the ends of the pieces of the cycle that repeats."""

    time_s: Floats
    winding_C: Floats
    housing_C: Floats

    @property
    def hottest_winding_C(self) -> float:
        """Largest temperature of the winding."""
        return float(self.winding_C.max())

    @property
    def hottest_housing_C(self) -> float:
        """Largest temperature of the housing."""
        return float(self.housing_C.max())


@dataclass(frozen=True)
class MotorHeat:
    """Two-node model of one motor: resistances K/W, capacities J/K.

    ``estimated``: the figures that are estimates, for reports. ``brushless``: at standstill one phase carries all.
    ``mount``: resistance from housing to air over that of the maker's test.
    """

    continuous_Nm: float
    limit_C: float
    winding_K_W: float
    housing_K_W: float
    winding_J_K: float
    housing_J_K: float
    brushless: bool
    estimated: tuple[str, ...] = ()
    mount: float = 1.0

    @cached_property
    def loss_W_Nm2(self) -> float:
        """Heat at 25 C over the square of the torque."""
        hot = self.limit_C - RATED_AT_C
        return hot / (self.winding_K_W + self.housing_K_W) / (1.0 + COPPER_PER_K * hot) / self.continuous_Nm**2

    @property
    def winding_time_s(self) -> float:
        """Time constant of the winding."""
        return self.winding_J_K * self.winding_K_W

    @property
    def motor_time_s(self) -> float:
        """Time constant of the whole motor."""
        return (self.winding_J_K + self.housing_J_K) * self.housing_K_W * self.mount

    def continuous_at_Nm(self, ambient_C: float) -> float:
        """Torque that leads to the winding's limit after a long time."""
        hot = self.limit_C - ambient_C
        if hot <= 0.0:
            return 0.0
        resistance = self.winding_K_W + self.housing_K_W * self.mount
        warm = 1.0 + COPPER_PER_K * (self.limit_C - RATED_AT_C)
        return sqrt(hot / resistance / warm / self.loss_W_Nm2)

    def repeated(self, time_s: Floats, torque_Nm: Floats, ambient_C: float) -> Temperatures | None:
        """Temperatures of the cycle that repeats; None where the winding gets hotter without end, or absurdly hot."""
        times, torques = self._cut(time_s, torque_Nm)
        turn, add = self._pieces(times, torques, ambient_C)
        whole, added = np.eye(2), np.zeros(2)
        with np.errstate(over="ignore", invalid="ignore"):
            for a, b in zip(turn, add, strict=True):
                whole, added = a @ whole, a @ added + b
        if not np.isfinite(whole).all() or np.abs(np.linalg.eigvals(whole)).max() >= 1.0:
            return None
        at = np.linalg.solve(np.eye(2) - whole, added)
        found = [at]
        for a, b in zip(turn, add, strict=True):
            at = a @ at + b
            found.append(at)
        winding, housing = np.array(found).T
        if winding.max() > MEANINGLESS_C:
            return None
        return Temperatures(np.concatenate([[0.0], np.cumsum(times)]), winding, housing)

    def time_to_limit_s(self, torque_Nm: float, ambient_C: float, start_C: tuple[float, float] | None = None) -> float:
        """How long a constant torque takes to heat the winding to its limit; infinite where it does not.

        ``start_C``: temperatures of winding and housing at the start; left out, both are the ambient's.
        """
        at = np.array([ambient_C, ambient_C] if start_C is None else start_C)
        if at[0] >= self.limit_C:
            return 0.0
        if torque_Nm <= self.continuous_at_Nm(ambient_C):
            return inf

        def winding_C(time: float) -> float:
            turn, add = self._pieces(np.array([time]), np.array([torque_Nm]), ambient_C)
            return float((turn[0] @ at + add[0])[0])

        # The winding reaches its limit once: from a warm start it may first cool, but then it rises for good.
        low, high = 0.0, self.winding_time_s * 1e-3
        while winding_C(high) < self.limit_C:
            low, high = high, 2.0 * high
            if high > _SETTLED * 1e3 * self.motor_time_s:
                return inf
        for _ in range(60):
            middle = 0.5 * (low + high)
            low, high = (middle, high) if winding_C(middle) < self.limit_C else (low, middle)
        return high

    def cycles_to_limit_s(self, time_s: Floats, torque_Nm: Floats, ambient_C: float) -> float:
        """How long the cycle may be repeated from cold until the winding reaches its limit; infinite where it may."""
        times, torques = self._cut(time_s, torque_Nm)
        turn, add = self._pieces(times, torques, ambient_C)
        at, passed, period = np.array([ambient_C, ambient_C]), 0.0, float(times.sum())
        for _ in range(min(_MOST_CYCLES, int(_SETTLED * self.motor_time_s / period) + 2)):
            for a, b, step in zip(turn, add, times, strict=True):
                at = a @ at + b
                passed += float(step)
                if at[0] >= self.limit_C:
                    return passed
        return inf

    def allowed_Nm(self, share: float, period_s: float, ambient_C: float) -> float:
        """Torque that may be given for a share of each period, without one for the rest."""
        if ambient_C >= self.limit_C:
            return 0.0
        times = np.array([share, 1.0 - share]) * period_s
        low, high = 0.0, self.continuous_at_Nm(ambient_C) / sqrt(share) * 1.001
        for _ in range(30):
            middle = 0.5 * (low + high)
            found = self.repeated(times, np.array([middle, 0.0]), ambient_C)
            fits = found is not None and found.hottest_winding_C <= self.limit_C
            low, high = (middle, high) if fits else (low, middle)
        return low

    def sigmas(self) -> tuple[tuple[MotorHeat, MotorHeat], ...]:
        """The motor with each uncertain figure one sigma higher, and lower."""
        spread = {"mount": MOUNT_SIGMA}
        if "winding_K_W" in self.estimated:
            spread["winding_K_W"] = WINDING_SIGMA
        if "winding_J_K" in self.estimated:
            spread["winding_J_K"] = CAPACITY_SIGMA
        return tuple(
            (
                replace(self, **{name: getattr(self, name) * np.exp(sigma)}),
                replace(self, **{name: getattr(self, name) * np.exp(-sigma)}),
            )
            for name, sigma in spread.items()
        )

    def _cut(self, time_s: Floats, torque_Nm: Floats) -> tuple[Floats, Floats]:
        """The pieces, none longer than a share of the winding's time constant; many short ones as their mean."""
        step = _STEP_SHARE * self.winding_time_s
        if time_s.sum() < 0.2 * step:
            # Too short for the winding to follow.
            total = float(time_s.sum())
            return np.array([total]), np.array([sqrt(float((time_s * torque_Nm**2).sum()) / total)])
        times, torques = _joined(time_s, torque_Nm, 0.2 * step)
        parts = np.maximum(np.ceil(times / step).astype(int), 1)
        # A long rest does not need many points: it is only cut where its end counts.
        parts = np.minimum(parts, 60)
        return np.repeat(times / parts, parts), np.repeat(torques, parts)

    def _pieces(self, time_s: Floats, torque_Nm: Floats, ambient_C: float) -> tuple[Floats, Floats]:
        """Each piece as an affine map of (winding, housing): matrices (n, 2, 2) and vectors (n, 2)."""
        heat = self.loss_W_Nm2 * np.asarray(torque_Nm, float) ** 2
        between, out = 1.0 / self.winding_K_W, 1.0 / (self.housing_K_W * self.mount)
        rate = np.zeros((len(heat), 2, 2))
        rate[:, 0, 0] = (heat * COPPER_PER_K - between) / self.winding_J_K
        rate[:, 0, 1] = between / self.winding_J_K
        rate[:, 1, 0] = between / self.housing_J_K
        rate[:, 1, 1] = -(between + out) / self.housing_J_K
        given = np.zeros((len(heat), 2))
        given[:, 0] = heat * (1.0 - COPPER_PER_K * RATED_AT_C) / self.winding_J_K
        given[:, 1] = out * ambient_C / self.housing_J_K
        turn = _exponential(rate, np.asarray(time_s, float))
        rest = np.linalg.solve(rate, given[:, :, None])[:, :, 0]
        return turn, np.einsum("nij,nj->ni", turn, rest) - rest


def motor_heat(motor: Motor) -> MotorHeat:
    """The model of a catalogue entry; what the entry does not state is estimated from size and mass."""
    estimated = []
    capacity = CAPACITY_J_KGK * motor.mass_g * 1e-3
    winding_K_W, housing_K_W, limit_C = motor.winding_K_W, motor.housing_K_W, motor.winding_limit_C
    if winding_K_W is None:
        winding_K_W = WINDING_K_W
        estimated.append("winding_K_W")
    if housing_K_W is None:
        diameter_m, length_m = motor.diameter_mm * 1e-3, motor.length_mm * 1e-3
        housing_K_W = 1.0 / (AIR_W_M2K * pi * diameter_m * (length_m + 0.5 * diameter_m))
        estimated.append("housing_K_W")
    if motor.winding_time_s is None:
        winding = (WINDING_SHARE_BRUSHLESS if motor.brushless else WINDING_SHARE_DC) * capacity
        estimated.append("winding_J_K")
    else:
        winding = motor.winding_time_s / winding_K_W
    if motor.motor_time_s is None:
        estimated.append("housing_J_K")
    else:
        capacity = motor.motor_time_s / housing_K_W
    if limit_C is None:
        limit_C = LIMIT_C
        estimated.append("limit_C")
    return MotorHeat(
        motor.rated_torque_mNm * 1e-3,
        limit_C,
        winding_K_W,
        housing_K_W,
        winding,
        capacity - min(winding, 0.5 * capacity),
        motor.brushless,
        tuple(estimated),
    )


def _joined(time_s: Floats, torque_Nm: Floats, least_s: float) -> tuple[Floats, Floats]:
    """Pieces of a cycle; neighbours that are together shorter than ``least_s`` become one of the same heat."""
    ends = np.cumsum(time_s)
    group = np.floor(ends / least_s - 1e-9).astype(int)
    long = time_s >= least_s
    # A long piece stands alone.
    group = np.cumsum(np.concatenate([[0], (np.diff(group) != 0) | long[1:] | long[:-1]]))
    times = np.asarray(np.bincount(group, time_s), float)
    heat = np.asarray(np.bincount(group, time_s * np.asarray(torque_Nm, float) ** 2), float)
    kept = times > 0.0
    return times[kept], np.sqrt(heat[kept] / times[kept])


def _exponential(rate: Floats, time_s: Floats) -> Floats:
    """exp(rate t) of 2 x 2 matrices with real eigenvalues: e^(s t) (cosh(q t) I + sinh(q t)/q (rate - s I))."""
    mean = 0.5 * (rate[:, 0, 0] + rate[:, 1, 1])
    apart = np.sqrt(0.25 * (rate[:, 0, 0] - rate[:, 1, 1]) ** 2 + rate[:, 0, 1] * rate[:, 1, 0])
    high, low = np.exp((mean + apart) * time_s), np.exp((mean - apart) * time_s)
    unit = np.broadcast_to(np.eye(2), rate.shape)
    return np.asarray(
        0.5 * (high + low)[:, None, None] * unit
        + ((high - low) / (2.0 * apart))[:, None, None] * (rate - mean[:, None, None] * unit)
    )
