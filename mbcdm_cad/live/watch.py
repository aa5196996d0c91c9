"""``mbcdm watch``: after each save of a design file run the checks, draw the changed parts, update the page, build all.

The checks run in this process, which needs no kernel. A second process keeps the kernel loaded and draws the changed
parts. A third process makes the complete build with its interference run; a newer save ends it at once.
"""

from __future__ import annotations

import asyncio
import contextlib
import multiprocessing
import os
import signal
import sys
import time
from collections.abc import Callable
from dataclasses import dataclass
from multiprocessing.connection import Connection
from pathlib import Path

import watchfiles

from mbcdm_cad.checks.comparison import CheckResult
from mbcdm_cad.design.loaded import LoadedDesign
from mbcdm_cad.errors import MbcdmError
from mbcdm_cad.layouts.loader import load_text
from mbcdm_cad.live.server import Server, WatchState
from mbcdm_cad.live.worker import Drawn, Job, work
from mbcdm_cad.report.check_report import check_design

# Changes within this time, ms, count as one save: some editors save in several steps.
_GATHER_MS = 40
_LOOK_MS = 10
# Interval, ms, at which the wait for a save tests whether the process should end.
_END_MS = 300
# The whole build begins when the browser has loaded the new page, with low priority, since the next save is urgent.
_BUILD_AFTER_S = 1.5
_BUILD_NICENESS = 10

Say = Callable[[str], None]


@dataclass(frozen=True)
class Watched:
    """The design file and the output folders: ``folder`` of the whole build, ``live`` of the preview."""

    path: Path
    out: Path
    name: str
    use_cache: bool

    @property
    def folder(self) -> Path:
        """The design's output folder, as `mbcdm build` writes it."""
        return self.out / self.name

    @property
    def live(self) -> Path:
        """Folder of the parts after the newest save, before the whole build."""
        return self.out / f"{self.name}-live"


