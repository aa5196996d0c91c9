"""All derived dimensions of a design in one object, which the checks and the parts read."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from math import degrees

from mbcdm_cad.layouts.miso_spur.drive import RoundDrumDrive
from mbcdm_cad.layouts.miso_spur.support.dims import StarDims
from mbcdm_cad.layouts.siso_spur.layout import SpurLayout
from mbcdm_cad.layouts.siso_spur.layout import layout as layout_of_one_input
from mbcdm_cad.layouts.siso_spur.stack import SpurStack
from mbcdm_cad.layouts.siso_spur.support.dims import YokeDims
from mbcdm_cad.parts.collar.dims import CollarDims
from mbcdm_cad.parts.drum_sector.dims import SET_SCREW_ANGLES_DEG, DrumDims, HubDowels
from mbcdm_cad.parts.drum_shaft.dims import DrumShaftDims, PreloadSpringDims
from mbcdm_cad.parts.input_pulley.dims import InputPulleyDims
from mbcdm_cad.parts.motor_head.dims import HeadDims
from mbcdm_cad.routes.cable_path import CablePath
from mbcdm_cad.routes.curves import Helix, turned_about_y

# Dowels between the hubs, beside the payload's threads.
DOWEL_RADIUS_MM, DOWEL_LENGTH_MM = 1.0, 6.0
DOWEL_PRESSED_MM, DOWEL_PLAY_MM = 3.0, 0.5
# Opposite the set screws.
_FACE_DEG = (225.0, 315.0)


@dataclass(frozen=True)
class RoundDrumLayout:
    """Dimensions of every part of one design, mm, drum centred.

    ``first``: those of the first input with its cable and sector, as a drive of siso_spur. All sectors are equal; the
    face of the last one is the output.
    """

    drive: RoundDrumDrive
    first: SpurLayout

    @cached_property
    def units(self) -> tuple[SpurLayout, ...]:
        """Dimensions of each input, as of the first, turned so that it is above the drum; few checks need them."""
        return self.first, *(layout_of_one_input(self.drive.unit(k)) for k in range(1, self.drive.n_inputs))

    @cached_property
    def drum(self) -> DrumDims:
        """One sector."""
        return replace(self.first.drum, dowels=_dowels(self.first.drum, self.drive.n_inputs))

    @cached_property
    def drum_shaft(self) -> DrumShaftDims:
        """Shaft of the drum. It ends in the last hub, whose set screws hold all of them."""
        shaft, (near, far) = self.first.drum_shaft, SET_SCREW_ANGLES_DEG
        last, turned = self.drive.levels_mm[-1], degrees(self.drive.angles_rad[-1])
        return replace(
            shaft,
            y_end=shaft.y_end + last,
            flat_y=shaft.flat_y + last,
            flat_angles_deg=(near + turned, far + turned),
        )

    @cached_property
    def star(self) -> StarDims:
        """The frame, an arm for each input."""
        return StarDims(tuple(unit.frame for unit in self.units), tuple(degrees(a) for a in self.drive.angles_rad))

    @property
    def levels(self) -> SpurStack:
        """Levels of the first input."""
        return self.first.levels

    @property
    def preload_spring(self) -> PreloadSpringDims:
        """Wave spring of the drum's bearings."""
        return self.first.preload_spring

    @cached_property
    def inputs(self) -> tuple[InputPulleyDims, ...]:
        """The pulleys; each is longer by the distance of its cable from the first along the drum's axis."""
        return tuple(unit.inputs[0] for unit in self.units)

    @property
    def collar(self) -> CollarDims:
        """Clamp collar of each pulley."""
        return self.first.collar

    @property
    def frame(self) -> YokeDims:
        """Boss, and the arm of the frame at the first input."""
        return self.first.frame

    @property
    def head(self) -> HeadDims:
        """Motor head of each input."""
        return self.first.head

    @property
    def dowels(self) -> HubDowels:
        """Dowels between neighbouring hubs."""
        assert self.drum.dowels is not None
        return self.drum.dowels

    def cable_paths(self, drum_angle_rad: float) -> tuple[CablePath, ...]:
        """Centre line of each input's cable at a drum angle."""
        return tuple(
            _turned(path, angle)
            for unit, angle in zip(self.units, self.drive.angles_rad, strict=True)
            for path in unit.cable_paths(drum_angle_rad)
        )


def _turned(path: CablePath, angle_rad: float) -> CablePath:
    pieces = []
    for name, piece in path.pieces:
        assert not isinstance(piece, Helix)
        pieces.append((name, turned_about_y(piece, angle_rad)))
    return replace(path, pieces=tuple(pieces))


def _dowels(sector: DrumDims, n_inputs: int) -> HubDowels:
    """The next sector is turned about the axis, so its holes are turned back by that angle in its own frame."""
    return HubDowels(
        radius=DOWEL_RADIUS_MM,
        length=DOWEL_LENGTH_MM,
        circle_radius=sector.payload_circle_radius,
        face_depth=DOWEL_PRESSED_MM,
        # The hub begins behind the spigot, which rests on the face of the next hub.
        back_depth=DOWEL_LENGTH_MM - DOWEL_PRESSED_MM - (sector.hub_start_y - sector.spigot_y) + DOWEL_PLAY_MM,
        face_angles_deg=_FACE_DEG,
        back_angles_deg=tuple((a - 360.0 / n_inputs) % 360.0 for a in _FACE_DEG),
    )


def layout(drive: RoundDrumDrive) -> RoundDrumLayout:
    """The dimensions of a drive. Raises ValueError only if no geometry exists (pulleys that overlap)."""
    return RoundDrumLayout(drive, layout_of_one_input(drive.unit(0)))
