"""The part of ``Drive`` shared by drives whose cables end on a drum sector, and how its blocks are resolved."""

from collections.abc import Iterator
from dataclasses import dataclass
from math import inf, radians
from typing import Any

from mbcdm_cad.design.bought import NO_BEARING, Bearing, Material, SpringSpec, TensionerSpec
from mbcdm_cad.design.drive import CableRun, Drive
from mbcdm_cad.design.resolve import Catalogue
from mbcdm_cad.design.rules import NamedEntry
from mbcdm_cad.design.sector_blocks import Clearances, SectorCable, SectorDrum, SteppedPulleys

# Washers between springs, lug and nut: thickness over the springs' outside, and least thickness, mm (estimate).
SEAT_SHARE, LEAST_SEAT_MM = 0.1, 0.5


def seat_mm(outside_mm: float) -> float:
    """Thickness of the washers on either side of springs of this outside diameter."""
    return round(max(LEAST_SEAT_MM, SEAT_SHARE * outside_mm), 1)


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


@dataclass(frozen=True, kw_only=True)
class SectorBearings:
    """The bearing chosen for each role that every drive with a drum sector has."""

    drum: Bearing
    input_lower: Bearing  # next to the gearhead
    input_upper: Bearing  # next to the encoder

    def all(self) -> tuple[Bearing, ...]:
        """Those of the drum, of an input at the gearhead and at the encoder, in this order (types may repeat)."""
        return (self.drum, self.input_lower, self.input_upper)


@dataclass(frozen=True)
class SectorDrive(Drive):
    """A drive whose cables end on a drum sector.

    The blocks name their materials, bearings and tensioner; beside them the drive has these entries of the catalogue.
    """

    cables: tuple[SectorRun, ...]
    clearances: Clearances
    bearings: SectorBearings
    tensioner: TensionerSpec
    spring: SpringSpec | None  # on the stud of each terminal, ``drum.spring_count`` of it one behind the other
    springs: tuple[SpringSpec, ...]
    drum: SectorDrum
    drum_material: Material
    shaft_material: Material
    input_pulleys: SteppedPulleys
    pulley_material: Material
    support: Any  # the block of the frame: each configuration has its own
    frame_material: Material

    @property
    def passed_material(self) -> Material | None:
        """Material of the body that the cables pass between input pulley and drum; None without."""
        return None

    @property
    def anchor_m_N(self) -> float:
        """How far a terminal gives way for each newton at its end of the rope: its springs."""
        return 0.0 if self.spring is None else self.drum.spring_count * 1e-3 / self.spring.stiffness_N_mm

    @property
    def spring_seat_mm(self) -> float:
        """Thickness of each of both washers: on the lug over its slot, and under the nut."""
        return 0.0 if self.spring is None else seat_mm(self.spring.outside_mm)

    @property
    def spring_free_mm(self) -> float:
        """Height of the springs on a stud without load, with both washers; 0 without springs."""
        return 0.0 if self.spring is None else self.drum.spring_count * self.spring.free_mm + 2 * self.spring_seat_mm

    def spring_height_mm(self, force_N: float) -> float:
        """The same under a force, not less than solid."""
        if self.spring is None:
            return 0.0
        solid = self.drum.spring_count * self.spring.solid_mm + 2 * self.spring_seat_mm
        return max(solid, self.spring_free_mm - self.anchor_m_N * 1e3 * force_N)

    @property
    def ring_anchor_rad(self) -> float | None:
        """Where each cable leaves a whole drum, from the transfer point, drum centred; None for a sector."""
        return None

    def turn_beside_mm(self, end_rad: float) -> float:
        """Distance along y from a terminal on a whole drum to the flank of the turn of its cable beside it.

        ``end_rad``: where its pocket ends, from the transfer point, drum centred. Infinite without a turn beside it.
        """
        return inf

    @property
    def stopped(self) -> bool:
        """Whether a pin in the frame stops the drum at both ends of its travel."""
        return True

    @property
    def overhung(self) -> bool:
        """Whether the shaft of motor or gearhead alone carries each input pulley."""
        return self.input_pulleys.overhung

    @property
    def clamped_mm(self) -> float:
        """Diameter of the shaft that a collar clamps: of the gearhead, or of the journal in a wheel's hub."""
        return self.gearhead.shaft_diameter_mm if self.stage is None else self.bearings.input_lower.bore_mm


