"""The result of a build: a summary in a few lines, and its report as plain data.

The command line prints it, the Python API returns it.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from mbcdm_cad.report.check_report import CheckReport
from mbcdm_cad.report.table import preformatted


@dataclass(frozen=True)
class BuildReport:
    """Outcome of a build: ``folder`` is None where it was refused, ``data`` is report.json where parts were drawn.

    ``made`` names the parts that had to be drawn; ``unchanged``: the folder already contained everything.
    ``cache_problem``: why the cache could not be used, in one sentence; else empty.
    """

    name: str
    folder: Path | None
    checks: CheckReport
    data: dict[str, Any] | None
    made: tuple[str, ...]
    unchanged: bool = False
    cache_problem: str = ""

    @property
    def passed(self) -> bool:
        """Whether it was built and no check fails, of the design or of what was built."""
        return self.folder is not None and self.checks.passed

    def text(self) -> str:
        """What ``mbcdm build`` prints."""
        if self.folder is None or self.data is None:
            failed = ", ".join(check.id for check in self.checks.failed)
            return f"{self.name}: not built, {len(self.checks.failed)} check(s) fail: {failed}"
        mass, box, run = (self.data[key] for key in ("mass", "envelope", "interference"))
        counts = self.checks.counts
        some = f": {', '.join(self.made)}" if 0 < len(self.made) < 6 else ""
        drawn = "nothing changed" if self.unchanged else f"{len(self.made)} made{some}"
        size = " x ".join(f"{v:.2f}" for v in box["size_mm"])
        heavy = "" if mass["target_g"] is None else f" (target {mass['target_g']:g} +- {mass['tolerance_g']:g})"
        asked = "" if box["target_mm"] is None else f" (target {' x '.join(f'{v:g}' for v in box['target_mm'])})"
        lines = [
            f"{self.folder}: {drawn}",
            f"  mass {mass['mass_g']:.1f} g +- {mass['sigma_g']:.1f}{heavy}",
            f"  box X x Z x Y {size} mm{asked}",
            f"  interference: {len(run['clashes'])} clashes at {len(run['poses_deg'])} poses",
            f"  checks: {counts['fail']} fail, {counts['warn']} warn, of {len(self.checks)}; see report.md",
        ]
        if self.data["forced"]:
            lines.insert(1, f"  FORCED although these fail: {', '.join(self.data['failed_checks'])}")
        return "\n".join(lines)

    def __str__(self) -> str:
        """As :meth:`text`."""
        return self.text()

    def _repr_html_(self) -> str:
        """For notebooks: the text, then the checks that do not simply pass."""
        return preformatted(self.text()) + self.checks._repr_html_()

    def to_dict(self) -> dict[str, Any]:
        """The content of report.json, ready for JSON; for a refused build only the results of the checks."""
        return self.data if self.data is not None else {"checks": self.checks.to_dict()["checks"]}
