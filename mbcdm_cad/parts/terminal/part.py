"""The threaded terminal of a cable as a part."""

from __future__ import annotations

from dataclasses import dataclass
from math import pi
from typing import TYPE_CHECKING

from mbcdm_cad.parts.part import MadePart
from mbcdm_cad.parts.terminal.dims import TerminalDims
from mbcdm_cad.parts.volume import ring_mm3, segment_mm2

if TYPE_CHECKING:
    import cadquery as cq

    from mbcdm_cad.parts.sheets.description import Sheet


@dataclass(frozen=True)
class ThreadedTerminal(MadePart):
    """Terminal along Z, the cable from -Z."""

    dims: TerminalDims

    def solid(self) -> cq.Solid:
        """Drawn by ``draw.py`` beside this module."""
        from mbcdm_cad.parts.terminal.draw import create_terminal

        return create_terminal(self.dims)

    def volume_mm3(self) -> float:
        """Swage with its bore and flats, and the stud."""
        d = self.dims
        swage = pi * d.swage_radius**2 - 2 * segment_mm2(d.swage_radius, d.flat)
        bore = ring_mm3(d.bore_radius, 0.0, d.cable_end - d.swage_start)
        return swage * (d.swage_end - d.swage_start) + ring_mm3(d.stud_radius, 0.0, d.tip - d.swage_end) - bore

    def sheet(self, part: str) -> Sheet:
        """Described by ``sheet.py`` beside this module."""
        from mbcdm_cad.parts.terminal.sheet import terminal_sheet

        return terminal_sheet(part, self.dims)
