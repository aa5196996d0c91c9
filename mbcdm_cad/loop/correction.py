"""A correction table of the output angle for the controller: the error that repeats over angle, direction and load.

    corrected output angle = mean of the input angles / total ratio + correction(angle, direction, load)

``angle`` is that mean over the ratio, ``load`` the torque at the output, ``direction`` the sense of motion from -1 to
1: after a reversal it goes from one end to the other over a stated angle, so that the correction does not jump. The
table is computed from the measured output, whether or not a cause was named, because an error that repeats can be
corrected whatever its cause. An error that depends on time, temperature or speed cannot be in such a table: effects
that were named and depend on these are subtracted from the data first, and listed.
"""

import json
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import product

import numpy as np
from numpy.typing import NDArray

from mbcdm_cad.loop.prepare.prepared import held_out, played
from mbcdm_cad.loop.search.fit import Fit, Fitter
from mbcdm_cad.report.table import rendered
from mbcdm_cad.routes import Floats

ANGLES, LOADS = 65, 9
# Angles, as shares of the travel, over which the direction may change after a reversal; the best one is taken.
REVERSALS = (0.001, 0.002, 0.003, 0.005, 0.008, 0.012, 0.02, 0.03, 0.05, 0.1)
# A point of the table with less measured time than this near it is interpolated from its neighbours.
PRIOR_S = 0.1
# Weight, in samples, that draws all points to zero: it has influence only where there are hardly any data.
LEAST_RIDGE = 1e-2
# A line is in the table if one cycle has at least so many points of the table.
LEAST_POINTS = 8.0
DIRECTIONS = (-1.0, 1.0)


@dataclass(frozen=True, eq=False)
class Correction:
    """The table ``value_rad`` (angles, 2 directions, loads) over ``angle_rad`` and ``load_Nm``, and its accuracy.

    ``reversal_rad`` is the angle over which the direction changes; ``load_Nm`` has one entry where the load was not
    measured or did not vary, ``load_words`` says which. ``left_out`` are effects that no table can represent.
    ``before_rad`` and ``after_rad``: RMS of the angle's error on half sweeps that the table was not made from, without
    and with it, each run's mean taken off; ``noise_rad`` is what would stay in any case.
    """

    angle_rad: Floats
    load_Nm: Floats
    value_rad: Floats
    reversal_rad: float
    ratio: float
    load_words: str
    left_out: tuple[str, ...]
    before_rad: float
    after_rad: float
    noise_rad: float
    held_out: str

    def at(self, angle_rad: Floats, direction: Floats, load_Nm: Floats) -> tuple[Floats, NDArray[np.bool_]]:
        """Correction in rad and whether the point lies beyond the table, both (n,), as the C function returns."""
        i, u, off_angle = _place(self.angle_rad, angle_rad)
        k, w, off_load = _place(self.load_Nm, load_Nm)
        j = 0.5 * (np.clip(direction, -1.0, 1.0) + 1.0)
        found = np.zeros_like(np.asarray(angle_rad, dtype=float))
        more = min(1, self.load_Nm.size - 1)
        for di, wi in ((0, 1.0 - u), (1, u)):
            for dj, wj in ((0, 1.0 - j), (1, j)):
                for dk, wk in ((0, 1.0 - w), (more, w)):
                    found += wi * wj * wk * self.value_rad[i + di, dj, k + dk]
        return found, off_angle | off_load


def _place(points: Floats, at: Floats) -> tuple[NDArray[np.int64], Floats, NDArray[np.bool_]]:
    """Index of the point below, share of the way to the next, and whether it is beyond the ends."""
    at = np.asarray(at, dtype=float)
    if points.size == 1:
        return np.zeros(at.shape, dtype=np.int64), np.zeros(at.shape), np.zeros(at.shape, dtype=np.bool_)
    place = (at - points[0]) / (points[1] - points[0])
    beyond = (place < 0.0) | (place > points.size - 1)
    place = np.clip(place, 0.0, points.size - 1)
    index = np.minimum(place.astype(np.int64), points.size - 2)
    return index, place - index, beyond


def directions(angle_rad: Floats, reversal_rad: float) -> Floats:
    """Direction at each sample, -1 to 1: it follows the angle, 2 over ``reversal_rad``, and stays at its ends."""
    half = 0.5 * reversal_rad
    out = (angle_rad - played(angle_rad, half)) / half
    out[0] = out[min(1, out.size - 1)]
    return np.asarray(out)


