"""The drawing process of ``mbcdm watch``: it keeps the kernel loaded and drops a job when a newer one waits."""

from __future__ import annotations

import signal
from dataclasses import dataclass
from multiprocessing.connection import Connection
from pathlib import Path

from mbcdm_cad.checks.comparison import CheckResult
from mbcdm_cad.errors import MbcdmError
from mbcdm_cad.layouts.loader import load_text
from mbcdm_cad.parallel.forks import allow_processes
from mbcdm_cad.storage.cache import Cache, cache_folder

# The browser loads the new page meanwhile, for which it needs a core.
_CABLES_AFTER_S = 1.2


@dataclass(frozen=True)
class Job:
    """Draw the design of ``text``, which has passed its ``checks``; ``number`` counts the saves.

    With ``built``, the folder of its whole build, the page is made from that build's report instead.
    """

    number: int
    path: Path
    text: str
    checks: tuple[CheckResult, ...]
    built: Path | None = None


@dataclass(frozen=True)
class Drawn:
    """The result of a job: a page, or ``problem`` in words."""

    number: int
    page: bytes = b""
    written: tuple[str, ...] = ()
    problem: str = ""
    whole: bool = False


class _SupersededError(Exception):
    """Raised to stop a job when a newer one waits."""


def work(connection: Connection, folder: Path, use_cache: bool) -> None:
    """Draw the jobs that arrive through ``connection`` until None arrives or the other end is closed."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is for the process that watches; it closes the connection
    # Imported here, so that the process that starts this one needs no kernel; this process loads it before the first
    # job.
    from mbcdm_cad.live.preview import Previewer

    allow_processes()

    def look() -> None:
        if connection.poll():
            raise _SupersededError

    previewer = Previewer(folder, Cache(cache_folder() if use_cache else None), look)
    try:
        while (job := _newest(connection)) is not None:
            try:
                loaded = load_text(job.text, job.path)
                if job.built is not None:
                    page = previewer.complete(loaded, job.built, job.checks)
                    connection.send(Drawn(job.number, page, whole=True))
                else:
                    preview = previewer.preview(loaded, job.checks)
                    connection.send(Drawn(job.number, preview.page, preview.written))
                    if not connection.poll(_CABLES_AFTER_S):
                        previewer.draw_cables()
            except _SupersededError:
                continue
            except (MbcdmError, OSError) as error:
                connection.send(Drawn(job.number, problem=str(error)))
    except (EOFError, BrokenPipeError):
        return


def _newest(connection: Connection) -> Job | None:
    job: Job | None = connection.recv()
    while job is not None and connection.poll():
        job = connection.recv()
    return job
