"""Time series with the tension profile of every wrap in full: finite wraps, slack cables, winding history.

The same physics as :mod:`mbcdm_cad.model.hysteresis`, whose stack of turning points is faster where wraps are longer
than any slip zone and do not move with the pulleys. Here every wrap is a stack of knots
(:mod:`mbcdm_cad.model.wrap_profile`): exact if, between samples, ln T changes linearly with the angle of the pulley.

With ``winding`` the profiles move with the pulleys: cable wound on keeps the tension it had and brings it back when it
is wound off.
"""

import math
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from mbcdm_cad.model.si import DriveSI, ModelError
from mbcdm_cad.model.wrap_profile import ANGLE, RATIO, Profile, commit, go_over, probe
from mbcdm_cad.routes import Floats
from mbcdm_cad.storage.compiled import compiled, inlined


@dataclass(frozen=True, eq=False)
class Response:
    """Drum angle (rad, shape (n,)) and free-span tensions (N, shape (n_cables, n)) at each sample."""

    drum_angle_rad: Floats
    tension_N: Floats

    def input_torque_Nm(self, d: DriveSI) -> Floats:
        """Torque that holds each input at each sample, shape (n_inputs, n)."""
        pull = (d.sigma * d.input_radius_m)[:, None] * self.tension_N
        return np.stack([pull[[j for j, k in enumerate(d.input_of) if k == i]].sum(axis=0) for i in range(d.n_inputs)])


def checked_series(d: DriveSI, input_angle_rad: Any, load_Nm: Any) -> tuple[Floats, Floats]:
    """Input angles (n_inputs, n) and load (n,) as contiguous arrays; errors as in :func:`simulate`."""
    angle = np.ascontiguousarray(np.atleast_2d(np.asarray(input_angle_rad, dtype=float)))
    if d.batch_shape:
        raise ModelError(f"a series runs on one design, got a batch of shape {d.batch_shape}; loop over the designs")
    if angle.shape[0] != d.n_inputs or angle.ndim != 2:
        raise ModelError(
            f"input_angle_rad has shape {angle.shape}, the drive needs ({d.n_inputs}, n): one row an input"
        )
    load = np.asarray(load_Nm, dtype=float)
    if load.ndim > 1 or (load.ndim == 1 and load.size != angle.shape[1]):
        raise ModelError(f"load_Nm has shape {load.shape} for {angle.shape[1]} samples; give one value or one a sample")
    if not (np.isfinite(angle).all() and np.isfinite(load).all()):
        raise ModelError("input_angle_rad or load_Nm holds NaN or infinity; clean the series first")
    if not float(d.friction_coefficient) > 0.0:
        friction = float(d.friction_coefficient)
        raise ModelError(f"friction_coefficient {friction:g}: slip zones have no end; give it > 0")
    return angle, np.ascontiguousarray(np.broadcast_to(load, (angle.shape[1],)))


def path_offset_m(d: DriveSI, path_m: Any, samples: int) -> Floats:
    """``path_m`` as an array (n_cables, samples), zeros for None. Errors: ``ModelError`` for a wrong shape or NaN."""
    shape = (d.n_cables, samples)
    if path_m is None:
        return np.zeros(shape)
    path = np.asarray(path_m, dtype=float)
    if path.shape != shape or not np.isfinite(path).all():
        raise ModelError(f"path_m has shape {path.shape} or holds NaN; give finite numbers of shape {shape}")
    return path


# Columns of the table of constants, one row a cable.
FREE, UNIT, PRELOAD, DRUM, SIGMA = range(5)
INPUT_WRAP, DRUM_WRAP = range(2)
# Length of an unlimited wrap, rad: finite, but far longer than any slip zone or travel.
ENDLESS_RAD = 1e6
# A tension below this share of the preload counts as none, as in the static model.
FAINT = 1e-12
STEPS = 200
ROOM = 64
BALANCED, NO_BALANCE, RUN_OFF = 0, 1, 2


