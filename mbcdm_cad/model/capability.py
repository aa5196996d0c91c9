"""Peak torque at the drum in both directions and its limits: input ratings, cable strength, slack, slip at an input.

With equal preloads on unequal radii the two cables of an input leave a bias torque T_pre (r_2 - r_1) on it, so the
limit differs by direction; preloads with T ~ 1/r within a pair remove the bias.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mbcdm_cad.model.equilibrium import Equilibrium, solve_equilibrium, solve_weighted
from mbcdm_cad.model.errors import ModelError
from mbcdm_cad.model.si import DriveSI
from mbcdm_cad.model.solver import tension_of_stretch
from mbcdm_cad.model.wrap import slack_stretch_m
from mbcdm_cad.routes import Floats

# Name of the limit in `Analysis.limits`.
SLIP = "slip"
# With e^(mu theta) above this no drive reaches the slip limit.
_LARGEST_EXPONENT = 30.0


def input_bias_Nm(d: DriveSI) -> Floats:
    """Torque on each input from the preload alone, at no load, shape (n_inputs, *batch)."""
    return solve_equilibrium(d, 0.0).input_torque_Nm(d)


def balanced_preload_N(d: DriveSI) -> Floats:
    """Preloads with T ~ 1/r_i within each pair and the same mean per pair: no bias on any input."""
    inverse = 1.0 / d.input_radius_m
    preload = np.broadcast_to(d.preload_N, inverse.shape)
    scaled = np.empty_like(inverse)
    for i in range(d.n_inputs):
        pair = [j for j, k in enumerate(d.input_of) if k == i]
        scaled[pair] = inverse[pair] * preload[pair].mean(axis=0) / inverse[pair].mean(axis=0)
    return np.asarray(scaled)


def _load_of(d: DriveSI, at: Equilibrium) -> Floats:
    return np.asarray(np.einsum("j...,j...->...", d.column(d.sigma, at.tension_N.ndim) * d.drum_radius_m, at.tension_N))


def torque_at_input_limit_Nm(d: DriveSI, limit_Nm: Floats | float, direction: int) -> Floats:
    """Load (N m, >= 0, shape (n_inputs, *batch)) at which each input reaches ``limit_Nm`` in ``direction`` (+1 or -1).

    +1 is a load that opposes positive rotation of the drum. Zero where the bias alone reaches the limit.
    """
    bias = input_bias_Nm(d)
    rows = []
    for i in range(d.n_inputs):
        weight = d.column(d.sigma * d.of_input(i), 1 + len(d.batch_shape)) * d.input_radius_m
        at = solve_weighted(d, weight, direction * np.asarray(limit_Nm, dtype=float))
        load = direction * _load_of(d, at)
        rows.append(np.where(direction * bias[i] >= limit_Nm, 0.0, load))
    return np.stack(rows)


def torque_at_tension_limit_Nm(d: DriveSI, tension_N: Floats | float, direction: int) -> Floats:
    """Load (N m) at which each cable that ``direction`` tightens reaches ``tension_N``; inf for the others."""
    rows = []
    for j in range(d.n_cables):
        if d.sigma[j] != direction:
            rows.append(np.full(d.batch_shape, np.inf))
            continue
        weight = d.column(d.sigma * (np.arange(d.n_cables) == j), 1 + len(d.batch_shape))
        at = solve_weighted(d, weight, d.sigma[j] * np.asarray(tension_N, dtype=float))
        rows.append(np.maximum(direction * _load_of(d, at), 0.0))
    return np.stack(rows)


def torque_at_slack_Nm(d: DriveSI, direction: int) -> Floats:
    """Load (N m) at which each cable that ``direction`` slackens goes slack; inf for others and for endless wraps."""
    limit = slack_stretch_m(d)
    rows = []
    for j in range(d.n_cables):
        if d.sigma[j] == direction or not np.all(np.isfinite(limit[j])):
            rows.append(np.full(d.batch_shape, np.inf))
            continue
        drum_angle = -limit[j] / (d.sigma[j] * d.drum_radius_m[j])
        stretch = -d.column(d.sigma, 1 + len(d.batch_shape)) * d.drum_radius_m * drum_angle
        tension = tension_of_stretch(d, np.asarray(stretch))
        tension[j] = 0.0
        rows.append(direction * _load_of(d, Equilibrium(np.asarray(drum_angle), tension, np.asarray(stretch))))
    return np.stack(rows)


def slip_weight(d: DriveSI, index: int, direction: int | NDArray[np.int_]) -> Floats:
    """Weights w (n_cables, *batch) with sum w_j T_j = 0 where the cable begins to slip on input ``index``.

    Over a wrap angle theta friction holds at most T_h = T_l e^(mu theta) (capstan equation of Euler and Eytelwein).
    With equal linear sides this is a difference of 2 T_pre tanh(mu theta/2). Raises ``ModelError`` where the cables are
    anchored.
    """
    if d.through_wrap_rad is None:
        raise ModelError("cables are anchored on their inputs: none slips there")
    ndim = 1 + len(d.batch_shape)
    ratio = np.exp(np.minimum(d.friction_coefficient * d.through_wrap_rad[index], _LARGEST_EXPONENT))
    own = d.column(d.sigma * d.of_input(index), ndim)
    return np.asarray(own * np.where(own * direction > 0.0, 1.0, ratio))


def torque_at_slip_of_Nm(d: DriveSI, index: int, direction: int | NDArray[np.int_]) -> Floats:
    """Load (N m, shape (*batch)) at which the cable begins to slip on input ``index``.

    ``direction``: one for all designs of the batch, or one for each.
    """
    at = solve_weighted(d, slip_weight(d, index, direction), np.zeros(d.batch_shape))
    return np.maximum(direction * _load_of(d, at), 0.0)


def torque_at_slip_Nm(d: DriveSI, direction: int) -> Floats:
    """Load (N m, shape (n_inputs, *batch)) at which the cable begins to slip on each input."""
    return np.stack([torque_at_slip_of_Nm(d, i, direction) for i in range(d.n_inputs)])


@dataclass(frozen=True)
class TorqueLimit:
    """One limit of the drum's torque in one direction: which part reaches it first, and at which load."""

    cause: str
    limiting: str
    direction: int
    torque_Nm: float


