"""Errors of this room that a user can correct."""

from __future__ import annotations

from mbcdm_cad.errors import MbcdmError


class GeometryError(MbcdmError):
    """A solid that is not one sound body, or that cannot be meshed within its tolerance: says which and why."""
