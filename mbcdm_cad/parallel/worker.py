"""What a worker of a cluster loads at its start (``dask worker ... --preload mbcdm_cad.parallel.worker``).

It says which state of the package it has, so that the scheduler gives it only work of the same state.
"""

from typing import Any

import mbcdm_cad
from mbcdm_cad.storage.cache import content_key

# Beginning of the name of the resource by which a worker shows its state.
MARK = "mbcdm_cad "


def state() -> str:
    """The name of this machine's state: equal only if package, Python, numpy and CAD kernel are the same."""
    return f"{MARK}{mbcdm_cad.__version__} {content_key('worker', None)[:12]}"


def dask_setup(worker: Any) -> None:
    """Called by dask before the worker joins: show the state, one task at a time, one thread of linear algebra."""
    from threadpoolctl import threadpool_limits

    threadpool_limits(1)
    for known in (worker.state.total_resources, worker.state.available_resources):
        known[state()] = 1.0
