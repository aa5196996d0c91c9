"""Backlash by the paper's formulas and by the drum with all cables, stiffness with the inputs locked, and its modes.

The paper never prints E, so every E used here is calibrated on a measured backlash: all stretches are proportional to
1/E and the tensions do not depend on it, hence E = E_used theta(E_used)/theta_measured.
"""

from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from mbcdm_cad.model import equations as eq
from mbcdm_cad.model.equilibrium import Equilibrium, solve_equilibrium, sum_per_input
from mbcdm_cad.model.si import DriveSI, ModelError
from mbcdm_cad.model.wrap import stretch_first_loading
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


@dataclass(frozen=True)
class Chain:
    """Compliance in series with the cables, rad per N m on the drum: where parts give that are not rigid.

    ``before_inputs``: between rotors and input pulleys (gearheads, torsion of the pulleys), of all inputs together;
    ``before_drum``: between input pulleys and the drum's land (bearings, shafts, frame); ``in_drum``: between the
    drum's land and the payload (web and hub).
    """

    before_inputs: float = 0.0
    before_drum: float = 0.0
    in_drum: float = 0.0


RIGID = Chain()


@dataclass(frozen=True)
class TurningInertias:
    """What turns, kg m2: drum with all that turns with it; payload on its hub; each input pulley; each rotor, at it.

    Infinite ones are held. Without ``rotors`` these are part of the pulleys.
    """

    drum: float
    payload: float = 0.0
    pulleys: Any = np.inf
    rotors: Any = 0.0


def torsional_modes_Hz(d: DriveSI, inertias: TurningInertias, chain: Chain = RIGID) -> Floats:
    """Undamped frequencies in ascending order for small motion (every wrap sticks); a rigid turn of the whole is 0.

    Rotors, input pulleys, drum and payload as rigid bodies with springs between them; those without inertia follow the
    others.
    """
    n = d.n_inputs
    pulleys, rotors = (np.broadcast_to(np.asarray(x, float), (n,)) for x in (inertias.pulleys, inertias.rotors))
    # Where the cables would turn a drum on rigid parts; the drum's land; payload; pulleys; rotors.
    inertia = np.concatenate([[0.0, inertias.drum, inertias.payload], pulleys, rotors])
    # One compliance for each input, with which they store the energy of the chain's in their shares of the torque.
    share = sum_per_input(d, unit_tensions_N(d), d.input_radius_m)
    each = chain.before_inputs / float((share**2).sum())
    joints = [(chain.before_drum, 0, 1), (chain.in_drum, 1, 2), *((each, 3 + i, 3 + n + i) for i in range(n))]
    body = np.arange(inertia.size)
    for give, a, b in joints:
        if give == 0.0:
            body[b] = body[a]
    inertia = np.bincount(body, inertia, inertia.size).astype(float)
    matrix = np.zeros((inertia.size, inertia.size))

    def spring(stiffness: float, first: int, lever: float, second: int, other: float) -> None:
        row = np.zeros(inertia.size)
        row[body[first]] += lever
        row[body[second]] -= other
        matrix[...] += stiffness * np.outer(row, row)

    for give, a, b in joints:
        if give > 0.0:
            spring(1.0 / give, a, 1.0, b, 1.0)
    for j, i in enumerate(d.input_of):
        # Stretch per unit angle of drum and input; the sign sigma cancels in the square.
        stiffness = float(d.axial_stiffness_N / d.free_span_m[j])
        spring(stiffness, 0, float(d.drum_radius_m[j]), 3 + i, float(d.input_radius_m[j]))
    return _frequencies_Hz(matrix, inertia, set(body.tolist()))


def _frequencies_Hz(stiffness: Floats, inertia: Floats, bodies: set[int]) -> Floats:
    """Of ``bodies`` on springs: infinite inertias are held, those without one follow the others."""
    moves = [b for b in bodies if np.isfinite(inertia[b]) and inertia[b] > 0.0]
    follows = [b for b in bodies if inertia[b] == 0.0]
    coupled = stiffness[np.ix_(follows, moves)]
    reduced = stiffness[np.ix_(moves, moves)] - coupled.T @ np.linalg.solve(
        stiffness[np.ix_(follows, follows)], coupled
    )
    root = np.sqrt(inertia[moves])
    values = np.linalg.eigvalsh(reduced / np.outer(root, root))
    noise = 1e-9 * values.max()
    return np.asarray(np.sqrt(np.where(values < noise, 0.0, values)) / (2.0 * np.pi))


def unit_tensions_N(d: DriveSI) -> Floats:
    """Change of the tensions (n_cables,) per N m of load on the drum while every wrap sticks."""
    stiffness = d.axial_stiffness_N / d.free_span_m
    return np.asarray(d.sigma * stiffness * d.drum_radius_m / (stiffness * d.drum_radius_m**2).sum())
