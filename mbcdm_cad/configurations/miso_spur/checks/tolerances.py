"""Stacks of tolerances: those of one input, all being alike."""

from __future__ import annotations

from mbcdm_cad.configurations.siso_spur.checks.tolerances import stacks

__all__ = ["stacks"]
