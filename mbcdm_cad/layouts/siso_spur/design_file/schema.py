"""Schema of a siso_spur design file: the blocks that are this configuration's own, each field with its source.

Reference values of shared blocks are in ``reference.json``.
"""

from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar, Literal

from mbcdm_cad.design.blocks import TRAVEL_MAX_DEG, Design, Input, Length, Rope, Travel
from mbcdm_cad.design.fields import Block, Integer, Number, choice, quantity
from mbcdm_cad.design.loader import reference_of
from mbcdm_cad.design.sector_blocks import Clearances, SectorCable, WoundPulleys
from mbcdm_cad.layouts.siso_spur.drive import MOST_TURNS, SpurDrum, SpurLimits, YokeSupport
from mbcdm_cad.layouts.siso_spur.first_stage import FirstStageBlock
from mbcdm_cad.layouts.siso_spur.strand import IdlerBlock

REFERENCE = reference_of(Path(__file__).parent)


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

    ORDER: ClassVar[tuple[str, ...]] = (
        "type",
        "inline",
        "modulus_GPa",
        "modulus_area",
        "termination",
        "friction_coefficient",
        "preload_N",
        "helix_lead_mm",
        "cut_tolerance_mm",
    )

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
