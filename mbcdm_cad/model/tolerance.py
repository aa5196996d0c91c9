"""Tolerance stack: eccentricity, radius and preload tolerances of each part -> transmission error at the drum.

A displaced body changes the path of its cable by e . (u_in - u_out), for any wrap
(:mod:`mbcdm_cad.routes.route`). Radii add sigma_j dr theta of their own pulley. Linear theory assumes that every
wrap sticks; the Monte Carlo runs the whole time-series model with friction over a sweep of the travel.

Stack-up: how far one figure may fall below its nominal value, by three methods, in any unit.

A contribution shifts the figure by ``per_unit * tolerance`` at either end of its tolerance, to first order.

- RSS: sqrt(sum of squares), the three-sigma spread where each tolerance is three sigma of its part and all are
  independent (Evans, "Statistical tolerancing", 1974).
- Worst case: sum of magnitudes, every part at the bad end of its tolerance at once.
- Monte Carlo: every part uniform within its tolerance; the fall that 99.865 % of all drives do not exceed. It lies
between the other two, because parts spread over the whole tolerance are worse than RSS assumes.
"""

from collections.abc import Iterable
from dataclasses import dataclass
from math import isfinite, sqrt
from typing import Any

import numpy as np

from mbcdm_cad.model.si import DriveSI, ModelError
from mbcdm_cad.routes import Floats
from mbcdm_cad.routes.route import path_slope


@dataclass(frozen=True)
class Tolerances:
    """Standard deviations. An eccentricity is that of each of its two components. The defaults are estimates."""

    drum_eccentricity_m: float = 5e-6
    passed_eccentricity_m: float = 5e-6
    input_eccentricity_m: float = 5e-6
    drum_radius_m: float = 5e-6
    input_radius_m: float = 5e-6
    preload_N: float = 3.5


@dataclass(frozen=True, eq=False)
class ToleranceStack:
    """Transmission error over the travel, zeroed at the centred drum, no load.

    ``pose_rad`` (m,); ``contributor`` (k,) names and ``contribution_rad`` (k,) each alone, RMS over the travel by
    linear theory; ``linear_rad`` and ``monte_carlo_rad`` (m,) standard deviations at each pose; ``peak_to_peak_rad``
    the 50 and 95 % points of the peak-to-peak error over the travel, (2, 2): linear, Monte Carlo.
    """

    pose_rad: Floats
    contributor: tuple[str, ...]
    contribution_rad: Floats
    linear_rad: Floats
    monte_carlo_rad: Floats
    peak_to_peak_rad: Floats


def eccentric_path_m(d: DriveSI, body: str, offset_m: Any, drum_angle_rad: Any) -> Floats:
    """Path error of each cable, m (n_cables, m), when ``body`` is eccentric by ``offset_m``, two components at angle 0.

    The components are along the body's reference and at a right angle to it about its axis; they turn with the body.
    Raises ``ModelError`` for an unknown body.
    """
    known = {found.name: found for found in d.routes.bodies}
    if body not in known:
        raise ModelError(f"body {body!r} is unknown; use one of {', '.join(known)}")
    turned = known[body].turns_per_drum * np.asarray(drum_angle_rad, dtype=float)
    first, second = np.asarray(offset_m, dtype=float)
    x, y = first * np.cos(turned) - second * np.sin(turned), first * np.sin(turned) + second * np.cos(turned)
    along = np.array(known[body].reference)
    across = np.cross(known[body].axis, along)
    slopes = np.array([path_slope(route, body) for route in d.routes.cables])
    return np.asarray((slopes @ along)[:, None] * x + (slopes @ across)[:, None] * y)


def sources(d: DriveSI, tolerances: Tolerances, drum_angle_rad: Floats) -> tuple[tuple[str, ...], Floats, Floats]:
    """Names (k,), path error (k, n_cables, m) and preload error (k, n_cables) of one sigma of each source."""
    names: list[str] = []
    paths, preloads = [], []
    nothing = np.zeros((d.n_cables, drum_angle_rad.size))
    size_of = {
        "drum": tolerances.drum_eccentricity_m,
        "passed": tolerances.passed_eccentricity_m,
        "input": tolerances.input_eccentricity_m,
    }
    for body in d.routes.bodies:
        size = size_of[body.kind]
        for axis, unit in (("1", (size, 0.0)), ("2", (0.0, size))):
            names.append(f"{body.name} eccentricity {axis}")
            paths.append(eccentric_path_m(d, body.name, unit, drum_angle_rad))
            preloads.append(np.zeros(d.n_cables))
    for j, cable in enumerate(d.cable_names):
        own = np.arange(d.n_cables) == j
        column = (d.sigma * own)[:, None]
        names += [f"{cable} input radius", f"{cable} drum radius", f"{cable} preload"]
        paths.append(column * tolerances.input_radius_m * d.total_ratio[j] * drum_angle_rad)
        paths.append(-column * tolerances.drum_radius_m * drum_angle_rad)
        paths.append(nothing)
        preloads += [np.zeros(d.n_cables), np.zeros(d.n_cables), own * tolerances.preload_N]
    return tuple(names), np.array(paths), np.array(preloads)


