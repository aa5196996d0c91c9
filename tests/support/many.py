"""The studies of tests/ on many processes or machines: their options, and how a worker finds their functions.

    python tests/reach.py --workers 4
    python tests/reach.py --scheduler tcp://192.168.1.10:8786

The workers of a cluster run from a checkout of the same state, with its folder on their path:
``PYTHONPATH=. dask worker ADDRESS --nthreads 1 --preload mbcdm_cad.parallel.worker``.
"""

from __future__ import annotations

import argparse
import hashlib
import inspect
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from functools import cache
from importlib import import_module
from pathlib import Path
from typing import Any, TypeVar

from mbcdm_cad.errors import MbcdmError
from mbcdm_cad.parallel.crew import crew
from mbcdm_cad.parallel.forks import allow_processes

TESTS = Path(__file__).resolve().parents[1]
Argument = TypeVar("Argument")
Result = TypeVar("Result")


def add_workers(parser: argparse.ArgumentParser) -> None:
    """The options of all studies."""
    parser.add_argument("--workers", type=int, default=1, help="processes of this machine")
    parser.add_argument("--scheduler", help="address of a dask scheduler whose workers are used instead")


def run_many(
    function: Callable[[Argument], Result], arguments: Iterable[Argument], options: argparse.Namespace
) -> Iterator[Result]:
    """``function(a)`` for each argument, in order, as the options of :func:`add_workers` say."""
    work: Callable[[Argument], Result] = function if options.scheduler is None else Named.of(function)
    if options.workers > 1:
        allow_processes()
    with crew(work, options.workers, options.scheduler) as workers:
        yield from workers.results(list(arguments))


@dataclass(frozen=True)
class Named:
    """A function of a program of tests/, by its name there, so that it can be sent to another machine."""

    module: str
    name: str
    state: str

    @classmethod
    def of(cls, function: Callable[..., Any]) -> Named:
        """The function of a program, also where the program itself runs and is called ``__main__``."""
        file = Path(inspect.getfile(function)).resolve().relative_to(TESTS.parent)
        return cls(".".join(file.with_suffix("").parts), function.__name__, tests_state())

    def __call__(self, argument: Any) -> Any:
        """Call it. Raises ``MbcdmError`` where the tests are others than those of who asks."""
        if tests_state() != self.state:
            raise MbcdmError(f"{TESTS}: the tests of this worker are not those of the study; check out the same state")
        return getattr(import_module(self.module), self.name)(argument)


@cache
def tests_state() -> str:
    """Hash of all programs of tests/."""
    digest = hashlib.sha256()
    for path in sorted(TESTS.rglob("*.py")):
        digest.update(f"{path.relative_to(TESTS)} {hashlib.sha256(path.read_bytes()).hexdigest()}\n".encode())
    return digest.hexdigest()
