"""The command line: parses arguments, runs a command, and turns errors into a message and an exit code.

Exit codes: 0 done, 1 a check failed, 2 bad input or a fault that you can correct, 70 a fault of the program, 130
interrupted, 141 output closed.
"""

import gc
import os
import shlex
import sys
import tempfile
import traceback
from collections.abc import Sequence

import click

from mbcdm_cad.cli import commands_on_designs, commands_on_runs, commands_that_draw  # noqa: F401  they join mbcdm
from mbcdm_cad.cli.group import mbcdm
from mbcdm_cad.errors import MbcdmError
from mbcdm_cad.parallel.forks import allow_processes
from mbcdm_cad.storage.folders import versions

# Variable that the start file of a shell sets for completion; see docs/command-line.md.
COMPLETE_VARIABLE = "_MBCDM_COMPLETE"


def main() -> None:
    """Entry point of the ``mbcdm`` command."""
    # The imports make about 100 000 objects that are never freed. Searching them for garbage, during the imports and at
    # the end, took a seventh of the time of a check.
    gc.set_threshold(100_000)
    allow_processes()
    os.environ.setdefault("PYDANTIC_DISABLE_PLUGINS", "__all__")  # the search for plugins takes a tenth of the start
    if COMPLETE_VARIABLE in os.environ:
        mbcdm.main(prog_name="mbcdm")  # a request of the shell for completions, which click answers, then exits
    code = run(sys.argv[1:])
    gc.freeze()
    sys.exit(code)


def run(arguments: Sequence[str]) -> int:
    """Run one command line and return its exit code; every expected error becomes a text on stderr."""
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
        # The reader of the output has ended (as in "| head"); without this Python reports the error again at exit.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 141
    except OSError as error:
        where = f"{error.filename}: " if error.filename else ""
        click.echo(f"{where}{error.strerror or error}; check the path, the rights and the space left", err=True)
        return 2
    except (KeyboardInterrupt, click.Abort):
        click.echo("interrupted", err=True)
        return 130
    except Exception as error:
        click.echo(_fault(error, arguments), err=True)
        return 70
    return int(code or 0)


def _fault(error: Exception, arguments: Sequence[str]) -> str:
    """One line on an exception that is no user's error, with the file of its traceback; all of it where none can be."""
    told = f"mbcdm {shlex.join(arguments)}\n{versions()}\n{''.join(traceback.format_exception(error))}"
    try:
        number, path = tempfile.mkstemp(prefix="mbcdm-fault-", suffix=".txt")
        os.write(number, told.encode(errors="backslashreplace"))
    except OSError:
        return told
    kind = f"{type(error).__name__}: {error}".splitlines()[0]
    return f"a fault of the program, not of your input ({kind:.200}); please report it with the file {path}"