def tolerance_stack(
    d: DriveSI,
    half_travel_rad: float,
    tolerances: Tolerances | None = None,
    draws: int = 400,
    poses: int = 121,
    seed: int = 0,
) -> ToleranceStack:
    """Linear theory and Monte Carlo (seeded: same input, same answer) over +-``half_travel_rad``."""
    pose = np.linspace(-half_travel_rad, half_travel_rad, poses)
    names, path, preload = sources(d, tolerances or Tolerances(), pose)
    effect = _linear_effect(d, path)
    rng = np.random.default_rng(seed)
    draw = rng.standard_normal((draws, len(names)))
    linear = draw @ effect
    measured = np.stack([_swept(d, pose, np.tensordot(x, path, 1), x @ preload) for x in draw])
    spread = np.quantile(np.stack([np.ptp(linear, axis=1), np.ptp(measured, axis=1)]), [0.5, 0.95], axis=1).T
    return ToleranceStack(
        pose,
        names,
        np.sqrt((effect**2).mean(axis=1)),
        np.sqrt((effect**2).sum(axis=0)),
        np.sqrt((measured**2).mean(axis=0)),
        spread,
    )


def linear_error(
    d: DriveSI, half_travel_rad: float, tolerances: Tolerances, poses: int = 31
) -> tuple[tuple[str, ...], Floats]:
    """Names of the sources (k,) and the error of one sigma of each at ``poses`` angles over the travel (k, m), rad.

    Linear theory, zeroed at the centred drum; fast enough for a check.
    """
    names, path, _ = sources(d, tolerances, np.linspace(-half_travel_rad, half_travel_rad, poses))
    return names, _linear_effect(d, path)


def _linear_effect(d: DriveSI, path: Floats) -> Floats:
    """Turn of the drum (k, m) for path errors (k, n_cables, m), zero at the middle pose."""
    hold = d.drum_radius_m / d.free_span_m
    weight = d.sigma * hold / (d.drum_radius_m * hold).sum()
    # In linear theory a preload error shifts the drum by the same angle everywhere, so it is zero after zeroing.
    effect = np.einsum("j,kjm->km", weight, path)
    centre = path.shape[2] // 2
    return np.asarray(effect - effect[:, centre : centre + 1])


def _swept(d: DriveSI, pose: Floats, path: Floats, preload_error: Floats) -> Floats:
    """Transmission error on the upward sweep, after a sweep that sets the friction's state; rad (m,), centre zero."""
    from mbcdm_cad.model.hysteresis import simulate  # loads compiled code, not needed by the checks

    centre = pose.size // 2
    # From the centre up, down, and up again without a jump; the last sweep is evaluated.
    order = np.concatenate([np.arange(centre, pose.size), np.arange(pose.size - 2, -1, -1), np.arange(1, pose.size)])
    ratio = d.input_turns
    held = d.with_(preload_N=np.maximum(d.preload_N + preload_error, 1.0))
    run = simulate(held, ratio[:, None] * pose[order], 0.0, path_m=path[:, order])
    error = run.drum_angle_rad[-pose.size :] - pose
    return np.asarray(error - error[centre])


# Share of drives beyond three sigma on one side of a normal law.
BEYOND_THREE_SIGMA = 0.00135
DRAWS = 200_000


@dataclass(frozen=True)
class Contribution:
    """One tolerance (half its band) and how much the figure changes for a change of it by one."""

    name: str
    tolerance: float
    per_unit: float = 1.0

    @property
    def shift(self) -> float:
        """Change of the figure at the end of the tolerance, without sign."""
        return abs(self.per_unit) * self.tolerance


@dataclass(frozen=True)
class StackUp:
    """Tolerance stack of ``figure``, whose nominal margin is ``margin``; infinite if nothing limits it."""

    figure: str
    margin: float
    contributions: tuple[Contribution, ...]

    @property
    def rss(self) -> float:
        """Root of the sum of squares."""
        return sqrt(sum(c.shift**2 for c in self.contributions))

    @property
    def worst_case(self) -> float:
        """All parts at the bad end of their tolerances."""
        return sum(c.shift for c in self.contributions)

    @property
    def costliest(self) -> Contribution:
        """The tolerance with the largest effect. Raises ``ValueError`` where there is none."""
        return max(self.contributions, key=lambda c: c.shift)

    @property
    def spare(self) -> float:
        """Margin after the RSS stack; below zero some drives exceed the limit."""
        return self.margin - self.rss

    def monte_carlo(self, draws: int = DRAWS, seed: int = 0) -> float:
        """How far 99.865 % of drives fall at most, each part uniform within its tolerance; seeded."""
        rng = np.random.default_rng(seed)
        total = np.zeros(draws)
        for c in self.contributions:
            total += c.shift * rng.uniform(-1.0, 1.0, draws)
        return float(np.quantile(total, 1.0 - BEYOND_THREE_SIGMA))


def stack_data(stack: StackUp, draws: int = 0) -> dict[str, Any]:
    """The stack as plain data, the costliest tolerance first; with ``draws`` by Monte Carlo too."""
    ordered = sorted(stack.contributions, key=lambda c: -c.shift)
    data: dict[str, Any] = {
        "figure": stack.figure,
        "margin": stack.margin if isfinite(stack.margin) else None,
        "rss": stack.rss,
        "worst_case": stack.worst_case,
        "contributions": [{"name": c.name, "tolerance": c.tolerance, "shift": c.shift} for c in ordered],
    }
    return data | ({"monte_carlo": stack.monte_carlo(draws)} if draws else {})


def tightest(stacks: Iterable[StackUp]) -> StackUp:
    """The stack with the least margin left."""
    return min(stacks, key=lambda stack: stack.spare)
