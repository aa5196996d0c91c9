"""All derived dimensions of a design in one object, which the checks and the parts read."""

from __future__ import annotations

from dataclasses import dataclass, replace

from mbcdm_cad.configurations.siso_spur.cable_path import cable_paths, longest_mm
from mbcdm_cad.configurations.siso_spur.drive import SpurDrive, laid
from mbcdm_cad.configurations.siso_spur.pulley import input_pulley
from mbcdm_cad.configurations.siso_spur.stack import SpurStack, spur_stack
from mbcdm_cad.configurations.siso_spur.support.dims import YokeDims, flange, yoke
from mbcdm_cad.parts.collar.dims import CollarDims, collar
from mbcdm_cad.parts.drum_sector.dims import DrumDims
from mbcdm_cad.parts.drum_sector.sizes import drum, drum_shaft, furthest_anchor_rad, preload_spring
from mbcdm_cad.parts.drum_shaft.dims import DrumShaftDims, PreloadSpringDims
from mbcdm_cad.parts.input_pulley.dims import InputPulleyDims
from mbcdm_cad.parts.motor_head.dims import HeadDims, head
from mbcdm_cad.parts.terminal.take_up import terminal_travel_mm
from mbcdm_cad.routes.cable_path import CablePath


@dataclass(frozen=True)
class SpurLayout:
    """Dimensions of every part of one design, mm, drum centred; heights of pulley and collar are along +Y.

    The drum is that of a cable at level 0, for any ``level_mm`` of the drive.
    """

    drive: SpurDrive
    levels: SpurStack
    drum: DrumDims
    drum_shaft: DrumShaftDims
    preload_spring: PreloadSpringDims
    inputs: tuple[InputPulleyDims, ...]
    collar: CollarDims
    frame: YokeDims
    head: HeadDims

    @property
    def anchors(self) -> dict[str, tuple[float, float]]:
        """Angle at which each side leaves its land, drum centred, and straight length from there, by its name."""
        return {t.cable_name: (t.anchor_rad, t.cable_end) for t in self.drum.tensioners}

    def cable_paths(self, drum_angle_rad: float) -> tuple[CablePath, ...]:
        """Centre line of each cable at a drum angle, to the bottom of the bore of each swage."""
        return cable_paths(self.drive, self.anchors, drum_angle_rad)


def layout(drive: SpurDrive) -> SpurLayout:
    """Compute all dimensions. Raises ValueError only if no geometry exists (pulleys that overlap)."""
    if drive.free_span_mm <= 0.0:
        reach = drive.drum_radius_mm + drive.input_radius_mm
        raise ValueError(
            f"centre distance {drive.centre_distance_mm:g} mm does not exceed r_o + r_i = {reach:.4g} mm; raise "
            "transmission.centre_distance_mm"
        )
    levels = spur_stack(drive)
    shaft, head_flange = drum_shaft(drive, levels), flange(drive)
    frame = yoke(drive, levels, head_flange)
    furthest = furthest_anchor_rad(drive)
    way = terminal_travel_mm(drive, {c.name: longest_mm(drive, furthest) for c in drive.cables})
    return SpurLayout(
        drive=drive,
        levels=levels,
        drum=drum(_at_level_0(drive), levels, frame.stop_pin_z, way),
        drum_shaft=shaft,
        preload_spring=preload_spring(drive, shaft),
        inputs=(input_pulley(drive, levels),),
        collar=collar(drive, *drive.collar_seat, levels.motor_shelf_top_z),
        frame=frame,
        head=head(drive, levels, head_flange),
    )


def _at_level_0(drive: SpurDrive) -> SpurDrive:
    return drive if drive.level_mm == 0.0 else laid(replace(drive, level_mm=0.0))
