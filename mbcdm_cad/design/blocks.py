"""Blocks of the design file that all configurations share: each field with type, bounds, unit and a line of meaning.

Those that the drive has as they are read are a ``PlainBlock``; from the others ``Drive`` is computed.

Fields keep the units in their names (mm, degrees, N, N m, g). A configuration adds blocks of its own to :class:`Design`
and gives the reference values with their sources (:mod:`mbcdm_cad.design.loader`). Conditions that concern several
fields are in :mod:`mbcdm_cad.design.rules` and in the configuration's rules.
"""

from dataclasses import dataclass
from typing import Annotated, ClassVar, Literal

from pydantic import ConfigDict, Field

from mbcdm_cad.design.bought import CableSpec
from mbcdm_cad.design.catalogue import OwnEntries, package_entries
from mbcdm_cad.design.fields import Block, CheckId, EntryName, Integer, Number, PlainBlock, Slug, Text, choice, quantity
from mbcdm_cad.design.stage import StageBlock

# Standard acceleration of gravity (CGPM 1901).
STANDARD_GRAVITY_M_S2 = 9.80665
# The most that a design may state: torque and stiffness at the drum, the payload's inertia, travel to each side (three
# turns of a whole drum). Bounds against slips of units; the rig's follow from them, so that it can run each drive.
TORQUE_MAX_NM, STIFFNESS_MAX_NM_RAD, INERTIA_MAX_KG_M2, TRAVEL_MAX_DEG = 1000.0, 1e7, 1e6, 1080.0
Length = Annotated[Number, Field(ge=0.5, le=500.0)]


class Travel(Block):
    """How far the drum turns."""

    ORDER: ClassVar[tuple[str, ...]] = ("half_angle_deg", "stop_clearance_deg")

    half_angle_deg: Number = quantity("travel each way; more: configuration siso_spur", "[1, 120]")
    from_deg: Number | None = quantity(
        "angle of the output at the lower end of the travel, in place of half_angle_deg; all other angles of the drum "
        "are counted from the middle of the travel",
        "[-2160, 2160]",
    )
    to_deg: Number | None = quantity(
        "angle of the output at the upper end of the travel; goes with from_deg", "[-2160, 2160]"
    )
    stop_clearance_deg: Number = quantity("angle from the end of the travel to the hard stops", "[0, 5]")


class Input(Block):
    """An input pulley with its own motor."""

    name: Slug = choice("name, used in part names")


class Cable(Block):
    """A cable from an input pulley to the drum."""

    name: Slug = choice("name, used in part names")
    input: Slug = choice("the input pulley on which it ends")
    preload_N: Number | None = quantity(
        "preload of this cable alone, in place of the rope's", "[0.1, 20000]", uncertain=True
    )


class Rope(Block):
    """The rope of all cables: a catalogue type, or all values inline."""

    type: EntryName | None = choice("catalogue rope; leave out when inline is given")
    inline: CableSpec | None = choice(
        "a rope written out in place of type, with all fields of a catalogue rope",
        example={**package_entries("ropes")["FF-081"], "source": "where these figures come from"},
    )
    modulus_GPa: Number | None = quantity("effective modulus in place of the catalogue's", "[1, 250]", uncertain=True)
    modulus_area: Literal["metallic", "nominal"] | None = choice(
        "area that modulus_GPa refers to: metallic (the wires) or nominal (pi d^2 / 4)"
    )
    termination: EntryName | None = choice(
        "catalogue entry for how its ends are made; if left out, the strongest that fits the rope", example="swaged"
    )
    friction_coefficient: Number = quantity(
        "friction coefficient mu of the rope on a pulley", "[0.01, 1]", uncertain=True
    )
    preload_N: Number = quantity(
        "tension of each cable with the drum centred and unloaded", "[0.1, 20000]", uncertain=True
    )
    cut_tolerance_mm: Number = quantity(
        "tolerance of the length of a finished cable from stop to terminal, plus or minus", "[0, 20]", default=0.5
    )


