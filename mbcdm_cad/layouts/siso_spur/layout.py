"""All derived dimensions of a design in one object, which the checks and the parts read."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

from mbcdm_cad.layouts.siso_spur.cable_path import cable_paths, longest_mm
from mbcdm_cad.layouts.siso_spur.drive import SpurDrive, laid
from mbcdm_cad.layouts.siso_spur.pulley import input_pulley
from mbcdm_cad.layouts.siso_spur.stack import SpurStack, spur_stack
from mbcdm_cad.layouts.siso_spur.support.dims import YokeDims, flange, yoke
from mbcdm_cad.parts.collar.dims import CollarDims, collar
from mbcdm_cad.parts.drum_sector.dims import DrumDims
from mbcdm_cad.parts.drum_sector.sizes import TerminalWay, drum, drum_shaft, furthest_anchor_rad, preload_spring
from mbcdm_cad.parts.drum_shaft.dims import DrumShaftDims, PreloadSpringDims
from mbcdm_cad.parts.input_pulley.dims import InputPulleyDims
from mbcdm_cad.parts.motor_head.dims import Flange, HeadDims, head
from mbcdm_cad.parts.terminal.take_up import terminal_travel_mm
from mbcdm_cad.routes.cable_path import CablePath


@dataclass(frozen=True)
class SpurLayout:
    """Dimensions of every part of one design, mm, drum centred; heights of pulley and collar are along +Y.

    Each is computed on first use: most trials of sizing need a few parts only. ``terminal_way``: take-up of the
    terminals. The drum is that of a cable at level 0, for any ``level_mm`` of the drive.
    """

    drive: SpurDrive
    terminal_way: TerminalWay

    @cached_property
    def levels(self) -> SpurStack:
        """Levels along Y."""
        return spur_stack(self.drive)

    @cached_property
    def drum(self) -> DrumDims:
        """Drum sector."""
        return drum(_at_level_0(self.drive), self.levels, self.frame.stop_pin_z, self.terminal_way)

    @cached_property
    def drum_shaft(self) -> DrumShaftDims:
        """Shaft of the drum."""
        return drum_shaft(self.drive, self.levels)

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
    def frame(self) -> YokeDims:
        """The frame."""
        return yoke(self.drive, self.levels, self.drum_shaft, self._flange)

    @cached_property
    def head(self) -> HeadDims:
        """Motor head."""
        return head(self.drive, self.levels, self._flange)

    @cached_property
    def _flange(self) -> Flange:
        return flange(self.drive)

    @property
    def anchors(self) -> dict[str, tuple[float, float]]:
        """Angle at which each side leaves its land, drum centred, and straight length from there, by its name."""
        return {t.cable_name: (t.anchor_rad, t.cable_end) for t in self.drum.tensioners}

    def cable_paths(self, drum_angle_rad: float) -> tuple[CablePath, ...]:
        """Centre line of each cable at a drum angle, to the bottom of the bore of each swage."""
        return cable_paths(self.drive, self.anchors, drum_angle_rad)


def layout(drive: SpurDrive) -> SpurLayout:
    """The dimensions of a drive. Raises ValueError only if no geometry exists (pulleys that overlap)."""
    if drive.free_span_mm <= 0.0:
        reach = drive.drum_radius_mm + drive.input_radius_mm
        raise ValueError(
            f"centre distance {drive.centre_distance_mm:g} mm does not exceed r_o + r_i = {reach:.4g} mm; raise "
            "transmission.centre_distance_mm"
        )
    longest = longest_mm(drive, furthest_anchor_rad(drive))
    return SpurLayout(drive, terminal_travel_mm(drive, {c.name: longest for c in drive.cables}))


def _at_level_0(drive: SpurDrive) -> SpurDrive:
    return drive if drive.level_mm == 0.0 else laid(replace(drive, level_mm=0.0))
