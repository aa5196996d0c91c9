"""Schema of a siso_spur design file: the blocks that are this configuration's own, each field with its source.

Reference values of shared blocks are in ``design_file/reference.json``.
"""

from dataclasses import dataclass
from pathlib import Path
from typing import Any, ClassVar, Literal

from mbcdm_cad.design.blocks import TRAVEL_MAX_DEG, Design, Input, Length, Limits, Rope, Travel, WoundRope
from mbcdm_cad.design.fields import ESTIMATE, Block, EntryName, Integer, Number, PlainBlock, choice, quantity
from mbcdm_cad.design.loader import reference_of
from mbcdm_cad.design.sector_blocks import Clearances, HeadSupport, SectorCable, SectorDrum, WoundPulleys
from mbcdm_cad.parts.drum_sector.dims import WHOLE_DEG

REFERENCE = reference_of(Path(__file__).parent / "design_file")


# Screws of the catalogue by their thread; their length depends on the base.
MOUNT_BOLTS = {"M3": "M3x8", "M4": "M4x10", "M5": "M5x16", "M6": "M6x25"}


# Most turns on an input (estimate: a winding some ten times as long as the input is thick).
MOST_TURNS = 100


@dataclass(frozen=True, kw_only=True)
class IdlerPlace(PlainBlock):
    """Where an idler of the side that lands on the drum at +x stands; that of the other side is its mirror image.

    The cables pass between the two.
    """

    x_mm: Number = quantity("axis of the idler, from the line of centres", "(0, 2000]", example=14.0)
    z_mm: Number = quantity("axis of the idler, from the drum's axis towards the input", "(0, 2000]", example=90.0)


@dataclass(frozen=True, kw_only=True)
class IdlerBlock(PlainBlock):
    """Idlers between the input and the drum, in pairs, one for each side of the cable."""

    pairs: Integer | None = quantity(
        "number of pairs that the rule places; left out, that of places, or else one", example=1, ge=1, le=1
    )
    radius_mm: Number = quantity("pitch radius of all idlers", "(0, 500]", example=14.0)
    width_mm: Number = quantity("land of an idler along its axis, on which the cable walks", "(0, 300]", example=15.0)
    bearing: EntryName = choice("bearing in both ends of each idler", example="624")
    places: tuple[IdlerPlace, ...] = choice(
        "the idlers of the side that lands on the drum at +x, in the order from the input to the drum: "
        "{x_mm: X, z_mm: Z}; the other side has their mirror images",
        example=[{"x_mm": 14.0, "z_mm": 90.0}],
        min_length=1,
        max_length=8,
    )


class SpurTransmission(Block):
    """Pitch radii (to the cable's centre line), centre distance, and how the cable is wound on the input."""

    drum_radius_mm: Length = quantity(
        "drum pitch radius r_o", uncertain=True, source="the mean of the paper's Table 2", reference=59.4
    )
    input_to_drum: Number | None = quantity(
        "drum radius over input radius; leave it out if the input radius is explicit, or to have it chosen with the "
        "motor",
        "[0.5, 60]",
        source="input radius 6 mm, the smallest of miso_bevel's reference",
        reference=9.9,
    )
    input_radius_mm: Length | None = quantity(
        "explicit input pitch radius r_i, in place of input_to_drum", uncertain=True, example=6.0
    )
    centre_distance_mm: Length = quantity(
        "drum axis to input axis",
        uncertain=True,
        source="estimate: space between rim and pulley to insert the cable",
        reference=70.0,
    )
    cables: Literal["continuous", "two_anchored"] = choice(
        "continuous: one cable for both senses, held on the input by friction; two_anchored: one for each sense, with "
        "a stop in the input",
        source="Fig. 1",
        reference="continuous",
        default="continuous",
    )
    spans: Literal["crossed", "open"] = choice(
        "crossed: the input turns against the drum; open: with it, both bend the cable the same way, and it wraps less "
        "of both",
        source="Fig. 1",
        reference="crossed",
        default="crossed",
    )
    parallel: Integer = quantity(
        "equal continuous cables side by side round the input, which share the load, each on a sector of its own with "
        "its own terminals; cables then names both sides of each, from the back on (siso_spur)",
        default=1,
        ge=1,
        le=4,
    )
    turns: Integer = quantity(
        "turns of the cable on the input, counted at the line of centres; of two anchored cables at the end of the "
        "travel that winds each up",
        source="a part of the cable stays on the input over the whole travel",
        reference=3,
        ge=1,
        le=MOST_TURNS,
    )


