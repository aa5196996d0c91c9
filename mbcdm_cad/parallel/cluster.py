"""Workers on other machines, by dask.distributed: it hands out tasks, and gives those of a dead worker to others.

A worker gets work only if it shows the state of the package that this process has (:mod:`mbcdm_cad.parallel.worker`);
so a result never depends on which worker found it. Workers may join and leave at any time.
"""

import logging
import pickle
from collections.abc import Callable, Generator, Sequence
from functools import lru_cache
from typing import Any, Self, TypeVar
from uuid import uuid4

from mbcdm_cad.errors import MbcdmError
from mbcdm_cad.parallel.worker import MARK, state

Argument = TypeVar("Argument")
Result = TypeVar("Result")
# Seconds until a scheduler must have answered, and between two looks at the workers while a result is waited for.
ANSWER_S, LOOK_S = 10.0, 2.0
_PRELOAD = "--preload mbcdm_cad.parallel.worker"
_log = logging.getLogger(__name__)


class ClusterCrew:
    """All workers of the dask scheduler at an address; see :class:`mbcdm_cad.parallel.forks.Crew`.

    Function, arguments and results must pickle. A worker that is refused, and a lack of workers, is told by the log.
    """

    def __init__(self, function: Callable[[Argument], Result], scheduler: str) -> None:
        self._address = scheduler
        self._work = pickle.dumps(function)
        self._told: set[str] = set()
        self._client = _connected(scheduler)

    def results(self, arguments: Sequence[Any]) -> Generator[Any, None, None]:
        """As of :class:`mbcdm_cad.parallel.forks.Crew`; raises ``MbcdmError`` too if the scheduler is lost."""
        name = f"mbcdm-{uuid4().hex}"
        if not arguments:
            return
        futures = self._client.map(
            _call,
            [self._work] * len(arguments),
            [pickle.dumps(one) for one in arguments],
            key=[f"{name}-{k}" for k in range(len(arguments))],
            resources={state(): 1.0},
            pure=False,
        )
        try:
            self._look()
            for future in futures:
                yield self._result(future)
        finally:
            for future in futures:
                future.release()

    def _result(self, future: Any) -> Any:
        from distributed import CancelledError, KilledWorker

        try:
            while not future.done():
                try:
                    future.result(timeout=LOOK_S)
                except TimeoutError:
                    if not future.done():
                        self._look()
            return pickle.loads(future.result())
        except KilledWorker as error:
            raise MbcdmError(
                f"a worker at {self._address} died again and again at the same work, perhaps for want of memory: "
                f"{str(error).splitlines()[0]}"
            ) from None
        except (CancelledError, OSError) as error:
            raise self._lost() from error

    def _look(self) -> None:
        """Tell once which workers get no work and why, and if there is none that does."""
        try:
            workers = self._client.scheduler_info()["workers"]
        except OSError as error:
            raise self._lost() from error
        mine = state()
        for address, worker in sorted(workers.items()):
            shown = [name for name in worker["resources"] if name.startswith(MARK)]
            if mine in shown:
                continue
            if shown:
                why = f"it has another state of the package, or another Python or numpy ({shown[0]}, here {mine})"
                self._tell(f"worker {address} gets no work: {why}; install there what is here")
            else:
                self._tell(f"worker {address} gets no work: it was started without {_PRELOAD}")
        if not any(mine in worker["resources"] for worker in workers.values()):
            self._tell(f"{self._address} has no worker for this work yet; waiting for one with {mine}")

    def _tell(self, sentence: str) -> None:
        if sentence not in self._told:
            self._told.add(sentence)
            _log.warning("%s", sentence)

    def _lost(self) -> MbcdmError:
        return MbcdmError(f"--scheduler {self._address}: the connection was lost; see whether the scheduler still runs")

    def __enter__(self) -> Self:
        """The workers themselves."""
        return self

    def __exit__(self, *_: object) -> None:
        """Leave the scheduler, which drops what has not begun."""
        self._client.close(timeout=ANSWER_S)


def _connected(address: str) -> Any:
    try:
        from distributed import Client
    except ImportError:
        raise MbcdmError(
            "--scheduler: dask.distributed is not installed; pip install 'mbcdm-cad[cluster]' brings it"
        ) from None
    # What the library tells of lost connections, this module tells in its own words.
    logging.getLogger("distributed").setLevel(logging.CRITICAL)
    try:
        return Client(address, timeout=ANSWER_S, set_as_default=False)
    except (OSError, ValueError) as error:
        why = str(error).splitlines()[0] if str(error) else type(error).__name__
        raise MbcdmError(
            f"--scheduler {address}: no dask scheduler answers within {ANSWER_S:g} s ({why}); start one with: dask "
            "scheduler --host ADDRESS, which others reach and strangers do not"
        ) from error


def _call(work: bytes, argument: bytes) -> bytes:
    """The work of one task. Everything is pickled here and not by dask, so that the scheduler need not read it."""
    return pickle.dumps(_function(work)(pickle.loads(argument)))


@lru_cache(maxsize=4)
def _function(work: bytes) -> Callable[[Any], Any]:
    function: Callable[[Any], Any] = pickle.loads(work)
    return function
