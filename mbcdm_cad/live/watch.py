"""``mbcdm watch``: after each save of a design file run the checks, draw the changed parts, update the page, build all.

The checks run in this process, which needs no kernel. A second process keeps the kernel loaded and draws the changed
parts. A third process makes the complete build with its interference run; a newer save ends it at once. The page is
served over HTTP to this machine only, at a secret address.
"""

import asyncio
import contextlib
import hmac
import json
import multiprocessing
import os
import re
import secrets
import signal
import sys
import time
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass, field
from importlib.resources import files
from multiprocessing.connection import Connection
from pathlib import Path

import watchfiles
from aiohttp import web
from aiohttp.typedefs import Handler

from mbcdm_cad.checks.comparison import CheckResult
from mbcdm_cad.design.loader import LoadedDesign
from mbcdm_cad.errors import MbcdmError
from mbcdm_cad.layouts.loader import load_design, load_text
from mbcdm_cad.live.preview import Drawn, Job, work
from mbcdm_cad.report.check_report import CheckReport, check_design
from mbcdm_cad.report.page.template import page_environment

_END = re.compile(r"</body>\s*</html>\s*$")


@dataclass
class WatchState:
    """The newest save, the results of its checks, and the page that is shown.

    ``stage`` is one of broken (the file cannot be read), failing (a check fails), drawing, page (parts drawn, the rest
    not yet tested) and built (the whole build stands). ``page`` counts the pages made; the last good one stays.
    """

    save: int = 0
    stage: str = "drawing"
    message: str = ""
    counts: dict[str, int] = field(default_factory=dict)
    findings: list[dict[str, str]] = field(default_factory=list)
    page: int = 0

    def judged(self, report: CheckReport) -> None:
        """Take over the results of the checks."""
        self.stage = "drawing" if report.passed else "failing"
        self.message = ""
        self.counts = report.counts
        found = (*report.failed, *report.warnings)
        self.findings = [
            {"id": c.id, "status": c.status, "message": c.message, "remedy": c.remedy or ""} for c in found
        ]


def live_page(page: bytes | None, number: int) -> bytes:
    """A report page that follows the design: it shows the state and reloads when a newer page exists."""
    waiting = page_environment(("mbcdm_cad.live", "assets")).get_template("waiting.html.j2")
    text = waiting.render() if page is None else page.decode()
    script = files("mbcdm_cad.live").joinpath("assets/live.js").read_text("utf-8")
    own = f"<script>window.liveDrive={{page:{number}}};</script><script>{script}</script></body></html>"
    return _END.sub(lambda _: own, text).encode()


HOST = "127.0.0.1"
_HEADERS = {"Cache-Control": "no-store", "Referrer-Policy": "no-referrer", "X-Content-Type-Options": "nosniff"}
# Time, s, after which a connection without a whole request ends, and one that does not take what is sent to it; and
# how many are answered at once.
_SLOW_S, _MOST = 10.0, 32


class Server:
    """Serves ``state`` and the newest page. Files come only from ``folders``, from the first that contains the file.

    Every address starts with a random token, and the host must be this machine by name or number, so that no other site
    can read the design through the browser.
    """

    def __init__(self, state: WatchState, folders: Sequence[Path]) -> None:
        self.state = state
        self.page: bytes | None = None
        self._folders = tuple(folders)
        self._token = secrets.token_urlsafe(16)
        # Set when there is a new state, which a new event then takes the place of.
        self._news = asyncio.Event()
        self._ended, self._answered = False, 0
        self._runner: web.AppRunner | None = None
        self._port = 0

    @property
    def address(self) -> str:
        """Address of the page."""
        return f"http://{HOST}:{self._port}/{self._token}/"

    async def start(self, port: int) -> None:
        """Listen on ``port`` of the loopback, 0 for any free one. Raises ``MbcdmError`` where it is taken."""
        app = web.Application(middlewares=[self._bounded])
        app.router.add_get("/{token}/", self._page)
        app.router.add_get("/{token}/events", self._events)
        app.router.add_get("/{token}/{file:.+}", self._file)
        self._runner = web.AppRunner(
            app, access_log=None, shutdown_timeout=0.5, keepalive_timeout=_SLOW_S, handler_cancellation=True
        )
        await self._runner.setup()
        try:
            site = web.TCPSite(self._runner, HOST, port)
            await site.start()
        except OSError as error:
            await self._runner.cleanup()
            raise MbcdmError(f"--port: cannot listen on {HOST}:{port} ({error.strerror}); choose another") from error
        self._port = self._runner.addresses[0][1]

    async def stop(self) -> None:
        """Tell every open page that the process ends, and close."""
        self._ended = True
        self._news.set()
        if self._runner is not None:
            await self._runner.cleanup()

    def tell(self) -> None:
        """Send the state to every open page; one that is slow gets the newest alone."""
        self._news.set()
        self._news = asyncio.Event()

    @web.middleware
    async def _bounded(self, request: web.Request, handler: Handler) -> web.StreamResponse:
        """Answer who knows the address, and no more than so many requests at once, none for long."""
        named = request.host in (f"{HOST}:{self._port}", f"localhost:{self._port}")
        token = request.match_info.get("token", "").encode()
        if not (named and hmac.compare_digest(token, self._token.encode())):
            raise web.HTTPNotFound
        if self._answered >= _MOST:
            raise web.HTTPServiceUnavailable
        self._answered += 1
        try:
            response = await handler(request)
            async with asyncio.timeout(_SLOW_S):
                await response.prepare(request)
                await response.write_eof()
        except (ConnectionError, TimeoutError):  # the page was closed, or does not read
            if request.transport is not None:
                request.transport.abort()
            raise asyncio.CancelledError from None
        finally:
            self._answered -= 1
        return response

    async def _page(self, request: web.Request) -> web.Response:
        body = live_page(self.page, self.state.page)
        return web.Response(body=body, content_type="text/html", charset="utf-8", headers=_HEADERS)

    async def _events(self, request: web.Request) -> web.StreamResponse:
        response = web.StreamResponse(headers={**_HEADERS, "Content-Type": "text/event-stream"})
        await response.prepare(request)
        while not self._ended:
            news = self._news
            async with asyncio.timeout(_SLOW_S):
                await response.write(f"data: {json.dumps(asdict(self.state))}\n\n".encode())
            await news.wait()
        return response

    async def _file(self, request: web.Request) -> web.FileResponse:
        for folder in self._folders:
            with contextlib.suppress(OSError, ValueError):  # no name that a file could have
                root = folder.resolve()
                path = (root / request.match_info["file"]).resolve()
                if path.is_relative_to(root) and path.is_file():
                    return web.FileResponse(path, headers=_HEADERS)
        raise web.HTTPNotFound