class SpurRope(Rope):
    """The rope: a catalogue type, or all values inline."""

    ORDER: ClassVar[tuple[str, ...]] = WoundRope.ORDER

    helix_lead_mm: Number = quantity(
        "axial lead of the turns on the input; larger than the rope's diameter",
        "[0.2, 10]",
        source="rope makers' tables for grooves, rounded up",
        reference=0.9,
    )


@dataclass(frozen=True, kw_only=True)
class SpurClearances(Clearances):
    """Gaps between finished surfaces."""

    land_edge_mm: Number = quantity("flank of the cable to the inner face of the drum's rim", "[0, 5]")
    running_mm: Number = quantity("any moving solid to any fixed one", "[0.01, 5]")


@dataclass(frozen=True, kw_only=True)
class ShaftPulleys(WoundPulleys):
    """The input pulley, carried by a bearing at both ends, or by the motor's shaft alone."""

    surface: Literal["smooth", "grooved"] = choice(
        "a smooth land, or a helical groove that leads each cable",
        source="usual in built capstan drives",
        reference="grooved",
        default="grooved",
    )
    carried_by: Literal["bearings", "motor"] = choice(
        "bearings: one at either end of the pulley; motor: the pulley sits overhung on the shaft of the motor, or of "
        "its gearhead, whose own bearings carry the cables; both bearings and the encoder are then none",
        default="bearings",
    )

    @property
    def overhung(self) -> bool:
        """Whether the shaft of motor or gearhead alone carries the pulley."""
        return self.carried_by == "motor"


class SpurSide(SectorCable):
    """One side of the cable, or one of two anchored cables, from the input to the drum."""

    drum_side: Literal["-x", "+x"] = choice("side of the drum, from the line of centres")


@dataclass(frozen=True, kw_only=True)
class YokeSupport(HeadSupport):
    """Frame: a plate with the drum's boss and a yoke over the input, and the motor head behind it."""

    ORDER: ClassVar[tuple[str, ...]] = (
        *("material", "back_y_mm", "plate_mm", "bridge_mm", "side_wall_mm"),
        *("motor_shelf_mm", "coupling_space_mm", "bearing_shelf_mm", "encoder_shelf_mm"),
    )

    material: EntryName = choice("material of frame and motor head", source=ESTIMATE, reference="aluminium-7075")
    back_y_mm: Number = quantity(
        "end of the drum's encoder behind the frame",
        "[-300, -1]",
        source="distance between the drum's bearings",
        reference=-25.5,
    )
    plate_mm: Number = quantity("plate thickness", "[0.3, 50]", source=ESTIMATE, reference=5.0)
    bridge_mm: Number = quantity(
        "bridge from the plate to the encoder shelf, over the input", "[0.3, 50]", source=ESTIMATE, reference=4.0
    )
    side_wall_mm: Number = quantity("twice the wall of the motor head", "[0.3, 50]", source=ESTIMATE, reference=4.0)
    coupling_space_mm: Number = quantity(
        "length between the shelves: coupling collar, gearhead screws and the tools for both",
        "[2, 100]",
        source=ESTIMATE,
        reference=9.6,
    )
    mount_screw: Literal["M3", "M4", "M5", "M6"] = choice(
        "screws that hold the frame on its base, in threads of the plate", source=ESTIMATE, reference="M3", default="M3"
    )

    @property
    def mount_bolt(self) -> str:
        """The screw of the catalogue that gives the mounting threads their sizes."""
        return MOUNT_BOLTS[self.mount_screw]


