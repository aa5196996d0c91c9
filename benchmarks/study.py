"""A study: many runs, each judged by itself, kept in a file so that it goes on where it was stopped, and a table.

    python -m benchmarks.studies.plan --workers 4
    python -m benchmarks.studies.plan --scheduler tcp://192.168.1.10:8786

The workers of a cluster run from a checkout of the same state, with its folder on their path:
``PYTHONPATH=. dask worker ADDRESS --nthreads 1 --preload mbcdm_cad.parallel.worker``.
"""

from __future__ import annotations

import argparse
import hashlib
import inspect
import json
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from functools import cache
from importlib import import_module
from pathlib import Path
from typing import Any, TypeVar

from mbcdm_cad.errors import MbcdmError
from mbcdm_cad.parallel.forks import allow_processes, crew

ROOT = Path(__file__).resolve().parents[1]
Argument = TypeVar("Argument")
Result = TypeVar("Result")
Row = dict[str, Any]


@dataclass(frozen=True)
class Study:
    """``judge`` makes the row of one task, a tuple of plain values that the row holds as ``task``; ``table`` is the
    text of all rows."""

    judge: Callable[[Any], Row]
    table: Callable[[list[Row]], str]

    def run(self, tasks: Iterable[tuple[Any, ...]], options: argparse.Namespace) -> list[Row]:
        """The rows of ``options.rows`` and of the tasks that it does not have, which are added to it; print them."""
        rows = read_rows(options.rows)
        done = {tuple(row["task"]) for row in rows}
        wanted = [task for task in tasks if task not in done]
        for task, row in zip(wanted, run_many(self.judge, wanted, options), strict=True):
            rows.append({"task": list(task), **row})
            print(json.dumps(rows[-1]), flush=True)
            if options.rows:
                options.rows.parent.mkdir(parents=True, exist_ok=True)
                with options.rows.open("a", encoding="utf-8") as kept:
                    kept.write(json.dumps(rows[-1]) + "\n")
        print(self.table(rows))
        return rows


def parser(about: str | None, runs: int = 0) -> argparse.ArgumentParser:
    """The options of all studies: how many runs, from which seed, where the rows are, on how many processes."""
    found = argparse.ArgumentParser(description=about, formatter_class=argparse.RawDescriptionHelpFormatter)
    found.add_argument("--runs", type=int, default=runs, help="how many; those in the file count")
    found.add_argument("--first-seed", type=int, default=1)
    found.add_argument("--rows", type=Path, help="JSON lines of what was judged; nothing in it is judged again")
    add_workers(found)
    return found


def read_rows(path: Path | None) -> list[Row]:
    """The rows of a file; none of a file that is not there."""
    return [json.loads(line) for line in path.read_text("utf-8").splitlines()] if path and path.exists() else []


def add_workers(parser: argparse.ArgumentParser) -> None:
    """The options of all programs that use many processes."""
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
    """A function of a program of tests/ or benchmarks/, by its name, so that it can be sent to another machine."""

    module: str
    name: str
    state: str

    @classmethod
    def of(cls, function: Callable[..., Any]) -> Named:
        """The function of a program, also where the program itself runs and is called ``__main__``."""
        file = Path(inspect.getfile(function)).resolve().relative_to(ROOT)
        return cls(".".join(file.with_suffix("").parts), function.__name__, state())

    def __call__(self, argument: Any) -> Any:
        """Call it. Raises ``MbcdmError`` where the programs are others than those of who asks."""
        if state() != self.state:
            raise MbcdmError(f"{ROOT}: the tests of this worker are not those of the study; check out the same state")
        return getattr(import_module(self.module), self.name)(argument)


@cache
def state() -> str:
    """Hash of all programs of tests/ and benchmarks/."""
    digest = hashlib.sha256()
    for path in sorted([*(ROOT / "tests").rglob("*.py"), *(ROOT / "benchmarks").rglob("*.py")]):
        digest.update(f"{path.relative_to(ROOT)} {hashlib.sha256(path.read_bytes()).hexdigest()}\n".encode())
    return digest.hexdigest()
