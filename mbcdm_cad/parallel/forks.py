"""Parallel map: independent work on several cores, by forked processes that share the memory of this one."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from typing import Any, TypeVar

Argument = TypeVar("Argument")
Result = TypeVar("Result")
# Interval, s, at which a caller that waits for forked work may stop it.
_LOOK_S = 0.02

# Work of the forked processes: inherited with the memory, so that no kernel shape has to be pickled.
_work: tuple[Callable[[Any], Any], Sequence[Any]] | None = None
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
    if jobs <= 1 or not arguments or not may_fork():
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
        with multiprocessing.get_context("fork").Pool(min(jobs, len(arguments)), begin_worker) as pool:
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


def _call(index: int) -> Any:
    assert _work is not None
    function, arguments = _work
    return function(arguments[index])