def torque_limits(d: DriveSI, input_ratings_Nm: dict[str, float], tension_limit_N: float) -> tuple[TorqueLimit, ...]:
    """Every limit both ways for one design, +1 first: one per rating (by its name), ``strength`` and ``slack``.

    ``slip`` too, where friction alone holds a cable on an input.
    """
    found = []
    for direction in (1, -1):
        for cause, rating in input_ratings_Nm.items():
            loads = torque_at_input_limit_Nm(d, rating, direction)
            first = int(np.argmin(loads))
            found.append(TorqueLimit(cause, d.input_names[first], direction, float(loads[first])))
        for cause, loads in (
            ("strength", torque_at_tension_limit_Nm(d, tension_limit_N, direction)),
            ("slack", torque_at_slack_Nm(d, direction)),
        ):
            first = int(np.argmin(loads))
            name = d.cable_names[first] if np.isfinite(loads[first]) else "none"
            found.append(TorqueLimit(cause, name, direction, float(loads[first])))
        if d.through_wrap_rad is not None:
            loads = torque_at_slip_Nm(d, direction)
            first = int(np.argmin(loads))
            found.append(TorqueLimit(SLIP, d.input_names[first], direction, float(loads[first])))
    return tuple(found)


def torque_to_weight_Nm_kg(torque_Nm: float, mass_g: float) -> float:
    """Torque over mass in N m/kg."""
    return torque_Nm / (mass_g * 1e-3)
