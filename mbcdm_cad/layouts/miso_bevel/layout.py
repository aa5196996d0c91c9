"""All derived dimensions of a design in one object, which the checks and the parts read."""

from __future__ import annotations

from dataclasses import dataclass

from mbcdm_cad.layouts.miso_bevel.cable_path import cable_path
from mbcdm_cad.layouts.miso_bevel.drive import BevelDrive
from mbcdm_cad.layouts.miso_bevel.drum import drum
from mbcdm_cad.layouts.miso_bevel.pulleys import axle, guide, input_pulley
from mbcdm_cad.layouts.miso_bevel.stack import Stack, stack
from mbcdm_cad.layouts.miso_bevel.support.dims import FrameDims, TopPlateDims, frame, top_plate
from mbcdm_cad.parts.axle.dims import AxleDims
from mbcdm_cad.parts.collar.dims import CollarDims, collar
from mbcdm_cad.parts.drum_sector.dims import DrumDims
from mbcdm_cad.parts.drum_sector.sizes import drum_shaft, preload_spring
from mbcdm_cad.parts.drum_shaft.dims import DrumShaftDims, PreloadSpringDims
from mbcdm_cad.parts.idler_pulley.dims import IdlerDims
from mbcdm_cad.parts.input_pulley.dims import InputPulleyDims
from mbcdm_cad.routes.cable_path import CablePath


@dataclass(frozen=True)
class Layout:
    """Dimensions of every part of one design, mm, drum centred."""

    drive: BevelDrive
    levels: Stack
    drum: DrumDims
    drum_shaft: DrumShaftDims
    preload_spring: PreloadSpringDims
    inputs: tuple[InputPulleyDims, ...]
    collar: CollarDims
    guide: IdlerDims
    axle: AxleDims
    frame: FrameDims
    top_plate: TopPlateDims

    def cable_paths(self, drum_angle_rad: float) -> tuple[CablePath, ...]:
        """Centre lines of all cables at a drum angle, from the stop in the pulley to the bottom of the swage's bore."""
        terminals = {t.cable_name: t for t in self.drum.tensioners}
        return tuple(
            cable_path(self.drive, c, terminals[c.name].anchor_rad, terminals[c.name].cable_end, drum_angle_rad)
            for c in self.drive.cables
        )


def layout(drive: BevelDrive) -> Layout:
    """Compute all dimensions. Raises ValueError only if no geometry exists (pulleys that overlap)."""
    levels = stack(drive)
    shaft = drum_shaft(drive, levels)
    return Layout(
        drive=drive,
        levels=levels,
        drum=drum(drive, levels),
        drum_shaft=shaft,
        preload_spring=preload_spring(drive, shaft),
        inputs=tuple(input_pulley(drive, levels, name) for name in drive.input_names),
        collar=collar(drive, *drive.collar_seat, levels.from_gearhead.motor_shelf_top_z),
        guide=guide(drive, levels),
        axle=axle(drive, levels),
        frame=frame(drive, levels),
        top_plate=top_plate(drive, levels),
    )
