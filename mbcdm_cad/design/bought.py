"""Entries of the catalogue, one class per kind: what a file states is the bought part that all rooms read.

Fields are declared with unit, bounds and meaning; pydantic validates those of a design's own entries by them. An
object made in Python is not validated. Units are those of the files: mm, N, grams, GPa.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field
from math import tau
from typing import Annotated, Any, Literal

from pydantic import BeforeValidator, Field
from pydantic.json_schema import SkipJsonSchema
from pydantic_core import PydanticCustomError

from mbcdm_cad.design.fields import EntryName, Integer, Number, PlainBlock, Text, entry_field


def _no_field_of_files(value: Any) -> Any:
    raise PydanticCustomError("extra_forbidden", "Extra inputs are not permitted")


@dataclass(frozen=True, kw_only=True)
class Entry(PlainBlock):
    """Anything in the catalogue."""

    # In files the key above the entry.
    name: SkipJsonSchema[Annotated[str, BeforeValidator(_no_field_of_files)]] = field(
        default="", metadata={"exclude": True}
    )
    source: Text = entry_field("source of the values; says 'estimate' for a value that is estimated")
    price_EUR: Number | None = entry_field(
        "price of a piece, of a metre of rope, of a kilogram of a material", ge=0.0, le=1e6
    )
    price_source: Text | None = entry_field("source of the price; says 'estimate' for one")


@dataclass(frozen=True, kw_only=True)
class LifeAnchor(PlainBlock):
    """A bending test of one's own on a rope; it replaces the generic figures of its life."""

    bendings: Number = entry_field("bendings on and off a pulley at which half of the ropes had broken", gt=0.0, le=1e9)
    bend_ratio: Number = entry_field(
        "diameter of the test's pulley at the rope's centre line over the rope's", gt=1.0, le=1000.0
    )
    load_share: Number = entry_field("tension in the test over the breaking load", gt=0.0, le=1.0)
    groove: Number | None = entry_field(
        "radius of its groove over the rope's diameter; smooth if left out", ge=0.5, le=5.0
    )
    lubrication: Literal["oiled", "dry"] = entry_field("how the rope was run")
    count: Integer = entry_field("number of ropes tested", ge=1, le=1000)
    source: Text = entry_field("who tested, when and how")


@dataclass(frozen=True, kw_only=True)
class CableSpec(Entry):
    """A rope. Its modulus always comes with the area to which it refers."""

    construction: Literal["7x7", "7x19", "1x19", "braid"] = entry_field("strands x wires, or braid for fibre")
    diameter_mm: Number = entry_field("nominal diameter", uncertain=True, ge=0.2, le=5.0)
    metallic_area_mm2: Number = entry_field("cross-section of all wires or fibres", uncertain=True, gt=0.0, le=20.0)
    modulus_GPa: Number = entry_field("effective tensile modulus of the rope", uncertain=True, ge=1.0, le=250.0)
    modulus_area: Literal["metallic", "nominal"] = entry_field("area the modulus refers to: wires, or pi d^2 / 4")
    breaking_load_N: Number = entry_field("minimum breaking load", ge=10.0, le=50000.0)
    mass_g_m: Number = entry_field("mass per length", gt=0.0, le=200.0)
    bedding_in_share: Number = entry_field(
        "permanent stretch in the first runs under load, over the length (constructional stretch)",
        default=0.003,
        ge=0.0,
        le=0.05,
    )
    creep_per_decade: Number = entry_field(
        "strain a decade of time, extrapolated to the breaking load; none for wire", default=0.0, ge=0.0, le=0.1
    )
    creep_per_year: Number = entry_field(
        "steady strain a year at 0.3 of the breaking load and 20 degrees C", default=0.0, ge=0.0, le=1.0
    )
    creep_load_exponent: Number = entry_field("power of the load in the steady creep", default=1.0, ge=1.0, le=20.0)
    creep_activation_kJ_mol: Number = entry_field(
        "activation energy of the steady creep", default=0.0, ge=0.0, le=500.0
    )
    bend_ratio_minimum: Number = entry_field("smallest D/d that the maker allows", ge=1.0, le=200.0)
    bend_ratio_desired: Number = entry_field("D/d that the maker recommends", ge=1.0, le=200.0)
    material: EntryName = entry_field("material of the wires")
    life_anchor: LifeAnchor | None = entry_field(
        "a bending test of one's own, from which the life of the cables is scaled"
    )

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