def correction_of(fitter: Fitter, fit: Fit, noise_rad: float) -> Correction:
    """The table for the runs of ``fitter``; ``fit`` has the effects that were named."""
    left, left_out = _without_the_passing(fitter, fit)
    angle, error, load = [], [], []
    for part, setup in zip(fitter.parts, fitter.base, strict=True):
        p = setup.p
        angle.append(setup.drum_rad)
        error.append(left[part] - p.mean_rad / setup.ratio)
        load.append(np.zeros_like(p.time_s) if p.load_Nm is None else p.load_Nm)
    angles, errors, loads = (np.concatenate(rows) for rows in (angle, error, load))
    measured = all(p.load_Nm is not None for p in fitter.runs)
    grid = np.linspace(float(angles.min()), float(angles.max()), ANGLES)
    spans = measured and float(np.ptp(loads)) > 0.0
    load_grid = np.linspace(float(loads.min()), float(loads.max()), LOADS) if spans else np.array([float(loads.mean())])
    words = "as measured" if spans else "that of the run, not known"
    if measured and not spans:
        words = f"{loads.mean():.4g} N m throughout"
    run = np.concatenate([np.full(p.time_s.size, k) for k, p in enumerate(fitter.runs)])
    fits = []
    for share in REVERSALS:
        reversal = share * float(np.ptp(angles))
        sense = np.concatenate([directions(one, reversal) for one in angle])
        table, square = _fitted(grid, load_grid, (angles, sense, loads), errors, run, fitter)
        fits.append((square, reversal, table, sense))
    _, reversal, table, sense = min(fits, key=lambda one: one[0])
    before, noted = _held_rms(fitter, errors), (float(fitter.ratio), words, tuple(left_out))
    found = Correction(grid, load_grid, table, reversal, *noted, before, before, noise_rad, held_out(fitter.runs))
    told = found.at(angles, sense, loads)[0]
    # The table's own zero: the middle of the travel, without load, between the two directions.
    idle = np.clip(np.zeros(1), load_grid[0], load_grid[-1])
    zero = found.at(grid[ANGLES // 2 : ANGLES // 2 + 1], np.zeros(1), idle)[0]
    return replace(found, value_rad=table - float(zero[0]), after_rad=_held_rms(fitter, errors - told))


def _without_the_passing(fitter: Fitter, fit: Fit) -> tuple[Floats, list[str]]:
    """The measured output minus the named effects that depend on time, temperature or speed, and their names."""
    passing = [k for k, effect in enumerate(fit.effects) if effect.hangs_on or _too_fast(fitter, fit, k)]
    if not passing:
        return fitter.output, []
    rest = [k for k in range(len(fit.effects)) if k not in passing]
    whole = fitter.predict(fit.effects, fit.values, fit.offsets)
    less = fitter.predict([fit.effects[k] for k in rest], [fit.values[k] for k in rest], fit.offsets)
    names = [
        f"{fit.effects[k].label}: depends on {fit.effects[k].hangs_on or 'the angle more finely than the table does'}"
        for k in passing
    ]
    return np.asarray(fitter.output - whole + less), names


def _too_fast(fitter: Fitter, fit: Fit, k: int) -> bool:
    """Whether the effect is a line with too few points of the table in a cycle."""
    index = fit.effects[k].order_index
    if index is None:
        return False
    step = max(float(np.ptp(setup.drum_rad)) for setup in fitter.base) / (ANGLES - 1)
    return bool(2.0 * np.pi / float(fit.values[k][index]) < LEAST_POINTS * step)


def _fitted(
    grid: Floats, load_grid: Floats, at: Sequence[Floats], errors: Floats, run: NDArray[np.int64], fitter: Fitter
) -> tuple[Floats, float]:
    """The table by least squares on the samples that are not held back, and the mean square that it leaves of them."""
    train = fitter.train
    every = max(1, int(train.sum()) // 40_000)
    chosen = np.flatnonzero(train)[::every]
    angle, sense, load = (values[chosen] for values in at)
    columns = _columns(grid, load_grid, angle, sense, load)
    levels = np.stack([run[chosen] == k for k in range(int(run.max()) + 1)], axis=1).astype(float)
    x = np.hstack([columns, levels])
    weak = PRIOR_S / fitter.runs[0].step_s / every
    gram = x.T @ x + np.diag(np.concatenate([np.full(columns.shape[1], LEAST_RIDGE), np.full(levels.shape[1], 1e-9)]))
    y = errors[chosen] - errors[chosen].mean()
    # Where few samples lie, neighbouring points of the angle are smoothed: curvature is penalised, slope is not.
    bend, second = np.zeros_like(gram), np.diff(np.eye(ANGLES), 2, axis=0)
    bend[: 2 * ANGLES, : 2 * ANGLES] = np.kron(np.eye(2), second.T @ second)
    solved = np.linalg.solve(gram + weak * bend, x.T @ y)
    square = float(np.mean((y - x @ solved) ** 2))
    mesh = np.meshgrid(grid, DIRECTIONS, load_grid, indexing="ij")
    table = _columns(grid, load_grid, *(values.ravel() for values in mesh)) @ solved[: columns.shape[1]]
    return table.reshape(grid.size, 2, load_grid.size), square


def _columns(grid: Floats, load_grid: Floats, angle: Floats, sense: Floats, load: Floats) -> Floats:
    """Columns of the table: a curve of the angle and one of the load for each direction, and load times angle."""
    up = 0.5 * (1.0 + sense)
    hats = _hat_columns(grid, angle)
    parts = [hats * (1.0 - up)[:, None], hats * up[:, None]]
    if load_grid.size > 1:
        loads = _hat_columns(load_grid, load)
        both = (load / np.abs(load_grid).max() * (angle - grid.mean()) / np.ptp(grid))[:, None]
        parts += [loads * (1.0 - up)[:, None], loads * up[:, None], both * (1.0 - up)[:, None], both * up[:, None]]
    return np.hstack(parts)


def _hat_columns(points: Floats, at: Floats) -> Floats:
    """Linear interpolation between ``points`` as columns (n, points)."""
    index, share, _ = _place(points, at)
    out = np.zeros((at.size, points.size))
    rows = np.arange(at.size)
    out[rows, index] = 1.0 - share
    out[rows, index + 1] += share
    return out


def _held_rms(fitter: Fitter, errors: Floats) -> float:
    """RMS on the samples held back, each run's mean over its other samples subtracted, rad."""
    return float(np.sqrt(np.mean(fitter.centred(errors, fitter.train)[fitter.test] ** 2)))


CSV, JSON, HEADER = "correction.csv", "correction.json", "correction.h"
SIGN = "corrected output angle = mean of the input angles / total ratio + correction; angle 0 is the inputs' own zero"


def correction_files(found: Correction, source: str) -> dict[str, bytes]:
    """The three files by name; ``source`` names design and runs."""
    return {CSV: _csv(found, source), JSON: _json(found, source), HEADER: _header(found, source)}


def correction_words(found: Correction) -> str:
    """The accuracy of the table in words, for the terminal."""
    words = (
        f"error of the output angle on held-out half sweeps {1e6 * found.before_rad:.3g} urad RMS without and "
        f"{1e6 * found.after_rad:.3g} with it (noise {1e6 * found.noise_rad:.3g}); load {found.load_words}"
    )
    return words + "".join(f"; left out {one}" for one in found.left_out)


def _head(found: Correction, source: str) -> list[str]:
    return [
        f"Correction of the output angle, from {source}",
        SIGN,
        f"direction: -1 to 1, follows the angle by 2 per {found.reversal_rad:.6g} rad after a reversal",
        f"load: {found.load_words}; positive where it opposes positive rotation",
        f"held-out error {found.before_rad:.4g} rad RMS before, {found.after_rad:.4g} after ({found.held_out})",
        *(f"left out: {one}" for one in found.left_out),
    ]


def _csv(found: Correction, source: str) -> bytes:
    at = product(found.angle_rad, DIRECTIONS, found.load_Nm)
    rows = (f"{a:.9g},{d:g},{load:.9g},{v:.9g}" for (a, d, load), v in zip(at, found.value_rad.flat, strict=True))
    head = (f"# {line}" for line in _head(found, source))
    return "\n".join([*head, "angle_rad,direction,load_Nm,correction_rad", *rows, ""]).encode()


def _json(found: Correction, source: str) -> bytes:
    content = {
        "source": source,
        "sign": SIGN,
        "total_ratio": found.ratio,
        "angle_rad": found.angle_rad.tolist(),
        "direction": list(DIRECTIONS),
        "load_Nm": found.load_Nm.tolist(),
        "load": found.load_words,
        "correction_rad": found.value_rad.tolist(),
        "reversal_rad": found.reversal_rad,
        "left_out": list(found.left_out),
        "error": {name: getattr(found, name) for name in ("before_rad", "after_rad", "noise_rad", "held_out")},
    }
    return (json.dumps(content, indent=1) + "\n").encode()


def _header(found: Correction, source: str) -> bytes:
    return (rendered("correction.h.j2", "mbcdm_cad.loop", head=_head(found, source), found=found) + "\n").encode()
