"""Parallel map: independent work on several cores, by forked processes that share the memory of this one."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, TypeVar

Argument = TypeVar("Argument")
Result = TypeVar("Result")

# What the forked processes work on: inherited with the memory, so that no kernel shape has to be pickled.
_work: tuple[Callable[[Any], Any], Sequence[Any]] | None = None
_allowed = False


def allow_processes() -> None:
    """Let :func:`fork_map` fork. For a program of our own at its start.

    A process that imports the package may run threads (a notebook, a browser's driver, the kernel's own), and a fork of
    it can wait for ever for a lock that one of them held: there the work is done in the process itself.
    """
    global _allowed
    _allowed = True


def fork_map(function: Callable[[Argument], Result], arguments: Sequence[Argument], jobs: int) -> list[Result]:
    """``[function(a) for a in arguments]`` on up to ``jobs`` processes; give the longest work first.

    Results must pickle; function and arguments need not. An exception of ``function`` is raised here. One process, one
    that has not called :func:`allow_processes`, or a system that cannot fork, does the work in this process. Not to be
    called from within ``function``.
    """
    global _work
    jobs = min(jobs, len(arguments))
    if jobs <= 1 or not _allowed:
        return [function(argument) for argument in arguments]
    import multiprocessing  # every command imports this file, few of them fork

    if "fork" not in multiprocessing.get_all_start_methods():
        return [function(argument) for argument in arguments]
    assert _work is None, "fork_map within fork_map"
    _work = (function, arguments)
    try:
        with multiprocessing.get_context("fork").Pool(jobs) as pool:
            return pool.map(_call, range(len(arguments)), chunksize=1)
    finally:
        _work = None


def _call(index: int) -> Any:
    assert _work is not None
    function, arguments = _work
    return function(arguments[index])
