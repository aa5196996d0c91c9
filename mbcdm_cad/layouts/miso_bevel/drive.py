"""The fields of a miso_bevel drive that other drives do not have: guide, steps and sides, and its parts."""

from dataclasses import dataclass
from math import asin, cos
from typing import Literal

from mbcdm_cad.design.blocks import SpanLimits
from mbcdm_cad.design.bought import Bearing, Material
from mbcdm_cad.design.drive import Drive
from mbcdm_cad.design.fields import ESTIMATE, EntryName, Number, PlainBlock, choice, quantity
from mbcdm_cad.design.sector_blocks import TransferClearances, WoundPulleys
from mbcdm_cad.parts.drum_sector.design import SectorBearings, SectorDrive, SectorRun


@dataclass(frozen=True)
class BevelRun(SectorRun):
    """One cable, with the guide's step that it runs on: steps 1 to 4, the same on guide and drum."""

    input_side: int  # -1: input at x = -L, +1: at x = +L
    guide_radius_mm: float

    @property
    def land_y_mm(self) -> float:
        """y of the cable on the drum, mm: the transfer point is (0, r_g, r_o)."""
        return self.guide_radius_mm


@dataclass(frozen=True, kw_only=True)
class BevelBearings(SectorBearings):
    """The bearing chosen for each role, the guide's too."""

    guide: Bearing

    def all(self) -> tuple[Bearing, ...]:
        """The four roles in the order drum, guide, input lower, input upper (types may repeat)."""
        return (self.drum, self.guide, self.input_lower, self.input_upper)


@dataclass(frozen=True, kw_only=True)
class Support(PlainBlock):
    """Frame: back plate, side walls, shelves, ribs and the separate top plate."""

    material: EntryName = choice("material of frame and top plate", source=ESTIMATE, reference="aluminium-7075")
    back_y_mm: Number = quantity(
        "outer face of the back plate", "[-200, -1]", source="derived from the 34.8 mm box", reference=-14.0
    )
    back_plate_mm: Number = quantity(
        "back plate thickness", "[0.3, 50]", source="held by limits.frame_windup_max_mrad", reference=5.0
    )
    side_wall_mm: Number = quantity(
        "side wall thickness", "[0.3, 50]", source="heads of the top plate's screws, with walls", reference=5.8
    )
    motor_shelf_mm: Number = quantity(
        "shelf that carries the gearheads",
        "[0.5, 50]",
        source="gearhead screws engage one diameter; held by limits.frame_windup_max_mrad",
        reference=4.0,
    )
    coupling_space_mm: Number = quantity(
        "height between the shelves: coupling collar, gearhead screws and the tools for both",
        "[2, 100]",
        source=ESTIMATE,
        reference=9.6,
    )
    bearing_shelf_mm: Number = quantity(
        "shelf of the input pulleys' lower bearings", "[0.5, 50]", source=ESTIMATE, reference=4.0
    )
    top_plate_mm: Number = quantity("top plate thickness", "[0.5, 50]", source=ESTIMATE, reference=3.6)
    rib_mm: Number = quantity(
        "rib thickness", "[0.3, 50]", source="held by limits.frame_windup_max_mrad", reference=7.0
    )
    mount_screw: Literal["M3", "M4", "M5", "M6"] = choice(
        "screws that hold the frame on its base, on washers if the frame is printed", source=ESTIMATE, reference="M3"
    )


@dataclass(frozen=True)
class BevelDrive(SectorDrive):
    """A drive with two inputs, a guide and a bevel transfer. ``input_sides``: -1 for an input at x = -L, +1 at +L."""

    cables: tuple[BevelRun, ...]
    limits: SpanLimits
    input_sides: tuple[int, ...]
    centre_distance_mm: float
    input_setback_mm: float  # input axes at y = -this, behind the guide's axis
    motors_above: bool  # on the top plate, the encoders then under the bearing shelf
    guide_slips: bool  # the rope creeps on the guide's wraps
    radii_explicit: bool
    bearings: BevelBearings
    guide_material: Material
    axle_material: Material
    clearances: TransferClearances
    input_pulleys: WoundPulleys
    support: Support

    @property
    def passed_material(self) -> Material:
        """See the base class: the guide's."""
        return self.guide_material

    @property
    def input_turn_rad(self) -> float:
        """Angle, rad, between the X axis and the line from the guide's axis to an input's, positive away from the drum.

        asin(setback / L). Raises ValueError for a setback over L.
        """
        return asin(self.input_setback_mm / self.centre_distance_mm)

    @property
    def input_x_mm(self) -> float:
        """Distance of an input's axis from the plane x = 0, sqrt(L^2 - setback^2)."""
        return self.centre_distance_mm * cos(self.input_turn_rad)

    @property
    def input_y_mm(self) -> float:
        """y of both inputs' axes."""
        return 0.0 - self.input_setback_mm

    @property
    def fleet_angle_max_deg(self) -> float:
        """Largest fleet angle that the input pulleys' surface allows."""
        limits = self.limits
        return limits.fleet_angle_grooved_max_deg if self.input_pulleys.grooved else limits.fleet_angle_max_deg

    @property
    def shelf_bearing(self) -> Bearing:
        """Bearing of an input pulley in the bearing shelf."""
        return self.bearings.input_upper if self.motors_above else self.bearings.input_lower

    @property
    def plate_bearing(self) -> Bearing:
        """Bearing of an input pulley in the top plate."""
        return self.bearings.input_lower if self.motors_above else self.bearings.input_upper

    @property
    def encoder_plate_mm(self) -> float:
        """Thickness of the plate or shelf that carries the inputs' encoders."""
        return self.support.bearing_shelf_mm if self.motors_above else self.support.top_plate_mm

    def turn_deg(self, x_mm: float) -> float:
        """How far gearhead and motor of the input at this x are turned, seen against the shaft: both sides mirror."""
        return self.gearhead_angle_deg if x_mm > 0.0 else 0.0 - self.gearhead_angle_deg


def bevel(drive: Drive) -> BevelDrive:
    """``drive`` as one of this configuration. Raises ``TypeError`` for a drive of another."""
    if not isinstance(drive, BevelDrive):
        raise TypeError(f"{drive.name}: a drive of configuration {drive.configuration}, not of miso_bevel")
    return drive
