"""Work on several processes gives the same result as on one."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from contextlib import suppress
from pathlib import Path

import pytest

from mbcdm_cad.errors import GeometryError
from mbcdm_cad.parallel import forks
from mbcdm_cad.parallel.forks import fork_map, forked
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