@dataclass(frozen=True, kw_only=True)
class TerminationSpec(Entry):
    """A way to make the ends of a rope: a terminal's sleeve at one end, a stop at the other."""

    constructions: tuple[Literal["7x7", "7x19", "1x19", "braid"], ...] = entry_field(
        "constructions of rope for which it is made", min_length=1, max_length=4
    )
    smallest_mm: Number = entry_field("thinnest rope for which it is made", ge=0.1, le=20.0)
    largest_mm: Number = entry_field("thickest rope for which it is made", ge=0.1, le=20.0)
    strength_share: Number = entry_field("strength of the end divided by the rope's breaking load", gt=0.0, le=1.0)
    sleeve_ratio: Number = entry_field(
        "smallest diameter of the terminal's sleeve divided by the rope's", ge=1.1, le=10.0
    )
    grip_ratio: Number = entry_field(
        "smallest length of rope in the sleeve divided by the rope's diameter", ge=0.5, le=30.0
    )
    stop_radius_ratio: Number = entry_field("radius of the stop over the rope's diameter", ge=0.6, le=5.0)
    stop_length_ratio: Number = entry_field("length of the stop over the rope's diameter", ge=0.5, le=20.0)
    setting_ratio: Number = entry_field(
        "rope that the end gives off at its first loads, over the rope's diameter: a knot tightens, a clamp beds in",
        default=0.0,
        ge=0.0,
        le=20.0,
    )
    tail_ratio: Number = entry_field(
        "rope that making the end uses beyond sleeve or stop, over the rope's diameter; counted in the length to cut",
        default=0.0,
        ge=0.0,
        le=200.0,
    )
    making: Text | None = entry_field("how it is made, for the order of assembly")

    def fits(self, rope: CableSpec) -> bool:
        """Whether it is made on ropes of this construction and diameter."""
        return rope.construction in self.constructions and self.smallest_mm <= rope.diameter_mm <= self.largest_mm


@dataclass(frozen=True, kw_only=True)
class Servo(PlainBlock):
    """What makes a motor a bought servo: gears and sensor of its own, a housing with ears, and a horn on its spline.

    Heights count from the front faces of the ears, which lie on the frame.
    """

    ratio: Number = entry_field("reduction of its own gears", ge=1.0, le=10000.0)
    efficiency: Number = entry_field("efficiency of its gears", gt=0.0, le=1.0)
    rated_torque_mNm: Number = entry_field("continuous torque at the horn", gt=0.0, le=1e6)
    max_torque_mNm: Number = entry_field("torque at the horn at standstill", gt=0.0, le=1e6)
    stiffness_Nm_rad: Number = entry_field("torsional stiffness of its gears at the horn", gt=0.0, le=1e7)
    lash_deg: Number = entry_field("play of its gears at the horn, from one side to the other", ge=0.0, le=20.0)
    sensor: Literal["output", "motor"] = entry_field("where its own sensor is: on the horn's shaft, or the motor's")
    sensor_steps: Integer = entry_field("steps a turn of its sensor", ge=16, le=2**26)
    body_mm: Number = entry_field("length of its housing", ge=5.0, le=200.0)
    width_mm: Number = entry_field("width of its housing", ge=3.0, le=150.0)
    behind_mm: Number = entry_field("depth of its housing behind the ears' front", ge=1.0, le=200.0)
    before_mm: Number = entry_field("height of its housing before the ears' front", ge=0.5, le=50.0)
    axis_mm: Number = entry_field("horn's axis from the middle of the housing, along its length", ge=0.0, le=100.0)
    ears_mm: Number = entry_field("length over both ears", ge=6.0, le=300.0)
    ear_mm: Number = entry_field("thickness of the ears", ge=0.5, le=20.0)
    hole_length_mm: Number = entry_field("distance of the ears' holes along the length", ge=6.0, le=300.0)
    hole_width_mm: Number = entry_field("distance of the ears' holes along the width", ge=2.0, le=150.0)
    spline: Text = entry_field("teeth of its spline, as makers of horns name it")
    horn_mm: Number = entry_field("diameter of its horn, a disc", ge=5.0, le=150.0)
    horn_face_mm: Number = entry_field("front of the horn before the ears' front", ge=2.0, le=100.0)
    horn_thickness_mm: Number = entry_field("thickness of the horn", ge=0.5, le=30.0)
    horn_circle_mm: Number = entry_field("diameter of the circle of the horn's threads", ge=3.0, le=140.0)
    horn_screw: EntryName = entry_field("screw for the horn's threads")
    horn_screws: Integer = entry_field("number of those threads", ge=2, le=12)
    centre_screw: EntryName = entry_field("screw that holds the horn on its spline")