def simulate_profiles(
    d: DriveSI,
    input_angle_rad: Any,
    load_Nm: Any,
    path_m: Any = None,
    winding: bool = False,
    through_rad: float | None = None,
) -> Response:
    """Run the model over a series; arguments and shapes as in :func:`mbcdm_cad.model.hysteresis.simulate`.

    Finite ``input_wrap_rad`` and ``drum_wrap_rad`` are the live wraps with all angles zero; slip that reaches the
    anchor stops there, and a cable can go slack (tension 0) and come back. ``through_rad`` is the wrap over each input
    that friction alone holds, for cables that run through there: their two sides then share it, and rope goes over from
    one to the other (:mod:`mbcdm_cad.model.wrap_profile`). Errors besides those of the series:
    ``ModelError`` where a pulley would wind off more than its wrap, and for winding with slip on passed bodies.
    """
    angle, load = checked_series(d, input_angle_rad, load_Nm)
    slipped = [(radius, wrap) for radius, wrap in d.passed_wraps if np.any(wrap > 0.0)]
    if winding and slipped:
        raise ModelError(
            "winding history together with slip on passed bodies is not modelled: the cable there runs on to the drum; "
            "leave passed_wrap_rad at 0 or winding off"
        )
    offset = (d.sigma * d.input_radius_m)[:, None] * angle[list(d.input_of)] + path_offset_m(d, path_m, load.size)
    on_input = d.input_wrap_rad if through_rad is None else np.full(d.n_cables, 0.5 * through_rad)
    wraps = [(d.input_radius_m, on_input), (d.drum_radius_m, d.drum_wrap_rad)]
    # Slip comes from both ends: two wraps of half the angle, which do not move with the pulley.
    wraps += slipped
    radius, length = (np.stack([np.broadcast_to(w[i], (d.n_cables,)) for w in wraps], axis=1) for i in (0, 1))
    if not np.all(length >= 0.0):
        raise ModelError(f"a wrap of {np.min(length):g} rad: give wraps of 0 or more")
    columns = (d.free_span_m, d.axial_stiffness_N / d.preload_N, d.preload_N, d.drum_radius_m, d.sigma)
    table = np.ascontiguousarray(np.stack(np.broadcast_arrays(*columns), axis=1))
    drum, tension = np.empty(load.size), np.empty((d.n_cables, load.size))
    wound = _Wraps(
        table,
        np.ascontiguousarray(radius),
        np.minimum(length, ENDLESS_RAD),
        float(d.friction_coefficient),
        winding,
        _pairs(d, through_rad),
    )
    series = _Series(np.ascontiguousarray(angle[list(d.input_of)]), np.ascontiguousarray(offset), load)
    outcome, k, j = _run(wound, series, drum, tension)
    if outcome == RUN_OFF:
        raise ModelError(
            f"sample {k}: cable {d.cable_names[j]} would wind off more than its wrap "
            f"({float(length[j, 0]):.3g} rad on the input, {float(length[j, 1]):.3g} rad on the drum); "
            "give longer wraps or a shorter travel"
        )
    if outcome == NO_BALANCE:
        raise ModelError(
            f"sample {k}: no drum angle balances a load of {load[k]:.6g} N m; check its unit and sign, and whether "
            "every cable that could hold it is slack"
        )
    return Response(drum, tension)


class _Wraps(NamedTuple):
    """Constants of the cables (n, 5), radius and length of their wraps (n, n_wraps), friction, whether they wind.

    ``through`` (m, 2): the two sides of each cable that has one wrap on its input.
    """

    table: Floats
    radius: Floats
    length: Floats
    mu: float
    winding: bool
    through: Any


def _pairs(d: DriveSI, through_rad: float | None) -> Any:
    """The two sides of each cable, (n, 2), if they share a wrap; else (0, 2)."""
    return np.array(d.through_sides if through_rad is not None else (), dtype=np.int64).reshape(-1, 2)


class _Series(NamedTuple):
    """Input angle and stretch from it of each cable (n, samples), load (samples,)."""

    angles: Floats
    offsets: Floats
    load: Floats


@inlined
def next_angle(low: float, high: float, theta: float, miss: float, slope: float) -> Any:
    """The bounds of the drum angle narrowed at ``theta``, which misses the load by ``miss``, and the angle to try next.

    That of Newton's step, or the middle of the bounds where it lies beyond them.
    """
    if miss > 0.0:
        low = theta
    else:
        high = theta
    following = theta + miss / slope
    if not (low < following < high):
        following = 0.5 * (low + high)
    return low, high, following


@inlined
def _pull(
    c: Floats, radius: Floats, stacks: Floats, counts: Any, ends: Floats, mu: float, stretch: float, guess: float
) -> tuple[float, float]:
    """Tension over preload at ``stretch`` (m), and its derivative (1/m); 0 slope where the cable is slack."""
    goal, low, high, u = stretch * c[UNIT], 0.0, math.inf, guess
    rate = c[FREE]
    for _ in range(STEPS):
        log_u = math.log(u)
        miss, rate = c[FREE] * (u - 1.0) - goal, c[FREE]
        for w in range(radius.size):
            total, part, _, _, _, _ = probe(stacks[w], counts[w], ends[w], u, log_u, mu)
            miss += radius[w] * total
            rate += radius[w] * part
        if miss > 0.0:
            high = u
            if u <= FAINT:
                return FAINT, 0.0
        else:
            low = u
        following = u - miss / rate
        if not (low <= following <= high):
            following = max(0.5 * (low + high) if high <= 4.0 * low else math.sqrt(max(low, FAINT) * high), FAINT)
        step = abs(following - u)
        u = max(following, FAINT)
        if step <= 1e-14 * u:
            break
    return u, c[UNIT] / rate