# Gap between an input pulley's end face and a shelf, bridged by the inner ring's shoulder; the pulley's axial play
# between its two bearings (estimates).
SHELF_GAP_MM, END_PLAY_MM = 0.6, 0.1


@dataclass(frozen=True, kw_only=True)
class InputLevels:
    """Levels in mm: ``_z`` along an input's axis, from motor to encoder, ``_y`` along the drum's.

    The named body lies just before (``_top``) or behind (``_bottom``) the level.
    """

    motor_bottom_z: float
    gearhead_bottom_z: float
    motor_shelf_bottom_z: float  # the gearhead's face
    motor_shelf_top_z: float
    bearing_shelf_bottom_z: float
    bearing_shelf_top_z: float
    top_plate_bottom_z: float  # or the encoder shelf
    top_plate_top_z: float
    encoder_top_z: float
    back_y: float
    front_y: float  # of shelves and plates
    drum_inner_y: float
    drum_outer_y: float
    hub_face_y: float
    boss_front_y: float

    @property
    def upper_neck_top_z(self) -> float:
        """Top of the pulley's upper neck, which its play keeps from the bearing."""
        return self.top_plate_bottom_z - END_PLAY_MM


@dataclass(frozen=True, kw_only=True)
class LandLevels(InputLevels):
    """Those of a pulley whose land is not led by a guide's steps."""

    land_bottom_z: float
    land_top_z: float


def sector_values(design: Any, catalogue: Catalogue) -> dict[str, Any]:
    """The fields of :class:`~mbcdm_cad.parts.drum_sector.design.SectorDrive` but cables and bearings, and the frame."""
    drum, pulleys, support = design.drum, design.input_pulleys, design.support
    return {
        "clearances": design.clearances,
        "tensioner": catalogue.get("tensioners", drum.tensioner),
        "spring": None if drum.spring is None else catalogue.get("springs", drum.spring),
        "springs": catalogue.all("springs"),
        "drum": drum,
        "drum_material": catalogue.material(drum.material),
        "shaft_material": catalogue.material(drum.shaft_material),
        "input_pulleys": pulleys,
        "pulley_material": catalogue.material(pulleys.material),
        "support": support,
        "frame_material": catalogue.material(support.material),
    }


def terminal_angle_rad(cable: SectorCable) -> float | None:
    """Angle on the drum, rad, at which a cable is to leave its land; None if the file leaves it out."""
    return None if cable.terminal_angle_deg is None else radians(cable.terminal_angle_deg)


def sector_entries(design: Any) -> Iterator[NamedEntry]:
    """Entries of the catalogue that these blocks name."""
    drum, pulleys = design.drum, design.input_pulleys
    yield NamedEntry(("drum", "material"), "materials", drum.material)
    yield NamedEntry(("drum", "bearing"), "bearings", drum.bearing)
    yield NamedEntry(("drum", "shaft_material"), "materials", drum.shaft_material)
    yield NamedEntry(("drum", "tensioner"), "tensioners", drum.tensioner)
    yield NamedEntry(("drum", "spring"), "springs", drum.spring)
    yield NamedEntry(("input_pulleys", "material"), "materials", pulleys.material)
    for field, name in (("lower_bearing", pulleys.lower_bearing), ("upper_bearing", pulleys.upper_bearing)):
        own = pulleys.overhung and name == NO_BEARING
        yield NamedEntry(("input_pulleys", field), "bearings", None if own else name)
    yield NamedEntry(("input_pulleys", "collar_screw"), "screws", pulleys.collar_screw)
