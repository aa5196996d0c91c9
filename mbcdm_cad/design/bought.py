"""Entries of the catalogue, one class per kind: what a file states is the bought part that all rooms read.

Fields are declared with unit, bounds and meaning; pydantic validates those of a design's own entries by them. An
object made in Python is not validated. Units are those of the files: mm, N, grams, GPa.
"""

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
        "price of a piece, of a metre of rope, of a kilogram of a material", "[0, 1e6]"
    )
    price_source: Text | None = entry_field("source of the price; says 'estimate' for one")


@dataclass(frozen=True, kw_only=True)
class LifeAnchor(PlainBlock):
    """A bending test of one's own on a rope; it replaces the generic figures of its life."""

    bendings: Number = entry_field("bendings on and off a pulley at which half of the ropes had broken", "(0, 1e9]")
    bend_ratio: Number = entry_field(
        "diameter of the test's pulley at the rope's centre line over the rope's", "(1, 1000]"
    )
    load_share: Number = entry_field("tension in the test over the breaking load", "(0, 1]")
    groove: Number | None = entry_field("radius of its groove over the rope's diameter; smooth if left out", "[0.5, 5]")
    lubrication: Literal["oiled", "dry"] = entry_field("how the rope was run")
    count: Integer = entry_field("number of ropes tested", ge=1, le=1000)
    source: Text = entry_field("who tested, when and how")