@dataclass(frozen=True, kw_only=True)
class Motor(Entry):
    """A motor. A motor with a shaft and a mounting face can be used without a gearhead.

    Torque constant and resistance are those between two terminals (60 / (2 pi Kv), phase to phase).
    """

    diameter_mm: Number = entry_field("body diameter", ge=3.0, le=400.0)
    length_mm: Number = entry_field("body length", ge=3.0, le=300.0)
    rated_torque_mNm: Number = entry_field("continuous torque", uncertain=True, gt=0.0, le=100000.0)
    rotor_inertia_g_cm2: Number = entry_field("rotor inertia", gt=0.0, le=1e6)
    mass_g: Number = entry_field("mass", gt=0.0, le=50000.0)
    torque_constant_mNm_A: Number | None = entry_field("torque over current, 60 / (2 pi Kv)", gt=0.0, le=1e5)
    resistance_ohm: Number | None = entry_field("resistance between two terminals", gt=0.0, le=1000.0)
    no_load_current_A: Number | None = entry_field(
        "current that turns it without a load: its friction is this times the torque constant", gt=0.0, le=100.0
    )
    continuous_current_A: Number | None = entry_field("continuous current", gt=0.0, le=1000.0)
    peak_current_A: Number | None = entry_field("largest current for a short time", gt=0.0, le=5000.0)
    voltage_V: Number | None = entry_field("voltage that the motor is made for", gt=0.0, le=1000.0)
    pole_pairs: Integer | None = entry_field("pairs of magnet poles", ge=1, le=100)
    winding_limit_C: Number | None = entry_field("hottest winding; 125 if left out", ge=40.0, le=300.0)
    # Thermal figures, each estimated from size or mass if left out.
    winding_K_W: Number | None = entry_field("thermal resistance, winding to housing", gt=0.0, le=1e3)
    housing_K_W: Number | None = entry_field("thermal resistance, housing to air", gt=0.0, le=1e3)
    radial_load_N: Number | None = entry_field("radial load that the shaft can take", gt=0.0, le=10000.0)
    radial_load_at_mm: Number | None = entry_field(
        "distance from the face at which it can take radial_load_N; half the shaft's length if left out",
        gt=0.0,
        le=200.0,
    )
    bearing_span_mm: Number | None = entry_field(
        "distance between the shaft's own bearings; 0.6 of the body's length if left out", gt=0.0, le=300.0
    )
    shaft_diameter_mm: Number | None = entry_field("shaft diameter", ge=1.0, le=40.0)
    shaft_length_mm: Number | None = entry_field("shaft length from the face", ge=1.0, le=80.0)
    pilot_diameter_mm: Number | None = entry_field("centring boss diameter", ge=1.0, le=200.0)
    pilot_height_mm: Number | None = entry_field("centring boss height", ge=0.1, le=10.0)
    bolt_circle_mm: Number | None = entry_field("diameter of the screws' circle on the face", ge=2.0, le=300.0)
    screw: EntryName | None = entry_field("screw that holds it at the face")
    screw_count: Integer | None = entry_field("number of those screws", ge=2, le=12)
    winding_time_s: Number | None = entry_field("thermal time constant, winding", gt=0.0, le=1e5)
    motor_time_s: Number | None = entry_field("thermal time constant, motor", gt=0.0, le=1e6)
    servo: Servo | None = entry_field(
        "gears, sensor, housing and horn of a servo; the entry's torques, constants and rotor are of the motor in "
        "it, its shaft the spline, its screws those of the ears"
    )

    def __post_init__(self) -> None:
        # Entries of the package are read as plain data.
        if isinstance(self.servo, dict):
            object.__setattr__(self, "servo", Servo(**self.servo))

    @property
    def brushless(self) -> bool:
        """Whether it has no brushes: the catalogue has its pairs of poles."""
        return self.pole_pairs is not None

    @property
    def idle_torque_mNm(self) -> float | None:
        """Torque that turns it without current, by its no-load current; None where the catalogue has none."""
        if self.no_load_current_A is None or self.torque_constant_mNm_A is None:
            return None
        return self.no_load_current_A * self.torque_constant_mNm_A

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


