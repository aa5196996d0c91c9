"""Schema of a miso_bevel design file: the blocks that are this configuration's own, each field with its source.

``source`` speaks of the reference value, the one that ``mbcdm init --reference`` writes. Reference values of the
blocks that all configurations share are in ``reference.json``.
"""

from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar, Literal

from mbcdm_cad.design.blocks import Design, DriveTrain, Input, Length, SpanLimits, WoundRope
from mbcdm_cad.design.fields import ESTIMATE, Block, EntryName, Integer, Number, choice, quantity
from mbcdm_cad.design.loader import reference_of
from mbcdm_cad.design.sector_blocks import SectorCable, SectorDrum, TransferClearances, WoundPulleys
from mbcdm_cad.layouts.miso_bevel.drive import Support

REFERENCE = reference_of(Path(__file__).parent)

Side = Literal["-x", "+x"]


class Ratios(Block):
    """Reductions, large radius over small; every cable then satisfies Eq. (1) exactly."""

    input_to_guide: Number = quantity(
        "guide radius over input radius", "[0.2, 20]", source="Table 2: 9/6", reference=1.5
    )
    guide_to_drum: Number = quantity(
        "drum radius over guide radius", "[0.5, 50]", source="Table 2: 54/9", reference=6.0
    )


class Transmission(Block):
    """Pitch radii (to the cable's centre line), by step 1 to 4, and where the pulleys stand."""

    centre_distance_mm: Number = quantity(
        "input pulley axis to guide axis, L", "[2, 500]", uncertain=True, source="Table 2", reference=34.6
    )
    ratio: Number | None = quantity(
        "drum radius over input radius; sizing divides it between guide and inputs if ratios and radii are left "
        "out, and chooses it with the motor if it is left out too",
        "[0.5, 100]",
        source="Table 2: 54/6",
        example=9.0,
    )
    drum_radius_mm: Number | None = quantity(
        "drum pitch radius of step 1; sizing adds the steps if drum_radii_mm is left out",
        "[5, 500]",
        source="Table 2",
        example=54.0,
    )
    input_setback_mm: Number = quantity(
        "input axes behind the guide's axis, away from the drum, so that drives and collars clear the drum's terminals",
        "[0, 100]",
        default=0.0,
    )
    drum_radii_mm: tuple[Length, ...] = quantity(
        "drum pitch radii r_o of steps 1 to 4",
        uncertain=True,
        source="Table 2",
        reference=[54.0, 57.6, 61.2, 64.8],
        min_length=4,
        max_length=4,
    )
    ratios: Ratios | None = quantity(
        "reductions that give guide and input radii; leave out when the radii are explicit",
        source="Table 2",
        reference={},
    )
    guide_radii_mm: tuple[Length, ...] | None = quantity(
        "explicit guide pitch radii r_g of steps 1 to 4, in place of ratios; Eq. (1) is then checked",
        uncertain=True,
        source="Table 2",
        example=[9.0, 9.6, 10.2, 10.8],
        min_length=4,
        max_length=4,
    )
    input_radii_mm: tuple[Length, ...] | None = quantity(
        "explicit input pitch radii r_m of steps 1 to 4, in place of ratios",
        uncertain=True,
        source="Table 2",
        example=[6.0, 6.4, 6.8, 7.2],
        min_length=4,
        max_length=4,
    )


@dataclass(frozen=True, kw_only=True)
class BevelClearances(TransferClearances):
    """Gaps between finished surfaces."""

    transfer_gap_mm: Number = quantity(
        "gap from guide step 1 to the drum's inner face; under half a rope, so that no rope slips in", "[0.01, 5]"
    )


@dataclass(frozen=True, kw_only=True)
class Drum(SectorDrum):
    """Drum sector with web, hub and tensioners; y is along the drum axis from the guide's axis."""


class Guide(Block):
    """Guide pulley, an idler on a fixed axle."""

    material: EntryName = choice("material of the pulley", source=ESTIMATE, reference="aluminium-7075")
    bearing: EntryName = choice("both bearings inside the pulley", source=ESTIMATE, reference="618/4")
    axle_material: EntryName = choice("material of the axle", source=ESTIMATE, reference="steel")
    slip: Literal["none", "counted"] = choice(
        "whether the rope creeps on the guide's wraps too: none, as the paper reckons, the tension does not change "
        "along a wrap; or counted, in model, checks, rig and loop, from both ends of each wrap",
        default="none",
    )


class BevelDriveTrain(DriveTrain):
    """Motor, gearhead and encoders, from the catalogue."""

    motor_side: Literal["below", "above"] = choice(
        "side of the pulleys on which gearheads and motors are: below, under the motor shelf, the encoders on the top "
        "plate; or above, on the top plate, the encoders under the bearing shelf",
        default="below",
    )


@dataclass(frozen=True, kw_only=True)
class InputPulleys(WoundPulleys):
    """Input pulleys, carried by a bearing at both ends."""

    material: EntryName = choice("material of both pulleys")
    surface: Literal["smooth", "grooved"] = choice(
        "smooth lands, or a helical groove for each cable, which allows limits.fleet_angle_grooved_max_deg",
        default="smooth",
    )
    upper_bearing: EntryName = choice("bearing in the top plate")


class BevelInput(Input):
    """An input pulley with its own motor."""

    side: Side = choice("side of the guide on which it stands, at x = -L or +L", source="Fig. 2")


class BevelCable(SectorCable):
    """A cable from an input pulley over the guide to the drum."""

    step: Integer = choice("step of guide and drum it runs on, 1 the smallest", source="Table 2", ge=1, le=4)
    drum_side: Side = choice("side to which it runs on the drum from the transfer point", source="Fig. 2")


_BEHIND_DRUM = Design.ORDER.index("drum") + 1


class BevelDesign(Design):
    """A cable drive."""

    ORDER: ClassVar[tuple[str, ...]] = (*Design.ORDER[:_BEHIND_DRUM], "guide", *Design.ORDER[_BEHIND_DRUM:])

    configuration: Literal["miso_bevel"] = choice(
        "layout: miso_bevel is (d) of Fig. 1, two inputs and a bevel transfer", source="Fig. 1", reference="miso_bevel"
    )
    transmission: Transmission
    inputs: tuple[BevelInput, ...] = choice(
        "input pulleys, one on each side", source="Fig. 2", reference=REFERENCE.inputs, min_length=1, max_length=8
    )
    cables: tuple[BevelCable, ...] = choice(
        "cables: which input each runs from and which way round the drum; each may have a preload_N and a "
        "terminal_angle_deg",
        source="Table 2 and Fig. 2",
        reference=REFERENCE.cables,
        min_length=1,
        max_length=16,
    )
    rope: WoundRope
    clearances: BevelClearances
    drive: BevelDriveTrain
    drum: Drum
    guide: Guide
    input_pulleys: InputPulleys
    support: Support
    limits: SpanLimits
