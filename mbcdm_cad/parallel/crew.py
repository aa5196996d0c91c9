"""One function called with many arguments, for work of minutes to hours: on this machine's cores, or on a cluster.

The results, and their order, are the same on any number of workers; a worker that dies is replaced.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Generator, Iterator, Sequence
from contextlib import contextmanager
from types import TracebackType
from typing import Any, Protocol, Self, TypeVar

from mbcdm_cad.errors import MbcdmError
from mbcdm_cad.parallel.forks import begin_worker, may_fork

Argument = TypeVar("Argument")
Result = TypeVar("Result")
# Work that killed its process is given to another this often in all.
ATTEMPTS = 3


class Crew(Protocol):
    """Workers that keep calling one function, inside a ``with`` block."""

    def results(self, arguments: Sequence[Any]) -> Generator[Any, None, None]:
        """``function(a)`` for each argument, in order. Raises ``MbcdmError`` if one kills its worker again and again.

        An exception of the function is raised here.
        """

    def __enter__(self) -> Self:
        """The workers themselves."""

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """End the work."""


def crew(function: Callable[[Argument], Result], workers: int | None = None, scheduler: str | None = None) -> Crew:
    """Workers that call ``function``: ``workers`` processes of this machine (all cores by default).

    With ``scheduler``, the address of a dask scheduler, all workers there; then function, arguments and results must
    pickle. Raises ``MbcdmError`` if nobody answers at the address.
    """
    if scheduler is None:
        return LocalCrew(function, workers or len(os.sched_getaffinity(0)))
    # Imported here: it takes as long as two checks.
    from mbcdm_cad.parallel.cluster import ClusterCrew

    return ClusterCrew(function, scheduler)


class LocalCrew:
    """Forked processes, which share the memory of this one as it is at their start.

    As for :func:`mbcdm_cad.parallel.forks.fork_map`, one process, or one that has not called ``allow_processes``, does
    the work itself.
    """

    def __init__(self, function: Callable[[Argument], Result], workers: int) -> None:
        self._function = function
        self._workers = workers if may_fork() else 1
        self._pool: Any = None

    def results(self, arguments: Sequence[Any]) -> Generator[Any, None, None]:
        """As of :class:`Crew`."""
        if self._workers <= 1:
            yield from map(self._function, arguments)
            return
        from concurrent.futures.process import BrokenProcessPool

        waiting: dict[int, Any] = {}
        for k in range(len(arguments)):
            for attempt in range(ATTEMPTS):
                try:
                    for later in range(k, len(arguments)):
                        if later not in waiting:
                            waiting[later] = self._started().submit(_worker_call, arguments[later])
                    found = waiting.pop(k).result()
                    break
                except BrokenProcessPool:
                    self.close()
                    waiting.clear()
                    if attempt + 1 == ATTEMPTS:
                        raise killed_again(ATTEMPTS) from None
            yield found

    def _started(self) -> Any:
        """The pool of processes, begun if there is none."""
        global _worker_function
        if self._pool is None:
            import multiprocessing
            import signal
            from concurrent.futures import ProcessPoolExecutor

            _worker_function = self._function
            fork = multiprocessing.get_context("fork")
            # An interrupt waits meanwhile: Python drops one that comes while it forks.
            before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
            try:
                self._pool = ProcessPoolExecutor(self._workers, fork, begin_worker)
                self._pool.submit(int)  # with the first work all processes start
            finally:
                signal.pthread_sigmask(signal.SIG_SETMASK, before)
        return self._pool

    def close(self) -> None:
        """Kill the processes: nobody waits for what they still do. A further interrupt meanwhile does not count."""
        if self._pool is None:
            return
        with _uninterrupted():
            pool, self._pool = self._pool, None
            # Python has a public name for these processes from 3.14 on (kill_workers).
            processes = tuple(pool._processes.values())
            pool.shutdown(wait=False, cancel_futures=True)
            for process in processes:
                process.kill()
            pool.shutdown(wait=True)

    def __del__(self) -> None:
        """End the processes, should an interrupt have come before the ``with`` block could."""
        self.close()

    def __enter__(self) -> Self:
        """The workers themselves; they start with the first work."""
        return self

    def __exit__(self, *_: object) -> None:
        """End the processes."""
        self.close()


def killed_again(attempts: int) -> MbcdmError:
    """The error for work that has killed its worker ``attempts`` times."""
    return MbcdmError(
        f"a worker process was killed {attempts} times at the same work, perhaps for want of memory; take fewer workers"
    )


@contextmanager
def _uninterrupted() -> Iterator[None]:
    """Ignore the keyboard's interrupt; only the main thread ever gets it."""
    import signal
    import threading

    if threading.current_thread() is not threading.main_thread():
        yield
        return
    before = signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)


_worker_function: Callable[[Any], Any] | None = None


def _worker_call(argument: Any) -> Any:
    assert _worker_function is not None
    return _worker_function(argument)
