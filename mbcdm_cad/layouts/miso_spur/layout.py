"""The layout of Fig. 1 (b): two to four inputs evenly round one drum, each with its own cable."""

from dataclasses import replace
from functools import cached_property
from math import degrees

from mbcdm_cad.layouts.base import Conventions, dimensions
from mbcdm_cad.layouts.miso_spur.drive import RoundDrumDrive
from mbcdm_cad.layouts.miso_spur.support.dims import StarDims
from mbcdm_cad.layouts.siso_spur.drive import SpurRun
from mbcdm_cad.layouts.siso_spur.layout import SpurLayout
from mbcdm_cad.layouts.siso_spur.stack import SpurStack, spur_stack
from mbcdm_cad.layouts.siso_spur.support.dims import YokeDims
from mbcdm_cad.parts.coupling import CollarDims
from mbcdm_cad.parts.input_pulley.dims import InputPulleyDims
from mbcdm_cad.parts.motor_head.dims import HeadDims
from mbcdm_cad.parts.turned import IdlerDims, PreloadSpringDims
from mbcdm_cad.routes.curves import CablePath, Helix, turned_about_y


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

    def refuse_impossible(self) -> None:
        """Refuses pulleys that overlap."""
        self.unit.refuse_impossible()

    @property
    def input_units(self) -> tuple[SpurLayout, ...]:
        """See the base class."""
        return self.units

    @property
    def hubs_in_line(self) -> int:
        """See the base class."""
        return self.drive.n_inputs

    @dimensions
    def idlers(self) -> tuple[tuple[str, IdlerDims, tuple[SpurRun, int]], ...]:
        """Those of all inputs."""
        return tuple(each for unit in self.units for each in unit.idlers) if self.drive.idlers else ()

    @dimensions
    def star(self) -> StarDims:
        """The frame, an arm for each input."""
        return StarDims(tuple(unit.frame for unit in self.units), tuple(degrees(a) for a in self.drive.angles_rad))

    @cached_property
    def levels(self) -> SpurStack:
        """Levels of the first input."""
        return self.unit.levels

    @dimensions
    def preload_spring(self) -> PreloadSpringDims:
        """Wave spring of the drum's bearings."""
        return self.unit.preload_spring

    @dimensions
    def inputs(self) -> tuple[InputPulleyDims, ...]:
        """The pulleys; each is longer by the distance of its cable from the first along the drum's axis."""
        return tuple(unit.inputs[0] for unit in self.units)

    @dimensions
    def collar(self) -> CollarDims:
        """Clamp collar of each pulley."""
        return self.unit.collar

    @dimensions
    def frame(self) -> YokeDims:
        """Boss, and the arm of the frame at the first input."""
        return self.unit.frame

    @dimensions
    def head(self) -> HeadDims:
        """Motor head of each input."""
        return self.unit.head

    def cable_paths(self, drum_angle_rad: float) -> tuple[CablePath, ...]:
        """Centre line of each input's cable at a drum angle."""
        return tuple(
            _turned(path, angle)
            for unit, angle in zip(self.units, self.drive.angles_rad, strict=True)
            for path in unit.cable_paths(drum_angle_rad)
        )

    def levels_of(self, index: int) -> SpurStack:
        """See the base class."""
        return self.once(f"levels_{index}", lambda s: spur_stack(s.drive.unit(index)))


def _turned(path: CablePath, angle_rad: float) -> CablePath:
    pieces = []
    for name, piece in path.pieces:
        assert not isinstance(piece, Helix)
        pieces.append((name, turned_about_y(piece, angle_rad)))
    return replace(path, pieces=tuple(pieces))


LAYOUT = RoundDrumLayout
