"""Entries of the catalogue as the other rooms read them: materials, ropes, bearings, motors and others.

The entries of catalogue files are validated by :mod:`mbcdm_cad.design.entries`, with the same field names. Units are
those of the files: mm, N, grams, GPa.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True)
class Material:
    """A material of the catalogue. ``colour`` is linear RGB in 0..1."""

    name: str
    density_g_cm3: float
    youngs_modulus_GPa: float
    poisson_ratio: float
    yield_MPa: float
    process: str  # "milled", "turned", "printed" (filament), "sintered" (powder) or "bought"
    min_wall_mm: float
    min_internal_radius_mm: float
    colour: tuple[float, float, float]
    source: str

    @property
    def printed(self) -> bool:
        """Whether parts of it are 3D printed, from filament or from powder."""
        return self.process in ("printed", "sintered")


# A wall of filament needs at least two lines to be closed.
WALL_LINES = 2


def least_wall_mm(process: str, min_wall_mm: float, nozzle_mm: float) -> float:
    """Thinnest wall of a material: its own limit, and of filament two lines of the nozzle."""
    return max(min_wall_mm, WALL_LINES * nozzle_mm) if process == "printed" else min_wall_mm


@dataclass(frozen=True)
class CableSpec:
    """The rope. E is never given without the area it refers to (``area_mm2``)."""

    name: str
    construction: str
    diameter_mm: float
    metallic_area_mm2: float
    modulus_GPa: float
    modulus_area: str  # "metallic" or "nominal"
    breaking_load_N: float
    mass_g_m: float
    bedding_in_share: float  # lasting stretch in the first runs under load, over the length
    bend_ratio_minimum: float
    bend_ratio_desired: float
    material: str
    source: str
    creep_per_decade: float = 0.0  # strain, extrapolated to the breaking load
    creep_per_year: float = 0.0  # steady strain at 0.3 of the breaking load and 20 degrees C
    creep_load_exponent: float = 1.0
    creep_activation_kJ_mol: float = 0.0

    @property
    def area_mm2(self) -> float:
        """Area that ``modulus_GPa`` refers to: metallic, or pi d^2 / 4 (nominal)."""
        if self.modulus_area == "metallic":
            return self.metallic_area_mm2
        return 3.141592653589793 * self.diameter_mm**2 / 4.0

    @property
    def axial_stiffness_N(self) -> float:
        """EA in N (GPa x mm^2 = kN)."""
        return self.modulus_GPa * self.area_mm2 * 1e3


@dataclass(frozen=True)
class TerminationSpec:
    """A way of ending a rope; ratios are over the rope's diameter."""

    name: str
    constructions: tuple[str, ...]
    smallest_mm: float
    largest_mm: float
    strength_share: float  # of the rope's breaking load
    sleeve_ratio: float
    grip_ratio: float
    stop_radius_ratio: float
    stop_length_ratio: float
    source: str

    def fits(self, rope: CableSpec) -> bool:
        """Whether it is made on ropes of this construction and diameter."""
        return rope.construction in self.constructions and self.smallest_mm <= rope.diameter_mm <= self.largest_mm


@dataclass(frozen=True)
class Bearing:
    """Deep-groove bearing: bore d, outside D, width B; shoulder limits d_a (inner ring) and D_a (outer ring)."""

    name: str
    bore_mm: float
    outer_diameter_mm: float
    width_mm: float
    inner_shoulder_mm: float
    outer_shoulder_mm: float
    static_rating_N: float
    mass_g: float
    source: str


@dataclass(frozen=True)
class Motor:
    """A motor. Electrical values and face are None where the catalogue holds none.

    Torque constant and resistance are those of a DC machine between two terminals: torque = constant x current, copper
    loss = resistance x current^2. A sinusoidal drive of the same torque loses as much.
    """

    name: str
    diameter_mm: float
    length_mm: float
    rated_torque_mNm: float
    rotor_inertia_g_cm2: float
    mass_g: float
    source: str
    torque_constant_mNm_A: float | None = None
    resistance_ohm: float | None = None
    continuous_current_A: float | None = None
    peak_current_A: float | None = None
    voltage_V: float | None = None
    pole_pairs: int | None = None
    radial_load_N: float | None = None
    shaft_diameter_mm: float | None = None
    shaft_length_mm: float | None = None
    pilot_diameter_mm: float | None = None
    pilot_height_mm: float | None = None
    bolt_circle_mm: float | None = None
    screw: str | None = None
    screw_count: int | None = None

    @property
    def peak_torque_mNm(self) -> float:
        """Torque at the peak current; the continuous torque where the catalogue has no current."""
        if self.torque_constant_mNm_A is None or self.peak_current_A is None:
            return self.rated_torque_mNm
        return self.torque_constant_mNm_A * self.peak_current_A


