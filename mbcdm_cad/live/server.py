"""Serve the page over HTTP to this machine only: secret address, page, its files, and events of the design.

:class:`WatchState` is what page and terminal show while a design file is followed.
"""

from __future__ import annotations

import asyncio
import hmac
import json
import re
import secrets
from collections.abc import Sequence
from dataclasses import asdict, dataclass, field
from importlib.resources import files
from pathlib import Path
from typing import Any

from aiohttp import web

from mbcdm_cad.errors import MbcdmError
from mbcdm_cad.report.check_report import CheckReport

_WAITING = (
    "<!DOCTYPE html><html lang='en'><head><meta charset='utf-8'><title>mbcdm watch</title>"
    "<meta name='viewport' content='width=device-width, initial-scale=1'></head>"
    "<body style='font-family:system-ui;margin:3em'><h1>Drawing the design</h1>"
    "<p>The page appears here as soon as its parts are drawn.</p></body></html>"
)
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

    def to_dict(self) -> dict[str, Any]:
        """As plain data, for the page."""
        return asdict(self)

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
    text = page.decode() if page is not None else _WAITING
    script = files("mbcdm_cad.live").joinpath("assets/live.js").read_text("utf-8")
    own = f"<script>window.liveDrive={{page:{number}}};</script><script>{script}</script></body></html>"
    return _END.sub(lambda _: own, text).encode()


HOST = "127.0.0.1"
_HEADERS = {"Cache-Control": "no-store", "Referrer-Policy": "no-referrer", "X-Content-Type-Options": "nosniff"}


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
        self._listeners: set[asyncio.Queue[str | None]] = set()
        self._runner: web.AppRunner | None = None
        self._port = 0

    @property
    def address(self) -> str:
        """Address of the page."""
        return f"http://{HOST}:{self._port}/{self._token}/"

    async def start(self, port: int) -> None:
        """Listen on ``port`` of the loopback, 0 for any free one. Raises ``MbcdmError`` where it is taken."""
        app = web.Application()
        app.router.add_get("/{token}/", self._page)
        app.router.add_get("/{token}/events", self._events)
        app.router.add_get("/{token}/{file:.+}", self._file)
        self._runner = web.AppRunner(app, access_log=None, shutdown_timeout=0.5)
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
        for queue in self._listeners:
            queue.put_nowait(None)
        if self._runner is not None:
            await self._runner.cleanup()

    def tell(self) -> None:
        """Send the state to every open page."""
        text = json.dumps(self.state.to_dict())
        for queue in self._listeners:
            queue.put_nowait(text)

    def _refuse_strangers(self, request: web.Request) -> None:
        named = request.host in (f"{HOST}:{self._port}", f"localhost:{self._port}")
        token = request.match_info["token"]
        if not (named and hmac.compare_digest(token.encode(), self._token.encode())):
            raise web.HTTPNotFound

    async def _page(self, request: web.Request) -> web.Response:
        self._refuse_strangers(request)
        body = live_page(self.page, self.state.page)
        return web.Response(body=body, content_type="text/html", charset="utf-8", headers=_HEADERS)

    async def _events(self, request: web.Request) -> web.StreamResponse:
        self._refuse_strangers(request)
        response = web.StreamResponse(headers={**_HEADERS, "Content-Type": "text/event-stream"})
        await response.prepare(request)
        queue: asyncio.Queue[str | None] = asyncio.Queue()
        self._listeners.add(queue)
        try:
            text: str | None = json.dumps(self.state.to_dict())
            while text is not None:
                await response.write(f"data: {text}\n\n".encode())
                text = await queue.get()
        except ConnectionResetError:
            pass
        finally:
            self._listeners.discard(queue)
        return response

    async def _file(self, request: web.Request) -> web.FileResponse:
        self._refuse_strangers(request)
        for folder in self._folders:
            root = folder.resolve()
            path = (root / request.match_info["file"]).resolve()
            if path.is_relative_to(root) and path.is_file():
                return web.FileResponse(path, headers=_HEADERS)
        raise web.HTTPNotFound
