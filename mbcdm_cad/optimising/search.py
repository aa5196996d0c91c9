"""The search: generation after generation of every layout until the front stands or a limit is reached; its file.

Lines are only added, each with a hash of itself and all before it. A search goes on from the last line before the first
that a kill cut off, or that anything else changed.

Which points are evaluated, and in which order, follows from the request alone; the journal has their results in this
order. A search that goes on asks the engine again from the start and takes from the journal what it has.
"""

import hashlib
import json
import os
import time
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import AbstractContextManager, contextmanager
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

import filelock
import numpy as np

from mbcdm_cad.errors import OutputError
from mbcdm_cad.optimising import Effort
from mbcdm_cad.optimising.engine import Engine, front_of, hypervolume, reference_of
from mbcdm_cad.optimising.evaluate import FAULT, NO_FIGURE, Evaluated, evaluate
from mbcdm_cad.optimising.wishes import Keep, Values, Variable, Wishes, point_of
from mbcdm_cad.parallel.forks import Crew, crew
from mbcdm_cad.routes import Floats
from mbcdm_cad.solving.question import Question
from mbcdm_cad.storage.folders import locked

Record = dict[str, Any]


@contextmanager
def sole_search(path: Path) -> Iterator[None]:
    """Hold the journal ``path`` for the block; raises ``OutputError`` if another process holds it."""
    lock = path.with_name(f".{path.name}.lock")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        with locked(lock, 0.0):
            yield
    except filelock.Timeout:
        raise OutputError(f"{path}: another search is writing it; wait for it, or choose another --out") from None
    except OSError as error:
        raise OutputError(f"{path}: cannot write: {error.strerror or error}; choose another --out") from error


class Journal(AbstractContextManager["Journal"]):
    """The records of one search, read from its file and added to it. ``request``: all that its results depend on."""

    def __init__(self, path: Path, request: Mapping[str, Any], *, resume: bool) -> None:
        """Open the file, or begin it.

        Raises ``OutputError`` if there is one and ``resume`` is not given, if it belongs to another search, or if the
        system refuses.
        """
        self.path = path
        self.records: list[Record] = []
        self._chain, self._size = b"", 0
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
            content = path.read_bytes() if path.exists() else b""
            found = list(self._good(content))
            if b"\n" in content and not found:
                raise OutputError(f"{path}: damaged, or of another version of this program; remove it and begin anew")
            if found and not resume:
                raise OutputError(
                    f"{path}: there are {len(found) - 1} evaluated points of a search before; add --resume to go on "
                    "with it, or remove the file to begin anew"
                )
            if found:
                asked = json.loads(json.dumps(request))
                differ = [name for name in asked if found[0].get(name) != asked[name]]
                if differ:
                    raise OutputError(
                        f"{self.path}: belongs to a search with another {', '.join(differ)}; remove it, or choose "
                        "another folder with --out"
                    )
                self.records = found[1:]
            # Without a buffer, so that what a call has written is with the system even if this process is killed.
            self._file = open(path, "ab", buffering=0)  # noqa: SIM115 - closed by __exit__
            self._file.truncate(self._size)
            # Written with the first record: a request that turns out to be wrong begins no search.
            self._head: tuple[Record, ...] = () if found else (dict(request),)
        except OSError as error:
            raise self._refused(error) from error

    def _good(self, content: bytes) -> Iterator[Record]:
        """The contents of the lines before the first that is not as it was written."""
        for line in content.splitlines(keepends=True):
            try:
                record = json.loads(line)["record"]
                if line != self._sealed(record):
                    return
            except (ValueError, LookupError, TypeError, RecursionError):
                return
            self._chain, self._size = line, self._size + len(line)
            yield record

    def _sealed(self, content: Record) -> bytes:
        """The next line: the content with a hash of it and of the line before, which has that of all before."""
        record = json.dumps(content, separators=(",", ":"), allow_nan=False).encode()
        return b'{"sha256":"%s","record":%s}\n' % (hashlib.sha256(self._chain + record).hexdigest().encode(), record)

    def add(self, record: Record) -> None:
        """Add one record. Raises ``OutputError`` if the system refuses, such as for a full disk."""
        try:
            for content in (*self._head, record):
                self._write(content)
            self._head = ()
        except OSError as error:
            raise self._refused(error) from error
        self.records.append(record)

    def keep(self) -> None:
        """Have all records on the disk. Raises as :meth:`add`."""
        try:
            os.fsync(self._file.fileno())
        except OSError as error:
            raise self._refused(error) from error

    def _write(self, content: Record) -> None:
        line = self._sealed(content)
        written = self._file.write(line)
        while written < len(line):  # a full disk takes a part, then refuses with a reason
            written += self._file.write(line[written:])
        self._chain = line

    def _refused(self, error: OSError) -> OutputError:
        return OutputError(
            f"{self.path}: cannot write: {error.strerror or error}; make room or rights, then go on with --resume"
        )

    def __exit__(self, *_: object) -> None:
        """Close the file."""
        self._file.close()