@inlined
def _place(ends: Floats, table: Floats, winding: bool, angle: Floats, theta: float) -> None:
    """End of each wrap, rad, counted from its end with all angles zero; winding on is positive."""
    if winding:
        for j in range(table.shape[0]):
            ends[j, INPUT_WRAP] = table[j, SIGMA] * angle[j]
            ends[j, DRUM_WRAP] = -table[j, SIGMA] * theta


@compiled
def _roomier(stacks: Floats) -> Floats:
    """The stacks with room for twice as many knots."""
    wider = np.zeros((*stacks.shape[:3], 2 * stacks.shape[3]))
    wider[:, :, :, : stacks.shape[3]] = stacks
    return wider


@compiled
def _run(wound: _Wraps, series: _Series, drum: Floats, tension: Floats) -> tuple[int, int, int]:
    """Fill ``drum`` and ``tension``. Returns the outcome, the sample and the cable where it failed."""
    table, radius, length, mu, winding = wound.table, wound.radius, wound.length, wound.mu, wound.winding
    angles, offsets, load = series.angles, series.offsets, series.load
    n_cables, n_wraps = radius.shape
    stacks = np.zeros((n_cables, n_wraps, 4, ROOM))
    counts = np.full((n_cables, n_wraps), 2)
    stacks[:, :, RATIO, :2] = 1.0
    stacks[:, :, ANGLE, 0] = -np.maximum(length, 1e-12)
    ends = np.zeros((n_cables, n_wraps))
    pulled, rates, before = np.ones(n_cables), np.zeros(n_cables), np.zeros(n_cables)
    theta, scale = 0.0, 0.0
    for j in range(n_cables):
        scale += table[j, PRELOAD] * table[j, DRUM]
    for k in range(load.size):
        # Prediction: the drum follows the mean of the inputs, weighted by the stiffness of their sticking cables.
        push, grip = 0.0, 0.0
        for j in range(n_cables):
            push += table[j, SIGMA] * table[j, DRUM] / table[j, FREE] * (offsets[j, k] - before[j])
            grip += table[j, DRUM] ** 2 / table[j, FREE]
            before[j] = offsets[j, k]
        theta += push / grip
        low, high, miss = -math.inf, math.inf, math.inf
        for _ in range(STEPS):
            _place(ends, table, winding, angles[:, k], theta)
            for j in range(n_cables):
                for w in range(n_wraps):
                    if ends[j, w] <= stacks[j, w, ANGLE, 0]:
                        return RUN_OFF, k, j
            miss, slope = -load[k], 0.0
            for j in range(n_cables):
                lever = table[j, SIGMA] * table[j, DRUM]
                pulled[j], rates[j] = _pull(
                    table[j], radius[j], stacks[j], counts[j], ends[j], mu, offsets[j, k] - lever * theta, pulled[j]
                )
                if pulled[j] > FAINT:
                    miss += lever * table[j, PRELOAD] * pulled[j]
                slope += lever * lever * table[j, PRELOAD] * rates[j]
            if abs(miss) <= 1e-13 * scale:
                break
            low, high, following = next_angle(low, high, theta, miss, slope)
            if following == theta or not math.isfinite(following):
                break
            theta = following
        if not abs(miss) <= 1e-9 * scale:
            return NO_BALANCE, k, 0
        for j in range(n_cables):
            log_u = math.log(pulled[j])
            for w in range(n_wraps):
                if counts[j, w] + 2 > stacks.shape[3]:
                    stacks = _roomier(stacks)
                counts[j, w] = commit(stacks[j, w], counts[j, w], ends[j, w], pulled[j], log_u, mu)
            tension[j, k] = table[j, PRELOAD] * pulled[j] if pulled[j] > FAINT else 0.0
        for m in range(wound.through.shape[0]):
            one, other = wound.through[m, 0], wound.through[m, 1]
            if counts[one, INPUT_WRAP] + counts[other, INPUT_WRAP] + 2 > stacks.shape[3]:
                stacks = _roomier(stacks)
            counts[one, INPUT_WRAP], counts[other, INPUT_WRAP] = go_over(
                Profile(stacks[one, INPUT_WRAP], counts[one, INPUT_WRAP]),
                Profile(stacks[other, INPUT_WRAP], counts[other, INPUT_WRAP]),
                length[one, INPUT_WRAP],
                mu,
                math.log(table[one, PRELOAD] / table[other, PRELOAD]),
            )
        drum[k] = theta
    return BALANCED, 0, 0
