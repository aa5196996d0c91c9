"""The fields of a siso_bevel drive that other drives with a drum sector do not have: one input, its frame."""

from __future__ import annotations

from dataclasses import dataclass

from mbcdm_cad.design.bought import Bearing, Material
from mbcdm_cad.design.drive import Drive, Sigmas
from mbcdm_cad.parts.drum_sector.design import SectorRun, TransferClearances
from mbcdm_cad.parts.motor_head.dims import HeadedDrive


@dataclass(frozen=True)
class DirectRun(SectorRun):
    """One cable: steps 1 and 2, the same on input and drum."""

    @property
    def land_y_mm(self) -> float:
        """y of the cable on the drum, mm: the transfer point is (0, r_m, r_o)."""
        return self.input_radius_mm


@dataclass(frozen=True)
class DirectBearings:
    """The bearing chosen for each role."""

    drum: Bearing
    input_lower: Bearing  # next to the gearhead
    input_upper: Bearing  # next to the encoder

    def all(self) -> tuple[Bearing, ...]:
        """The three roles in the order drum, gearhead's end, encoder's end (types may repeat)."""
        return (self.drum, self.input_lower, self.input_upper)


@dataclass(frozen=True)
class ColumnSpec:
    """Frame and motor head."""

    material: Material
    back_y_mm: float
    back_plate_mm: float
    side_wall_mm: float
    motor_shelf_mm: float
    coupling_space_mm: float
    bearing_shelf_mm: float
    encoder_shelf_mm: float
    rib_mm: float


@dataclass(frozen=True, kw_only=True)
class DirectSigmas(Sigmas):
    """Standard deviations of this configuration's own lengths too."""

    input_radius_mm: tuple[float, ...]
    drum_radius_mm: tuple[float, ...]


@dataclass(frozen=True)
class DirectDrive(HeadedDrive):
    """A drive whose one input turns the drum without a guide.

    ``reserve_deg``: wrap that stays on the input at the unwound end of the travel.
    """

    cables: tuple[DirectRun, ...]
    sigmas: DirectSigmas
    clearances: TransferClearances
    reserve_deg: float
    radii_explicit: bool
    bearings: DirectBearings
    support: ColumnSpec

    @property
    def total_ratio(self) -> float:
        """i = r_o / r_m of the first step."""
        return self.cables[0].drum_radius_mm / self.cables[0].input_radius_mm


def direct(drive: Drive) -> DirectDrive:
    """``drive`` as one of this configuration. Raises ``TypeError`` for a drive of another."""
    if not isinstance(drive, DirectDrive):
        raise TypeError(f"{drive.name}: a drive of configuration {drive.configuration}, not of siso_bevel")
    return drive
