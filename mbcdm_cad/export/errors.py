"""Errors of this room that a user can put right."""

from __future__ import annotations

from mbcdm_cad.errors import MbcdmError


class OutputError(MbcdmError):
    """The output folder cannot be written, or must not be: says which folder, why, and what to do."""