SEED = 36
# Rounds over which the growth of the front's hypervolume is taken; a round is a generation of every layout.
ROUNDS = 12

# Is called with a sentence on the best so far and the number of evaluated points.
Told = Callable[[str, int], None]


@dataclass(frozen=True)
class TriedPoint:
    """One evaluated point: of which question, the values of its variables, its result."""

    question: int
    values: Values
    result: Evaluated


@dataclass(frozen=True)
class Searched:
    """All points in order, the rows of the front, and why the search ended.

    ``curve``: (points evaluated, hypervolume of the front) after each round, against one reference point; ``grown``:
    the share by which it grew in the last :data:`ROUNDS` rounds, None while there are fewer. ``failing``: how often
    each check failed and each keep was missed; ``left_out``: why an aim had no figure, and of how many designs.
    """

    wishes: Wishes
    tried: tuple[TriedPoint, ...]
    front: tuple[int, ...]
    curve: tuple[tuple[int, float], ...]
    stopped: str
    finished: bool
    failing: Mapping[str, int] = field(default_factory=dict)
    refused: Mapping[str, int] = field(default_factory=dict)
    faults: tuple[str, ...] = ()
    grown: float | None = None
    left_out: Mapping[str, int] = field(default_factory=dict)

    @property
    def passing(self) -> int:
        """Number of points that pass every check and keep every figure."""
        return sum(one.result.passes for one in self.tried)

    def aims(self, row: int) -> Floats:
        """The aims of one passing point, less is better."""
        return _aims(self.wishes, self.tried[row].result)


def _aims(wishes: Wishes, result: Evaluated) -> Floats:
    return np.array([aim.less(result.figures[aim.figure]) if result.passes else 0.0 for aim in wishes.aims])


@dataclass(frozen=True)
class _Evaluation:
    """Evaluates (question, values of its variables). Plain data, so that it can be sent to another machine."""

    questions: tuple[Question, ...]
    variables: tuple[tuple[Variable, ...], ...]
    keeps: tuple[Keep, ...]
    names: tuple[str, ...]

    def __call__(self, asked: tuple[int, Values]) -> Evaluated:
        which, values = asked
        return evaluate(self.questions[which], point_of(self.variables[which], values), self.keeps, self.names)


