"""The command ``mbcdm``, to which all others belong, and what they share: options, examples on help pages."""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import click

from mbcdm_cad import __version__

FILE = click.Path(path_type=Path)
DESIGN = click.argument("design", type=FILE)


def _seconds(_context: click.Context, _parameter: click.Parameter, value: str | None) -> float | None:
    """The seconds of ``300s``, ``5min`` or ``2h``; a number without unit is in seconds."""
    if value is None:
        return None
    found = re.fullmatch(r"(\d+\.?\d*) *(s|min|h)?", value)
    if found is None:
        raise click.BadParameter(f"{value} is not a time; write 300s, 5min or 2h, say")
    return float(found[1]) * {"min": 60.0, "h": 3600.0}.get(found[2], 1.0)


TIME = click.option(
    "--time", "time_s", metavar="TIME", default=None, callback=_seconds, help="Stop after this time: 300s, 5min, 2h."
)


def examples(*lines: str) -> str:
    """Lines for the end of a help page; the mark prevents click from joining them to a paragraph."""
    return "\b\n" + "\n".join(["Examples:" if len(lines) > 1 else "Example:", *(f"  {line}" for line in lines)])


def out_folder(text: str) -> Callable[[Any], Any]:
    """The option ``--out``, described by ``text``."""
    return click.option("--out", type=FILE, default=Path("out"), show_default=True, metavar="DIR", help=text)


def _finite(_context: click.Context, _parameter: click.Parameter, value: float) -> float:
    if not math.isfinite(value):
        raise click.BadParameter(f"{value} is not an angle; give degrees within the travel, such as 12.5")
    return value


ANGLE = click.option(
    "--angle", "angle_deg", type=float, default=0.0, metavar="DEG", callback=_finite, help="Drum angle of the assembly."
)
NO_CACHE = click.option("--no-cache", is_flag=True, help="Neither read nor write the cache.")
JOBS = click.option(
    "--jobs", type=click.IntRange(1, 64), default=None, metavar="N", help="Number of processes; all cores by default."
)

WORKERS = click.option("--workers", type=click.IntRange(1, 64), metavar="N", help="Processes; all cores by default.")
SCHEDULER = click.option(
    "--scheduler", metavar="ADDRESS", help="Run on the workers of this dask scheduler, tcp://HOST:PORT, instead."
)


@click.group(
    context_settings={"help_option_names": ["-h", "--help"]},
    epilog=examples(
        "mbcdm init my_drive.yaml     a short file with the requirements",
        "mbcdm check my_drive.yaml    a fraction of a second, no CAD",
        "mbcdm build my_drive.yaml    STEP, STL, GLB, report into out/my_drive",
    ),
)
@click.version_option(__version__, prog_name="mbcdm")
def mbcdm() -> None:
    """Cable drives from a design file: checks, parts, report, model, loop.

    Exit codes: 0 done, 1 a check failed, 2 bad input. Completion for the shell: see docs/command-line.md.
    """