@dataclass(frozen=True, kw_only=True)
class Gearhead(Entry):
    """A gearhead: body, output shaft and face pattern."""

    ratio: Number = entry_field("reduction", ge=1.0, le=10000.0)
    efficiency: Number = entry_field("efficiency at rated torque", gt=0.0, le=1.0)
    rated_torque_mNm: Number = entry_field("continuous output torque", gt=0.0, le=1e6)
    max_torque_mNm: Number = entry_field("intermittent output torque", gt=0.0, le=1e6)
    radial_load_N: Number = entry_field("radial load that the output shaft can take", gt=0.0, le=10000.0)
    radial_load_at_mm: Number | None = entry_field(
        "distance from the face at which it can take radial_load_N; half the shaft's length if left out",
        gt=0.0,
        le=200.0,
    )
    bearing_span_mm: Number | None = entry_field(
        "distance between the output shaft's own bearings; 0.3 of the body's length if left out", gt=0.0, le=300.0
    )
    stiffness_Nm_rad: Number | None = entry_field(
        "torsional stiffness at the output; estimated from the diameter if left out", gt=0.0, le=1e7
    )
    diameter_mm: Number = entry_field("body diameter", ge=3.0, le=100.0)
    length_mm: Number = entry_field("body length", ge=3.0, le=200.0)
    shaft_diameter_mm: Number = entry_field("output shaft diameter", ge=1.0, le=20.0)
    shaft_length_mm: Number = entry_field("output shaft length from the face", ge=1.0, le=60.0)
    pilot_diameter_mm: Number = entry_field("centring boss diameter", ge=1.0, le=60.0)
    pilot_height_mm: Number = entry_field("centring boss height", ge=0.1, le=10.0)
    bolt_circle_mm: Number = entry_field("diameter of the screws' circle on the face", ge=2.0, le=90.0)
    screw: EntryName = entry_field("screw that holds it at the face")
    screw_count: Integer = entry_field("number of those screws", ge=1, le=12)
    mass_g: Number = entry_field("mass", gt=0.0, le=5000.0)

    @property
    def absent(self) -> bool:
        """Whether there is no gearhead: the values are then those of the motor's own face."""
        return self.name == NO_GEARHEAD

    @property
    def span_mm(self) -> float:
        """Distance between the shaft's own bearings, the front one at the face: stated, else estimated."""
        return GEARHEAD_SPAN * self.length_mm if self.bearing_span_mm is None else self.bearing_span_mm

    @property
    def front_reaction_N(self) -> float:
        """Load of the shaft's front bearing under the permitted radial load: it decides (statics of a beam)."""
        at = self.shaft_length_mm / 2 if self.radial_load_at_mm is None else self.radial_load_at_mm
        return self.radial_load_N * (at + self.span_mm) / self.span_mm

    def permitted_N(self, at_mm: float) -> float:
        """Radial load that the shaft can take at a distance from the face: the one with the same load in front."""
        return self.front_reaction_N * self.span_mm / (at_mm + self.span_mm)


# Distance between the bearings of an output shaft over the body's length, of gearheads and of motors (estimates: the
# output stage takes a third of a gearhead, a motor's bearings stand in its two ends).
GEARHEAD_SPAN, MOTOR_SPAN = 0.3, 0.6
# Name in place of a gearhead in a design file whose motor drives the input directly.
NO_GEARHEAD = "none"
# Name of the gears of a servo in place of a gearhead's.
OWN_GEARS = "own"


