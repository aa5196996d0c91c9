"""The engine that proposes points: NSGA-II of pymoo for numbers and choices together, by ask and tell.

It proposes ten times the points of a generation; a surrogate model preselects those that are evaluated. A quarter of a
generation are scouts, which try options that no good design has.

A proposal depends on the seed and on what the engine was told, and on nothing else.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from mbcdm_cad.optimising.scouts import Scouts
from mbcdm_cad.optimising.surrogate import Surrogate
from mbcdm_cad.optimising.variables import Values, Variable, first_values
from mbcdm_cad.routes import Floats

# Points of a generation: this many, fewer where few fields are free.
MOST, LEAST, EACH = 40, 8, 4
# Fields that a mutation changes on average, and the index of its distribution for numbers: the smaller, the wider.
CHANGED, WIDTH = 1.5, 6.0
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
                mutation={Real: PM(prob=1.0, prob_var=share, eta=WIDTH), Choice: ChoiceRandomMutation(1.0, share)},
                eliminate_duplicates=unlike,
                n_max_iterations=TIMES,
            ),
            n_offsprings=POOL * population,
            eliminate_duplicates=unlike,
        )
        self._surrogate, self._scouts, self._population = (
            Surrogate(variables, aims),
            Scouts(variables, seed),
            population,
        )
        self._algorithm.setup(problem, termination=NoTermination(), seed=seed, verbose=False)
        self._asked: Any = None

    def ask(self) -> list[Values]:
        """The points of the next generation; empty if the engine finds none that it has not proposed before."""
        from pymoo.core.population import Population

        self._asked = self._algorithm.ask()
        if self._asked is None:
            return []
        proposed = [_plain(one.X) for one in self._asked]
        scouts = self._scouted()
        unscreened = min(len(proposed), round(UNSCREENED * self._population) - len(scouts))
        screened = self._population - unscreened - len(scouts)
        best = self._surrogate.preselected(proposed[unscreened:], screened)
        chosen = [*range(unscreened), *(unscreened + k for k in best)]
        also = np.empty(len(scouts), dtype=object)
        also[:] = scouts
        self._asked = Population.merge(self._asked[chosen], Population.new("X", also))
        return [*(proposed[k] for k in chosen), *scouts]

    def _scouted(self) -> list[Values]:
        """The scouts of the next generation; none before anything is known."""
        known = self._algorithm.pop
        if known is None or not len(known):
            return []
        good = [_plain(one.X) for one in known if one.G[0] <= 0.0] or [_plain(one.X) for one in known]
        return self._scouts.proposed(round(SCOUTS * self._population), good, self._surrogate)

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