# Changes within this time, ms, count as one save: some editors save in several steps.
_GATHER_MS = 40
_LOOK_MS = 10
# Interval, ms, at which the wait for a save tests whether the process should end.
_END_MS = 300
# The whole build begins when the browser has loaded the new page, with low priority, since the next save is urgent.
_BUILD_AFTER_S = 1.5
_BUILD_NICENESS = 10

Say = Callable[[str], None]


class Watch:
    """Follows one design file until it is cancelled: ``out/NAME-live`` has the parts after the newest save at once,
    ``out/NAME`` the whole build."""

    def __init__(self, path: Path, out: Path, name: str, use_cache: bool, say: Say) -> None:
        self._path, self._out, self._name, self._use_cache = path, out, name, use_cache
        self._folder, live = out / name, out / f"{name}-live"
        self._say = say
        self._state = WatchState()
        self.server = Server(self._state, (live, self._folder))
        self._loaded: LoadedDesign | None = None
        self._checks: tuple[CheckResult, ...] = ()
        self._saved_s = 0.0
        self._build: asyncio.Task[None] | None = None
        context = multiprocessing.get_context("spawn")
        self._worker, other = context.Pipe()
        self._process = context.Process(target=work, args=(other, live, use_cache), daemon=False)
        self._others_end: Connection = other

    async def run(self, port: int) -> None:
        """Serve and follow. Raises ``MbcdmError`` where the port is taken."""
        await self.server.start(port)
        self._process.start()
        self._others_end.close()
        loop = asyncio.get_running_loop()
        loop.add_reader(self._worker.fileno(), self._drawn)
        try:
            self._say(f"{self.server.address}\nfollows {self._path}; Ctrl-C ends it")
            await self._changed()
            folder, name = self._path.resolve().parent, self._path.name
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
        path, state = self._path, self._state
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
        if loaded.drive.name != self._name:
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
            self._say(f"  built {self._folder} ({self._since()})")
            return
        written = f"{len(drawn.written)} parts" if len(drawn.written) > 5 else ", ".join(drawn.written) or "no part"
        self._say(f"  page: {written} drawn ({self._since()})")
        self._build = asyncio.create_task(self._whole_build(drawn.number))

    async def _whole_build(self, number: int) -> None:
        """`mbcdm build` in a process group of its own, so that all of it ends when a newer save comes."""
        await asyncio.sleep(_BUILD_AFTER_S)
        arguments = [sys.executable, "-m", "mbcdm_cad", "build", str(self._path), "--out", str(self._out)]
        process = await asyncio.create_subprocess_exec(
            *arguments,
            *(() if self._use_cache else ("--no-cache",)),
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
            self._worker.send(Job(number, self._path, self._loaded.text, self._checks, built=self._folder))
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


def follow(path: Path, *, out: Path, port: int, use_cache: bool) -> None:
    """Follow a design file until Ctrl-C or SIGTERM; what was started always ends with this process."""
    watch = Watch(path, out, load_design(path).drive.name, use_cache, lambda text: print(text, flush=True))

    async def until_told() -> None:
        task = asyncio.ensure_future(watch.run(port))
        for told in (signal.SIGINT, signal.SIGTERM):
            asyncio.get_running_loop().add_signal_handler(told, task.cancel)
        await task

    with contextlib.suppress(asyncio.CancelledError):
        asyncio.run(until_told())
