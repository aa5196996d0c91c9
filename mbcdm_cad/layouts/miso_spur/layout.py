"""The layout of Fig. 1 (b): two to four inputs evenly round one drum, each with its own cable."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import cached_property
from math import degrees
from typing import Any

from mbcdm_cad.layouts.base import Conventions, dimensions
from mbcdm_cad.layouts.miso_spur.drive import RoundDrumDrive
from mbcdm_cad.layouts.miso_spur.support.dims import StarDims
from mbcdm_cad.layouts.siso_spur.cable_path import side_length_mm
from mbcdm_cad.layouts.siso_spur.drive import SpurRun
from mbcdm_cad.layouts.siso_spur.layout import SpurLayout
from mbcdm_cad.layouts.siso_spur.stack import SpurStack, spur_stack
from mbcdm_cad.layouts.siso_spur.support.dims import YokeDims
from mbcdm_cad.parts.collar import CollarDims
from mbcdm_cad.parts.drum_sector.design import SectorRun
from mbcdm_cad.parts.drum_sector.dims import SET_SCREW_ANGLES_DEG, DrumDims, HubDowels
from mbcdm_cad.parts.drum_shaft import DrumShaftDims, PreloadSpringDims
from mbcdm_cad.parts.idler_pulley import IdlerDims
from mbcdm_cad.parts.input_pulley.dims import InputPulleyDims
from mbcdm_cad.parts.motor_head.dims import HeadDims
from mbcdm_cad.parts.terminal.part import Tensioner
from mbcdm_cad.routes.cable_path import CablePath
from mbcdm_cad.routes.curves import Helix, turned_about_y

# Dowels between the hubs, beside the payload's threads.
DOWEL_RADIUS_MM, DOWEL_LENGTH_MM = 1.0, 6.0
DOWEL_PRESSED_MM, DOWEL_PLAY_MM = 3.0, 0.5
# Opposite the set screws.
_FACE_DEG = (225.0, 315.0)


class RoundDrumLayout(SpurLayout):
    """One design. All sectors are equal; the face of the last one is the output.

    Most checks use the first input; ``steps`` are the sides on the first sector.
    """

    name = "miso_spur"
    title = "two to four inputs evenly round one drum, a cable round each, axes parallel (Fig. 1 b)"
    conventions = Conventions(
        frame="Frame: origin on the drum axis (Y), in the middle of the first input's cable; the first input stands at "
        "+Z, the others evenly about Y, each further along it; lengths in mm.",
        cables="Cables are round rods at the nominal diameter; their turns walk along the inputs as the drum turns.",
    )

    drive: RoundDrumDrive

    def __init__(self, drive: RoundDrumDrive, **given: Any) -> None:
        super().__init__(drive, **given)
        self.steps = tuple(c for c in self.steps if c.input_name == drive.input_names[0])

    def refuse_impossible(self) -> None:
        """Refuses pulleys that overlap."""
        self.first.refuse_impossible()

    @cached_property
    def first(self) -> SpurLayout:
        """The first input with its cable and sector, as a drive of siso_spur."""
        return SpurLayout(self.drive.unit(0))

    @dimensions
    def units(self) -> tuple[SpurLayout, ...]:
        """Dimensions of each input, as of the first, turned so that it is above the drum; few checks need them."""
        return self.first, *(SpurLayout(self.drive.unit(k)) for k in range(1, self.drive.n_inputs))

    @property
    def arms(self) -> tuple[SpurLayout, ...]:
        """See the base class."""
        return self.units

    @dimensions
    def idlers(self) -> tuple[tuple[str, IdlerDims, tuple[SpurRun, int]], ...]:
        """Those of all inputs."""
        return tuple(each for unit in self.units for each in unit.idlers) if self.drive.idlers else ()

    @dimensions
    def drum(self) -> DrumDims:
        """One sector."""
        return replace(self.first.drum, dowels=_dowels(self.first.drum, self.drive.n_inputs))

    @dimensions
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

    @dimensions
    def star(self) -> StarDims:
        """The frame, an arm for each input."""
        return StarDims(tuple(unit.frame for unit in self.units), tuple(degrees(a) for a in self.drive.angles_rad))

    @cached_property
    def levels(self) -> SpurStack:
        """Levels of the first input."""
        return self.first.levels

    @dimensions
    def preload_spring(self) -> PreloadSpringDims:
        """Wave spring of the drum's bearings."""
        return self.first.preload_spring

    @dimensions
    def inputs(self) -> tuple[InputPulleyDims, ...]:
        """The pulleys; each is longer by the distance of its cable from the first along the drum's axis."""
        return tuple(unit.inputs[0] for unit in self.units)

    @dimensions
    def collar(self) -> CollarDims:
        """Clamp collar of each pulley."""
        return self.first.collar

    @dimensions
    def frame(self) -> YokeDims:
        """Boss, and the arm of the frame at the first input."""
        return self.first.frame

    @dimensions
    def head(self) -> HeadDims:
        """Motor head of each input."""
        return self.first.head

    @dimensions
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

    @property
    def terminals(self) -> tuple[Tensioner, ...]:
        """See the base class."""
        return tuple(t for unit in self.units for t in unit.drum.tensioners)

    def terminal_of(self, cable: SectorRun) -> Tensioner:
        """See the base class; those of the first input are known before the others."""
        on_first = (t for t in self.drum.tensioners if t.cable_name == cable.name)
        return next(on_first, None) or super().terminal_of(cable)

    def levels_of(self, index: int) -> SpurStack:
        """See the base class."""
        return self.once(f"levels_{index}", lambda s: spur_stack(s.drive.unit(index)))

    def tensioned_lengths_mm(self) -> Sequence[float]:
        """Length that each terminal tensions, mm: half of its cable."""
        return [side_length_mm(unit.drive, c, *unit.anchors[c.name]) for unit in self.units for c in unit.drive.cables]


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


LAYOUT = RoundDrumLayout
