"""Work on several processes gives the same result as on one.

Workers of this machine and of a cluster (here threads of this process) give the same results and errors.
"""

import argparse
import logging
import os
import pickle
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager, suppress
from dataclasses import replace
from pathlib import Path

import pytest
from distributed import LocalCluster

from benchmarks.study import Named, run_many
from mbcdm_cad.errors import GeometryError, InputError, MbcdmError, Problem
from mbcdm_cad.parallel import cluster, forks
from mbcdm_cad.parallel.forks import crew, fork_map, forked
from mbcdm_cad.parallel.worker import state
from tests.support.loopback import PATIENCE_S


@pytest.fixture(autouse=True)
def allowed(monkeypatch: pytest.MonkeyPatch) -> None:
    """As in a program of our own."""
    monkeypatch.setattr(forks, "_allowed", True)


@pytest.mark.parametrize("jobs", [1, 2, 5])
def test_results_keep_their_order(jobs: int) -> None:
    seen = [object() for _ in range(7)]  # not to be pickled, and not needing to be
    found = fork_map(lambda k: (k, id(seen[k])), range(7), jobs)
    assert found == [(k, id(seen[k])) for k in range(7)]


def test_several_processes_do_the_work() -> None:
    def work(_: int) -> int:
        time.sleep(0.05)
        return os.getpid()

    assert len(set(fork_map(work, range(6), 2))) == 2
    assert set(fork_map(work, range(2), 1)) == {os.getpid()}


def test_nothing_is_forked_where_nobody_allowed_it(monkeypatch: pytest.MonkeyPatch) -> None:
    """A notebook has threads of its own, and a fork of it may wait for ever."""
    monkeypatch.setattr(forks, "_allowed", False)
    assert set(fork_map(lambda _: os.getpid(), range(6), 2)) == {os.getpid()}


@pytest.mark.parametrize("jobs", [1, 3])
def test_an_error_comes_through(jobs: int) -> None:
    def work(k: int) -> int:
        if k == 2:
            raise GeometryError("drum: no solid")
        return k

    with pytest.raises(GeometryError, match="drum: no solid"):
        fork_map(work, range(4), jobs)
    assert fork_map(abs, [-1, 2], jobs) == [1, 2]


@pytest.mark.parametrize("deaths", [1, 3])
def test_a_worker_that_is_killed_is_replaced_three_times(deaths: int, tmp_path: Path) -> None:
    """As the system does for want of memory; the caller waited for ever."""

    def work(k: int) -> int:
        if k == 1 and len(died := list(tmp_path.iterdir())) < deaths:
            (tmp_path / str(len(died))).touch()
            os.kill(os.getpid(), signal.SIGKILL)
        return k

    if deaths == 1:
        assert fork_map(work, range(4), 2) == [0, 1, 2, 3]
    else:
        with pytest.raises(MbcdmError, match="killed 3 times at the same work, perhaps for want of memory"):
            fork_map(work, range(4), 2)


def test_interrupted_workers_say_nothing() -> None:
    """Ctrl-C reaches them too; what it means is for the main process to say."""
    program = (
        "import os, signal, time; from mbcdm_cad.parallel.forks import allow_processes, forked; allow_processes()\n"
        "signal.signal(signal.SIGINT, signal.default_int_handler)\n"  # a shell's background job would ignore it
        f"def work(_): os.write(1, b'begun\\n'); time.sleep({PATIENCE_S})\n"
        "def look(): os.write(1, b'waits\\n')\n"
        "try:\n"
        "  with forked(work, range(4), 2) as results: results(look)\n"
        "except KeyboardInterrupt: print('stopped')\n"
    )
    words, pipe = [sys.executable, "-c", program], subprocess.PIPE
    with subprocess.Popen(words, stdout=pipe, stderr=pipe, text=True, start_new_session=True) as running:
        assert running.stdout is not None
        try:
            lines = iter(running.stdout.readline, "")
            seen: list[str] = []
            while seen.count("begun\n") < 2 or "waits\n" not in seen:
                seen.append(next(lines))
            os.killpg(running.pid, signal.SIGINT)
            said, wrong = running.communicate(timeout=PATIENCE_S / 2)
        finally:
            with suppress(ProcessLookupError):
                os.killpg(running.pid, signal.SIGKILL)
    assert (said.replace("waits\n", ""), wrong) == ("stopped\n", "")


