"""A surrogate model of all points evaluated so far, which preselects proposals that are worth their evaluation.

The model is a ridge regression: each aim, and whether a design passes, as a sum of what each field adds, and of
products of the numbers that have no rule. It only chooses among proposals; every figure of a search is evaluated.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from mbcdm_cad.optimising.front import front_of
from mbcdm_cad.optimising.variables import STILL, Values, Variable
from mbcdm_cad.routes import Floats

# The model follows the newest points: it has to be best where the search is.
NEWEST = 1500
# Passing points below which the aims are not modelled, as a multiple of the number of fields.
ENOUGH = 1.0
# Lower confidence bound, in standard deviations, that is taken for an aim: options that were seldom tried are tried.
CONFIDENCE = 1.0
# A point that the model is sure to fail still counts by this much: it may be wrong.
LEAST_CHANCE = 0.02
# Width, as a share of the front's extent, over which a point behind the front still counts a little.
SOFT = 0.05
# Strength of the ridge, in points.
RIDGE = 1.0
# Weight of a point with another option, where the violation of one option is modelled.
OTHERS = 0.3
# Digits of a score: what a matrix library rounds otherwise on another machine must not change a choice.
DIGITS = 6


class Surrogate:
    """The results of points so far, as numbers, and the choice that follows from them."""

    def __init__(self, variables: Sequence[Variable], aims: int) -> None:
        self._variables = tuple(variables)
        # The column of each option among the features.
        self._columns: dict[tuple[str, Any], int] = {}
        column = 1
        for v in self._variables:
            self._columns |= {(v.field, option): column + k for k, option in enumerate(v.options)}
            column += len(v.options) or 3 * v.ruled
        self._rows, self._aims, self._violation = np.empty((0, 0)), np.empty((0, aims)), np.empty(0)

    def add(self, points: Sequence[Values], aims: Floats, violation: Floats) -> None:
        """Results of points: aims (n, k), of which less is better, which count where ``violation`` (n,) is zero."""
        rows = self._features(points)
        if self._rows.size:
            rows = np.vstack([self._rows, rows])
        self._rows = rows[-NEWEST:]
        self._aims = np.vstack([self._aims, aims])[-NEWEST:]
        self._violation = np.concatenate([self._violation, violation])[-NEWEST:]

    def preselected(self, points: Sequence[Values], count: int) -> list[int]:
        """Indices of ``count`` of the points, in their order.

        One after the other, the one with the most probable gain over the front and over those taken before; before
        the first design that passes, simply the first ones.
        """
        passes = self._violation <= 0.0
        if count >= len(points) or not passes.any():
            return list(range(min(count, len(points))))
        rows = self._features(points)
        chance = np.clip(_predicted(self._rows, passes[:, None].astype(float), rows)[0][:, 0], LEAST_CHANCE, 1.0)
        if passes.sum() < ENOUGH * len(self._variables):
            return sorted(np.argsort(-np.round(chance, DIGITS), kind="stable")[:count].tolist())
        known = self._aims[passes]
        front = known[front_of(known)]
        # A front of one point has no extent, and an aim that is the same everywhere none at all.
        extent = np.maximum(np.ptp(front, axis=0), 0.05 * np.ptp(known, axis=0))
        scale = np.where(extent > 0.0, extent, 1.0)
        front = front / scale
        found, doubt = _predicted(self._rows[passes], known / scale, rows)
        chosen: list[int] = []
        gain = _gains(found - CONFIDENCE * doubt, front)
        for _ in range(count):
            score = np.round(chance * gain, DIGITS)
            score[chosen] = -np.inf
            one = int(np.argmax(score))
            chosen.append(one)
            gain = np.minimum(gain, _gains(found, found[one : one + 1]))
        return sorted(chosen)

    def nearest(self, points: Sequence[Values], field: str, option: Any) -> int:
        """Index of the one of ``points``, which all have this option, that is the nearest to a pass, as modelled.

        The model is that of :meth:`preselected`, of the violation by its rank; points with the option count most.
        """
        weight = np.where(self._rows[:, self._columns[field, option]] > 0.0, 1.0, OTHERS)
        rank = np.searchsorted(np.sort(self._violation), self._violation) / len(self._violation)
        rows = self._rows * weight[:, None]
        rank = (rank - np.average(rank, weights=weight**2)) * weight
        found = np.linalg.solve(rows.T @ rows + RIDGE * np.eye(rows.shape[1]), rows.T @ rank)
        return int(np.argmin(np.round(self._features(points) @ found, DIGITS)))

    def _features(self, points: Sequence[Values]) -> Floats:
        """The points as rows of the regression."""
        columns: list[Floats] = [np.ones(len(points))]
        ranged: list[Floats] = []
        for v in self._variables:
            given = [point[v.field] for point in points]
            if v.options:
                columns += [np.array([float(value == option) for value in given]) for option in v.options]
                continue
            u = np.array(given, dtype=float)
            if v.ruled:
                moved = np.maximum(np.abs(u) - STILL, 0.0) / (1.0 - STILL)
                columns += [np.where(u > 0.0, moved, 0.0), np.where(u < 0.0, moved, 0.0), moved**2]
            else:
                ranged.append(2.0 * u - 1.0)
        columns += ranged
        columns += [one * two for k, one in enumerate(ranged) for two in ranged[k:]]
        return np.stack(columns, axis=1)


def _predicted(rows: Floats, values: Floats, wanted: Floats) -> tuple[Floats, Floats]:
    """Values (n, k) of a ridge regression at the rows ``wanted``, and their standard deviations."""
    mean = values.mean(axis=0)
    inverse = np.linalg.inv(rows.T @ rows + RIDGE * np.eye(rows.shape[1]))
    found = inverse @ (rows.T @ (values - mean))
    rest = np.sqrt(np.mean((values - mean - rows @ found) ** 2, axis=0))
    spread = np.sqrt(np.maximum(np.einsum("ij,ij->i", wanted @ inverse, wanted), 0.0))
    return np.asarray(mean + wanted @ found), np.asarray(spread[:, None] * rest)


def _gains(points: Floats, front: Floats) -> Floats:
    """How far each of ``points`` (n, k) leads beyond a front (m, k): the share by which the front would have to move
    to be as good there, on a scale that is above zero everywhere."""
    lead = (front[None, :, :] - points[:, None, :]).max(axis=2).min(axis=1)
    return np.asarray(np.logaddexp(0.0, lead / SOFT) * SOFT)