class WoundRope(Rope):
    """The rope of all cables: a catalogue type, or all values inline."""

    ORDER: ClassVar[tuple[str, ...]] = (
        "type",
        "inline",
        "modulus_GPa",
        "modulus_area",
        "termination",
        "friction_coefficient",
        "preload_N",
        "helix_lead_mm",
        "dead_turns",
        "cut_tolerance_mm",
    )

    helix_lead_mm: Number = quantity(
        "axial distance from turn to turn on the input pulley; more than the rope's diameter", "[0.2, 10]"
    )
    dead_turns: Number = quantity("turns that stay on the input pulley at the unwound end", "[0, 10]")


class DriveTrain(Block):
    """Motor, gearhead and encoders, from the catalogue."""

    motor: EntryName = choice("motor of each input")
    gearhead: EntryName = choice("gearhead of each input; none where the motor's own shaft drives it")
    gearhead_angle_deg: Number = quantity(
        "gearheads turned with their motors about their axes, from where two screws are beside the axis, one of three "
        "is at the back, or four are on the diagonals; anticlockwise seen against the shaft, and of two inputs that "
        "mirror each other the one at -x clockwise",
        "[-180, 180]",
        default=0.0,
    )
    bus_voltage_V: Number | None = quantity(
        "voltage of the supply, for motors with a torque constant; if left out, the voltage that the motor is made for",
        "(0, 1000]",
    )
    encoder: EntryName = choice(
        "encoder on each input pulley, beyond its bearing; none where the motor's own tells the angle (spur layouts)"
    )
    drum_encoder: EntryName = choice("encoder on the drum shaft; none for a drum without one (spur layouts)")


@dataclass(frozen=True, kw_only=True)
class DutyRow(PlainBlock):
    """A part of the duty's cycle: a load on the drum, at rest or while the drum moves back and forth."""

    torque_Nm: Number = quantity(
        "load on the drum, which opposes positive rotation where it is above zero", ge=-TORQUE_MAX_NM, le=TORQUE_MAX_NM
    )
    share: Number = quantity("share of the time; shares count relative to their sum", "(0, 1]")
    speed_deg_s: Number | None = quantity(
        "speed of the drum while it moves back and forth; 0, or neither speed nor range: it holds", "[0, 10000]"
    )
    range_deg: Number | None = quantity(
        "angle from end to end that it moves over, there and back; left out at a speed: the whole travel",
        gt=0.0,
        le=2.0 * TRAVEL_MAX_DEG,
    )


@dataclass(frozen=True, kw_only=True)
class DutyBlock(PlainBlock):
    """What the drive does all day: one cycle, by its rows or by a record, that repeats."""

    rows: tuple[DutyRow, ...] = choice(
        "parts of one cycle, one after the other: {torque_Nm: M, share: S} and speed_deg_s, range_deg or both",
        default=(),
        max_length=64,
    )
    record: Text | None = choice(
        "CSV file of one cycle, in place of rows, relative to the design file; its header names columns and units: "
        "time_s,angle_deg,torque_Nm",
        example="a-day.csv",
    )
    period_s: Number | None = quantity("time of one cycle of rows; 10 if left out", "(0, 1e6]")
    ambient_C: Number | None = quantity("temperature of the air round the motors; 25 if left out", "[-60, 120]")