# Fields that a motor's entry needs to drive an input without a gearhead.
FACE_FIELDS = (
    "radial_load_N",
    "shaft_diameter_mm",
    "shaft_length_mm",
    "pilot_diameter_mm",
    "pilot_height_mm",
    "bolt_circle_mm",
    "screw",
    "screw_count",
)


@dataclass(frozen=True)
class Gearhead:
    """Gearhead on the motor: body, output shaft, face pattern."""

    name: str
    ratio: float
    efficiency: float
    rated_torque_mNm: float
    diameter_mm: float
    length_mm: float
    shaft_diameter_mm: float
    shaft_length_mm: float
    pilot_diameter_mm: float
    pilot_height_mm: float
    bolt_circle_mm: float
    screw: str
    screw_count: int
    max_torque_mNm: float
    radial_load_N: float
    mass_g: float
    source: str

    @property
    def absent(self) -> bool:
        """Whether there is no gearhead: the values are then those of the motor's own face."""
        return self.name == NO_GEARHEAD


# Name in place of a gearhead in a design file whose motor drives the input directly.
NO_GEARHEAD = "none"


def missing_face_fields(motor: Motor) -> list[str]:
    """Fields that the motor's entry lacks to drive an input without a gearhead."""
    return [name for name in FACE_FIELDS if getattr(motor, name) is None]


def without_gearhead(motor: Motor) -> Gearhead:
    """The motor's own shaft and face as a gearhead of ratio 1 without losses, length and mass.

    ``KeyError`` names a field that the motor's entry lacks for this.
    """
    missing = missing_face_fields(motor)
    if missing:
        raise KeyError(f"motor {motor.name}: no {', '.join(missing)}")
    values: dict[str, Any] = {name: getattr(motor, name) for name in FACE_FIELDS}
    return Gearhead(
        name=NO_GEARHEAD,
        ratio=1.0,
        efficiency=1.0,
        rated_torque_mNm=motor.rated_torque_mNm,
        max_torque_mNm=motor.peak_torque_mNm,
        diameter_mm=motor.diameter_mm,
        length_mm=0.0,
        mass_g=0.0,
        source=motor.source,
        **values,
    )


@dataclass(frozen=True)
class Encoder:
    """Encoder housing on a shaft, fixed by axial screws on a bolt circle."""

    name: str
    resolution_urad: float
    diameter_mm: float
    length_mm: float
    bore_mm: float
    bolt_circle_mm: float
    screw: str
    screw_count: int
    mass_g: float
    source: str


@dataclass(frozen=True)
class Screw:
    """Socket-head cap screw or set screw (``head_diameter_mm`` 0). ``key_mm`` is across flats of the socket."""

    name: str
    thread_mm: float
    tap_drill_mm: float
    clearance_mm: float
    length_mm: float
    head_diameter_mm: float
    head_height_mm: float
    key_mm: float
    mass_g: float
    source: str


@dataclass(frozen=True)
class InsertSpec:
    """Knurled brass bush with an inside thread, set with heat into a hole of a printed part."""

    name: str
    thread_mm: float
    hole_mm: float
    outside_mm: float
    length_mm: float
    wall_mm: float  # of plastic round the hole
    mass_g: float
    source: str

    @property
    def depth_mm(self) -> float:
        """Least depth of its hole, mm, with room below it for the displaced plastic."""
        return self.length_mm + 1.0


def shortest_insert(inserts: Iterable[InsertSpec], thread_mm: float) -> InsertSpec | None:
    """The shortest insert that holds a screw of this thread over its diameter; None where there is none."""
    fitting = [insert for insert in inserts if insert.length_mm >= thread_mm == insert.thread_mm]
    return min(fitting, key=lambda insert: insert.length_mm, default=None)


@dataclass(frozen=True)
class TensionerSpec:
    """Threaded terminal swaged on the cable, nut and lock nut against a lug of the drum."""

    name: str
    thread_mm: float
    clearance_mm: float
    stress_area_mm2: float
    pitch_mm: float
    nut_across_flats_mm: float
    nut_height_mm: float
    swage_diameter_mm: float
    swage_flats_mm: float  # across the two flats that keep the terminal from turning
    swage_length_mm: float
    lug_thickness_mm: float
    stud_length_mm: float
    material: str
    source: str
