"""The engine that proposes points: NSGA-II of pymoo for numbers and choices together, by ask and tell.

The model is a ridge regression: each aim, and whether a design passes, as a sum of what each field adds, and of
products of the numbers that have no rule. It only chooses among proposals; every figure of a search is evaluated.

Another rope seldom passes in the place of the present one: it also needs another ratio and radius. So an option that
is taken into a good design misses something, is given up, and with it an end of the front. Here each option keeps the
point that was nearest to a pass, and is tried on from there, with whatever else it needs.

It proposes ten times the points of a generation; a surrogate model preselects those that are evaluated. A quarter of a
generation are scouts, which try options that no good design has.

A proposal depends on the seed and on what the engine was told, and on nothing else.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from mbcdm_cad.optimising.wishes import STILL, Values, Variable, first_values
from mbcdm_cad.routes import Floats

# The reference point of the hypervolume lies beyond the worst of each aim by this share of its spread.
BEYOND = 0.1


def front_of(points: Floats) -> list[int]:
    """Rows of ``points`` (n, k), less is better, that no other dominates, in order; of equal ones the first."""
    kept: list[int] = []
    for k in np.lexsort(points.T[::-1]):
        # Sorted by the first aim, then the next: only rows before can dominate this one.
        if not any((points[other] <= points[k]).all() for other in kept):
            kept.append(int(k))
    return sorted(kept)


def reference_of(points: Floats) -> tuple[Floats, Floats]:
    """(reference point, scale) of the hypervolume of points (n, k): beyond the worst, and the spread of each aim."""
    least, most = points.min(axis=0), points.max(axis=0)
    spread = np.where(most > least, most - least, np.maximum(np.abs(most), 1.0))
    return np.asarray(most + BEYOND * spread), np.asarray(spread)


def hypervolume(points: Floats | Sequence[Floats], reference: Floats, scale: Floats) -> float:
    """Volume that the points (n, k) dominate up to the reference point, each aim over its scale."""
    from pymoo.indicators.hv import HV

    given = np.asarray(points, dtype=float)
    if not given.size:
        return 0.0
    return float(HV(ref_point=reference / scale)(given / scale))


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


# Share of the scouts that try options which pass somewhere, but in no good design.
PASSING = 0.2
# Points drawn for each scout, of which the surrogate takes one.
DRAWS = 40
# Fields that differ from the point before, on average, besides one; and how often one of them is a range.
MORE, RANGED = 1.5, 0.5
# How far a number moves, as a share of its extent; how often it is drawn anew, and then from its rule.
NEAR, ANEW, RULED = 0.15, 0.3, 0.5
# How often a scout takes fields from a good design, and what share of them.
MIXED, SHARE = 0.3, 0.3


@dataclass
class _Option:
    """What is known of an option: the least violation, the point that has it, and the scouts since; -1: none yet."""

    violation: float = np.inf
    values: Values | None = None
    stalled: int = -1


class Scouts:
    """The options of all choices. Which points they propose follows from ``seed`` and what was added."""

    def __init__(self, variables: Sequence[Variable], seed: int) -> None:
        self._variables = tuple(v for v in variables if len(v.options) != 1)
        self._ranges = [v for v in self._variables if not v.options and not v.ruled]
        self._options = {(v.field, option): _Option() for v in self._variables for option in v.options}
        self._rng = np.random.default_rng([seed, len(self._options)])
        self._seen: set[tuple[Any, ...]] = set()

    def add(self, points: Sequence[Values], violation: Floats) -> None:
        """What was found of points."""
        for values, miss in zip(points, violation.tolist(), strict=True):
            self._seen.add(tuple(values.values()))
            for v in self._variables:
                if v.options and miss < self._options[v.field, values[v.field]].violation:
                    self._options[v.field, values[v.field]] = _Option(miss, values, 0)

    def proposed(self, count: int, good: Sequence[Values], surrogate: Surrogate) -> list[Values]:
        """At most ``count`` points, each with another option that none of the designs ``good`` has."""
        present = {(v.field, values[v.field]) for values in good for v in self._variables}
        rare = [key for key in self._options if key not in present]
        drawn = self._rng.permutation(len(rare)).tolist()
        found: list[Values] = []
        for key in self._order([rare[k] for k in drawn], count):
            option = self._options[key]
            points = [self._drawn(key, option.values, good) for _ in range(DRAWS)]
            points = [values for values in points if tuple(values.values()) not in self._seen]
            if points:
                option.stalled += 1
                passes = option.violation <= 0.0
                one = surrogate.preselected(points, 1)[0] if passes else surrogate.nearest(points, *key)
                found.append(points[one])
        return found

    def _order(self, keys: Sequence[tuple[str, Any]], count: int) -> list[tuple[str, Any]]:
        """The next ``count`` to be tried: what was never tried, then the oftener the nearer to a pass.

        A share goes to those that pass and are not good.
        """
        options = self._options
        missing = sorted((key for key in keys if options[key].violation > 0.0), key=lambda key: options[key].violation)
        tried = {key: (options[key].stalled + 1) * (1 + rank) for rank, key in enumerate(missing)}
        passing = sorted((key for key in keys if key not in tried), key=lambda key: options[key].stalled)
        least = max(round(PASSING * count), count - len(missing))
        return [*passing[:least], *sorted(tried, key=lambda key: tried[key])[: count - min(least, len(passing))]]

    def _drawn(self, key: tuple[str, Any], before: Values | None, good: Sequence[Values]) -> Values:
        """A point with the option ``key``, near the one ``before`` or, if there is none, near a good design."""
        rng, (field, option) = self._rng, key
        other = good[int(rng.integers(len(good)))]
        values = dict(before or other)
        if before is not None and rng.random() < MIXED:
            values = {name: other[name] if rng.random() < SHARE else value for name, value in values.items()}
        values[field] = option
        free = [v for v in self._variables if v.field != field]
        for _ in range(1 + rng.poisson(MORE) if free else 0):
            among = self._ranges if self._ranges and rng.random() < RANGED else free
            v = among[int(rng.integers(len(among)))]
            if v.options or rng.random() < ANEW:
                values[v.field] = v.start if rng.random() < RULED else v.drawn(rng)
            else:
                low = -1.0 if v.ruled else 0.0
                moved = values[v.field] + rng.normal(0.0, NEAR * (1.0 - low))
                values[v.field] = float(np.clip(moved, low, 1.0))
        return values


# Points of a generation: this many, fewer where few fields are free.
MOST, LEAST, EACH = 40, 8, 4
# Fields that a mutation changes on average, and the index of its distribution for numbers: the smaller, the wider.
CHANGED, ETA = 1.5, 6.0
# Points that are proposed for each that is evaluated.
POOL = 10
# Share of a generation that is taken as it is proposed, since the surrogate may be wrong.
UNSCREENED = 0.4
# Share of a generation for scouts, which take the place of some of these, where there are options to try.
SCOUTS = 0.25
# Times that it is asked for them, where most are equal.
TIMES = 20


class Engine:
    """One search over ``variables`` for ``aims`` figures, of which less is better."""

    def __init__(self, variables: Sequence[Variable], aims: int, seed: int) -> None:
        # Imported here: it takes as long as a hundred checks.
        from pymoo.algorithms.moo.nsga2 import NSGA2, binary_tournament
        from pymoo.core.duplicate import DuplicateElimination
        from pymoo.core.mixed import MixedVariableMating
        from pymoo.core.population import Population
        from pymoo.core.problem import Problem
        from pymoo.core.termination import NoTermination
        from pymoo.core.variable import Choice, Real
        from pymoo.operators.mutation.pm import PM
        from pymoo.operators.mutation.rm import ChoiceRandomMutation
        from pymoo.operators.selection.tournament import TournamentSelection

        space = {
            v.field: Choice(options=list(v.options)) if v.options else Real(bounds=(-1.0 if v.ruled else 0.0, 1.0))
            for v in variables
        }
        population = min(LEAST + EACH * len(variables), MOST)
        # The engine takes each choice alone, and would change half of them at once.
        share = min(0.5, CHANGED / len(space))
        drawn = first_values(variables, population, np.random.default_rng([seed, len(variables)]))
        first = np.empty(len(drawn), dtype=object)
        first[:] = drawn
        problem = Problem(vars=space, n_obj=aims, n_ieq_constr=1)

        class Unlike(DuplicateElimination):  # type: ignore[misc]
            """As pymoo's own for mixed variables, which compares all pairs and takes longer than all else."""

            def _do(self, pop: Any, other: Any, is_duplicate: Any) -> Any:
                seen = set() if other is None else {tuple(one.X.values()) for one in other}
                for k, one in enumerate(pop):
                    values = tuple(one.X.values())
                    is_duplicate[k] = values in seen
                    if other is None:
                        seen.add(values)
                return is_duplicate

        unlike = Unlike()
        self._algorithm = NSGA2(
            pop_size=population,
            sampling=Population.new("X", first),
            mating=MixedVariableMating(
                selection=TournamentSelection(func_comp=binary_tournament),
                mutation={Real: PM(prob=1.0, prob_var=share, eta=ETA), Choice: ChoiceRandomMutation(1.0, share)},
                eliminate_duplicates=unlike,
                n_max_iterations=TIMES,
            ),
            n_offsprings=POOL * population,
            eliminate_duplicates=unlike,
        )
        self._surrogate, self._scouts = Surrogate(variables, aims), Scouts(variables, seed)
        self._population = population
        self._algorithm.setup(problem, termination=NoTermination(), seed=seed, verbose=False)
        self._asked: Any = None

    def ask(self) -> list[Values]:
        """The points of the next generation; empty if the engine finds none that it has not proposed before."""
        from pymoo.core.population import Population

        self._asked = self._algorithm.ask()
        if self._asked is None:
            return []
        proposed = [_plain(one.X) for one in self._asked]
        known, scouts = self._algorithm.pop, list[Values]()
        if known is not None and len(known):
            good = [_plain(one.X) for one in known if one.G[0] <= 0.0] or [_plain(one.X) for one in known]
            scouts = self._scouts.proposed(round(SCOUTS * self._population), good, self._surrogate)
        unscreened = min(len(proposed), round(UNSCREENED * self._population) - len(scouts))
        screened = self._population - unscreened - len(scouts)
        best = self._surrogate.preselected(proposed[unscreened:], screened)
        chosen = [*range(unscreened), *(unscreened + k for k in best)]
        also = np.empty(len(scouts), dtype=object)
        also[:] = scouts
        self._asked = Population.merge(self._asked[chosen], Population.new("X", also))
        return [*(proposed[k] for k in chosen), *scouts]

    def tell(self, aims: Floats, violation: Floats) -> None:
        """Results of all points of the last :meth:`ask`: aims (n, k), of which less is better; violation (n,).

        Where the violation is above zero, the aims do not count.
        """
        points = [_plain(one.X) for one in self._asked]
        self._surrogate.add(points, aims, violation)
        self._scouts.add(points, violation)
        self._asked.set("F", aims, "G", violation[:, None], "H", np.zeros((len(aims), 0)))
        self._algorithm.tell(infills=self._asked)


def _plain(values: Values) -> Values:
    """The same values as Python's own types, as a file gives them back."""
    return {field: value.item() if isinstance(value, np.generic) else value for field, value in values.items()}
