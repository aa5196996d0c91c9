"""All commands. Each imports its modules when it runs, so that no command waits for the libraries of another."""

from __future__ import annotations

from mbcdm_cad.cli import commands_on_designs, commands_on_runs, commands_that_draw
from mbcdm_cad.cli.group import mbcdm

__all__ = ["commands_on_designs", "commands_on_runs", "commands_that_draw", "mbcdm"]
