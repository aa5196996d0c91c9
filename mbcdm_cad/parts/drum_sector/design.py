"""The part of ``Drive`` shared by drives whose cables end on a drum sector, from input pulleys of two steps."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

from mbcdm_cad.design.bought import Bearing, Material, TensionerSpec
from mbcdm_cad.design.drive import CableRun, Drive


@dataclass(frozen=True)
class SectorRun(CableRun):
    """One cable with the side and the step of the drum that it runs on."""

    drum_side: int  # +1: runs on the drum towards +x, -1: towards -x
    step: int  # from 1, the smallest
    terminal_angle_rad: float | None  # where it is to leave its land, drum centred; None: as far out as possible

    @property
    def land_y_mm(self) -> float:
        """Plane of this cable on the drum; each configuration has its own."""
        raise NotImplementedError

    @property
    def sense(self) -> int:
        """Sense in which this cable's tension turns the drum about +Y (mechanism: -1 towards +x, +1 towards -x)."""
        return -self.drum_side


@dataclass(frozen=True)
class Clearances:
    """Gaps the geometry must keep, all in mm between finished surfaces."""

    land_edge_mm: float  # edge of a drum land to the next cable's contact line
    running_mm: float  # any moving solid to any fixed one, elsewhere


@dataclass(frozen=True)
class TransferClearances(Clearances):
    """Clearances of a drive whose cables change to the drum from a pulley with an axis at a right angle to it."""

    transfer_gap_mm: float  # surface of the other pulley at step 1 to the drum's inner face


@dataclass(frozen=True)
class DrumSpec:
    """Drum sector and its shaft; y is measured along the drum axis from the axis of the pulley at the transfer."""

    material: Material
    sector_half_angle_deg: float
    rim_inner_radius_mm: float
    outer_face_y_mm: float
    web_thickness_mm: float
    hub_diameter_mm: float
    hub_face_y_mm: float
    output_circle_mm: float | None  # None: midway between shaft and edge
    output_screws: int
    shaft_bore_mm: float
    shaft_material: Material
    stop_pin_mm: float


@dataclass(frozen=True)
class InputPulleySpec:
    """Input pulleys, equal except for their radii. ``collar_screw``: screw of the clamp collar that couples each."""

    material: Material
    collar_screw: str


@dataclass(frozen=True)
class WoundPulleySpec(InputPulleySpec):
    """Input pulleys that cables wind on in a helix. ``surface``: ``smooth`` or ``grooved``."""

    surface: str

    @property
    def grooved(self) -> bool:
        """Whether each cable winds into a helical groove."""
        return self.surface == "grooved"


class SectorBearings(Protocol):
    """The bearings that every drive with a drum sector has."""

    @property
    def drum(self) -> Bearing:
        """Both bearings of the drum's shaft."""

    @property
    def input_lower(self) -> Bearing:
        """Bearing of an input pulley, next to the gearhead."""

    @property
    def input_upper(self) -> Bearing:
        """Bearing of an input pulley, next to its encoder."""

    def all(self) -> tuple[Bearing, ...]:
        """All roles; types may repeat."""


class FrameSpec(Protocol):
    """The frame's part of the design file."""

    @property
    def material(self) -> Material:
        """Material of the frame."""


@dataclass(frozen=True)
class SectorDrive(Drive):
    """A drive whose cables end on a drum sector."""

    cables: tuple[SectorRun, ...]
    clearances: Clearances
    bearings: SectorBearings
    tensioner: TensionerSpec
    drum: DrumSpec
    input_pulleys: InputPulleySpec
    support: FrameSpec


class SectorLevels(Protocol):
    """Depths along Y that the drum shares with the frame and the body before it, mm."""

    @property
    def back_y(self) -> float:
        """Outer face of the frame."""

    @property
    def boss_front_y(self) -> float:
        """Front of the boss that holds the drum's bearings."""

    @property
    def drum_inner_y(self) -> float:
        """Inner face of the drum's rim."""

    @property
    def drum_outer_y(self) -> float:
        """Outer face of the drum's rim."""

    @property
    def hub_face_y(self) -> float:
        """Face of the hub."""
