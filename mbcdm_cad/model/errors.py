"""The exception that the functions of the model raise."""

from __future__ import annotations

from mbcdm_cad.errors import MbcdmError


class ModelError(MbcdmError):
    """A question the model cannot answer; the text says what, the value, the limit and the remedy."""