@dataclass(frozen=True, kw_only=True)
class Payload(PlainBlock):
    """What the hub's face carries, with the drum's axis level, so that its weight turns the drum."""

    mass_kg: Number = quantity("mass", "[0, 1000]", default=0.0)
    distance_mm: Number = quantity(
        "centre of mass from the drum's axis, where its weight turns the drum most", "[0, 10000]", default=0.0
    )
    ahead_mm: Number = quantity(
        "centre of mass, and place of radial_N, in front of the hub's face", "[0, 10000]", default=0.0
    )
    inertia_kg_m2: Number | None = quantity(
        "moment of inertia about the drum's axis; left out, that of the mass as a point at distance_mm",
        ge=0.0,
        le=INERTIA_MAX_KG_M2,
    )
    radial_N: Number = quantity(
        "largest force across the drum's axis besides the weight, such as that of a foot or a hand",
        "[0, 1e6]",
        default=0.0,
    )
    moment_Nm: Number = quantity(
        "largest moment that tilts the drum's axis, besides those of weight and radial_N", "[0, 10000]", default=0.0
    )

    @property
    def weight_torque_Nm(self) -> float:
        """Torque of the weight on the drum with the centre of mass beside the axis."""
        return self.mass_kg * STANDARD_GRAVITY_M_S2 * self.distance_mm * 1e-3

    @property
    def across_N(self) -> float:
        """Largest force across the drum's axis: weight and ``radial_N`` in one direction."""
        return self.mass_kg * STANDARD_GRAVITY_M_S2 + self.radial_N

    @property
    def tilt_Nm(self) -> float:
        """Largest moment across the drum's axis about the middle of the hub's face."""
        return self.across_N * self.ahead_mm * 1e-3 + self.moment_Nm

    @property
    def about_axis_kg_m2(self) -> float:
        """Moment of inertia about the drum's axis."""
        return self.mass_kg * (self.distance_mm * 1e-3) ** 2 if self.inertia_kg_m2 is None else self.inertia_kg_m2


NO_PAYLOAD = Payload()


@dataclass(frozen=True, kw_only=True)
class Loads(PlainBlock):
    """External torques on the drum at which the design is checked."""

    test_torque_Nm: Number = quantity("torque of the backlash test", uncertain=True, gt=0.0, le=TORQUE_MAX_NM)
    peak_torque_Nm: Number = quantity("torque that the design must hold in both directions", gt=0.0, le=TORQUE_MAX_NM)
    continuous_torque_Nm: Number | None = quantity(
        "torque that the design must hold continuously, gearheads included, besides that of the payload's weight; not "
        "checked if left out",
        gt=0.0,
        le=TORQUE_MAX_NM,
    )
    speed_deg_s: Number | None = quantity(
        "speed that the drum must reach against the continuous torque, or the peak torque where that is left out; not "
        "checked if left out",
        "(0, 10000]",
    )
    stiffness_Nm_rad: Number | None = quantity(
        "least stiffness at the payload at the test torque, the inputs held: cables and all parts; rules raise what "
        "gives most until it holds or other checks refuse; not checked if left out",
        gt=0.0,
        le=STIFFNESS_MAX_NM_RAD,
    )
    structure_share: Number | None = quantity(
        "largest turn of the payload by all parts besides the cables, over that by the cables, at the test torque, the "
        "inputs held; 0.25 is a usual aim; rules raise what gives most until it holds or other checks refuse; left "
        "out, a warning beyond 2.5, printed 5",
        "(0, 100]",
    )
    backdrive_Nm: Number | None = quantity(
        "largest torque at the drum that may be needed to turn it, motors without current; not checked if left out",
        gt=0.0,
        le=TORQUE_MAX_NM,
    )
    duty: DutyBlock | None = choice(
        "what the drive does all day, from which the temperatures of its motors follow; an assumed one if left out",
        example={"rows": [{"torque_Nm": 1.0, "share": 0.3}, {"torque_Nm": 0.5, "share": 0.7, "range_deg": 60.0}]},
    )
    payload: Payload | None = choice(
        "what is screwed on the hub's face; left out, nothing but the torques above",
        example={"mass_kg": 0.2, "distance_mm": 50.0, "ahead_mm": 10.0},
    )

    @property
    def carried(self) -> Payload:
        """The payload; one without mass and load where the file states none."""
        return self.payload or NO_PAYLOAD

    @property
    def lasting_Nm(self) -> float | None:
        """Torque that the drive must hold without end: the stated one, not less than that of the payload's weight."""
        weight = self.carried.weight_torque_Nm
        return max(self.continuous_torque_Nm or 0.0, weight) or None


