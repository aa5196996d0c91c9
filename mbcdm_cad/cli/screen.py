"""Properties of the terminal: its width, and whether colours are wanted."""

from __future__ import annotations

import os
import shutil
import sys


def screen_width() -> int | None:
    """Columns to wrap text at; None if the output goes to a file or a pipe and COLUMNS is not set."""
    if sys.stdout.isatty() or os.environ.get("COLUMNS", "").isdigit():
        return shutil.get_terminal_size().columns
    return None


def coloured() -> bool:
    """Whether to use colours: on a terminal that has some, unless NO_COLOR is set (see no-color.org)."""
    return sys.stdout.isatty() and "NO_COLOR" not in os.environ and os.environ.get("TERM") != "dumb"