@dataclass(frozen=True, kw_only=True)
class SpurDrum(SectorDrum):
    """Drum sector with web, hub and tensioners; y is along the drum axis from the middle of the cable."""

    sector_half_angle_deg: Number = quantity(
        "half angle of the sector, from the line of centres, up to 175; 180: a whole drum, on which a cable may lie in "
        "more than one turn",
        ge=20.0,
        le=WHOLE_DEG,
    )
    shaft_end_mm: Number = quantity(
        "length of the drum's shaft that stands out behind the frame and is the output there; the frame's boss then "
        "ends in a flange to be screwed on, and drive.drum_encoder is none; 0: the hub alone is the output",
        "[0, 60]",
        default=0.0,
    )


@dataclass(frozen=True, kw_only=True)
class SpurLimits(Limits):
    """Limits of this design, which the checks use."""

    ORDER: ClassVar[tuple[str, ...]] = ("bend_ratio_min", "slip_margin_min")

    slip_margin_min: Number = quantity(
        "torque at which a continuous cable slips on the input over the peak torque",
        "[1, 20]",
        source="estimate: friction is known to a factor of two",
        reference=2.0,
        default=2.0,
    )


class SpurBlocks(Design):
    """The blocks of a drive whose cables go round inputs beside the drum."""

    transmission: SpurTransmission
    cables: tuple[SpurSide, ...]
    rope: SpurRope
    clearances: SpurClearances
    drum: SpurDrum
    input_pulleys: ShaftPulleys
    support: YokeSupport
    limits: SpurLimits
    idlers: IdlerBlock | None = choice(
        "idlers that lead the cable to an input away from the drum; left out, it runs straight to the drum",
        example={"pairs": 1},
    )


class SpurTravel(Travel):
    """How far the drum turns."""

    # A whole drum may turn more than once.

    half_angle_deg: Number = quantity("travel from the centre to each side", ge=1.0, le=TRAVEL_MAX_DEG)


@dataclass(frozen=True, kw_only=True)
class FirstStageBlock(PlainBlock):
    """A cable stage between the motor and the input: a whole drive of this layout, whose drum's shaft turns the input.

    Motor and gearhead of the block ``drive`` are then those of the first stage.
    """

    total_ratio: Number | None = quantity(
        "turns of the first stage's input for one of the drum; a rule splits it between the stages",
        "[2, 3600]",
        example=24.0,
    )
    ratio: Number | None = quantity(
        "drum radius over input radius of the first stage; left out: from total_ratio, else what the motor needs",
        "[1, 60]",
        example=6.0,
    )
    design: dict[str, Any] | None = choice(
        "other words for the first stage, as in a siso_spur file: {rope: {type: 7x7-0.54}, transmission: "
        "{drum_radius_mm: 40.0}}; what is left out follows from the rules",
        example={"transmission": {"drum_radius_mm": 40.0}},
    )


class SpurDesign(SpurBlocks):
    """A cable drive."""

    travel: SpurTravel

    configuration: Literal["siso_spur"] = choice(
        "layout: siso_spur is (a) of Fig. 1, one input beside the drum", source="Fig. 1", reference="siso_spur"
    )
    inputs: tuple[Input, ...] = choice(
        "the input pulley", source="Fig. 1", reference=REFERENCE.inputs, min_length=1, max_length=8
    )
    cables: tuple[SpurSide, ...] = choice(
        "the two sides of the cable, or two anchored cables, and the side of the drum of each; each may have a "
        "preload_N and a terminal_angle_deg",
        source="Fig. 1",
        reference=REFERENCE.cables,
        min_length=1,
        max_length=16,
    )
    first_stage: FirstStageBlock | None = choice(
        "a cable stage before the input, a whole drive of its own: {total_ratio: 24.0}; left out, the motor, or its "
        "gearhead, turns the input",
        example={"total_ratio": 24.0},
    )