@dataclass(frozen=True, kw_only=True)
class Limits(PlainBlock):
    """Limits of this design, which the checks use."""

    bend_ratio_min: Number = quantity("smallest D/d on any pulley; the rope's own minimum is a warning", "[1, 200]")
    tension_safety_factor: Number = quantity("breaking load over largest tension", "[1, 100]")
    preload_share_max: Number = quantity("preload over breaking load", "(0, 1]")
    frame_windup_max_mrad: Number | None = quantity(
        "turn of the drum from the frame's deflection at the test torque; left out, the turn of the cables there, or "
        "six times that for a printed frame",
        "(0, 100]",
    )
    losses: Literal["counted", "paper"] = choice(
        "torque that motors and gearheads must move: with all losses counted, or without any, as the paper reckons",
        default="counted",
    )

    @property
    def counts_losses(self) -> bool:
        """Whether motors and gearheads must move the torque with all losses."""
        return self.losses == "counted"


@dataclass(frozen=True, kw_only=True)
class Making(PlainBlock):
    """Tolerances of the parts, each half of its band; a gap smaller than their sum gives a warning."""

    rope_diameter_share: Number = quantity(
        "rope's diameter, plus or minus, over the diameter", "[0, 0.2]", default=0.03
    )
    run_out_mm: Number = quantity(
        "run-out of a turned surface to its bearing seats, full indicator reading", "[0, 1]", default=0.02
    )
    bearing_play_mm: Number = quantity(
        "radial play of a bearing that carries no preload, from one side to the other", "[0, 0.2]", default=0.008
    )
    position_mm: Number = quantity(
        "place of a bore, a face or a step from its datum, plus or minus", "[0, 1]", default=0.02
    )


@dataclass(frozen=True, kw_only=True)
class Printing(PlainBlock):
    """Settings for parts of printed materials; other parts do not use them."""

    hole_allowance_mm: Number = quantity("added to the diameter of round holes in the 3MF files", "[0, 1]", default=0.2)
    nozzle_mm: Number = quantity(
        "width of a line of filament; no wall is thinner than two lines", "[0.1, 2]", default=0.4
    )
    threads: Literal["cut", "inserts"] = choice(
        "threads of the payload and of the screws that close the frame: cut in the plastic, or brass inserts set in "
        "with heat",
        default="cut",
    )


@dataclass(frozen=True, kw_only=True)
class SpanLimits(Limits):
    """Limits of this design, which the checks use."""

    ORDER: ClassVar[tuple[str, ...]] = (
        "bend_ratio_min",
        "fleet_angle_max_deg",
        "fleet_angle_grooved_max_deg",
        "tension_safety_factor",
        "preload_share_max",
        "frame_windup_max_mrad",
    )

    fleet_angle_max_deg: Number = quantity("largest fleet angle on a smooth pulley", "(0, 20]")
    fleet_angle_grooved_max_deg: Number = quantity(
        "largest fleet angle on a grooved pulley; wire rope handbooks recommend 2, and 4 at most",
        "(0, 20]",
        default=2.0,
    )


@dataclass(frozen=True, kw_only=True)
class Targets(PlainBlock):
    """Mass and box to reach; a target that is left out is not checked."""

    mass_g: Number | None = quantity("mass of the whole", "(0, 1e6]")
    mass_tolerance_g: Number = quantity("how far it may differ", "(0, 1e6]", default=10.0)
    prototype_mass_g: Number | None = quantity("measured mass of the prototype, for comparison", "(0, 1e6]")
    envelope_mm: tuple[Length, Length, Length] | None = quantity("box with the drum centred, X, Z, Y")
    envelope_tolerance_mm: Number = quantity("how far each side may differ", "(0, 100]", default=0.5)
    life_cycles: Number | None = quantity("cycles of the output, to and fro, that the cables must last", "(0, 1e9]")
    life_h: Number | None = quantity(
        "hours of loads.duty that the cables must last, in place of life_cycles", "(0, 1e6]"
    )


@dataclass(frozen=True, kw_only=True)
class Export(PlainBlock):
    """Settings of the files written."""

    mesh_tolerance_mm: Number = quantity("largest distance of a mesh from its surface", "[0.001, 1]")
    threads: Literal["major", "tap_drill"] = choice(
        "tapped holes in the files of single parts: at the thread's major diameter, or as drilled for tapping",
        default="major",
    )


@dataclass(frozen=True, kw_only=True)
class Waiver(PlainBlock):
    """A check that may fail, with the reason, which the report prints."""

    check: CheckId = choice("id of the check")
    reason: Text = choice("reason why the failure is accepted")


