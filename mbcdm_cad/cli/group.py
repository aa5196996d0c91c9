"""The command ``mbcdm`` and what all commands share: options, examples on help pages, terminal, progress."""

import json
import math
import os
import re
import shutil
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import click

from mbcdm_cad import __version__, api
from mbcdm_cad.storage.cache import rounded


def screen_width() -> int | None:
    """Columns to wrap text at; None if the output goes to a file or a pipe and COLUMNS is not set."""
    if sys.stdout.isatty() or os.environ.get("COLUMNS", "").isdigit():
        return shutil.get_terminal_size().columns
    return None


def print_json(content: Any) -> None:
    """Print plain data as JSON."""
    click.echo(json.dumps(rounded(content), indent=1, allow_nan=False))


def print_report(report: Any, as_json: bool) -> None:
    """Print a report as JSON or as text."""
    if as_json:
        print_json(report.to_dict())
    else:
        click.echo(report.text(screen_width()))


def coloured() -> bool:
    """Whether to use colours: on a terminal that has some, unless NO_COLOR is set (see no-color.org)."""
    return sys.stdout.isatty() and "NO_COLOR" not in os.environ and os.environ.get("TERM") != "dumb"


@contextmanager
def sign_of_life(what: str) -> Iterator[None]:
    """A line on a terminal's standard error while ``what`` takes longer than two seconds; gone at the end."""
    if not sys.stderr.isatty():
        yield
        return
    shown = threading.Event()

    def show() -> None:
        shown.set()
        print(f"{what} ...", end="\r", file=sys.stderr, flush=True)

    timer = threading.Timer(_PATIENCE_S, show)
    timer.daemon = True
    timer.start()
    try:
        yield
    finally:
        timer.cancel()
        timer.join()
        if shown.is_set():
            print("\r\x1b[K", end="", file=sys.stderr, flush=True)


_PATIENCE_S = 2.0


def load(path: Path) -> api.DriveDesign:
    """The design of a file, with a sign of life while its rules size it."""
    with sign_of_life(f"{path}: sizing"):
        return api.load(path)


@contextmanager
def progress() -> Iterator[Callable[[str], None]]:
    """A function that is told each item while it is made: a spinner on a terminal, lines if the output is piped."""
    if not sys.stderr.isatty():
        yield lambda name: print(f"making {name}", file=sys.stderr, flush=True)
        return
    from rich.console import Console  # only where a terminal shows it

    console = Console(stderr=True)
    with console.status("reading") as status:
        yield lambda name: status.update(f"making {name}")


@contextmanager
def progress_of_trials(every: int = 20, *, stages: bool = True) -> Iterator[Callable[[str, int], None]]:
    """A function that is told the stage of a search and its trials: a line on a terminal, some lines if piped.

    These tell of every so many trials, and of each stage with ``stages``.
    """
    if sys.stderr.isatty():
        from rich.console import Console  # only where a terminal shows it

        with Console(stderr=True).status("searching") as status:
            yield lambda stage, count: status.update(f"{count} trials: {stage}")
        return
    last: tuple[str, int] = ("", -every)

    def told(stage: str, count: int) -> None:
        nonlocal last
        if (stages and stage != last[0]) or count >= last[1] + every:
            last = stage, count
            print(f"{count} trials: {stage}", file=sys.stderr, flush=True)

    yield told


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

    Exit codes: 0 done, 1 a check failed, 2 bad input, 70 a fault of the program. Completion for the shell: see
    docs/command-line.md.
    """
