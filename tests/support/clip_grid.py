"""The clip rule on a fine grid of cells along each wrap: a check of the closed form, and winding history.

An end tension T_e allows T_e e^{-mu s} <= T(s) <= T_e e^{mu s}; values outside are clipped to the bound, values inside
do not change. Because a stored profile never rises faster than e^{mu s}, the clipped cells are one stretch from the
end inwards, and a step computes only these.

With ``winding`` the profiles move with the pulleys: cable that is wound on keeps its tension and brings it back when it
is wound off; new cells take the end tension. This slow computation is the check of :mod:`mbcdm_cad.model.hysteresis`
(infinite wraps that do not move) and of :mod:`mbcdm_cad.model.profiles` (all others), which have no cells and are ten
to several hundred times faster.
"""

import math
from typing import Any

import numpy as np

from mbcdm_cad.model.profiles import Response, checked_series
from mbcdm_cad.model.si import DriveSI, ModelError
from mbcdm_cad.routes import Floats
from mbcdm_cad.storage.compiled import compiled

INPUT_WRAP_RAD = 16.0
DRUM_WRAP_RAD = 3.0
FREE, STIFFNESS, PRELOAD, DRUM, INPUT, SIGMA = range(6)
STEPS = 400
UNDAMPED_STEPS = 20
TOLERANCE = 1e-12
CELLS_INSIDE = 3


def simulate_on_grid(
    d: DriveSI,
    input_angle_rad: Any,
    load_Nm: Any,
    winding: bool = False,
    cell_rad: float = 1e-3,
    input_wrap_rad: float = INPUT_WRAP_RAD,
    drum_wrap_rad: float = DRUM_WRAP_RAD,
) -> Response:
    """Run the clip rule over a series; arguments and errors as in :func:`mbcdm_cad.model.hysteresis.simulate`.

    ``cell_rad`` is the length of a cell; the error of the drum angle is of order (mu cell)^2 without winding and of
    order mu cell with it. The wraps at zero angle are long enough by default for +-0.6 rad of the drum. Further errors:
    ``ModelError`` if a pulley would wind off more than its wrap.
    """
    angle, load = checked_series(d, input_angle_rad, load_Nm)
    if not 0.0 < cell_rad <= 0.1:
        raise ModelError(f"cell_rad {cell_rad:g} is not between 0 and 0.1 rad; 1e-3 is a good start")
    radii = np.stack([d.input_radius_m, d.drum_radius_m], axis=1)
    turns = np.abs(angle).max()
    reserve = np.array([turns, turns * float(np.max(d.input_radius_m / d.drum_radius_m))]) if winding else np.zeros(2)
    start = np.array([input_wrap_rad, drum_wrap_rad])
    if winding and not np.all(start > reserve + 0.1):
        raise ModelError(
            f"the series winds off up to {reserve[0]:.3g} rad of an input and {reserve[1]:.3g} rad of the drum, "
            f"the wraps hold {start[0]:g} and {start[1]:g} rad; give longer wraps or a shorter travel"
        )
    cells = int((start + reserve + 0.5).max() / cell_rad) + 4
    columns = (d.free_span_m, d.axial_stiffness_N, d.preload_N, d.drum_radius_m, d.input_radius_m, d.sigma)
    table = np.ascontiguousarray(np.stack(np.broadcast_arrays(*columns), axis=1))
    last = np.arange(load.size)
    if winding:
        angle, load, last = _refined(angle, load, cell_rad)
    drum, tension = np.empty(load.size), np.empty((d.n_cables, load.size))
    profile = np.empty((d.n_cables, 2, cells))
    profile[...] = np.broadcast_to(d.preload_N, (d.n_cables,))[:, None, None]
    rule = (float(d.friction_coefficient), cell_rad, start, winding)
    failed = _run_grid(table, np.array(d.input_of), radii, rule, (angle, load), profile, drum, tension)
    if failed >= 0:
        raise ModelError(
            f"sub-step {failed}: no balance found at {load[failed]:.6g} N m; use smaller steps between samples"
        )
    return Response(drum[last], tension[:, last])


def _refined(angle: Floats, load: Floats, cell_rad: float) -> tuple[Floats, Floats, Any]:
    """The series with straight sub-steps so that no input turns by more than a cell, and where the samples stand in it.

    Cable wound on in one step would otherwise all take the tension at its end, and the profile could jump.
    """
    travel = np.abs(np.diff(angle, axis=1, prepend=0.0)).max(axis=0)
    last = np.cumsum(np.maximum(np.ceil(travel / cell_rad), 1.0).astype(int)) - 1
    fine = np.arange(last[-1] + 1)
    knots = np.concatenate([[-1], last])
    # The load acts in full from the first sub-step: a brake's torque jumps while the drum stands still.
    held = np.repeat(load, np.diff(knots))
    moved = np.stack([np.interp(fine, knots, np.concatenate([[0.0], row])) for row in angle])
    return np.ascontiguousarray(moved), np.ascontiguousarray(held), last


