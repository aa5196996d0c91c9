"""Work on one fitter in parallel threads."""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from queue import Queue
from typing import TypeVar

from mbcdm_cad.loop.search.fit import Fitter
from mbcdm_cad.model.si import ModelError

MOST_THREADS = 4
Found = TypeVar("Found")


class Twins:
    """Twins of a fitter, one a thread."""

    def __init__(self, fitter: Fitter) -> None:
        self._twins = [fitter.twin() for _ in range(min(MOST_THREADS, os.cpu_count() or 1))]

    def each(self, tasks: Sequence[Callable[[Fitter], Found]]) -> list[Found]:
        """What the tasks return, in their order: the simulation runs outside the interpreter's lock.

        A candidate that cannot be simulated at its start (a slack cable, a negative radius) is left out.
        """
        twins = Queue[Fitter]()
        for twin in self._twins:
            twins.put(twin)

        def one(task: Callable[[Fitter], Found]) -> Found | None:
            twin = twins.get()
            try:
                return task(twin)
            except ModelError:
                return None
            finally:
                twins.put(twin)

        with ThreadPoolExecutor(len(self._twins)) as pool:
            return [found for found in pool.map(one, tasks) if found is not None]