@dataclass(frozen=True, kw_only=True)
class CableSpec(Entry):
    """A rope. Its modulus always comes with the area to which it refers."""

    construction: Literal["7x7", "7x19", "1x19", "braid"] = entry_field("strands x wires, or braid for fibre")
    diameter_mm: Number = entry_field("nominal diameter", "[0.2, 5]", uncertain=True)
    metallic_area_mm2: Number = entry_field("cross-section of all wires or fibres", "(0, 20]", uncertain=True)
    modulus_GPa: Number = entry_field("effective tensile modulus of the rope", "[1, 250]", uncertain=True)
    modulus_area: Literal["metallic", "nominal"] = entry_field("area the modulus refers to: wires, or pi d^2 / 4")
    breaking_load_N: Number = entry_field("minimum breaking load", "[10, 50000]")
    mass_g_m: Number = entry_field("mass per length", "(0, 200]")
    bedding_in_share: Number = entry_field(
        "permanent stretch in the first runs under load, over the length (constructional stretch)",
        "[0, 0.05]",
        default=0.003,
    )
    creep_per_decade: Number = entry_field(
        "strain a decade of time, extrapolated to the breaking load; none for wire", "[0, 0.1]", default=0.0
    )
    creep_per_year: Number = entry_field(
        "steady strain a year at 0.3 of the breaking load and 20 degrees C", "[0, 1]", default=0.0
    )
    creep_load_exponent: Number = entry_field("power of the load in the steady creep", "[1, 20]", default=1.0)
    creep_activation_kJ_mol: Number = entry_field("activation energy of the steady creep", "[0, 500]", default=0.0)
    bend_ratio_minimum: Number = entry_field("smallest D/d that the maker allows", "[1, 200]")
    bend_ratio_desired: Number = entry_field("D/d that the maker recommends", "[1, 200]")
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
    smallest_mm: Number = entry_field("thinnest rope for which it is made", "[0.1, 20]")
    largest_mm: Number = entry_field("thickest rope for which it is made", "[0.1, 20]")
    strength_share: Number = entry_field("strength of the end divided by the rope's breaking load", "(0, 1]")
    sleeve_ratio: Number = entry_field("smallest diameter of the terminal's sleeve divided by the rope's", "[1.1, 10]")
    grip_ratio: Number = entry_field(
        "smallest length of rope in the sleeve divided by the rope's diameter", "[0.5, 30]"
    )
    stop_radius_ratio: Number = entry_field("radius of the stop over the rope's diameter", "[0.6, 5]")
    stop_length_ratio: Number = entry_field("length of the stop over the rope's diameter", "[0.5, 20]")
    setting_ratio: Number = entry_field(
        "rope that the end gives off at its first loads, over the rope's diameter: a knot tightens, a clamp beds in",
        "[0, 20]",
        default=0.0,
    )
    tail_ratio: Number = entry_field(
        "rope that making the end uses beyond sleeve or stop, over the rope's diameter; counted in the length to cut",
        "[0, 200]",
        default=0.0,
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

    ratio: Number = entry_field("reduction of its own gears", "[1, 10000]")
    efficiency: Number = entry_field("efficiency of its gears", "(0, 1]")
    rated_torque_mNm: Number = entry_field("continuous torque at the horn", "(0, 1e6]")
    max_torque_mNm: Number = entry_field("torque at the horn at standstill", "(0, 1e6]")
    stiffness_Nm_rad: Number = entry_field("torsional stiffness of its gears at the horn", "(0, 1e7]")
    lash_deg: Number = entry_field("play of its gears at the horn, from one side to the other", "[0, 20]")
    sensor: Literal["output", "motor"] = entry_field("where its own sensor is: on the horn's shaft, or the motor's")
    sensor_steps: Integer = entry_field("steps a turn of its sensor", ge=16, le=2**26)
    body_mm: Number = entry_field("length of its housing", "[5, 200]")
    width_mm: Number = entry_field("width of its housing", "[3, 150]")
    behind_mm: Number = entry_field("depth of its housing behind the ears' front", "[1, 200]")
    before_mm: Number = entry_field("height of its housing before the ears' front", "[0.5, 50]")
    axis_mm: Number = entry_field("horn's axis from the middle of the housing, along its length", "[0, 100]")
    ears_mm: Number = entry_field("length over both ears", "[6, 300]")
    ear_mm: Number = entry_field("thickness of the ears", "[0.5, 20]")
    hole_length_mm: Number = entry_field("distance of the ears' holes along the length", "[6, 300]")
    hole_width_mm: Number = entry_field("distance of the ears' holes along the width", "[2, 150]")
    spline: Text = entry_field("teeth of its spline, as makers of horns name it")
    horn_mm: Number = entry_field("diameter of its horn, a disc", "[5, 150]")
    horn_face_mm: Number = entry_field("front of the horn before the ears' front", "[2, 100]")
    horn_thickness_mm: Number = entry_field("thickness of the horn", "[0.5, 30]")
    horn_circle_mm: Number = entry_field("diameter of the circle of the horn's threads", "[3, 140]")
    horn_screw: EntryName = entry_field("screw for the horn's threads")
    horn_screws: Integer = entry_field("number of those threads", ge=2, le=12)
    centre_screw: EntryName = entry_field("screw that holds the horn on its spline")


@dataclass(frozen=True, kw_only=True)
class Motor(Entry):
    """A motor. A motor with a shaft and a mounting face can be used without a gearhead.

    Torque constant and resistance are those between two terminals (60 / (2 pi Kv), phase to phase).
    """

    diameter_mm: Number = entry_field("body diameter", "[3, 400]")
    length_mm: Number = entry_field("body length", "[3, 300]")
    rated_torque_mNm: Number = entry_field("continuous torque", "(0, 100000]", uncertain=True)
    rotor_inertia_g_cm2: Number = entry_field("rotor inertia", "(0, 1e6]")
    mass_g: Number = entry_field("mass", "(0, 50000]")
    torque_constant_mNm_A: Number | None = entry_field("torque over current, 60 / (2 pi Kv)", "(0, 100000]")
    resistance_ohm: Number | None = entry_field("resistance between two terminals", "(0, 1000]")
    no_load_current_A: Number | None = entry_field(
        "current that turns it without a load: its friction is this times the torque constant", "(0, 100]"
    )
    continuous_current_A: Number | None = entry_field("continuous current", "(0, 1000]")
    peak_current_A: Number | None = entry_field("largest current for a short time", "(0, 5000]")
    voltage_V: Number | None = entry_field("voltage that the motor is made for", "(0, 1000]")
    pole_pairs: Integer | None = entry_field("pairs of magnet poles", ge=1, le=100)
    winding_limit_C: Number | None = entry_field("hottest winding; 125 if left out", "[40, 300]")
    # Thermal figures, each estimated from size or mass if left out.
    winding_K_W: Number | None = entry_field("thermal resistance, winding to housing", "(0, 1000]")
    housing_K_W: Number | None = entry_field("thermal resistance, housing to air", "(0, 1000]")
    radial_load_N: Number | None = entry_field("radial load that the shaft can take", "(0, 10000]")
    radial_load_at_mm: Number | None = entry_field(
        "distance from the face at which it can take radial_load_N; half the shaft's length if left out", "(0, 200]"
    )
    bearing_span_mm: Number | None = entry_field(
        "distance between the shaft's own bearings; 0.6 of the body's length if left out", "(0, 300]"
    )
    shaft_diameter_mm: Number | None = entry_field("shaft diameter", "[1, 40]")
    shaft_length_mm: Number | None = entry_field("shaft length from the face", "[1, 80]")
    pilot_diameter_mm: Number | None = entry_field("centring boss diameter", "[1, 200]")
    pilot_height_mm: Number | None = entry_field("centring boss height", "[0.1, 10]")
    bolt_circle_mm: Number | None = entry_field("diameter of the screws' circle on the face", "[2, 300]")
    screw: EntryName | None = entry_field("screw that holds it at the face")
    screw_count: Integer | None = entry_field("number of those screws", ge=2, le=12)
    winding_time_s: Number | None = entry_field("thermal time constant, winding", "(0, 100000]")
    motor_time_s: Number | None = entry_field("thermal time constant, motor", "(0, 1e6]")
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

    ratio: Number = entry_field("reduction", "[1, 10000]")
    efficiency: Number = entry_field("efficiency at rated torque", "(0, 1]")
    rated_torque_mNm: Number = entry_field("continuous output torque", "(0, 1e6]")
    max_torque_mNm: Number = entry_field("intermittent output torque", "(0, 1e6]")
    radial_load_N: Number = entry_field("radial load that the output shaft can take", "(0, 10000]")
    radial_load_at_mm: Number | None = entry_field(
        "distance from the face at which it can take radial_load_N; half the shaft's length if left out", "(0, 200]"
    )
    bearing_span_mm: Number | None = entry_field(
        "distance between the output shaft's own bearings; 0.3 of the body's length if left out", "(0, 300]"
    )
    stiffness_Nm_rad: Number | None = entry_field(
        "torsional stiffness at the output; estimated from the diameter if left out", "(0, 1e7]"
    )
    diameter_mm: Number = entry_field("body diameter", "[3, 100]")
    length_mm: Number = entry_field("body length", "[3, 200]")
    shaft_diameter_mm: Number = entry_field("output shaft diameter", "[1, 20]")
    shaft_length_mm: Number = entry_field("output shaft length from the face", "[1, 60]")
    pilot_diameter_mm: Number = entry_field("centring boss diameter", "[1, 60]")
    pilot_height_mm: Number = entry_field("centring boss height", "[0.1, 10]")
    bolt_circle_mm: Number = entry_field("diameter of the screws' circle on the face", "[2, 90]")
    screw: EntryName = entry_field("screw that holds it at the face")
    screw_count: Integer = entry_field("number of those screws", ge=1, le=12)
    mass_g: Number = entry_field("mass", "(0, 5000]")

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

    resolution_urad: Number = entry_field("resolution", "(0, 100000]")
    diameter_mm: Number = entry_field("housing diameter", "[3, 100]")
    length_mm: Number = entry_field("housing length", "[1, 100]")
    bore_mm: Number = entry_field("bore of the hub", "[0.5, 60]")
    bolt_circle_mm: Number = entry_field("diameter of the screws' circle", "[2, 90]")
    screw: EntryName = entry_field("screw that holds the housing")
    screw_count: Integer = entry_field("number of those screws", ge=1, le=12)
    mass_g: Number = entry_field("mass", "(0, 1000]")

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

    bore_mm: Number = entry_field("bore d", "[1, 200]")
    outer_diameter_mm: Number = entry_field("outside diameter D", "[2, 250]")
    width_mm: Number = entry_field("width B", "[0.5, 30]")
    inner_shoulder_mm: Number = entry_field("shoulder diameter d_a at the inner ring", "[1, 250]")
    outer_shoulder_mm: Number = entry_field("shoulder diameter D_a at the outer ring", "[1, 250]")
    static_rating_N: Number = entry_field("static load rating C0", "(0, 100000]")
    mass_g: Number = entry_field("mass", "(0, 2000]")


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

    thread_mm: Number = entry_field("nominal thread diameter", "[0.5, 12]")
    tap_drill_mm: Number = entry_field("tapping drill", "[0.3, 12]")
    clearance_mm: Number = entry_field("clearance hole", "[0.5, 15]")
    length_mm: Number = entry_field("length below the head", "[1, 100]")
    head_diameter_mm: Number = entry_field("head diameter", "[0, 25]")
    head_height_mm: Number = entry_field("head height", "[0, 15]")
    key_mm: Number = entry_field("hexagon socket across flats", "[0.3, 12]")
    mass_g: Number = entry_field("mass", "(0, 200]")


@dataclass(frozen=True, kw_only=True)
class InsertSpec(Entry):
    """A knurled brass bush with an inside thread, set with heat into a hole of a printed part."""

    thread_mm: Number = entry_field("nominal thread diameter", "[1, 12]")
    hole_mm: Number = entry_field("diameter of the hole that it is set into", "[1, 20]")
    outside_mm: Number = entry_field("diameter over the knurls", "[1, 20]")
    length_mm: Number = entry_field("length", "[1, 40]")
    wall_mm: Number = entry_field("least wall of plastic round the hole", "[0.2, 20]")
    mass_g: Number = entry_field("mass", "(0, 100]")

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

    thread_mm: Number = entry_field("nominal thread diameter", "[0.5, 12]")
    clearance_mm: Number = entry_field("clearance hole in the lug", "[0.5, 15]")
    stress_area_mm2: Number = entry_field("tensile stress area of the thread", "(0, 100]")
    pitch_mm: Number = entry_field("pitch of the thread", "(0, 3]")
    nut_across_flats_mm: Number = entry_field("nut across flats", "[1, 25]")
    nut_height_mm: Number = entry_field("nut height", "[0.3, 15]")
    swage_diameter_mm: Number = entry_field("diameter of the swaged sleeve", "[0.5, 20]")
    swage_flats_mm: Number = entry_field("across the two flats of the sleeve, which keep it from turning", "[0.4, 20]")
    swage_length_mm: Number = entry_field("length of the swaged sleeve", "[0.5, 50]")
    lug_thickness_mm: Number = entry_field("thickness of the drum's lug along the stud", "[0.5, 20]")
    stud_length_mm: Number = entry_field("length from the front of the sleeve to the end of the stud", "[2, 100]")
    material: EntryName = entry_field("material of stud, sleeve and nuts")


@dataclass(frozen=True, kw_only=True)
class SpringSpec(Entry):
    """A compression spring on the stud of a terminal, between lug and nut: a disc of a stack, or a coil."""

    kind: Literal["disc", "coil"] = entry_field("disc spring (DIN EN 16983), or coil of round wire")
    outside_mm: Number = entry_field("outside diameter", "[1, 60]")
    inside_mm: Number = entry_field("inside diameter, round the stud", "[0.5, 40]")
    strip_mm: Number = entry_field("thickness of a disc, or diameter of the wire", "[0.05, 10]")
    free_mm: Number = entry_field("height without load", "[0.1, 100]")
    solid_mm: Number = entry_field("height at which it is flat, or its coils touch", "[0.05, 100]")
    stiffness_N_mm: Number = entry_field("force over deflection within its usable travel", "(0, 1e6]")
    usable_share: Number = entry_field("most of the way from free to solid that it stands for long", "(0, 1]")
    mass_g: Number = entry_field("mass", "(0, 500]")
    material: EntryName = entry_field("material")

    @property
    def usable_N(self) -> float:
        """Largest force that it stands for long."""
        return self.stiffness_N_mm * self.usable_share * (self.free_mm - self.solid_mm)


Fraction = Annotated[Number, Field(ge=0.0, le=1.0)]


@dataclass(frozen=True, kw_only=True)
class Material(Entry):
    """A material and the limits of its process."""

    density_g_cm3: Number = entry_field("density", "[0.1, 25]")
    youngs_modulus_GPa: Number = entry_field("Young's modulus", "[0.01, 1000]")
    poisson_ratio: Number = entry_field("Poisson's ratio", "[0, 0.5)")
    yield_MPa: Number = entry_field("yield strength", "[1, 5000]")
    process: Literal["milled", "turned", "printed", "sintered", "bought"] = entry_field(
        "process by which parts are made; printed: from filament, sintered: from powder"
    )
    min_wall_mm: Number = entry_field("thinnest wall that can be made", "[0, 10]")
    min_internal_radius_mm: Number = entry_field("smallest internal corner radius", "[0, 10]")
    colour: tuple[Fraction, Fraction, Fraction] = entry_field("linear red, green, blue")
    seat_limit_C: Number | None = entry_field("hottest seat that keeps its shape", "[0, 1000]")

    @property
    def printed(self) -> bool:
        """Whether parts of it are 3D printed, from filament or from powder."""
        return self.process in ("printed", "sintered")


# A wall of filament needs at least two lines to be closed.
WALL_LINES = 2


def least_wall_mm(process: str, min_wall_mm: float, nozzle_mm: float) -> float:
    """Thinnest wall of a material: its own limit, and of filament two lines of the nozzle."""
    return max(min_wall_mm, WALL_LINES * nozzle_mm) if process == "printed" else min_wall_mm
