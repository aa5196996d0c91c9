"""The state that page and terminal show while a design file is followed."""

from __future__ import annotations

import re
from dataclasses import asdict, dataclass, field
from importlib.resources import files
from typing import Any

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
