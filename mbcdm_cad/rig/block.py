"""Base of every block of an experiment file."""

from __future__ import annotations

from pydantic import BaseModel, ConfigDict


class ExperimentBlock(BaseModel):
    """Unknown fields and strings for numbers are refused; units are in the fields' names."""

    model_config = ConfigDict(extra="forbid", frozen=True, strict=True, allow_inf_nan=False)
