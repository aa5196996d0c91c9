"""One step of the linearly implicit Euler method with dry friction in which a coordinate can stick completely.

The step solves A v = b + h lambda with |lambda_i| <= c_i, lambda_i = -c_i sign(v_i) where v_i is not 0, for
A = M + h D + h^2 K. As A is symmetric and positive definite there is one solution: the minimum of v.A v / 2 - b.v + h
sum c_i |v_i|. The solver assumes which coordinates stick and in which direction the others slide, solves, and corrects
the worst contradiction until there is none; if the corrections repeat, coordinate descent follows.
"""

from __future__ import annotations

import numpy as np

from mbcdm_cad.routes import Floats
from mbcdm_cad.storage.compiled import compiled

CORRECTIONS = 40
SWEEPS = 20000


@compiled
def solve_friction(A: Floats, b: Floats, limit: Floats, guess: Floats, v: Floats, push: Floats) -> int:
    """Solve for ``v`` (n,); ``limit`` is h c (n,). ``push`` (n,) receives the friction impulses h lambda.

    ``guess`` holds -1, 0 (sticks) or 1 for each coordinate; it is the start and receives the result. Returns the number
    of corrections, or -1 if coordinate descent was needed.
    """
    n = b.size
    for trial in range(CORRECTIONS):
        _solve_guess(A, b, limit, guess, v)
        worst, at, to = 0.0, -1, 0.0
        for i in range(n):
            if limit[i] <= 0.0:
                push[i] = 0.0
            elif guess[i] == 0.0:
                total = -b[i]
                for k in range(n):
                    total += A[i, k] * v[k]
                push[i] = total
                # An impulse above its limit, as the error in speed that it means.
                over = (abs(total) - limit[i]) / A[i, i]
                if over > worst and abs(total) > limit[i] * (1.0 + 1e-12):
                    worst, at, to = over, i, -np.sign(total)
            else:
                push[i] = -limit[i] * guess[i]
                if v[i] * guess[i] < 0.0 and -v[i] * guess[i] > worst:
                    worst, at, to = -v[i] * guess[i], i, 0.0
        if at < 0:
            return trial
        guess[at] = to
    _descend(A, b, limit, guess, v, push)
    return -1


@compiled
def _solve_guess(A: Floats, b: Floats, limit: Floats, guess: Floats, v: Floats) -> None:
    """Gauss elimination on the coordinates that do not stick."""
    n = b.size
    free = np.empty(n, np.int64)
    count = 0
    for i in range(n):
        v[i] = 0.0
        if limit[i] <= 0.0 or guess[i] != 0.0:
            free[count] = i
            count += 1
    work = np.empty((count, count + 1))
    for i in range(count):
        p = free[i]
        for k in range(count):
            work[i, k] = A[p, free[k]]
        work[i, count] = b[p] - (limit[p] * guess[p] if limit[p] > 0.0 else 0.0)
    for i in range(count):
        for r in range(i + 1, count):
            if work[r, i] != 0.0:
                factor = work[r, i] / work[i, i]
                for k in range(i, count + 1):
                    work[r, k] -= factor * work[i, k]
    for i in range(count - 1, -1, -1):
        total = work[i, count]
        for k in range(i + 1, count):
            total -= work[i, k] * v[free[k]]
        v[free[i]] = total / work[i, i]


@compiled
def _descend(A: Floats, b: Floats, limit: Floats, guess: Floats, v: Floats, push: Floats) -> None:
    """Coordinate descent to the same minimum; slow where A is stiff, but it always converges."""
    n = b.size
    for _ in range(SWEEPS):
        moved, size = 0.0, 1e-300
        for i in range(n):
            total = b[i]
            for k in range(n):
                if k != i:
                    total -= A[i, k] * v[k]
            now = 0.0
            if abs(total) > limit[i]:
                now = (total - np.sign(total) * limit[i]) / A[i, i]
            moved = max(moved, abs(now - v[i]))
            size = max(size, abs(now))
            v[i] = now
        if moved <= 1e-13 * size:
            break
    for i in range(n):
        total = -b[i]
        for k in range(n):
            total += A[i, k] * v[k]
        push[i] = total if limit[i] > 0.0 else 0.0
        guess[i] = np.sign(v[i])
