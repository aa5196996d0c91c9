"""The fields of a siso_bevel drive that other drives with a drum sector do not have: one input, its frame."""

from dataclasses import dataclass
from typing import ClassVar, Literal

from mbcdm_cad.design.fields import ESTIMATE, EntryName, Number, choice, quantity
from mbcdm_cad.design.sector_blocks import HeadSupport, TransferClearances
from mbcdm_cad.parts.drum_sector.design import SectorDrive, SectorRun

# Source of the walls that stiffen the frame.
CHOSEN = "for limits.frame_windup_max_mrad"


@dataclass(frozen=True)
class DirectRun(SectorRun):
    """One cable: steps 1 and 2, the same on input and drum."""

    @property
    def land_y_mm(self) -> float:
        """y of the cable on the drum, mm: the transfer point is (0, r_m, r_o)."""
        return self.input_radius_mm


@dataclass(frozen=True, kw_only=True)
class ColumnSupport(HeadSupport):
    """Frame with the drum's bearings and the pulley's box, and the motor head on top of it."""

    ORDER: ClassVar[tuple[str, ...]] = (
        *("material", "back_y_mm", "back_plate_mm", "side_wall_mm"),
        *("motor_shelf_mm", "coupling_space_mm", "bearing_shelf_mm", "encoder_shelf_mm"),
    )

    material: EntryName = choice("material of frame and motor head", source=ESTIMATE, reference="aluminium-7075")
    back_y_mm: Number = quantity(
        "outer face of the back plate", "[-300, -1]", source="the pulley clears the back plate", reference=-17.3
    )
    back_plate_mm: Number = quantity("back plate thickness", "[0.3, 50]", source=CHOSEN, reference=3.0)
    side_wall_mm: Number = quantity(
        "side walls of the pulley's box, with the motor head's screws",
        "[0.3, 50]",
        source="walls beside an M2 thread",
        reference=4.0,
    )
    coupling_space_mm: Number = quantity(
        "height between the shelves: coupling collar, gearhead screws and the tools for both",
        "[2, 100]",
        source=ESTIMATE,
        reference=9.6,
    )
    rib_mm: Number = quantity("side walls of the column", "[0.3, 50]", source=CHOSEN, reference=5.0)

    mount_screw: Literal["M3", "M4", "M5", "M6"] = choice(
        "screws that hold the frame on its base", source=ESTIMATE, reference="M3", default="M3"
    )


@dataclass(frozen=True)
class DirectDrive(SectorDrive):
    """A drive whose one input turns the drum without a guide.

    ``reserve_deg``: wrap that stays on the input at the unwound end of the travel.
    """

    cables: tuple[DirectRun, ...]
    clearances: TransferClearances
    reserve_deg: float
    radii_explicit: bool
    support: ColumnSupport

    @property
    def total_ratio(self) -> float:
        """i = r_o / r_m of the first step."""
        return self.cables[0].drum_radius_mm / self.cables[0].input_radius_mm
