"""Independent work on the cores of this machine, by forked processes that share its memory, or on a cluster.

The results, and their order, are the same on any number of workers; a worker that dies is replaced.
"""

import os
from collections.abc import Callable, Generator, Iterator, Sequence
from contextlib import AbstractContextManager, ExitStack, contextmanager, suppress
from itertools import islice
from types import FrameType
from typing import Any, Protocol, Self, TypeVar

from mbcdm_cad.errors import MbcdmError

Argument = TypeVar("Argument")
Result = TypeVar("Result")
# Interval, s, at which a caller that waits for forked work may stop it.
_LOOK_S = 0.02

_allowed = False


def allow_processes(allowed: bool = True) -> None:
    """Allow :func:`fork_map` to fork, or no longer. Called by the project's own programs at their start.

    A process that imports the package may run threads (a notebook, a browser's driver, the kernel), and its fork can
    wait for ever for a lock that one of them held. There the work is done in the process itself.
    """
    global _allowed
    _allowed = allowed


def fork_map(function: Callable[[Argument], Result], arguments: Sequence[Argument], jobs: int) -> list[Result]:
    """``[function(a) for a in arguments]`` on up to ``jobs`` processes; give the longest work first.

    Results must pickle; function and arguments need not. An exception of ``function`` is raised here. One process, one
    that has not called :func:`allow_processes`, or a system that cannot fork, does the work in this process. Not to be
    called from within ``function``.
    """
    with forked(function, arguments, jobs) as results:
        return results()


@contextmanager
def forked(
    function: Callable[[Argument], Result], arguments: Sequence[Argument], jobs: int
) -> Iterator[Callable[..., list[Result]]]:
    """:func:`fork_map`, begun at entry, so that this process can do something else meanwhile, and ended at exit.

    Yields ``results(look, first)``, which waits for all results, or for those of the ``first`` arguments; ``look`` is
    called regularly and may raise an exception to stop. If nothing is forked (also if ``jobs`` is one), the work is
    done when ``results`` is called.
    """

    def work(index: int) -> Result:
        return function(arguments[index])

    with LocalCrew(work, min(jobs, len(arguments))) as workers:
        coming, done = workers.results(range(len(arguments))), list[Result]()

        def results(look: Callable[[], None] = _go_on, first: int | None = None) -> list[Result]:
            workers.look = look
            done.extend(islice(coming, max(0, len(arguments[:first]) - len(done))))
            return done[:first]

        yield results


def may_fork() -> bool:
    """Whether this process may fork: the system can, and :func:`allow_processes` was called."""
    import multiprocessing  # every command imports this file, few of them fork

    return _allowed and "fork" in multiprocessing.get_all_start_methods()


def begin_worker() -> None:
    """First work of a forked process: it forks no others, and leaves the keyboard's interrupt to the main process."""
    import signal

    allow_processes(False)
    signal.signal(signal.SIGINT, signal.SIG_IGN)


def _go_on() -> None:
    pass


# Work that killed its process is given to another this often in all.
ATTEMPTS = 3


class Crew(AbstractContextManager["Crew"], Protocol):
    """Workers that keep calling one function, inside a ``with`` block."""

    def results(self, arguments: Sequence[Any]) -> Generator[Any, None, None]:
        """``function(a)`` for each argument, in order. Raises ``MbcdmError`` if one kills its worker again and again.

        An exception of the function is raised here.
        """


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

    As for :func:`fork_map`, one process, or one that has not called ``allow_processes``, does the work itself. ``look``
    is called regularly while a result is waited for, and may raise an exception to stop.
    """

    def __init__(self, function: Callable[[Argument], Result], workers: int) -> None:
        self._function = function
        self._workers = workers if may_fork() else 1
        self.look: Callable[[], None] = _go_on
        self._pool: Any = None
        self._interrupts = ExitStack()

    def results(self, arguments: Sequence[Any]) -> Generator[Any, None, None]:
        """As of :class:`Crew`; other processes begin with this call."""
        from concurrent.futures import wait
        from concurrent.futures.process import BrokenProcessPool

        waiting: dict[int, Any] = {}

        def submit(first: int) -> None:
            for k in range(first, len(arguments)):
                if k not in waiting:
                    waiting[k] = self._started().submit(_worker_call, arguments[k])

        def worked(k: int) -> Any:
            for _ in range(ATTEMPTS):
                try:
                    submit(k)
                    while not waiting[k].done():
                        self.look()
                        wait([waiting[k]], _LOOK_S)
                    return waiting.pop(k).result()
                except BrokenProcessPool:
                    self.close()
                    waiting.clear()
            why = f"a worker process was killed {ATTEMPTS} times at the same work, perhaps for want of memory"
            raise MbcdmError(f"{why}; take fewer of them")

        def own(k: int) -> Any:
            self.look()
            return self._function(arguments[k])

        if self._workers > 1:
            with suppress(BrokenProcessPool):  # of a worker that dies at once we hear where its result is wanted
                submit(0)
        return (one for one in map(worked if self._workers > 1 else own, range(len(arguments))))

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

    def _kill(self) -> None:
        if self._pool is not None:
            # Python has a public name for these processes from 3.14 on (kill_workers); after its end a pool has none.
            for process in tuple((self._pool._processes or {}).values()):
                process.kill()

    def close(self) -> None:
        """Kill the processes: nobody waits for what they still do."""
        self._kill()
        if self._pool is not None:
            self._pool.shutdown(wait=True)
        self._pool = None

    def __enter__(self) -> Self:
        """The workers themselves; they start with the first work."""
        self._interrupts.enter_context(_one_interrupt(self._kill))
        return self

    def __exit__(self, *_: object) -> None:
        """End the processes."""
        self.close()
        self._interrupts.close()


@contextmanager
def _one_interrupt(first: Callable[[], None]) -> Iterator[None]:
    """The keyboard's first interrupt calls ``first`` and is raised then; further ones are ignored until the end.

    ``first`` must leave nothing that Python waits for at its end: a second interrupt that came before a ``with`` block
    could end its processes left them at their work. Only the main thread ever gets interrupts.
    """
    import signal
    import threading

    before = signal.getsignal(signal.SIGINT)
    if not callable(before) or threading.current_thread() is not threading.main_thread():
        yield
        return
    told = False

    def interrupt(number: int, frame: FrameType | None) -> None:
        nonlocal told
        first()
        if not told:
            told = True
            before(number, frame)

    signal.signal(signal.SIGINT, interrupt)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)


_worker_function: Callable[[Any], Any] | None = None


def _worker_call(argument: Any) -> Any:
    assert _worker_function is not None
    return _worker_function(argument)
