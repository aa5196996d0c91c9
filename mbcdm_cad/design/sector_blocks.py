"""Blocks of the design file of drives whose cables end on a drum sector, each from a pulley of two steps.

As in :mod:`mbcdm_cad.design.blocks`, the reference values with their sources are the configurations' own.
"""

from dataclasses import dataclass
from typing import ClassVar, Literal

from mbcdm_cad.design.blocks import Cable
from mbcdm_cad.design.fields import ESTIMATE, EntryName, Integer, Number, PlainBlock, choice, quantity

# Largest half angle of a sector: beyond, no gap is left.
MOST_SECTOR_DEG = 175.0


@dataclass(frozen=True, kw_only=True)
class Clearances(PlainBlock):
    """Gaps between finished surfaces."""

    land_edge_mm: Number = quantity("edge of a drum land to the next cable's contact line", "[0, 5]")
    running_mm: Number = quantity("gap between any moving part and any fixed part elsewhere", "[0.01, 5]")


@dataclass(frozen=True, kw_only=True)
class TransferClearances(Clearances):
    """Gaps between finished surfaces."""

    ORDER: ClassVar[tuple[str, ...]] = ("transfer_gap_mm",)

    transfer_gap_mm: Number = quantity(
        "surface of step 1 at the transfer to the drum's inner face; under half a rope, so that none slips in",
        "[0.01, 5]",
    )


class SectorCable(Cable):
    """A cable that ends in a terminal on the drum."""

    ORDER: ClassVar[tuple[str, ...]] = ("name", "input", "step", "drum_side", "preload_N", "terminal_angle_deg")

    terminal_angle_deg: Number | None = quantity(
        "angle on the centred drum, from the direction of the pulley before it, at which the cable leaves its land for "
        "its terminal; left out: as far out as the sector allows",
        "[1, 355]",
    )


@dataclass(frozen=True, kw_only=True)
class SectorDrum(PlainBlock):
    """Drum sector with web, hub and tensioners; y is along the drum axis from the axis of the pulley before it."""

    material: EntryName = choice("material of the sector")
    sector_half_angle_deg: Number = quantity(
        "half angle of the sector, from the transfer point", ge=20.0, le=MOST_SECTOR_DEG
    )
    rim_inner_radius_mm: Number = quantity("inner radius of the rim that carries the lands", "[2, 500]")
    outer_face_y_mm: Number = quantity("outer face of the rim", "[0, 200]")
    web_thickness_mm: Number = quantity("web between rim and hub", "[0.3, 50]")
    windows: Literal["outer", "none"] = choice(
        "two windows in the web outside the stop's slot, for mass; or none: a full web, stiffer and stronger",
        default="outer",
    )
    hub_diameter_mm: Number = quantity("hub outside diameter", "[2, 200]")
    hub_face_y_mm: Number = quantity("face of the hub, where the output is taken", "[0, 300]")
    output_circle_mm: Number | None = quantity(
        "diameter of the circle of the payload's screws on the hub's face; left out: midway between shaft and edge",
        "[5, 300]",
    )
    output_screws: Integer = quantity(
        "number of the payload's screws, evenly on their circle; their thread follows from the peak torque",
        default=4,
        ge=3,
        le=12,
    )
    bearing: EntryName = choice("both bearings of the drum shaft")
    shaft_bore_mm: Number = quantity(
        "bore of the drum shaft, 0 for a solid one; stated: a hollow centre, for which spur layouts choose bearings",
        "[0, 100]",
    )
    shaft_material: EntryName = choice("material of the drum shaft")
    tensioner: EntryName = choice("tensioner of each cable")
    spring: EntryName | None = choice(
        "catalogue spring on the stud of each terminal, between lug and nut; if left out, the nut sits on the lug",
        example="disc-8x4.2x0.4",
    )
    spring_count: Integer = quantity(
        "springs one behind the other on each stud, discs turned against each other; used with spring",
        default=1,
        ge=1,
        le=40,
    )
    stop_pin_mm: Number = quantity(
        "pin in the frame that stops the drum at both ends of its travel", "[1, 20]", default=3.0
    )


@dataclass(frozen=True, kw_only=True)
class SteppedPulleys(PlainBlock):
    """Input pulleys, carried by a bearing at both ends."""

    ORDER: ClassVar[tuple[str, ...]] = ("material", "surface", "lower_bearing", "upper_bearing")

    material: EntryName = choice("material of the pulleys")
    lower_bearing: EntryName = choice("bearing towards the gearhead")
    upper_bearing: EntryName = choice("bearing towards the encoder")
    collar_screw: EntryName = choice(
        "screw of the clamp collar that couples a pulley to its gearhead", default="M1.6x6"
    )

    @property
    def grooved(self) -> bool:
        """Whether a groove leads each cable; each lies in the plane of its step here."""
        return False

    @property
    def overhung(self) -> bool:
        """Whether the shaft of motor or gearhead alone carries each pulley, without bearings of its own."""
        return False


@dataclass(frozen=True, kw_only=True)
class HeadSupport(PlainBlock):
    """Walls of a support with a motor head, along the input's axis."""

    motor_shelf_mm: Number = quantity(
        "shelf that carries the gearhead", "[0.5, 50]", source="gearhead screws engage one diameter", reference=4.0
    )
    bearing_shelf_mm: Number = quantity(
        "shelf of the bearing next to the gearhead, the motor head's flange",
        "[0.5, 50]",
        source=ESTIMATE,
        reference=4.0,
    )
    encoder_shelf_mm: Number = quantity(
        "shelf of the bearing next to the encoder", "[0.5, 50]", source=ESTIMATE, reference=4.0
    )


@dataclass(frozen=True, kw_only=True)
class WoundPulleys(SteppedPulleys):
    """Input pulleys that cables wind on in a helix."""

    surface: Literal["smooth", "grooved"] = choice("smooth lands, or a helical groove that leads each cable")

    @property
    def grooved(self) -> bool:
        """Whether each cable winds into a helical groove."""
        return self.surface == "grooved"