@dataclass
class FrontSearch:
    """A search over ``questions`` with their ``variables``."""

    questions: Sequence[Question]
    variables: Sequence[Sequence[Variable]]
    wishes: Wishes
    journal: Journal
    told: Told
    tried: list[TriedPoint] = field(default_factory=list)
    _known: dict[tuple[int, Any], int] = field(default_factory=dict)
    _fronts: list[tuple[int, list[int]]] = field(default_factory=list)
    _grown: float | None = None

    def run(self, effort: Effort) -> Searched:
        """FrontSearch until the front no longer grows, a limit is reached, or the keyboard interrupts."""
        end = np.inf if effort.time_s is None else time.monotonic() + effort.time_s
        names = [aim.figure for aim in self.wishes.aims]
        engines = [Engine(v, len(names), SEED + k) for k, v in enumerate(self.variables)]

        work = _Evaluation(tuple(self.questions), tuple(map(tuple, self.variables)), self.wishes.keeps, tuple(names))
        stopped = ""
        try:
            with crew(work, effort.workers, effort.scheduler) as workers:
                while not stopped:
                    stopped = self._round(engines, workers, end, effort)
        except KeyboardInterrupt:
            stopped = INTERRUPTED
        self.journal.keep()
        return self._searched(stopped)

    def _round(self, engines: Sequence[Engine], workers: Crew, end: float, effort: Effort) -> str:
        """One generation of every question; why the search ends here, empty if it goes on."""
        proposed, most = 0, effort.evaluations
        for k, engine in enumerate(engines):
            asked = engine.ask()
            proposed += len(asked)
            room = len(asked) if most is None else min(most - len(self.tried), len(asked))
            results = self._results(k, asked[:room], workers, end)
            if len(results) < len(asked):
                return TIME if len(results) < room else EVALUATIONS
            if asked:
                engine.tell(
                    np.array([_aims(self.wishes, result) for result in results]),
                    np.array([result.violation for result in results]),
                )
        self._fronts.append((len(self.tried), self._front()))
        if not proposed:
            return "every combination of the free values has been tried"
        # Share by which the hypervolume grew in the last rounds; None while there are fewer, or was no front.
        if len(self._fronts) > ROUNDS and self._fronts[-1 - ROUNDS][1]:
            before, now = (volume for _, volume in self._curve((self._fronts[-1 - ROUNDS], self._fronts[-1])))
            self._grown = (now - before) / now
        if self._grown is None or self._grown >= effort.growth:
            return ""
        grown = f"the front's hypervolume grew by {self._grown:.2%} in the last {ROUNDS} generations"
        return f"{grown} (limit {100.0 * effort.growth:.3g}%)"

    def _results(self, k: int, asked: Sequence[Values], workers: Crew, end: float) -> list[Evaluated]:
        """The results of points of question ``k`` in order; fewer of them once the time is over."""
        first = len(self.tried)
        todo: dict[int, Any] = {}
        for n, values in enumerate(asked, start=first):
            key = (k, frozenset(point_of(self.variables[k], values).items()))
            if n < len(self.journal.records):
                self._take(n, k, values)
            elif key not in self._known and key not in todo.values():
                todo[n] = key
            if n < len(self.journal.records):
                self._known.setdefault(key, n)
        fresh = workers.results([(k, asked[n - first]) for n in todo])
        for n in range(len(self.tried), first + len(asked)):
            if time.monotonic() >= end:
                break
            values = asked[n - first]
            key = (k, frozenset(point_of(self.variables[k], values).items()))
            if n in todo:
                result, same = next(fresh), None
                self._known[key] = n
            else:
                same = self._known[key]
                result = self.tried[same].result
            found = {"same": same} if same is not None else {name: x for name, x in asdict(result).items() if x}
            self.journal.add({"question": k, "values": dict(values)} | found)
            self.tried.append(TriedPoint(k, values, result))
            self.told(self._words(), len(self.tried))
        fresh.close()
        return [one.result for one in self.tried[first:]]

    def _take(self, n: int, k: int, values: Values) -> None:
        """Point ``n`` from the journal, which must be the one that the engine proposes."""
        record = self.journal.records[n]
        if record["question"] != k or record["values"] != dict(values):
            raise OutputError(
                f"{self.journal.path}: point {n + 1} is not the one that this search proposes; remove the file and "
                "begin anew"
            )
        same = record.get("same")
        result = self.tried[same].result if same is not None else _result(record)
        self.tried.append(TriedPoint(k, values, result))

    def _front(self) -> list[int]:
        rows = [n for n, one in enumerate(self.tried) if one.result.passes]
        if not rows:
            return []
        points = np.array([_aims(self.wishes, self.tried[n].result) for n in rows])
        return [rows[k] for k in front_of(points)]

    def _curve(self, fronts: Sequence[tuple[int, list[int]]]) -> list[tuple[int, float]]:
        """Hypervolumes against the reference of all points on these fronts."""
        rows = sorted({row for _, front in fronts for row in front})
        if not rows:
            return [(count, 0.0) for count, _ in fronts]
        found = {row: _aims(self.wishes, self.tried[row].result) for row in rows}
        reference, scale = reference_of(np.array(list(found.values())))
        return [
            (count, hypervolume(np.array([found[row] for row in front]), reference, scale)) for count, front in fronts
        ]

    def _words(self) -> str:
        """The best of each aim so far, for the progress."""
        good = [one.result.figures for one in self.tried if one.result.passes]
        if not good:
            return "no design passes yet"
        best = [f"{aim.figure} {min((f[aim.figure] for f in good), key=aim.less):.4g}" for aim in self.wishes.aims]
        grown = "" if self._grown is None else f"; the front grew by {self._grown:.2%} in {ROUNDS} generations"
        return f"{len(good)} pass, best {', '.join(best)}{grown}"

    def _searched(self, stopped: str) -> Searched:
        front = self._front()
        rounds = [*self._fronts]
        if not rounds or rounds[-1][0] < len(self.tried):
            rounds.append((len(self.tried), front))
        missed = counted(name for one in self.tried for name, _ in one.result.failing)
        refused = counted(one.result.refused for one in self.tried if one.result.refused)
        faults = dict.fromkeys(one.result.refused for one in self.tried if one.result.refused.startswith(FAULT))
        return Searched(
            self.wishes,
            tuple(self.tried),
            tuple(front),
            tuple(self._curve(rounds)),
            stopped,
            stopped not in (INTERRUPTED, TIME),
            {name: count for name, count in missed.items() if NO_FIGURE not in name},
            refused,
            tuple(faults),
            self._grown,
            {name: count for name, count in missed.items() if NO_FIGURE in name},
        )


def counted(names: Iterable[str]) -> dict[str, int]:
    """How often each occurs, the most first."""
    found = Counter(names)
    return {name: found[name] for name in sorted(found, key=lambda name: (-found[name], name))}


INTERRUPTED = "interrupted"
TIME = "the time is over"
EVALUATIONS = "the number of evaluations is reached"


def _result(record: Record) -> Evaluated:
    failing = tuple((name, miss) for name, miss in record.get("failing", ()))
    return Evaluated(failing, record.get("refused", ""), record.get("figures", {}), record.get("fields", {}))
