"""The command line: parses, calls, and turns errors into a message and an exit code.

Exit codes: 0 done, 1 a check failed, 2 bad input or a fault that you can correct, 130 interrupted, 141 reader gone.
"""

from __future__ import annotations

import gc
import os
import sys
from collections.abc import Sequence

import click

from mbcdm_cad.cli.commands import mbcdm
from mbcdm_cad.errors import MbcdmError
from mbcdm_cad.storage.parallel import allow_processes

# Set by the lines that a shell is given for completion; see docs/command-line.md.
COMPLETE_VARIABLE = "_MBCDM_COMPLETE"


def main() -> None:
    """Entry point of the ``mbcdm`` command."""
    # A start makes some 100 000 objects that all stay; looking for garbage among them, as they are made and once more
    # at the end, took a seventh of a check.
    gc.set_threshold(100_000)
    allow_processes()
    os.environ.setdefault("PYDANTIC_DISABLE_PLUGINS", "__all__")  # looking for plugins costs a tenth of a start
    if COMPLETE_VARIABLE in os.environ:
        mbcdm.main(prog_name="mbcdm")  # the shell asks for completions, which click answers here and exits
    code = run(sys.argv[1:])
    gc.freeze()
    sys.exit(code)


def run(arguments: Sequence[str]) -> int:
    """Run one command line and return its exit code; every foreseeable error ends as text on stderr."""
    try:
        with mbcdm.make_context("mbcdm", list(arguments)) as context:
            code = mbcdm.invoke(context)
        sys.stdout.flush()
    except click.exceptions.Exit as stop:
        return stop.exit_code
    except click.ClickException as error:
        error.show()
        return 2
    except MbcdmError as error:
        click.echo(str(error), err=True)
        return 2
    except BrokenPipeError:
        # the reader of our output has gone (as in "| head"); keep Python from complaining again when it flushes at exit
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 141
    except OSError as error:
        where = f"{error.filename}: " if error.filename else ""
        click.echo(f"{where}{error.strerror or error}; check the path, the rights and the space left", err=True)
        return 2
    except (KeyboardInterrupt, click.Abort):
        click.echo("interrupted", err=True)
        return 130
    return int(code or 0)
