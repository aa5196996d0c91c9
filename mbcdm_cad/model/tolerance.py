"""Tolerance stack: eccentricity, radius and preload tolerances of each part -> transmission error at the drum.

A displaced pulley lengthens the path of its cable by -e . (sum of the cable's pulls on it), whatever the wrap: for an
input -e . u_j, for the guide e . (u_j - q_j x), for the drum e . q_j x, with u_j along the span from input to guide and
q_j the drum side. Radii add sigma_j dr theta of their own pulley. Linear theory takes every wrap as sticking; the Monte
Carlo runs the whole time-series model, friction and its memory included, over a sweep of the travel.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from mbcdm_cad.model.bearing_loads import span_directions
from mbcdm_cad.model.errors import ModelError
from mbcdm_cad.model.hysteresis import simulate
from mbcdm_cad.model.si import DriveSI, Floats


@dataclass(frozen=True)
class Tolerances:
    """Standard deviations. An eccentricity is that of each of its two components. The defaults are estimates."""

    drum_eccentricity_m: float = 5e-6
    guide_eccentricity_m: float = 5e-6
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


def eccentric_path_m(d: DriveSI, part: str, offset_m: Any, drum_angle_rad: Any) -> Floats:
    """Path error of each cable (n_cables, m) when ``part`` is off its axis by ``offset_m``, two components at angle 0.

    ``part`` is "drum" (components x, z), "guide" or the name of an input (x, y); it turns with the rigid chain. Errors:
    ``ModelError`` for an unknown part.
    """
    drum = np.asarray(drum_angle_rad, dtype=float)
    first, second = np.asarray(offset_m, dtype=float)
    along, towards = span_directions(d), -d.sigma[:, None]
    if part == "drum":
        return np.asarray(towards * (first * np.cos(drum) + second * np.sin(drum)))
    if part == "guide":
        turn = -d.drum_radius_m[0] / d.guide_radius_m[0] * drum
        pulls = along[:, :2] - np.stack([-d.sigma, np.zeros(d.n_cables)], axis=1)
    elif part in d.input_names:
        index = d.input_names.index(part)
        turn = d.total_ratio[d.input_of.index(index)] * drum
        pulls = -along[:, :2] * d.of_input(index)[:, None]
    else:
        raise ModelError(f"part {part!r} is unknown; use drum, guide or one of {', '.join(d.input_names)}")
    x, y = first * np.cos(turn) - second * np.sin(turn), first * np.sin(turn) + second * np.cos(turn)
    return np.asarray(pulls[:, :1] * x + pulls[:, 1:] * y)


def sources(d: DriveSI, tolerances: Tolerances, drum_angle_rad: Floats) -> tuple[tuple[str, ...], Floats, Floats]:
    """Names (k,), path error (k, n_cables, m) and preload error (k, n_cables) of one sigma of each source."""
    names: list[str] = []
    paths, preloads = [], []
    nothing = np.zeros((d.n_cables, drum_angle_rad.size))
    eccentric = {"drum": tolerances.drum_eccentricity_m, "guide": tolerances.guide_eccentricity_m}
    eccentric |= dict.fromkeys(d.input_names, tolerances.input_eccentricity_m)
    for part, size in eccentric.items():
        for axis, unit in (("1", (size, 0.0)), ("2", (0.0, size))):
            names.append(f"{part} eccentricity {axis}")
            paths.append(eccentric_path_m(d, part, unit, drum_angle_rad))
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
    hold = d.drum_radius_m / d.free_span_m
    weight = d.sigma * hold / (d.drum_radius_m * hold).sum()
    centre = poses // 2
    # A preload error shifts the balance by the same angle everywhere, so it leaves the zeroed error by linear theory.
    effect = np.einsum("j,kjm->km", weight, path)
    effect -= effect[:, centre : centre + 1]
    rng = np.random.default_rng(seed)
    draw = rng.standard_normal((draws, len(names)))
    linear = draw @ effect
    measured = np.stack([_swept(d, pose, np.tensordot(x, path, 1), x @ preload) for x in draw])
    spread = np.quantile(np.stack([np.ptp(linear, axis=1), np.ptp(measured, axis=1)]), [0.5, 0.95], axis=1).T
    return ToleranceStack(
        pose, names, np.sqrt((effect**2).mean(axis=1)), np.sqrt((effect**2).sum(axis=0)),
        np.sqrt((measured**2).mean(axis=0)), spread,
    )  # fmt: skip


def _swept(d: DriveSI, pose: Floats, path: Floats, preload_error: Floats) -> Floats:
    """Transmission error on the way up, after one sweep has set the friction's memory; (m,), zero at the centre."""
    centre = pose.size // 2
    # From the centre up, down, and up again: no jump, and the last sweep is the one that counts.
    order = np.concatenate([np.arange(centre, pose.size), np.arange(pose.size - 2, -1, -1), np.arange(1, pose.size)])
    ratio = np.array([d.total_ratio[d.input_of.index(i)] for i in range(d.n_inputs)])
    held = d.with_(preload_N=np.maximum(d.preload_N + preload_error, 1.0))
    run = simulate(held, ratio[:, None] * pose[order], 0.0, path_m=path[:, order])
    error = run.drum_angle_rad[-pose.size :] - pose
    return np.asarray(error - error[centre])
