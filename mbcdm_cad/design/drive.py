"""The resolved design: every reference looked up, every radius known, nothing optional left open.

The YAML file is validated by :mod:`mbcdm_cad.design.loader`; what the other rooms read is the ``Drive`` below.
Units are those of the file: mm, degrees, N, grams, GPa. The model converts to SI in one place of its own.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol, TypeVar

from mbcdm_cad.design.bought import Bearing, CableSpec, Encoder, Gearhead, Material, Motor, Screw, TensionerSpec


@dataclass(frozen=True)
class CableRun:
    """One cable of the drive and the three pitch radii it runs on (to the cable's centre line)."""

    name: str
    input_name: str
    input_side: int  # -1: input at x = -L, +1: at x = +L
    drum_side: int  # +1: runs on the drum towards +x, -1: towards -x
    step: int  # 1..4, axial step on guide and drum
    input_radius_mm: float
    guide_radius_mm: float
    drum_radius_mm: float
    preload_N: float

    @property
    def sigma(self) -> int:
        """Sense in which this cable's tension turns the drum about +Y (mechanism: -1 towards +x, +1 towards -x)."""
        return -self.drum_side


@dataclass(frozen=True)
class Clearances:
    """Gaps the geometry must keep, all in mm between finished surfaces."""

    transfer_gap_mm: float  # guide step 1 surface to the drum's inner face
    land_edge_mm: float  # edge of a drum land to the next cable's contact line
    running_mm: float  # any moving solid to any fixed one, elsewhere


@dataclass(frozen=True)
class Bearings:
    """The bearing chosen for each role."""

    drum: Bearing
    guide: Bearing
    input_lower: Bearing  # next to the gearhead
    input_upper: Bearing  # in the top plate

    def all(self) -> tuple[Bearing, ...]:
        """The four roles in the order drum, guide, input lower, input upper (types may repeat)."""
        return (self.drum, self.guide, self.input_lower, self.input_upper)


@dataclass(frozen=True)
class DrumSpec:
    """Drum sector and its shaft; y is measured along the drum axis from the guide's axis."""

    material: Material
    sector_half_angle_deg: float
    rim_inner_radius_mm: float
    outer_face_y_mm: float
    web_thickness_mm: float
    hub_diameter_mm: float
    hub_face_y_mm: float
    shaft_bore_mm: float
    shaft_material: Material


@dataclass(frozen=True)
class GuideSpec:
    """Guide pulley and its fixed axle."""

    material: Material
    axle_material: Material


@dataclass(frozen=True)
class InputPulleySpec:
    """Input pulleys, both alike but for their radii."""

    material: Material


@dataclass(frozen=True)
class SupportSpec:
    """Frame: back plate, side walls, shelves, ribs and the separate top plate."""

    material: Material
    back_y_mm: float
    back_plate_mm: float
    side_wall_mm: float
    motor_shelf_mm: float
    coupling_space_mm: float
    bearing_shelf_mm: float
    top_plate_mm: float
    rib_mm: float


@dataclass(frozen=True)
class Loads:
    """External torques on the drum that the design is judged at."""

    test_torque_Nm: float
    peak_torque_Nm: float


@dataclass(frozen=True)
class Limits:
    """Limits of this design that the checks hold it against."""

    bend_ratio_min: float
    fleet_angle_max_deg: float
    tension_safety_factor: float
    preload_share_max: float
    frame_windup_max_mrad: float


@dataclass(frozen=True)
class Targets:
    """What mass and box should come to, and by how much they may differ. The box is (X, Z, Y)."""

    mass_g: float
    mass_tolerance_g: float
    prototype_mass_g: float
    envelope_mm: tuple[float, float, float]
    envelope_tolerance_mm: float


@dataclass(frozen=True)
class ExportSettings:
    """Settings of the files written."""

    mesh_tolerance_mm: float


@dataclass(frozen=True)
class Sigmas:
    """Standard deviations of the values that were given with one, 0 for the others; tuples are by cable."""

    preload_N: tuple[float, ...]
    input_radius_mm: tuple[float, ...]
    guide_radius_mm: tuple[float, ...]
    drum_radius_mm: tuple[float, ...]
    centre_distance_mm: float
    friction_coefficient: float
    modulus_GPa: float
    area_mm2: float  # of the area that the modulus refers to
    test_torque_Nm: float
    motor_torque_mNm: float


@dataclass(frozen=True)
class Waiver:
    """A check that may fail, and why."""

    check: str
    reason: str


@dataclass(frozen=True)
class AsBuiltValue:
    """One figure of an effect, SI; ``low`` and ``high``: its 95 % interval where it is known."""

    name: str
    value: float
    low: float | None
    high: float | None


@dataclass(frozen=True)
class AsBuilt:
    """An effect that the built drive was found to have; no cables: all."""

    name: str
    form: str
    stage: str | None
    cables: tuple[str, ...]
    values: tuple[AsBuiltValue, ...]
    source: str | None


@dataclass(frozen=True)
class Drive:
    """All that the model, the checks and the parts need to know of one design.

    ``as_built`` holds what was found on the built drive and is not among its values; a modulus, preload or friction
    that was found is (:mod:`mbcdm_cad.design.as_built`).

    ``screws`` and ``materials`` hold the whole catalogue with the design's own entries, since parts choose screws by
    name and bought parts name their material.
    """

    name: str
    configuration: str
    cables: tuple[CableRun, ...]
    input_names: tuple[str, ...]
    input_sides: tuple[int, ...]
    centre_distance_mm: float
    half_travel_deg: float
    stop_clearance_deg: float
    cable: CableSpec
    friction_coefficient: float
    helix_lead_mm: float
    dead_turns: float
    radii_explicit: bool
    clearances: Clearances
    motor: Motor
    gearhead: Gearhead
    encoder: Encoder
    drum_encoder: Encoder
    bearings: Bearings
    tensioner: TensionerSpec
    drum: DrumSpec
    guide: GuideSpec
    input_pulleys: InputPulleySpec
    support: SupportSpec
    loads: Loads
    limits: Limits
    targets: Targets
    export: ExportSettings
    waivers: tuple[Waiver, ...]
    screws: tuple[Screw, ...]
    materials: tuple[Material, ...]
    sigmas: Sigmas
    as_built: tuple[AsBuilt, ...]

    def screw(self, name: str) -> Screw:
        """The screw of the catalogue called ``name``; KeyError if there is none."""
        return _named(self.screws, name, "screw")

    def material(self, name: str) -> Material:
        """The material of the catalogue called ``name``; KeyError if there is none."""
        return _named(self.materials, name, "material")

    def waiver(self, check: str) -> Waiver | None:
        """The waiver for the check with this id, if the design holds one."""
        return next((waiver for waiver in self.waivers if waiver.check == check), None)


class _Named(Protocol):
    @property
    def name(self) -> str: ...


_Entry = TypeVar("_Entry", bound=_Named)


def _named(entries: tuple[_Entry, ...], name: str, kind: str) -> _Entry:
    for entry in entries:
        if entry.name == name:
            return entry
    raise KeyError(f"no {kind} {name!r} in the catalogue; it holds {', '.join(entry.name for entry in entries)}")
