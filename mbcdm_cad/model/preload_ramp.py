"""The preloads of one input's cables from a ramp of its torque while the drum is held.

With the drum held, an input turned by an angle x stretches each of its cables by sigma r x. Its torque then follows
from the law of the cables, which bends where a cable goes slack:

    M(x) = sum_j sigma_j r_j T_j(sigma_j r_j x)

The two preloads are fitted to measured angles and torques together with the rope's stiffness and the friction of its
wraps, which are known to a standard deviation only (maximum of the posterior density, linear sigmas).
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from mbcdm_cad.model.equilibrium import tension_of_stretch
from mbcdm_cad.model.si import DriveSI, ModelError
from mbcdm_cad.routes import Floats

# What the design does not know of stiffness and friction: standard deviations of their logarithms (estimates).
SIGMA_STIFFNESS, SIGMA_FRICTION = 0.1, 0.2
# A cable with a smaller share of its preload counts as slack.
SLACK_SHARE = 0.05
# The ramp goes on beyond the knee by this share of the angle.
BEYOND = 1.3
_POINTS, _STEP, _ROUNDS = 61, 1e-4, 40


@dataclass(frozen=True, eq=False)
class HeldDrive:
    """A drive whose drum is held at a stop, and the wraps (input, drum) of its cables there, each (n_cables,).

    ``falling_rad``: at the stop towards which the drum turns with falling angles, ``rising_rad``: at the other.
    """

    d: DriveSI
    falling_rad: tuple[Floats, Floats]
    rising_rad: tuple[Floats, Floats]

    def tensions_N(self, index: int, angle_rad: Floats) -> Floats:
        """Tensions (n_cables, n) with the input ``index`` turned by the angles (n,)."""
        angle = np.asarray(angle_rad, float)
        wraps = [
            np.where(angle >= 0.0, rising[:, None], falling[:, None])
            for falling, rising in zip(self.falling_rad, self.rising_rad, strict=True)
        ]
        wide = self.d.spread(angle.size).with_(input_wrap_rad=wraps[0], drum_wrap_rad=wraps[1])
        return tension_of_stretch(wide, np.multiply.outer(self.lever_m(index), angle))

    def lever_m(self, index: int) -> Floats:
        """Lever of each cable at an input, with its sense; 0 for the cables of others."""
        return np.asarray(self.d.of_input(index) * self.d.sigma * self.d.input_radius_m)

    def torque_Nm(self, index: int, angle_rad: Floats) -> Floats:
        """Torque (n,) at the input ``index`` turned by the angles (n,)."""
        return np.asarray((self.lever_m(index)[:, None] * self.tensions_N(index, angle_rad)).sum(axis=0))


@dataclass(frozen=True)
class SampleNoise:
    """Standard deviations of one sample of a ramp."""

    angle_rad: float
    torque_Nm: float


@dataclass(frozen=True, eq=False)
class Ramp:
    """Expected ramps of one input: with the angle rising from 0, at one stop of the drum, and falling, at the other.

    ``angle_rad`` and ``torque_Nm`` (n,), sorted by the angle; ``sigma_Nm`` (n,): of the torque, by what is not known
    of stiffness and friction. ``knee_rad`` and ``knee_Nm``: where a cable goes slack, falling and rising.
    ``sigma_N`` (n_own,): of each preload that the ramps will give.
    """

    input_name: str
    cables: tuple[int, ...]
    angle_rad: Floats
    torque_Nm: Floats
    sigma_Nm: Floats
    knee_rad: tuple[float, float]
    knee_Nm: tuple[float, float]
    slack_first: tuple[str, str]
    sigma_N: Floats


@dataclass(frozen=True, eq=False)
class MeasuredPreloads:
    """Preloads of an input's cables found from its ramps, N, their sigmas; stiffness and friction over the design's."""

    cables: tuple[int, ...]
    preload_N: Floats
    sigma_N: Floats
    stiffness: float
    friction: float


def expected(held: HeldDrive, index: int, noise: SampleNoise, samples: int = 200) -> Ramp:
    """The ramps of an input on the drive as designed, ``samples`` each way. ``ModelError`` if no cable goes slack."""
    d = held.d
    own = tuple(j for j, i in enumerate(d.input_of) if i == index)
    ends, slack = [], []
    for sense in (-1.0, 1.0):
        knee, name = _knee(held, index, own, sense)
        ends.append(sense * knee)
        slack.append(name)
    angle = np.concatenate(
        [np.linspace(BEYOND * ends[0], 0.0, _POINTS)[:-1], np.linspace(0.0, BEYOND * ends[1], _POINTS)]
    )
    found = held.torque_Nm(index, angle)
    columns = _slopes(held, index, own, angle)
    spread = np.hypot(columns[-2] * SIGMA_STIFFNESS, columns[-1] * SIGMA_FRICTION)
    scale = samples / _POINTS
    sigma = np.sqrt(np.diag(_covariance(columns, _weight(held, index, angle, noise) * scale)))[: len(own)]
    knees = held.torque_Nm(index, np.array(ends))
    return Ramp(
        d.input_names[index],
        own,
        angle,
        found,
        spread,
        (ends[0], ends[1]),
        (float(knees[0]), float(knees[1])),
        (slack[0], slack[1]),
        sigma * d.preload_N[list(own)],
    )


def fitted(held: HeldDrive, index: int, angle_rad: Floats, measured_Nm: Floats, noise: SampleNoise) -> MeasuredPreloads:
    """Preloads from ramps both ways. Raises ``ModelError`` for fewer than 8 samples or where the fit does not end."""
    angle, torque = np.asarray(angle_rad, float), np.asarray(measured_Nm, float)
    if angle.size < 8 or angle.size != torque.size:
        raise ModelError(f"a ramp of {angle.size} angles and {torque.size} torques; give at least 8 samples of both")
    d = held.d
    own = [j for j, i in enumerate(d.input_of) if i == index]
    x, known = np.zeros(len(own) + 2), np.array([0.0] * len(own) + [SIGMA_STIFFNESS**-2, SIGMA_FRICTION**-2])
    size = float("inf")
    for _ in range(_ROUNDS):
        now = _changed(held, own, x)
        weight = _weight(now, index, angle, noise)
        columns = _slopes(now, index, tuple(own), angle)
        miss = torque - now.torque_Nm(index, angle)
        hessian = (columns * weight) @ columns.T + np.diag(known)
        step = np.linalg.solve(hessian, (columns * weight) @ miss - known * x)
        size = float(np.abs(step).max())
        x = x + np.clip(step, -0.5, 0.5)
        if size < 1e-6:
            break
    if not size < 1e-3:
        raise ModelError(
            f"the preloads of input {d.input_names[index]} do not follow from this ramp; see docs/preload.md"
        )
    covariance = np.linalg.inv(hessian)
    preload = d.preload_N[own] * np.exp(x[: len(own)])
    return MeasuredPreloads(
        tuple(own),
        preload,
        preload * np.sqrt(np.diag(covariance)[: len(own)]),
        float(np.exp(x[-2])),
        float(np.exp(x[-1])),
    )


def _changed(held: HeldDrive, own: list[int], x: Floats) -> HeldDrive:
    """The drive with logarithms of preloads, stiffness and friction changed."""
    d = held.d
    preload = d.preload_N.copy()
    preload[own] *= np.exp(x[: len(own)])
    changed = d.with_(
        preload_N=preload,
        modulus_Pa=d.modulus_Pa * np.exp(x[-2]),
        friction_coefficient=d.friction_coefficient * np.exp(x[-1]),
    )
    return replace(held, d=changed)


def _slopes(held: HeldDrive, index: int, own: tuple[int, ...], angle: Floats) -> Floats:
    """Change of the torque for each logarithm: preloads of the input's cables, stiffness, friction; (n_own + 2, n)."""
    rows = []
    for k in range(len(own) + 2):
        step = np.zeros(len(own) + 2)
        step[k] = _STEP
        up, down = (_changed(held, list(own), sign * step).torque_Nm(index, angle) for sign in (1.0, -1.0))
        rows.append((up - down) / (2.0 * _STEP))
    return np.array(rows)


