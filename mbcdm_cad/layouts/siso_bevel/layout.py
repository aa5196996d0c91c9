"""All derived dimensions of a design in one object, which the checks and the parts read."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

from mbcdm_cad.layouts.siso_bevel.cable_path import cable_path, longest_mm
from mbcdm_cad.layouts.siso_bevel.drive import DirectDrive
from mbcdm_cad.layouts.siso_bevel.pulley import input_pulley
from mbcdm_cad.layouts.siso_bevel.stack import DirectStack, direct_stack
from mbcdm_cad.layouts.siso_bevel.support.dims import ColumnDims, column, flange
from mbcdm_cad.parts.collar.dims import CollarDims, collar
from mbcdm_cad.parts.drum_sector.dims import DrumDims
from mbcdm_cad.parts.drum_sector.sizes import drum, drum_shaft, furthest_anchor_rad, preload_spring
from mbcdm_cad.parts.drum_shaft.dims import DrumShaftDims, PreloadSpringDims
from mbcdm_cad.parts.input_pulley.dims import InputPulleyDims
from mbcdm_cad.parts.motor_head.dims import HeadDims, head
from mbcdm_cad.parts.terminal.take_up import terminal_travel_mm
from mbcdm_cad.routes.cable_path import CablePath


@dataclass(frozen=True)
class DirectLayout:
    """Dimensions of every part of one design, mm, drum centred; pulley and collar with their heights along -Z.

    Parts that exist for every drive are computed on first use: most trials of sizing need a few of them only.
    """

    drive: DirectDrive
    levels: DirectStack
    drum: DrumDims
    drum_shaft: DrumShaftDims
    frame: ColumnDims

    @cached_property
    def preload_spring(self) -> PreloadSpringDims:
        """Wave spring of the drum's bearings."""
        return preload_spring(self.drive, self.drum_shaft)

    @cached_property
    def inputs(self) -> tuple[InputPulleyDims, ...]:
        """The one input pulley."""
        return (input_pulley(self.drive, self.levels),)

    @cached_property
    def collar(self) -> CollarDims:
        """Clamp collar of the pulley."""
        return collar(self.drive, *self.drive.collar_seat, self.levels.motor_shelf_top_z)

    @cached_property
    def head(self) -> HeadDims:
        """Motor head."""
        return head(self.drive, self.levels, flange(self.levels))

    def cable_paths(self, drum_angle_rad: float) -> tuple[CablePath, ...]:
        """Centre lines of all cables at a drum angle, from the stop in the pulley to the bottom of the swage's bore."""
        terminals = {t.cable_name: t for t in self.drum.tensioners}
        return tuple(
            cable_path(self.drive, c, terminals[c.name].anchor_rad, terminals[c.name].cable_end, drum_angle_rad)
            for c in self.drive.cables
        )


def layout(drive: DirectDrive) -> DirectLayout:
    """The dimensions of a drive. Raises ValueError only if no geometry exists (a pulley too small for a stop)."""
    # First, because it fails if the pulley is too small.
    furthest = furthest_anchor_rad(drive)
    way = terminal_travel_mm(drive, {c.name: longest_mm(drive, c, furthest) for c in drive.cables})
    levels = direct_stack(drive)
    shaft = drum_shaft(drive, levels)
    frame = column(drive, levels, shaft)
    return DirectLayout(drive, levels, drum(drive, levels, frame.stop_pin_z, way), shaft, frame)
