"""Errors of this room that a user can correct."""

from __future__ import annotations

from mbcdm_cad.errors import MbcdmError


class GeometryError(MbcdmError):
    """A solid that is not one valid body, or cannot be meshed within its tolerance; the text says which and why."""
