"""The drive of siso_bevel and its design file: its own blocks, each field with its source, its rules, a short file.

Reference values of shared blocks are in ``reference.json``, the short file to start from in ``starting.txt``.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar, Literal

from mbcdm_cad.design.blocks import Design, Input, Length
from mbcdm_cad.design.drive import Sigmas
from mbcdm_cad.design.fields import ESTIMATE, Block, EntryName, Integer, Number, choice, quantity
from mbcdm_cad.design.loader import DesignFile, reference_of
from mbcdm_cad.design.resolve import Catalogue, by_step, preload_N, shared_sigmas, shared_values
from mbcdm_cad.design.rules import Broken, NamedEntry, counted, encoders_needed, in_line_only, on_one_side, unique
from mbcdm_cad.design.sector_blocks import HeadSupport, SectorCable, SectorDrum, SteppedPulleys, TransferClearances
from mbcdm_cad.design.yamltree import FieldPath
from mbcdm_cad.parts.drum_sector.design import (
    SectorBearings,
    SectorDrive,
    SectorRun,
    sector_entries,
    sector_values,
    terminal_angle_rad,
)

# Source of the walls that stiffen the frame.
CHOSEN = "for limits.frame_windup_max_mrad"


@dataclass(frozen=True)
class DirectRun(SectorRun):
    """One cable: steps 1 and 2, the same on input and drum."""

    @property
    def land_y_mm(self) -> float:
        """y of the cable on the drum, mm: the transfer point is (0, r_m, r_o)."""
        return self.input_radius_mm


@dataclass(frozen=True, kw_only=True)
class ColumnSupport(HeadSupport):
    """Frame with the drum's bearings and the pulley's box, and the motor head on top of it."""

    ORDER: ClassVar[tuple[str, ...]] = (
        *("material", "back_y_mm", "back_plate_mm", "side_wall_mm"),
        *("motor_shelf_mm", "coupling_space_mm", "bearing_shelf_mm", "encoder_shelf_mm"),
    )

    material: EntryName = choice("material of frame and motor head", source=ESTIMATE, reference="aluminium-7075")
    back_y_mm: Number = quantity(
        "outer face of the back plate", "[-300, -1]", source="the pulley clears the back plate", reference=-17.3
    )
    back_plate_mm: Number = quantity("back plate thickness", "[0.3, 50]", source=CHOSEN, reference=3.0)
    side_wall_mm: Number = quantity(
        "side walls of the pulley's box, with the motor head's screws",
        "[0.3, 50]",
        source="walls beside an M2 thread",
        reference=4.0,
    )
    coupling_space_mm: Number = quantity(
        "height between the shelves: coupling collar, gearhead screws and the tools for both",
        "[2, 100]",
        source=ESTIMATE,
        reference=9.6,
    )
    rib_mm: Number = quantity("side walls of the column", "[0.3, 50]", source=CHOSEN, reference=5.0)

    mount_screw: Literal["M3", "M4", "M5", "M6"] = choice(
        "screws that hold the frame on its base", source=ESTIMATE, reference="M3", default="M3"
    )


@dataclass(frozen=True)
class DirectDrive(SectorDrive):
    """A drive whose one input turns the drum without a guide.

    ``reserve_deg``: wrap that stays on the input at the unwound end of the travel.
    """

    cables: tuple[DirectRun, ...]
    clearances: TransferClearances
    reserve_deg: float
    radii_explicit: bool
    support: ColumnSupport

    @property
    def total_ratio(self) -> float:
        """i = r_o / r_m of the first step."""
        return self.cables[0].drum_radius_mm / self.cables[0].input_radius_mm


REFERENCE = reference_of(Path(__file__).parent)


class DirectTransmission(Block):
    """Pitch radii (to the cable's centre line) of steps 1 and 2, and the wrap that stays on the input."""

    drum_radius_mm: Number | None = quantity(
        "drum pitch radius of step 1; sizing adds step 2 if drum_radii_mm is left out",
        "[5, 500]",
        source="the paper's Table 2",
    )
    drum_radii_mm: tuple[Length, ...] = quantity(
        "drum pitch radii r_o of steps 1 and 2",
        uncertain=True,
        source="their mean is that of the paper's Table 2",
        reference=[58.05, 60.75],
        min_length=2,
        max_length=2,
    )
    input_to_drum: Number | None = quantity(
        "drum radius over input radius, the same for both steps; leave it out if the input radii are explicit",
        "[0.5, 60]",
        source="highest ratio with which travel, reserve and stop slot fit on one turn of the input",
        reference=4.5,
    )
    input_radii_mm: tuple[Length, ...] | None = quantity(
        "explicit input pitch radii r_m of steps 1 and 2, in place of input_to_drum",
        uncertain=True,
        example=[12.9, 13.5],
        min_length=2,
        max_length=2,
    )
    reserve_deg: Number = quantity(
        "wrap that stays on the input at the unwound end of the travel, before the stop's bend",
        "[0, 360]",
        source=ESTIMATE,
        reference=18.0,
    )


class DirectCable(SectorCable):
    """A cable from the input pulley to the drum."""

    step: Integer = choice("step of input and drum, 1 the smaller", ge=1, le=2)
    drum_side: Literal["-x", "+x"] = choice("side of the drum, from the transfer point")


class DirectDesign(Design):
    """A cable drive."""

    configuration: Literal["siso_bevel"] = choice(
        "layout: siso_bevel is (c) of Fig. 1, one input straight onto the drum", source="Fig. 1", reference="siso_bevel"
    )
    transmission: DirectTransmission
    inputs: tuple[Input, ...] = choice(
        "the input pulley", source="Fig. 1", reference=REFERENCE.inputs, min_length=1, max_length=8
    )
    cables: tuple[DirectCable, ...] = choice(
        "cables, each with its step and its side of the drum; each may have a preload_N and a terminal_angle_deg",
        source="Fig. 1",
        reference=REFERENCE.cables,
        min_length=1,
        max_length=16,
    )
    clearances: TransferClearances
    drum: SectorDrum
    input_pulleys: SteppedPulleys
    support: ColumnSupport


_SIGN = {"-x": -1, "+x": 1}


def drive(design: DirectDesign, catalogue: Catalogue, sigmas: Mapping[FieldPath, float]) -> DirectDrive:
    """The drive of a valid design; its cables are in the order of their steps."""
    places = by_step(design.cables)
    pulleys = input_radii_mm(design.transmission)

    def radii(name: str) -> tuple[float, ...]:
        return tuple(sigmas.get(("transmission", name, design.cables[k].step - 1), 0.0) for k in places)

    return DirectDrive(
        **shared_values(design, catalogue),
        **sector_values(design, catalogue),
        # The cable stays in its plane; the reserve is given as an angle.
        helix_lead_mm=0.0,
        dead_turns=design.transmission.reserve_deg / 360.0,
        cables=tuple(
            DirectRun(
                name=cable.name,
                input_name=cable.input,
                drum_side=_SIGN[cable.drum_side],
                step=cable.step,
                input_radius_mm=pulleys[cable.step - 1],
                drum_radius_mm=design.transmission.drum_radii_mm[cable.step - 1],
                preload_N=preload_N(design, cable),
                terminal_angle_rad=terminal_angle_rad(cable),
            )
            for cable in (design.cables[k] for k in places)
        ),
        reserve_deg=design.transmission.reserve_deg,
        radii_explicit=design.transmission.input_to_drum is None,
        bearings=SectorBearings(
            drum=catalogue.bearing(design.drum.bearing),
            input_lower=catalogue.bearing(design.input_pulleys.lower_bearing),
            input_upper=catalogue.bearing(design.input_pulleys.upper_bearing),
        ),
        sigmas=Sigmas(
            **shared_sigmas(design, catalogue, sigmas, places),
            lengths_mm={"input_radius_mm": radii("input_radii_mm"), "drum_radius_mm": radii("drum_radii_mm")},
        ),
    )


def input_radii_mm(transmission: DirectTransmission) -> tuple[float, ...]:
    """Input pitch radii by step, from the ratio or as given; those from the ratio are rounded to 1e-9 mm."""
    if transmission.input_to_drum is None:
        return transmission.input_radii_mm or ()
    return tuple(round(radius / transmission.input_to_drum, 9) for radius in transmission.drum_radii_mm)


def broken_rules(design: DirectDesign) -> Iterator[Broken]:
    """The rules of this configuration that the design breaks, in the order of the file's blocks."""
    yield from _transmission(design)
    yield from encoders_needed(design)
    yield from in_line_only(design)
    yield from counted(design, "inputs", 1, "give exactly one input; miso_bevel has two")
    yield from counted(design, "cables", 2, "give one cable for each sense of the drum")
    yield from unique("cables", "step", [cable.step for cable in design.cables])
    if len(design.cables) == 2 and design.cables[0].drum_side == design.cables[1].drum_side:
        yield on_one_side(1, design.cables[1].drum_side, "cables")


def named_entries(design: DirectDesign) -> Iterator[NamedEntry]:
    """Entries of the catalogue that the blocks of this configuration name."""
    yield from sector_entries(design)
    yield NamedEntry(("support", "material"), "materials", design.support.material)


def _transmission(design: DirectDesign) -> Iterator[Broken]:
    block = design.transmission
    if block.input_to_drum is not None and block.input_radii_mm is not None:
        where, remedy = ("transmission", "input_radii_mm"), "remove input_to_drum, or remove input_radii_mm"
        yield Broken(where, "given beside input_to_drum", "", "input_to_drum or explicit radii", remedy)
    elif block.input_to_drum is None and block.input_radii_mm is None:
        what, remedy = "radii of the input pulley are not given", "add input_to_drum, or input_radii_mm"
        yield Broken(("transmission",), what, "", "input_to_drum or explicit radii", remedy)
    small, large = block.drum_radii_mm
    if block.drum_radius_mm is not None and block.drum_radius_mm != small:
        yield Broken(
            ("transmission", "drum_radius_mm"),
            "contradicts drum_radii_mm",
            f"{block.drum_radius_mm:g} mm",
            f"{small:g} mm, the first of drum_radii_mm",
            "leave one of the two out, so that it follows",
        )
    if large <= small:
        remedy = "order the radii from step 1, the smaller, to step 2"
        step = ("transmission", "drum_radii_mm", 1)
        yield Broken(step, "steps do not grow", f"{large:g} mm", f"over {small:g} mm", remedy)


DESIGN_FILE = DesignFile(
    DirectDesign,
    REFERENCE.values,
    broken_rules,
    named_entries,
    drive,
    "mbcdm_cad.layouts.siso_bevel.sizing",
    Path(__file__).with_name("starting.txt").read_text("utf-8"),
)