class Watch:
    """Follows one design file until it is cancelled."""

    def __init__(self, watched: Watched, say: Say) -> None:
        self._watched = watched
        self._say = say
        self._state = WatchState()
        self.server = Server(self._state, (watched.live, watched.folder))
        self._loaded: LoadedDesign | None = None
        self._checks: tuple[CheckResult, ...] = ()
        self._saved_s = 0.0
        self._build: asyncio.Task[None] | None = None
        context = multiprocessing.get_context("spawn")
        self._worker, other = context.Pipe()
        self._process = context.Process(target=work, args=(other, watched.live, watched.use_cache), daemon=False)
        self._others_end: Connection = other

    async def run(self, port: int) -> None:
        """Serve and follow. Raises ``MbcdmError`` where the port is taken."""
        await self.server.start(port)
        self._process.start()
        self._others_end.close()
        loop = asyncio.get_running_loop()
        loop.add_reader(self._worker.fileno(), self._drawn)
        try:
            self._say(f"{self.server.address}\nfollows {self._watched.path}; Ctrl-C ends it")
            await self._changed()
            folder, name = self._watched.path.resolve().parent, self._watched.path.name
            async for _ in watchfiles.awatch(
                folder,
                watch_filter=lambda change, path: Path(path).name == name,
                debounce=_GATHER_MS,
                step=_LOOK_MS,
                recursive=False,
                rust_timeout=_END_MS,
            ):
                await self._changed()
        finally:
            loop.remove_reader(self._worker.fileno())
            await self._stop_build()
            await self.server.stop()
            self._worker.close()
            self._process.join(timeout=1.0)
            if self._process.is_alive():
                self._process.kill()

    async def _changed(self) -> None:
        """Read the file, check it, and have it drawn if all checks pass."""
        self._saved_s = time.perf_counter()
        path, state = self._watched.path, self._state
        try:
            text = path.read_bytes().decode("utf-8")
        except FileNotFoundError:
            return  # between the two steps of an editor that saves by rename
        except (OSError, UnicodeDecodeError) as error:
            await self._refused(f"{path}: cannot be read: {error}")
            return
        if self._loaded is not None and text == self._loaded.text and state.stage != "broken":
            return
        state.save += 1
        await self._stop_build()
        try:
            loaded = load_text(text, path)
            report = check_design(loaded)
        except MbcdmError as error:
            await self._refused(str(error))
            return
        if loaded.drive.name != self._watched.name:
            await self._refused(f"{path}: name: changed to {loaded.drive.name}; end this and start it again for it")
            return
        self._loaded, self._checks = loaded, report.results
        state.judged(report)
        self.server.tell()
        counts = report.counts
        self._say(f"save {state.save}: {counts['fail']} fail, {counts['warn']} warn of {len(report)} ({self._since()})")
        for check in report.failed:
            self._say(f"  fail: {check.id}: {check.message}; {check.remedy}")
        if report.passed:
            self._worker.send(Job(state.save, path, text, report.results))

    async def _refused(self, message: str) -> None:
        self._state.stage, self._state.message = "broken", message
        self._state.counts, self._state.findings = {}, []
        self.server.tell()
        self._say(message)

    def _drawn(self) -> None:
        """Receive the results of the worker: the page of the newest save is used, others are dropped."""
        try:
            drawn: Drawn = self._worker.recv()
        except EOFError:
            asyncio.get_running_loop().remove_reader(self._worker.fileno())
            self._say("the process that draws has ended; end this one with Ctrl-C and start it again")
            return
        if drawn.number != self._state.save or self._state.stage in ("broken", "failing"):
            return
        if drawn.problem:
            self._state.stage, self._state.message = "failing", drawn.problem
            self.server.tell()
            self._say(f"  not drawn: {drawn.problem}")
            return
        self.server.page = drawn.page
        self._state.page += 1
        self._state.stage = "built" if drawn.whole else "page"
        self.server.tell()
        if drawn.whole:
            self._say(f"  built {self._watched.folder} ({self._since()})")
            return
        written = f"{len(drawn.written)} parts" if len(drawn.written) > 5 else ", ".join(drawn.written) or "no part"
        self._say(f"  page: {written} drawn ({self._since()})")
        self._build = asyncio.create_task(self._whole_build(drawn.number))

    async def _whole_build(self, number: int) -> None:
        """`mbcdm build` in a process group of its own, so that all of it ends when a newer save comes."""
        await asyncio.sleep(_BUILD_AFTER_S)
        watched = self._watched
        arguments = [sys.executable, "-m", "mbcdm_cad", "build", str(watched.path), "--out", str(watched.out)]
        process = await asyncio.create_subprocess_exec(
            *arguments,
            *(() if watched.use_cache else ("--no-cache",)),
            stdout=asyncio.subprocess.DEVNULL,
            stderr=asyncio.subprocess.PIPE,
            start_new_session=True,
        )
        with contextlib.suppress(ProcessLookupError):
            os.setpriority(os.PRIO_PROCESS, process.pid, _BUILD_NICENESS)
        try:
            _, errors = await process.communicate()
        except asyncio.CancelledError:
            with contextlib.suppress(ProcessLookupError):
                os.killpg(process.pid, signal.SIGKILL)
            await process.wait()
            raise
        if process.returncode == 0 and self._loaded is not None:
            self._worker.send(Job(number, watched.path, self._loaded.text, self._checks, built=watched.folder))
            return
        lines = [line for line in errors.decode().splitlines() if not line.startswith("making ")]
        self._state.stage, self._state.message = "failing", "\n".join(lines)
        self.server.tell()
        self._say("\n".join(f"  {line}" for line in lines))

    async def _stop_build(self) -> None:
        if self._build is not None:
            self._build.cancel()
            with contextlib.suppress(asyncio.CancelledError):
                await self._build
            self._build = None

    def _since(self) -> str:
        return f"{time.perf_counter() - self._saved_s:.2f} s"