@dataclass(frozen=True, kw_only=True)
class ServoOutput(Gearhead):
    """The gears of a servo, with its housing and horn, in place of a gearhead."""

    servo: Servo


# Name of a first cable stage in place of a gearhead's.
FIRST_STAGE = "first-stage"


@dataclass(frozen=True, kw_only=True)
class CableStageOutput(Gearhead):
    """A first cable stage in place of a gearhead: its drum's shaft turns the input, its frame's boss is the face.

    Ratio, losses and stiffness are those from the motor's shaft, its own gearhead included, to the end of that shaft.
    ``idle_torque_Nm``: friction at its output without load, apart from the motor's own; ``lash_rad``: play there
    with the motor held.
    """

    idle_torque_Nm: float
    lash_rad: float


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
    values: dict[str, Any] = {name: getattr(motor, name) for name in (*FACE_FIELDS, "radial_load_at_mm")}
    values |= {"source": motor.source, "length_mm": 0.0, "mass_g": 0.0}
    servo, length_mm = motor.servo, motor.length_mm if motor.servo is None else motor.servo.before_mm
    values["bearing_span_mm"] = MOTOR_SPAN * length_mm if motor.bearing_span_mm is None else motor.bearing_span_mm
    if servo is not None:
        gears = ("ratio", "efficiency", "rated_torque_mNm", "max_torque_mNm", "stiffness_Nm_rad")
        values |= {name: getattr(servo, name) for name in gears}
        return ServoOutput(name=OWN_GEARS, diameter_mm=servo.width_mm, servo=servo, **values)
    return Gearhead(
        name=NO_GEARHEAD,
        ratio=1.0,
        efficiency=1.0,
        rated_torque_mNm=motor.rated_torque_mNm,
        max_torque_mNm=motor.peak_torque_mNm,
        diameter_mm=motor.diameter_mm,
        **values,
    )


# Name in place of an encoder in a design file of a drive without one.
NO_ENCODER = "none"
# Steps a turn of the encoder that a motor has in its own housing: 14 bit (usual of magnetic ones; estimate).
MOTOR_ENCODER_STEPS = 2**14


@dataclass(frozen=True, kw_only=True)
class Encoder(Entry):
    """An encoder housing on a shaft."""

    resolution_urad: Number = entry_field("resolution", gt=0.0, le=100000.0)
    diameter_mm: Number = entry_field("housing diameter", ge=3.0, le=100.0)
    length_mm: Number = entry_field("housing length", ge=1.0, le=100.0)
    bore_mm: Number = entry_field("bore of the hub", ge=0.5, le=60.0)
    bolt_circle_mm: Number = entry_field("diameter of the screws' circle", ge=2.0, le=90.0)
    screw: EntryName = entry_field("screw that holds the housing")
    screw_count: Integer = entry_field("number of those screws", ge=1, le=12)
    mass_g: Number = entry_field("mass", gt=0.0, le=1000.0)

    @property
    def absent(self) -> bool:
        """Whether there is no encoder: no size, the resolution of the motor's own, seen at its gearhead's output."""
        return self.name == NO_ENCODER


def without_encoder(gearhead: Gearhead, motor_turns: float) -> Encoder:
    """No encoder: the motor's own, or the sensor of a servo, tells where its input is.

    ``motor_turns``: turns of the motor for one of its input, by gearhead and stage.
    """
    step = tau / MOTOR_ENCODER_STEPS / motor_turns
    if isinstance(gearhead, ServoOutput):
        servo = gearhead.servo
        step = tau / servo.sensor_steps / (servo.ratio if servo.sensor == "motor" else 1.0)
    return Encoder(
        name=NO_ENCODER,
        resolution_urad=step * 1e6,
        diameter_mm=0.0,
        length_mm=0.0,
        bore_mm=0.0,
        bolt_circle_mm=0.0,
        screw="M1.6x4",
        screw_count=0,
        mass_g=0.0,
        source="none; resolution of the motor's own: estimate, 14 bit",
    )


