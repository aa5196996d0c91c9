"""For a file without a passing design by the sizing rules: find a design, or a proof that none exists.

There are two kinds of proof. By a bound: a few requirements exclude each other for any other choice
(:mod:`reach_bound`). By searches: ``mbcdm solve`` finds no design and names the requirements that must change, and an
independent search (:mod:`random_search`) finds none either.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import yaml

from mbcdm_cad.errors import InputError
from mbcdm_cad.solving.question import question_of
from mbcdm_cad.solving.solve import solve
from tests.support.random_search import search
from tests.support.reach_bound import asked, excluding

BOUND, SEARCHES, SOLVED, FOUND, OPEN = "bound", "searches", "solved", "found", "open"
WORDS = {
    SOLVED: "get a design from 'mbcdm solve'",
    FOUND: "get one from the independent search alone",
    BOUND: "exclude each other by a bound over the catalogue",
    SEARCHES: "exclude each other by both searches, and a design passes after one is relaxed",
    OPEN: "are neither: no design found, and no requirement that helps when it is relaxed",
}


@dataclass(frozen=True)
class Proof:
    """``kind``: one of :data:`WORDS`; ``names``: the requirements that exclude each other, or what was moved."""

    seed: int
    kind: str
    names: tuple[str, ...]


def proof(seed: int, data: dict[str, Any], *, searched: bool = True) -> Proof:
    """Of one file that does not pass. Without ``searched`` only the bound is asked, which takes a tenth of a second."""
    names = excluding(asked(data))
    if names:
        return Proof(seed, BOUND, names)
    if not searched:
        return Proof(seed, OPEN, ())
    try:
        solution = solve(question_of(yaml.safe_dump(data, sort_keys=False)))
    except InputError as error:
        return Proof(seed, OPEN, (str(error.problems[0].what),))
    if solution.conflict is None:
        return Proof(seed, SOLVED, tuple(change.field for change in solution.changes))
    found = search(data)
    if found is not None:
        return Proof(seed, FOUND, tuple(found))
    conflict = solution.conflict
    gives = (*conflict.either, *conflict.first) if conflict.either else ()
    return Proof(seed, SEARCHES if gives else OPEN, tuple(sorted({way.field for way in gives})))


def summary(passing: int, count: int, proofs: Sequence[Proof]) -> Iterator[str]:
    """How many files of each kind, which sets exclude each other, and the files that are left."""
    kinds = Counter(found.kind for found in proofs)
    yield f"{passing} of {count} pass every check by the rules alone"
    yield from (f"{kinds[kind]} {words}" for kind, words in WORDS.items())
    settled = passing + kinds[SOLVED] + kinds[BOUND] + kinds[SEARCHES]
    yield f"{settled} of {count} settled ({settled / count:.1%})"
    sets = Counter((found.kind, found.names) for found in proofs if found.kind in (BOUND, SEARCHES))
    yield from (f"  {number:>4} {kind:<9}{', '.join(names)}" for (kind, names), number in sets.most_common())
    yield from (
        f"  seed {found.seed}: {found.kind} {', '.join(found.names)}"
        for found in proofs
        if found.kind in (SOLVED, FOUND, OPEN)
    )
