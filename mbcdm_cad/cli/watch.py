"""The command ``watch``."""

from __future__ import annotations

import asyncio
import contextlib
import signal
from collections.abc import Coroutine
from pathlib import Path
from typing import Any

import click

from mbcdm_cad.layouts.loader import load_design
from mbcdm_cad.live.watch import Watch, Watched


def watch_command(path: Path, *, out: Path, port: int, use_cache: bool) -> int:
    """Follow a design file until Ctrl-C. 0 then."""
    name = load_design(path).drive.name
    watch = Watch(Watched(path, out, name, use_cache), lambda text: click.echo(text))
    with contextlib.suppress(asyncio.CancelledError):
        asyncio.run(_until_told(watch.run(port)))
    return 0


async def _until_told(following: Coroutine[Any, Any, None]) -> None:
    """Run until Ctrl-C or SIGTERM, so that the processes that were started always end with this one."""
    task = asyncio.ensure_future(following)
    loop = asyncio.get_running_loop()
    for told in (signal.SIGINT, signal.SIGTERM):
        loop.add_signal_handler(told, task.cancel)
    await task
