"""The design under test of this configuration: its inputs are equal, so that most checks use the first of them."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property
from typing import Any

from mbcdm_cad.layouts.miso_spur.drive import RoundDrumDrive
from mbcdm_cad.layouts.miso_spur.layout import RoundDrumLayout, layout
from mbcdm_cad.layouts.siso_spur.cable_path import side_length_mm
from mbcdm_cad.layouts.siso_spur.design_under_test import SpurUnderTest
from mbcdm_cad.layouts.siso_spur.stack import SpurStack, spur_stack
from mbcdm_cad.parts.drum_sector.design import SectorRun
from mbcdm_cad.parts.terminal.dims import Tensioner


class RoundDrumUnderTest(SpurUnderTest):
    """Adds the other inputs. ``steps`` are the sides on the first sector."""

    drive: RoundDrumDrive

    def __init__(self, drive: RoundDrumDrive, layout: Any = None) -> None:
        super().__init__(drive, layout)
        self.steps = tuple(c for c in self.steps if c.input_name == drive.input_names[0])

    @cached_property
    def layout(self) -> RoundDrumLayout:  # type: ignore[override]  # has all that the checks of one input read
        """All dimensions: the given ones, else computed from the drive."""
        return self.given_or(lambda: layout(self.drive))

    @property
    def terminals(self) -> tuple[Tensioner, ...]:
        """See the base class."""
        return tuple(t for unit in self.layout.units for t in unit.drum.tensioners)

    def terminal_of(self, cable: SectorRun) -> Tensioner:
        """See the base class; those of the first input are known before the others."""
        on_first = (t for t in self.layout.drum.tensioners if t.cable_name == cable.name)
        return next(on_first, None) or super().terminal_of(cable)

    def levels_of(self, index: int) -> SpurStack:
        """See the base class."""
        if self._given is not None:
            return self.layout.units[index].levels
        return self.once(f"levels_{index}", lambda s: spur_stack(s.drive.unit(index)))

    def tensioned_lengths_mm(self) -> Sequence[float]:
        """Length that each terminal tensions, mm: half of its cable."""
        return [
            side_length_mm(unit.drive, c, *unit.anchors[c.name])
            for unit in self.layout.units
            for c in unit.drive.cables
        ]


UNDER_TEST = RoundDrumUnderTest