@compiled
def _wrap(
    cells: Floats, total: float, committed: float, now: float, end: float, rule: Any, commit: bool
) -> tuple[float, float]:
    """Integral of (T - T_pre) ds over a wrap of length ``now`` with end tension ``end``, and its derivative by ``end``.

    ``total`` is that integral as stored, for length ``committed``; ``commit`` writes the clipped cells back;
    ``rule``: rest tension, friction, length of a cell.
    """
    preload, mu, cell = rule
    kept = int(committed / cell)
    top = int(now / cell)
    rate = 0.0
    if top <= kept:
        for k in range(top, kept + 1):
            upper = min((k + 1) * cell, committed)
            lower = max(k * cell, now)
            total -= (cells[k] - preload) * (upper - lower)
    else:
        total += (cells[kept] - preload) * ((kept + 1) * cell - committed)
        for k in range(kept + 1, top + 1):
            width = min((k + 1) * cell, now) - k * cell
            total += (end - preload) * width
            rate += width
            if commit:
                cells[k] = end
    inside = 0
    for k in range(min(top, kept), -1, -1):
        lower, upper = k * cell, min((k + 1) * cell, now)
        bound = math.exp(mu * (now - 0.5 * (lower + upper)))
        old = cells[k]
        new = min(max(old, end / bound), end * bound)
        if new == old:
            # The cell at the end is cut anywhere; its neighbours may still lie outside when it does not.
            inside += 1
            if inside > CELLS_INSIDE:
                break
            continue
        inside = 0
        total += (new - old) * (upper - lower)
        rate += (upper - lower) * (bound if new < old else 1.0 / bound)
        if commit:
            cells[k] = new
    return total, rate


@compiled
def _run_grid(
    table: Floats, input_of: Any, radii: Floats, rule: Any, series: Any, profile: Floats, drum: Floats, tension: Floats
) -> int:
    """Fill ``drum`` and ``tension``; the first sample without balance, or -1."""
    (mu, cell, start, winding), (angle, load) = rule, series
    n_cables = table.shape[0]
    theta = 0.0
    pulled = table[:, PRELOAD].copy()
    totals = np.zeros((n_cables, 2))
    lengths = np.empty((n_cables, 2))
    lengths[:, 0], lengths[:, 1] = start[0], start[1]
    offset = np.zeros(n_cables)
    stretch, slope, now = np.empty(n_cables), np.empty(n_cables), lengths.copy()
    for k in range(load.size):
        push, grip = 0.0, 0.0
        for j in range(n_cables):
            before = offset[j]
            offset[j] = table[j, SIGMA] * table[j, INPUT] * angle[input_of[j], k]
            push += table[j, SIGMA] * table[j, DRUM] / table[j, FREE] * (offset[j] - before)
            grip += table[j, DRUM] ** 2 / table[j, FREE]
        theta += push / grip
        worst = math.inf
        for step in range(STEPS):
            linear, ease = -load[k], 0.0
            for j in range(n_cables):
                sigma, lever = table[j, SIGMA], table[j, SIGMA] * table[j, DRUM]
                if winding:
                    now[j, 0] = start[0] + sigma * angle[input_of[j], k]
                    now[j, 1] = start[1] - sigma * theta
                total, rate = (pulled[j] - table[j, PRELOAD]) * table[j, FREE], table[j, FREE]
                own = (table[j, PRELOAD], mu, cell)
                for wrap in range(2):
                    area, part = _wrap(
                        profile[j, wrap], totals[j, wrap], lengths[j, wrap], now[j, wrap], pulled[j], own, False
                    )
                    total += radii[j, wrap] * area
                    rate += radii[j, wrap] * part
                stretch[j], slope[j] = total / table[j, STIFFNESS], rate / table[j, STIFFNESS]
                linear += lever * (pulled[j] + (offset[j] - stretch[j]) / slope[j])
                ease += lever * lever / slope[j]
            following = linear / ease
            # The law has a kink where the motion reverses; half steps end a cycle across it.
            share = 1.0 if step < UNDAMPED_STEPS else 0.5
            worst = abs(following - theta) * table[0, DRUM] / slope[0] / table[0, PRELOAD]
            for j in range(n_cables):
                wanted = (offset[j] - table[j, SIGMA] * table[j, DRUM] * following - stretch[j]) / slope[j]
                worst = max(worst, abs(wanted) / table[j, PRELOAD])
                pulled[j] = max(pulled[j] + share * wanted, 0.2 * pulled[j])
            theta += share * (following - theta)
            if worst <= TOLERANCE:
                break
        if not worst <= 1e-7:
            return k
        for j in range(n_cables):
            own = (table[j, PRELOAD], mu, cell)
            for wrap in range(2):
                totals[j, wrap], _ = _wrap(
                    profile[j, wrap], totals[j, wrap], lengths[j, wrap], now[j, wrap], pulled[j], own, True
                )
                lengths[j, wrap] = now[j, wrap]
            tension[j, k] = pulled[j]
        drum[k] = theta
    return -1