def test_nothing_to_do() -> None:
    assert fork_map(abs, [], 4) == []


def test_forked_work_goes_on_while_this_process_does_something_else(tmp_path: Path) -> None:
    with forked(lambda k: (tmp_path / str(k)).write_text(str(os.getpid())), range(3), 2) as results:
        end = time.monotonic() + PATIENCE_S
        while len(list(tmp_path.iterdir())) < 3:  # before anybody has asked for the results
            assert time.monotonic() < end, list(tmp_path.iterdir())
            time.sleep(0.01)
        assert len(results()) == 3
    assert str(os.getpid()) not in {path.read_text() for path in tmp_path.iterdir()}


@pytest.mark.parametrize("jobs", [1, 2])
def test_first_results_are_there_before_the_others(jobs: int, tmp_path: Path) -> None:
    def work(k: int) -> int:
        if k == 2:
            end = time.monotonic() + PATIENCE_S
            while not (tmp_path / "go").exists() and time.monotonic() < end:
                time.sleep(0.01)
        (tmp_path / f"done-{k}").touch()
        return k * k

    with forked(work, range(4), jobs) as results:
        assert results(first=2) == [0, 1]
        assert not (tmp_path / "done-2").exists()
        (tmp_path / "go").touch()
        assert results() == [0, 1, 4, 9] and results(first=1) == [0]


@pytest.mark.parametrize("jobs", [1, 2])
def test_who_waits_for_forked_work_may_give_up_and_ends_it(jobs: int) -> None:
    def stop() -> None:
        raise InterruptedError

    began = time.monotonic()
    with pytest.raises(InterruptedError), forked(lambda _: time.sleep(PATIENCE_S), range(4), jobs) as results:
        results(stop)
    assert time.monotonic() - began < PATIENCE_S / 2
    assert fork_map(abs, [-1, 2], jobs) == [1, 2]


PRELOAD = "mbcdm_cad.parallel.worker"


TWO_MISTAKES = (
    Problem("a.yaml", 3, "drum.web_mm", "not a number", "x", "1 to 9 mm", "write the bare number"),
    Problem("a.yaml", 7, "rope", "missing", missing=True, may_move=True),
)


def square(k: int) -> int:
    """What the workers do; the first takes the longest, 13 and 14 fail."""
    if k == 13:
        raise GeometryError("drum: no solid")
    if k == 14:
        raise InputError(TWO_MISTAKES)
    time.sleep(0.02 if k == 0 else 0.0)
    return k * k


@pytest.fixture
def own(monkeypatch: pytest.MonkeyPatch) -> None:
    """As in a program of our own, on a machine where nobody waits long."""
    monkeypatch.setattr(forks, "_allowed", True)
    monkeypatch.setattr(cluster, "LOOK_S", 0.05)


@contextmanager
def cluster_of(count: int, **how: str) -> Iterator[LocalCluster]:
    """A scheduler with so many workers, all threads of this process."""
    local = {"processes": False, "threads_per_worker": 1, "dashboard_address": ":0", "silence_logs": logging.CRITICAL}
    with LocalCluster(n_workers=count, **local, **how) as found:
        yield found


@pytest.mark.parametrize("workers", [1, 2, 5])
def test_results_keep_the_order_of_the_arguments(own: None, workers: int) -> None:
    with crew(square, workers) as found:
        assert list(found.results(range(7))) == [k * k for k in range(7)]
        assert list(found.results([])) == []
        with pytest.raises(GeometryError, match="drum: no solid"):
            list(found.results([1, 13, 2]))
        assert list(found.results([4])) == [16]


STOPPED = """
import signal, time
from mbcdm_cad.parallel.forks import crew
from mbcdm_cad.parallel.forks import allow_processes

signal.signal(signal.SIGINT, signal.default_int_handler)  # a shell's background job would ignore it
allow_processes()
try:
    with crew(time.sleep, 2) as found:
        print("begun", flush=True)
        list(found.results([PATIENCE] * 9))
except KeyboardInterrupt:
    print("stopped", flush=True)
    time.sleep(0.5)
"""


