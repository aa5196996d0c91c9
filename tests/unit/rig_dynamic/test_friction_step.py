"""The implicit step with dry friction: the conditions of contact hold for any initial guess."""

from __future__ import annotations

import numpy as np
import pytest

from mbcdm_cad.rig.dynamic.plant import _descend, solve_friction


def case(rng: np.random.Generator, n: int = 6) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    root = rng.normal(size=(n, n))
    matrix = root @ root.T * 10 ** rng.uniform(-3, 3) + np.diag(10 ** rng.uniform(-6, 1, n))
    limit = np.where(rng.random(n) < 0.3, 0.0, 10 ** rng.uniform(-2, 0.5, n))
    return matrix, rng.normal(size=n), limit


def test_balance_and_friction_law_hold_for_any_guess() -> None:
    rng = np.random.default_rng(0)
    worst, stuck = 0.0, 0
    for _ in range(2000):
        matrix, b, limit = case(rng)
        guess = rng.integers(-1, 2, b.size).astype(float)
        v, push = np.zeros(b.size), np.zeros(b.size)
        solve_friction(matrix, b, limit, guess, v, push)
        balance = np.abs(matrix @ v - b - push).max()
        beyond = (np.abs(push) - limit).max()
        slides = np.abs(np.where(v != 0.0, push + limit * np.sign(v), 0.0)).max()
        worst = max(worst, balance, beyond, slides)
        stuck += int(((v == 0.0) & (limit > 0.0)).sum())
    assert worst < 1e-9, f"worst contradiction {worst:.3g}"
    assert stuck > 500, f"only {stuck} coordinates stuck: the cases test nothing"


def test_coordinate_descent_finds_the_same() -> None:
    rng = np.random.default_rng(1)
    for _ in range(50):
        root = rng.normal(size=(4, 4))
        matrix, b, limit = root @ root.T + np.eye(4), rng.normal(size=4), rng.uniform(0.0, 1.0, 4)
        found = []
        for solve in (solve_friction, _descend):
            v, push = np.zeros(4), np.zeros(4)
            solve(matrix, b, limit, np.zeros(4), v, push)
            found.append(np.concatenate([v, push]))
        assert found[1] == pytest.approx(found[0], abs=1e-9)