@dataclass(frozen=True, kw_only=True)
class Bearing(Entry):
    """A deep-groove ball bearing."""

    bore_mm: Number = entry_field("bore d", ge=1.0, le=200.0)
    outer_diameter_mm: Number = entry_field("outside diameter D", ge=2.0, le=250.0)
    width_mm: Number = entry_field("width B", ge=0.5, le=30.0)
    inner_shoulder_mm: Number = entry_field("shoulder diameter d_a at the inner ring", ge=1.0, le=250.0)
    outer_shoulder_mm: Number = entry_field("shoulder diameter D_a at the outer ring", ge=1.0, le=250.0)
    static_rating_N: Number = entry_field("static load rating C0", gt=0.0, le=100000.0)
    mass_g: Number = entry_field("mass", gt=0.0, le=2000.0)


# Name in place of the bearings of an input pulley in a design file whose motor carries it.
NO_BEARING = "none"
# Outside diameter, width and shoulders of a motor's own bearings over the bore: those of the series 60 and 62.
OWN_OUTSIDE, OWN_WIDTH, OWN_INNER, OWN_OUTER = 2.5, 0.8, 1.4, 2.1


def own_bearing(face: Gearhead) -> Bearing:
    """Either bearing of the shaft of a motor or gearhead, as catalogues describe none: by the shaft's diameter.

    Its static rating is the load of the front one under the permitted radial load.
    """
    d = face.shaft_diameter_mm
    return Bearing(
        name=NO_BEARING,
        bore_mm=d,
        outer_diameter_mm=OWN_OUTSIDE * d,
        width_mm=OWN_WIDTH * d,
        inner_shoulder_mm=OWN_INNER * d,
        outer_shoulder_mm=OWN_OUTER * d,
        static_rating_N=face.front_reaction_N,
        mass_g=0.0,
        source="the motor's own; proportions of usual bearings: estimate",
    )


@dataclass(frozen=True, kw_only=True)
class Screw(Entry):
    """A socket-head cap screw, or a set screw (head sizes 0)."""

    thread_mm: Number = entry_field("nominal thread diameter", ge=0.5, le=12.0)
    tap_drill_mm: Number = entry_field("tapping drill", ge=0.3, le=12.0)
    clearance_mm: Number = entry_field("clearance hole", ge=0.5, le=15.0)
    length_mm: Number = entry_field("length below the head", ge=1.0, le=100.0)
    head_diameter_mm: Number = entry_field("head diameter", ge=0.0, le=25.0)
    head_height_mm: Number = entry_field("head height", ge=0.0, le=15.0)
    key_mm: Number = entry_field("hexagon socket across flats", ge=0.3, le=12.0)
    mass_g: Number = entry_field("mass", gt=0.0, le=200.0)


@dataclass(frozen=True, kw_only=True)
class InsertSpec(Entry):
    """A knurled brass bush with an inside thread, set with heat into a hole of a printed part."""

    thread_mm: Number = entry_field("nominal thread diameter", ge=1.0, le=12.0)
    hole_mm: Number = entry_field("diameter of the hole that it is set into", ge=1.0, le=20.0)
    outside_mm: Number = entry_field("diameter over the knurls", ge=1.0, le=20.0)
    length_mm: Number = entry_field("length", ge=1.0, le=40.0)
    wall_mm: Number = entry_field("least wall of plastic round the hole", ge=0.2, le=20.0)
    mass_g: Number = entry_field("mass", gt=0.0, le=100.0)

    @property
    def depth_mm(self) -> float:
        """Least depth of its hole, mm, with room below it for the displaced plastic."""
        return self.length_mm + 1.0


def shortest_insert(inserts: Iterable[InsertSpec], thread_mm: float) -> InsertSpec | None:
    """The shortest insert that holds a screw of this thread over its diameter; None where there is none."""
    fitting = [insert for insert in inserts if insert.length_mm >= thread_mm == insert.thread_mm]
    return min(fitting, key=lambda insert: insert.length_mm, default=None)