def _weight(held: HeldDrive, index: int, angle: Floats, noise: SampleNoise) -> Floats:
    """Inverse variance of each sample's torque, the noise of its angle included."""
    step = 1e-3 * float(np.abs(angle).max())
    slope = (held.torque_Nm(index, angle + step) - held.torque_Nm(index, angle - step)) / (2.0 * step)
    return np.asarray(1.0 / (noise.torque_Nm**2 + (slope * noise.angle_rad) ** 2))


def _covariance(columns: Floats, weight: Floats) -> Floats:
    known = np.array([0.0] * (len(columns) - 2) + [SIGMA_STIFFNESS**-2, SIGMA_FRICTION**-2])
    return np.asarray(np.linalg.inv((columns * weight) @ columns.T + np.diag(known)))


def _knee(held: HeldDrive, index: int, own: tuple[int, ...], sense: float) -> tuple[float, str]:
    """Angle at which the first cable of an input goes slack, and the cable's name."""
    d = held.d

    def shares(angle: float) -> Floats:
        return np.asarray(held.tensions_N(index, np.array([sense * angle]))[list(own), 0] / d.preload_N[list(own)])

    high = float(d.preload_N.max() * d.free_span_m.max() / d.axial_stiffness_N / d.input_radius_m.min())
    for _ in range(40):
        if shares(high).min() < SLACK_SHARE:
            break
        high *= 2.0
    else:
        raise ModelError(f"no cable of input {d.input_names[index]} goes slack, however far it is turned")
    low = 0.0
    for _ in range(30):
        middle = 0.5 * (low + high)
        low, high = (low, middle) if shares(middle).min() < SLACK_SHARE else (middle, high)
    return high, d.cable_names[own[int(np.argmin(shares(high)))]]