@dataclass(frozen=True, kw_only=True)
class AsBuiltValue(PlainBlock):
    """One figure of an effect that was found on the built drive, in the SI unit that its name ends in."""

    name: EntryName = choice("name of the figure")
    value: Number = choice("what was found", ge=-1e6, le=1e6)
    low: Number | None = choice("lower end of its 95 % interval", ge=-1e6, le=1e6)
    high: Number | None = choice("upper end of its 95 % interval", ge=-1e6, le=1e6)


@dataclass(frozen=True, kw_only=True)
class AsBuiltCorrelation(PlainBlock):
    """How one value of an entry goes with another of its own, or one of an entry that was found together with it."""

    own: EntryName = choice("name of the entry's value")
    entry: Integer = choice("number of the other entry in the list, from 0", ge=0, le=31)
    other: EntryName = choice("name of the other entry's value")
    correlation: Number = choice("correlation of what is not known of the two", ge=-1.0, le=1.0)


@dataclass(frozen=True, kw_only=True)
class AsBuilt(PlainBlock):
    """An effect that the built drive was found to have, written by 'mbcdm loop --apply'."""

    name: Slug = choice("name of the effect, as in docs/loop-effects.md")
    form: Text = choice("physical form of the effect")
    stage: Slug | None = choice("shaft on which the effect acts")
    cables: tuple[Slug, ...] = choice("the cables that have it; all where none is named", default=())
    values: tuple[AsBuiltValue, ...] = choice(
        "its values: {name: share, value: 0.12, low: 0.11, high: 0.13}",
        example=[{"name": "share", "value": 0.12, "low": 0.11, "high": 0.13}],
        min_length=1,
        max_length=12,
    )
    correlated: tuple[AsBuiltCorrelation, ...] = choice(
        "correlations within the entry and with earlier ones: {own: share, entry: 0, other: share, correlation: -0.8}",
        example=[{"own": "share", "entry": 0, "other": "share", "correlation": -0.8}],
        default=(),
        max_length=256,
    )
    source: Text | None = choice("the measured run that it was found in")


class Design(Block):
    """A cable drive.

    A configuration's own schema extends it: ``configuration`` becomes the one word that names it, ``inputs`` and
    ``cables`` get the fields that it needs of each. ``ORDER`` also names the blocks that every configuration adds.
    """

    model_config = ConfigDict(title="Design")

    ORDER: ClassVar[tuple[str, ...]] = (
        "schema_version",
        "name",
        "configuration",
        "travel",
        "transmission",
        "inputs",
        "cables",
        "rope",
        "clearances",
        "drive",
        "drum",
        "input_pulleys",
        "support",
    )

    schema_version: Annotated[Integer, Field(ge=1, le=1)] = choice("version of this file's layout")
    name: Slug = choice("name of the design and of its output folder: a-z, 0-9, _ and -")
    configuration: str = choice("layout of the drive")
    travel: Travel
    inputs: tuple[Input, ...]
    cables: tuple[Cable, ...]
    rope: Rope
    drive: DriveTrain
    stage: StageBlock | None = choice(
        "belt or gears between the motor, or its gearhead, and each input: {kind: belt, ratio: 3.0}; left out, the "
        "motor stands behind its input",
        example={"kind": "belt", "ratio": 3.0},
    )
    loads: Loads
    limits: Limits
    making: Making = Field(default_factory=Making)
    printing: Printing = Field(default_factory=Printing)
    targets: Targets
    export: Export
    waivers: tuple[Waiver, ...] = choice(
        "checks that may fail: {check: ID, reason: WHY}", reference=[], default=(), max_length=64
    )
    as_built: tuple[AsBuilt, ...] = choice(
        "effects that the built drive was found to have, written by 'mbcdm loop --apply'",
        reference=[],
        default=(),
        max_length=32,
    )
    catalogue: OwnEntries = Field(
        default=OwnEntries.model_construct(),
        description="entries of this design's own, by kind and name; they override the package's",
        json_schema_extra={"unit": "-", "source": "-", "examples": [{}], "in_reference": True},
    )