@pytest.mark.parametrize("between_s", [0.0, 0.002, 0.1])
def test_a_search_interrupted_twice_with_all_its_workers_ends(between_s: float) -> None:
    """Ctrl-C, and ``timeout -s INT``, which sends two at once, reach the workers too."""
    words = [sys.executable, "-c", STOPPED.replace("PATIENCE", f"{PATIENCE_S}")]
    running = subprocess.Popen(words, stdout=subprocess.PIPE, text=True, start_new_session=True)
    assert running.stdout is not None and running.stdout.readline() == "begun\n"
    try:
        time.sleep(0.3)
        os.killpg(running.pid, signal.SIGINT)
        time.sleep(between_s)
        os.killpg(running.pid, signal.SIGINT)
        said, _ = running.communicate(timeout=PATIENCE_S / 2)
        with pytest.raises(ProcessLookupError):
            os.killpg(running.pid, signal.SIGKILL)
    finally:
        with suppress(ProcessLookupError):
            os.killpg(running.pid, signal.SIGKILL)
    assert said == "stopped\n"


def test_a_mistake_in_a_file_comes_back_whole(own: None) -> None:
    with crew(square, 2) as found, pytest.raises(InputError) as raised:
        list(found.results([1, 14]))
    assert raised.value.problems == TWO_MISTAKES
    assert str(raised.value) == "\n".join(map(str, TWO_MISTAKES))


def test_a_cluster_gives_the_same(own: None) -> None:
    with cluster_of(2, preload=PRELOAD) as many, crew(square, scheduler=many.scheduler_address) as found:
        with pytest.raises(InputError) as raised:
            list(found.results([1, 14]))
        assert raised.value.problems == TWO_MISTAKES
        assert list(found.results(range(7))) == [k * k for k in range(7)]
        assert list(found.results([])) == []
        with pytest.raises(GeometryError, match="drum: no solid"):
            list(found.results([1, 13, 2]))
        half = found.results(range(7))
        assert next(half) == 0
        half.close()
        assert list(found.results([4])) == [16]


def test_a_worker_that_does_not_show_its_state_is_refused_and_a_late_one_does_the_work(
    own: None, caplog: pytest.LogCaptureFixture
) -> None:
    with cluster_of(1) as many, crew(square, scheduler=many.scheduler_address) as found, ThreadPoolExecutor(1) as aside:
        waits = aside.submit(list, found.results(range(3)))
        end = time.monotonic() + PATIENCE_S
        while "waiting for one with" not in caplog.text and time.monotonic() < end:
            time.sleep(0.01)
        assert "gets no work: it was started without --preload mbcdm_cad.parallel.worker" in caplog.text
        assert not waits.done()
        many.new_spec["options"]["preload"] = PRELOAD
        many.scale(2)
        assert waits.result(PATIENCE_S) == [0, 1, 4]
    assert caplog.text.count("waiting for one with") == 1


def test_a_scheduler_that_ends_is_told(own: None) -> None:
    with ThreadPoolExecutor(1) as aside:
        with cluster_of(0) as many:
            found = crew(square, scheduler=many.scheduler_address)
            waits = aside.submit(list, found.results(range(3)))
            time.sleep(0.2)
        with pytest.raises(MbcdmError, match="the connection was lost"):
            waits.result(PATIENCE_S)
        found.__exit__(None, None, None)


def test_no_scheduler_is_told_with_the_remedy(own: None, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(cluster, "ANSWER_S", 0.2)
    with pytest.raises(MbcdmError, match=r"--scheduler tcp://127.0.0.1:9: no dask scheduler answers within 0.2 s"):
        crew(square, scheduler="tcp://127.0.0.1:9")


def test_a_state_is_that_of_the_package() -> None:
    assert state() == state() and state().startswith("mbcdm_cad 0.1.0 ") and len(state().split()[2]) == 12


def double(k: int) -> int:
    return 2 * k


def test_a_function_of_a_program_is_found_by_its_name() -> None:
    found = pickle.loads(pickle.dumps(Named.of(double)))
    assert found.module == "tests.unit.parallel.test_forks" and found(21) == 42


def test_other_tests_are_refused() -> None:
    with pytest.raises(MbcdmError, match="check out the same state"):
        replace(Named.of(double), state="another")(21)


def test_results_come_in_order() -> None:
    assert list(run_many(double, iter(range(5)), argparse.Namespace(workers=1, scheduler=None))) == [0, 2, 4, 6, 8]
