"""Stiffness at the drum with the inputs locked, and the torsional modes that follow from it."""

from __future__ import annotations

from typing import Any

import numpy as np

from mbcdm_cad.model.equilibrium import solve_equilibrium
from mbcdm_cad.model.si import DriveSI
from mbcdm_cad.model.wrap import stretch_first_loading
from mbcdm_cad.routes import Floats


def tangent_stiffness_Nm_rad(d: DriveSI, load_Nm: Any) -> Floats:
    """dM/dtheta at the drum after first loading to ``load_Nm``, N m/rad: sum of r_o^2 dT/d(delta)."""
    at = solve_equilibrium(d, load_Nm)
    w = d.lifted(at.drum_angle_rad.shape)
    # A slack cable has no stiffness; any tension serves where its law ends.
    _, slope = stretch_first_loading(w, np.where(at.slack, w.preload_N, at.tension_N))
    return np.asarray(np.where(at.slack, 0.0, w.drum_radius_m**2 / slope).sum(axis=0))


def sticking_stiffness_Nm_rad(d: DriveSI) -> Floats:
    """dM/dtheta while every wrap sticks: at no load and just after a reversal, sum of r_o^2 EA/L_free."""
    return np.asarray((d.drum_radius_m**2 * d.axial_stiffness_N / d.free_span_m).sum(axis=0))


def sticking_response(d: DriveSI, path_m: Any) -> tuple[Floats, Floats]:
    """Response to a change of the cables' path lengths with inputs locked, no load, and every wrap sticking.

    ``path_m`` (n_cables, ...) is how much longer each cable's path is. Returns the drum's turn (rad, (...)) and the
    change of each tension (N, (n_cables, ...)): the most it can be, since slip on the wraps only makes cables softer.
    """
    path = np.asarray(path_m, dtype=float)
    stiffness = d.column(d.axial_stiffness_N / d.free_span_m, path.ndim)
    lever = d.column(d.sigma * d.drum_radius_m, path.ndim)
    angle = (stiffness * lever * path).sum(axis=0) / (stiffness * lever**2).sum(axis=0)
    return np.asarray(angle), np.asarray(stiffness * (path - lever * angle))


def secant_stiffness_Nm_rad(d: DriveSI, load_Nm: Any) -> Floats:
    """M over the drum's turn from the unloaded state; the sticking stiffness in the limit of no load."""
    load = np.asarray(load_Nm, dtype=float)
    turn = np.abs(solve_equilibrium(d, load).drum_angle_rad - solve_equilibrium(d, 0.0).drum_angle_rad)
    moving = turn > 1e-15
    return np.asarray(np.where(moving, np.abs(load) / np.where(moving, turn, 1.0), sticking_stiffness_Nm_rad(d)))


def torsional_modes_Hz(d: DriveSI, drum_inertia_kg_m2: float, input_inertia_kg_m2: Any = np.inf) -> Floats:
    """Undamped frequencies in ascending order for small motion (every wrap sticks).

    ``input_inertia_kg_m2`` is that of each input with motor and gearhead reflected to it, one value or one each.
    The default locks the inputs and leaves the drum's single mode. With free inputs the first is the rigid turn (0).
    """
    stiffness = d.axial_stiffness_N / d.free_span_m
    inertia = np.broadcast_to(np.asarray(input_inertia_kg_m2, dtype=float), (d.n_inputs,))
    size = 1 + d.n_inputs
    matrix = np.zeros((size, size))
    for j, i in enumerate(d.input_of):
        # Stretch per unit angle of drum and input; the sign sigma cancels in the square.
        row = np.zeros(size)
        row[0], row[1 + i] = -d.drum_radius_m[j], d.input_radius_m[j]
        matrix += stiffness[j] * np.outer(row, row)
    free = [0] + [1 + i for i in range(d.n_inputs) if np.isfinite(inertia[i])]
    root = np.sqrt(np.concatenate([[drum_inertia_kg_m2], inertia])[free])
    values = np.linalg.eigvalsh(matrix[np.ix_(free, free)] / np.outer(root, root))
    noise = 1e-9 * values.max()
    return np.asarray(np.sqrt(np.where(values < noise, 0.0, values)) / (2.0 * np.pi))


def unit_tensions_N(d: DriveSI) -> Floats:
    """Change of the tensions (n_cables,) per N m of load on the drum while every wrap sticks."""
    stiffness = d.axial_stiffness_N / d.free_span_m
    return np.asarray(d.sigma * stiffness * d.drum_radius_m / (stiffness * d.drum_radius_m**2).sum())
