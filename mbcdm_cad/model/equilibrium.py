"""All cables at once: the drum angle at which the cables balance the load while every input is held.

Cable j stretches by delta_j = sigma_j (r_ij theta_i - r_oj theta_o), and sum_j sigma_j T_j r_oj = M_l (M_l > 0 opposes
positive rotation). The numbers are found by :mod:`mbcdm_cad.model.solver`.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from mbcdm_cad.model.si import DriveSI
from mbcdm_cad.model.solver import balance
from mbcdm_cad.routes import Floats


@dataclass(frozen=True, eq=False)
class Equilibrium:
    """Drum angle (rad, shape (...)), tensions (N) and stretches (m) of the cables, shape (n_cables, ...)."""

    drum_angle_rad: Floats
    tension_N: Floats
    stretch_m: Floats

    def input_torque_Nm(self, d: DriveSI) -> Floats:
        """Torque that holds each input, sum_j sigma_j T_j r_ij over its cables, shape (n_inputs, ...)."""
        return _sum_per_input(d, self.tension_N, d.lifted(self.drum_angle_rad.shape).input_radius_m)

    def drum_torque_by_input_Nm(self, d: DriveSI) -> Floats:
        """Torque of the cables of each input on the drum, sum_j sigma_j T_j r_oj, N m, shape (n_inputs, ...)."""
        return _sum_per_input(d, self.tension_N, d.lifted(self.drum_angle_rad.shape).drum_radius_m)

    def load_share(self, d: DriveSI, load_Nm: Any) -> Floats:
        """Share of the load that each input takes: the change of its drum torque from no load, over the load."""
        idle = solve_equilibrium(d, 0.0)
        before = idle.drum_torque_by_input_Nm(d)
        now = self.drum_torque_by_input_Nm(d)
        before = before.reshape(before.shape[0], *(1,) * (now.ndim - before.ndim), *before.shape[1:])
        return np.asarray((now - before) / np.asarray(load_Nm, dtype=float))

    @property
    def slack(self) -> Any:
        """True where a cable carries no tension, shape (n_cables, ...)."""
        return self.tension_N <= 0.0


def _sum_per_input(d: DriveSI, tension: Floats, radius: Floats) -> Floats:
    pull = d.column(d.sigma, tension.ndim) * tension * radius
    return np.stack([pull[[j for j, k in enumerate(d.input_of) if k == i]].sum(axis=0) for i in range(d.n_inputs)])


def solve_equilibrium(
    d: DriveSI, load_Nm: Any, input_angle_rad: Any = None, path_m: Any = None, turned_at_N: Floats | None = None
) -> Equilibrium:
    """Drum angle and tensions under ``load_Nm`` (shape broadcastable to the batch, or any shape for one design).

    ``input_angle_rad`` (n_inputs, ...) defaults to zero: both inputs locked where they were preloaded. ``path_m``
    (n_cables, ...) lengthens the path of each cable, as an eccentric pulley does, and is added to its stretch.
    ``turned_at_N`` (n_cables, ...) are the tensions from which a first loading was reversed; without it this is the
    first loading. Errors: ``ModelError`` where no drum angle carries the load.
    """
    load = np.asarray(load_Nm, dtype=float)
    given = [np.shape(a)[1:] for a in (input_angle_rad, path_m) if a is not None]
    shape = np.broadcast_shapes(load.shape, d.batch_shape, *given)
    wide = d.lifted(shape)
    weight = d.column(d.sigma, len(shape) + 1) * wide.drum_radius_m
    return solve_weighted(wide, weight, np.broadcast_to(load, shape), input_angle_rad, path_m, turned_at_N)


def solve_weighted(
    d: DriveSI,
    weight: Floats,
    target: Any,
    input_angle_rad: Any = None,
    path_m: Any = None,
    turned_at_N: Floats | None = None,
) -> Equilibrium:
    """The equilibrium at which sum_j weight_j T_j = ``target``.

    ``weight`` (n_cables, ...) has sigma's sign or is zero, not all zero. With the drum's radii the target is the load;
    with the input radii of one input it is that input's torque; with one cable alone it is sigma times its tension.
    ``d`` must already be lifted to the shape of the answer. Other arguments as in :func:`solve_equilibrium`.
    """
    goal = np.asarray(target, dtype=float)
    shape = np.broadcast_shapes(goal.shape, d.batch_shape, weight.shape[1:])
    full = (d.n_cables, *shape)
    sigma = d.column(d.sigma, len(full))
    lever = np.broadcast_to(sigma * d.drum_radius_m, full)
    offset = np.zeros(full)
    if input_angle_rad is not None:
        angle = np.asarray(input_angle_rad, dtype=float)[list(d.input_of)]
        offset = offset + sigma * d.input_radius_m * d.column(angle, len(full))
    if path_m is not None:
        offset = offset + d.column(np.asarray(path_m, dtype=float), len(full))
    theta, tension = balance(d, np.broadcast_to(weight, full), np.broadcast_to(goal, shape), lever, offset, turned_at_N)
    return Equilibrium(theta, tension, offset - lever * theta)
