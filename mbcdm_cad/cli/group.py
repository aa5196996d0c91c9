"""The command ``mbcdm``, to which all others belong."""

from __future__ import annotations

import click

from mbcdm_cad import __version__
from mbcdm_cad.cli.options import examples


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
