"""Parallel map: independent work on several cores, by forked processes that share the memory of this one."""

from __future__ import annotations

from collections.abc import Callable, Generator, Iterator, Sequence
from contextlib import contextmanager
from typing import Any, TypeVar

from mbcdm_cad.errors import MbcdmError

Argument = TypeVar("Argument")
Result = TypeVar("Result")
# Interval, s, at which a caller that waits for forked work may stop it.
_LOOK_S = 0.02

# Work of the forked processes: inherited with the memory, so that no kernel shape has to be pickled.
_work: tuple[Callable[[Any], Any], Sequence[Any]] | None = None
_allowed = False


def allow_processes() -> None:
    """Allow :func:`fork_map` to fork. Called by the project's own programs at their start.

    A process that imports the package may run threads (a notebook, a browser's driver, the kernel), and its fork can
    wait for ever for a lock that one of them held. There the work is done in the process itself.
    """
    global _allowed
    _allowed = True


def fork_map(function: Callable[[Argument], Result], arguments: Sequence[Argument], jobs: int) -> list[Result]:
    """``[function(a) for a in arguments]`` on up to ``jobs`` processes; give the longest work first.

    Results must pickle; function and arguments need not. An exception of ``function`` is raised here. One process, one
    that has not called :func:`allow_processes`, or a system that cannot fork, does the work in this process. Not to be
    called from within ``function``.
    """
    with forked(function, arguments, min(jobs, len(arguments))) as results:
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
    global _work
    if jobs <= 1 or not arguments or not _allowed or not _can_fork():
        done: list[Result] = []

        def worked(look: Callable[[], None] = _go_on, first: int | None = None) -> list[Result]:
            for argument in arguments[len(done) : first]:
                look()
                done.append(function(argument))
            return done[:first]

        yield worked
        return
    import multiprocessing

    assert _work is None, "fork_map within fork_map"
    _work = (function, arguments)
    try:
        with multiprocessing.get_context("fork").Pool(min(jobs, len(arguments))) as pool:
            pending = [pool.apply_async(_call, (index,)) for index in range(len(arguments))]

            def results(look: Callable[[], None] = _go_on, first: int | None = None) -> list[Result]:
                for one in pending[:first]:
                    while not one.ready():
                        look()
                        one.wait(_LOOK_S)
                return [one.get() for one in pending[:first]]

            yield results
    finally:
        _work = None


def _can_fork() -> bool:
    import multiprocessing  # every command imports this file, few of them fork

    return "fork" in multiprocessing.get_all_start_methods()


def _go_on() -> None:
    pass


def _call(index: int) -> Any:
    assert _work is not None
    function, arguments = _work
    return function(arguments[index])


class Workers:
    """Processes that keep calling one function, and are replaced if they are killed; for work of hours.

    As for :func:`fork_map`, they share the memory of this process as it is at their start, and one process, or one
    that has not called :func:`allow_processes`, does the work itself. Results come in the order of the arguments.
    """

    def __init__(self, function: Callable[[Argument], Result], jobs: int) -> None:
        self._function = function
        self._jobs = jobs if _allowed and _can_fork() else 1
        self._pool: Any = None

    def results(self, arguments: Sequence[Any]) -> Generator[Any, None, None]:
        """``function(a)`` for each argument, in order. Raises ``MbcdmError`` if one kills its worker again and again.

        An exception of ``function`` is raised here.
        """
        if self._jobs <= 1:
            yield from map(self._function, arguments)
            return
        from concurrent.futures.process import BrokenProcessPool

        waiting: dict[int, Any] = {}
        for k in range(len(arguments)):
            for attempt in range(_ATTEMPTS):
                try:
                    for later in range(k, len(arguments)):
                        if later not in waiting:
                            waiting[later] = self._started().submit(_worker_call, arguments[later])
                    found = waiting.pop(k).result()
                    break
                except BrokenProcessPool:
                    self.close()
                    waiting.clear()
                    if attempt + 1 == _ATTEMPTS:
                        raise MbcdmError(
                            f"a worker process was killed {_ATTEMPTS} times at the same work, perhaps for want of "
                            "memory; take fewer workers"
                        ) from None
            yield found

    def _started(self) -> Any:
        """The pool of processes, begun if there is none."""
        global _worker_function
        if self._pool is None:
            import multiprocessing
            from concurrent.futures import ProcessPoolExecutor

            _worker_function = self._function
            fork = multiprocessing.get_context("fork")
            self._pool = ProcessPoolExecutor(self._jobs, fork, _leave_interrupts)
        return self._pool

    def close(self) -> None:
        """End the processes; work that has not begun is dropped."""
        if self._pool is not None:
            self._pool.shutdown(wait=True, cancel_futures=True)
            self._pool = None

    def __enter__(self) -> Workers:
        """The workers themselves; they start with the first work."""
        return self

    def __exit__(self, *_: object) -> None:
        """End the processes."""
        self.close()


# Work that killed its process is given to another this often in all.
_ATTEMPTS = 3
_worker_function: Callable[[Any], Any] | None = None


def _leave_interrupts() -> None:
    """An interrupt from the keyboard reaches all processes; only the main one answers."""
    import signal

    signal.signal(signal.SIGINT, signal.SIG_IGN)


def _worker_call(argument: Any) -> Any:
    assert _worker_function is not None
    return _worker_function(argument)
