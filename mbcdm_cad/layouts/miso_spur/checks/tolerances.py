"""Tolerance stacks of one input, since all inputs are equal."""

from __future__ import annotations

from mbcdm_cad.layouts.siso_spur.checks.tolerances import stacks

__all__ = ["stacks"]
