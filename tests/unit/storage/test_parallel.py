"""Work on several processes gives what it gives on one."""

from __future__ import annotations

import os
import time

import pytest

from mbcdm_cad.build.errors import GeometryError
from mbcdm_cad.storage import parallel
from mbcdm_cad.storage.parallel import fork_map


@pytest.fixture(autouse=True)
def allowed(monkeypatch: pytest.MonkeyPatch) -> None:
    """As in a program of our own."""
    monkeypatch.setattr(parallel, "_allowed", True)


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
    monkeypatch.setattr(parallel, "_allowed", False)
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


def test_nothing_to_do() -> None:
    assert fork_map(abs, [], 4) == []
