"""Transmission backlash by the paper's formulas and by the drum with all cables; the modulus that one implies.

The paper never prints E, so every E used here is calibrated on a measured backlash: all stretches are proportional to
1/E and the tensions do not depend on it, hence E = E_used theta(E_used)/theta_measured.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from mbcdm_cad.model import equations as eq
from mbcdm_cad.model.equilibrium import Equilibrium, solve_equilibrium
from mbcdm_cad.model.si import DriveSI, ModelError
from mbcdm_cad.routes import Floats


@dataclass(frozen=True, eq=False)
class CableBacklash:
    """Per cable (n_cables, ...): tensions (N) and theta_b (rad), exact by Eq. (14) and simplified by (16) to (18)."""

    low_N: Floats
    high_N: Floats
    backlash_rad: Floats
    low_simplified_N: Floats
    high_simplified_N: Floats
    backlash_simplified_rad: Floats

    @property
    def simplification_error(self) -> Floats:
        """(simplified - exact)/exact of theta_b: the error of setting kappa = 0 in (14)."""
        return np.asarray(self.backlash_simplified_rad / self.backlash_rad - 1.0)


def cable_backlash(d: DriveSI, load_Nm: Any) -> CableBacklash:
    """Each cable alone, as the paper does: one input's share of the load on a pair of its radii. Sign of M ignored."""
    load = np.abs(np.asarray(load_Nm, dtype=float))
    w = d.lifted(np.broadcast_shapes(load.shape, d.batch_shape))
    low, high = eq.eq14_tensions(load, w.preload_N, w.drum_radius_m, w.kappa, d.n_inputs)
    simple_low = eq.eq17_low_tension(load, w.preload_N, w.drum_radius_m, d.n_inputs)
    simple_high = eq.eq18_high_tension(load, w.preload_N, w.drum_radius_m, d.n_inputs)

    def angle(tension: Floats) -> Floats:
        return eq.eq20_backlash(
            tension,
            w.preload_N,
            w.friction_coefficient,
            w.drum_radius_m,
            w.input_radius_m,
            w.free_span_m,
            w.axial_stiffness_N,
        )

    return CableBacklash(low, high, angle(high), simple_low, simple_high, angle(simple_high))


def mean_radii(d: DriveSI) -> DriveSI:
    """The same drive with every radius, and the preload, replaced by its mean over the cables."""

    def mean(values: Floats) -> Floats:
        return np.asarray(np.broadcast_to(values.mean(axis=0), values.shape).copy())

    lengths = {name: mean(d.parameters[name]) for name in d.geometry.per_cable}
    return d.with_(**lengths, preload_N=mean(d.preload_N))


@dataclass(frozen=True, eq=False)
class DrumBacklash:
    """All cables together (rad, >= 0): first loading from the even preload, and the swing of a full reversal."""

    first_loading_rad: Floats
    reversal_swing_rad: Floats
    idle: Equilibrium
    loaded: Equilibrium
    reversed_: Equilibrium


def drum_backlash(d: DriveSI, load_Nm: Any) -> DrumBacklash:
    """Inputs locked: load to M (turn counted from the unloaded drum), then reverse to -M (swing counted from +M)."""
    load = np.asarray(load_Nm, dtype=float)
    idle = solve_equilibrium(d, 0.0)
    loaded = solve_equilibrium(d, load)
    back = solve_equilibrium(d, -load, turned_at_N=loaded.tension_N)
    return DrumBacklash(
        np.abs(loaded.drum_angle_rad - idle.drum_angle_rad),
        np.abs(back.drum_angle_rad - loaded.drum_angle_rad),
        idle,
        loaded,
        back,
    )


Reading = Literal["reversal", "single"]
Route = Literal["mean_radii", "all_cables"]


def implied_modulus_Pa(
    d: DriveSI,
    theta_b_rad: float,
    load_Nm: float,
    reading: Reading = "reversal",
    route: Route = "mean_radii",
    give_rad_Nm: float = 0.0,
) -> float:
    """E (Pa, on the area of ``d``) for which the model gives ``theta_b_rad`` at ``load_Nm``.

    ``reading``: the measured figure is the swing at a load reversal, or the one-sided turn on first loading.
    ``route``: corrected Eq. (20) with the paper's simplified tensions at the mean radii, or all cables at once.
    ``give_rad_Nm``: what all else turns for 1 N m; infinite E where that alone turns as far as was measured.
    """
    if not theta_b_rad > 0.0:
        raise ModelError(f"theta_b_rad: {theta_b_rad:.6g} is not a backlash; give a measured angle above 0 rad")
    if reading not in ("reversal", "single"):
        raise ModelError(f"reading {reading!r} is unknown; use 'reversal' or 'single'")
    if route == "mean_radii":
        one_sided = float(np.ravel(cable_backlash(mean_radii(d), load_Nm).backlash_simplified_rad)[0])
        predicted = 2.0 * one_sided if reading == "reversal" else one_sided
    elif route == "all_cables":
        drum = drum_backlash(d, load_Nm)
        predicted = float(drum.reversal_swing_rad if reading == "reversal" else drum.first_loading_rad)
    else:
        raise ModelError(f"route {route!r} is unknown; use 'mean_radii' or 'all_cables'")
    by_cables = theta_b_rad - (2.0 if reading == "reversal" else 1.0) * give_rad_Nm * load_Nm
    return float(d.modulus_Pa) * predicted / by_cables if by_cables > 0.0 else np.inf
