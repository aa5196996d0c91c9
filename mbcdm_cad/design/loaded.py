"""A design that was read: what :func:`mbcdm_cad.configurations.loader.load_design` gives."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

from mbcdm_cad.design.blocks import Design
from mbcdm_cad.design.drive import Drive
from mbcdm_cad.design.fieldpath import FieldPath, nearest_line
from mbcdm_cad.design.sized import SizedValue


@dataclass(frozen=True)
class LoadedDesign:
    """A design file that passed schema and rules.

    ``design`` is the file as its schema's model, ``sized`` the fields that the file leaves out and sizing filled.
    ``sha256`` is the hash of the content: all values and the catalogue entries that they use, without layout and
    comments.
    """

    drive: Drive
    path: Path
    sha256: str
    design: Design = field(repr=False)
    text: str = field(repr=False)
    lines: Mapping[FieldPath, int] = field(repr=False)
    sized: tuple[SizedValue, ...] = field(default=(), repr=False)

    def line_of(self, *field_path: str | int) -> int:
        """Line of a field, as in ``line_of("cables", 0, "step")``; of the block above it where it is not given."""
        return nearest_line(self.lines, field_path)
