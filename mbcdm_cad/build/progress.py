"""Progress on standard error: a spinner on a terminal, one line for each stage if the output is piped."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager


@contextmanager
def progress() -> Iterator[Callable[[str], None]]:
    """A function that is called with the name of each item while it is made."""
    if not sys.stderr.isatty():
        yield lambda name: print(f"making {name}", file=sys.stderr, flush=True)
        return
    from rich.console import Console  # only where a terminal shows it

    console = Console(stderr=True)
    with console.status("reading") as status:
        yield lambda name: status.update(f"making {name}")