@dataclass(frozen=True, kw_only=True)
class TensionerSpec(Entry):
    """A threaded terminal swaged on the cable, with nut and lock nut."""

    thread_mm: Number = entry_field("nominal thread diameter", ge=0.5, le=12.0)
    clearance_mm: Number = entry_field("clearance hole in the lug", ge=0.5, le=15.0)
    stress_area_mm2: Number = entry_field("tensile stress area of the thread", gt=0.0, le=100.0)
    pitch_mm: Number = entry_field("pitch of the thread", gt=0.0, le=3.0)
    nut_across_flats_mm: Number = entry_field("nut across flats", ge=1.0, le=25.0)
    nut_height_mm: Number = entry_field("nut height", ge=0.3, le=15.0)
    swage_diameter_mm: Number = entry_field("diameter of the swaged sleeve", ge=0.5, le=20.0)
    swage_flats_mm: Number = entry_field(
        "across the two flats of the sleeve, which keep it from turning", ge=0.4, le=20.0
    )
    swage_length_mm: Number = entry_field("length of the swaged sleeve", ge=0.5, le=50.0)
    lug_thickness_mm: Number = entry_field("thickness of the drum's lug along the stud", ge=0.5, le=20.0)
    stud_length_mm: Number = entry_field("length from the front of the sleeve to the end of the stud", ge=2.0, le=100.0)
    material: EntryName = entry_field("material of stud, sleeve and nuts")


@dataclass(frozen=True, kw_only=True)
class SpringSpec(Entry):
    """A compression spring on the stud of a terminal, between lug and nut: a disc of a stack, or a coil."""

    kind: Literal["disc", "coil"] = entry_field("disc spring (DIN EN 16983), or coil of round wire")
    outside_mm: Number = entry_field("outside diameter", ge=1.0, le=60.0)
    inside_mm: Number = entry_field("inside diameter, round the stud", ge=0.5, le=40.0)
    strip_mm: Number = entry_field("thickness of a disc, or diameter of the wire", ge=0.05, le=10.0)
    free_mm: Number = entry_field("height without load", ge=0.1, le=100.0)
    solid_mm: Number = entry_field("height at which it is flat, or its coils touch", ge=0.05, le=100.0)
    stiffness_N_mm: Number = entry_field("force over deflection within its usable travel", gt=0.0, le=1e6)
    usable_share: Number = entry_field("most of the way from free to solid that it stands for long", gt=0.0, le=1.0)
    mass_g: Number = entry_field("mass", gt=0.0, le=500.0)
    material: EntryName = entry_field("material")

    @property
    def usable_N(self) -> float:
        """Largest force that it stands for long."""
        return self.stiffness_N_mm * self.usable_share * (self.free_mm - self.solid_mm)


Fraction = Annotated[Number, Field(ge=0.0, le=1.0)]


@dataclass(frozen=True, kw_only=True)
class Material(Entry):
    """A material and the limits of its process."""

    density_g_cm3: Number = entry_field("density", ge=0.1, le=25.0)
    youngs_modulus_GPa: Number = entry_field("Young's modulus", ge=0.01, le=1000.0)
    poisson_ratio: Number = entry_field("Poisson's ratio", ge=0.0, lt=0.5)
    yield_MPa: Number = entry_field("yield strength", ge=1.0, le=5000.0)
    process: Literal["milled", "turned", "printed", "sintered", "bought"] = entry_field(
        "process by which parts are made; printed: from filament, sintered: from powder"
    )
    min_wall_mm: Number = entry_field("thinnest wall that can be made", ge=0.0, le=10.0)
    min_internal_radius_mm: Number = entry_field("smallest internal corner radius", ge=0.0, le=10.0)
    colour: tuple[Fraction, Fraction, Fraction] = entry_field("linear red, green, blue")
    seat_limit_C: Number | None = entry_field("hottest seat that keeps its shape", ge=0.0, le=1000.0)

    @property
    def printed(self) -> bool:
        """Whether parts of it are 3D printed, from filament or from powder."""
        return self.process in ("printed", "sintered")


# A wall of filament needs at least two lines to be closed.
WALL_LINES = 2


def least_wall_mm(process: str, min_wall_mm: float, nozzle_mm: float) -> float:
    """Thinnest wall of a material: its own limit, and of filament two lines of the nozzle."""
    return max(min_wall_mm, WALL_LINES * nozzle_mm) if process == "printed" else min_wall_mm
