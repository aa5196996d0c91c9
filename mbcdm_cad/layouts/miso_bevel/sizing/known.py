"""The data that the sizing rules of miso_bevel read: fields, catalogue, and figures that several rules share."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from math import pi, radians, sqrt, tan
from typing import Any

from pydantic import ValidationError

from mbcdm_cad.design.bought import Gearhead, InsertSpec, shortest_insert
from mbcdm_cad.design.resolve import Catalogue
from mbcdm_cad.design.rules import every_broken_rule
from mbcdm_cad.design.sized import SizingError
from mbcdm_cad.layouts.base import NoFigureError
from mbcdm_cad.layouts.miso_bevel.checks.spans import straight_span_distance_mm
from mbcdm_cad.layouts.miso_bevel.design_file.resolve import broken_rules, drive, named_entries
from mbcdm_cad.layouts.miso_bevel.design_file.schema import BevelDesign
from mbcdm_cad.layouts.miso_bevel.drive import BevelDrive
from mbcdm_cad.layouts.miso_bevel.stack import stack
from mbcdm_cad.layouts.miso_bevel.support.dims import MOUNT_HEAD_PLAY_MM
from mbcdm_cad.parts.drum_sector.design import seat_mm
from mbcdm_cad.parts.drum_sector.sizes import lug_wall_mm
from mbcdm_cad.parts.fits import MOUNT_SCREWS, MountScrew
from mbcdm_cad.parts.input_pulley.dims import GROOVE_LEAD, GROOVE_RADIUS
from mbcdm_cad.sizing.known import RopeKnown

STEPS = 4
# Largest share of a cable in the torque over an even one: inner steps are shorter, hence stiffer.
UNEVEN = 1.25
# Values of fields that are filled last, for trial drives: they do not affect the checks that are run on these.
LATER = {
    "drum__hub_face_y_mm": 100.0,
    "drum__outer_face_y_mm": 50.0,
    "drum__web_thickness_mm": 2.0,
    "drum__rim_inner_radius_mm": 20.0,
    "drum__hub_diameter_mm": 20.0,
    "drum__shaft_bore_mm": 1.0,
    "drum__sector_half_angle_deg": 90.0,
    "support__rib_mm": 1.0,
    "support__back_y_mm": -100.0,
}
# Fields on which the height of the frame's lowest shelf depends.
_SHELF_RESTS_ON = (
    "travel",
    "transmission",
    "rope",
    "clearances",
    "cables",
    "input_pulleys",
    "support.bearing_shelf_mm",
    "support.coupling_space_mm",
    "support.motor_shelf_mm",
    "drive",
)
# Largest fleet angle on grooves where the file names none: the schema's own.
GROOVED_FLEET_DEG = 2.0
# A lead that just clears the turn before it is raised by this share of the rope's diameter: stacked tolerances.
LEAD_SPARE = 0.008
LEAD_STEP_MM = 0.01


@dataclass(frozen=True)
class FrameStart:
    """What the rules of the frame begin with: the screws of its base, and factors on the walls that make it stiff.

    ``stiffer``: back plate and ribs; ``shelves``: bearing shelf and side walls.

    Both checks need the whole frame, so that :func:`mbcdm_cad.layouts.miso_bevel.sizing.size` raises the values where
    the frame that follows from them misses a check.
    """

    mount_screw: str = "M3"
    stiffer: float = 1.0
    shelves: float = 1.0


class BevelKnown(RopeKnown):
    """Adds figures that follow from a few fields each; reading a figure records these fields."""

    def __init__(self, data: dict[str, Any], frame: FrameStart | None = None) -> None:
        super().__init__(data)
        self.frame = frame or FrameStart()

    # The values on which the height of the lowest shelf depends, as text, and that height; two rules read it.
    _shelf_bottom: tuple[str, float] | None = None

    @property
    def mount(self) -> MountScrew:
        """The screw that holds the frame on its base."""
        return MOUNT_SCREWS[self["support.mount_screw"]]

    @property
    def mount_head_mm(self) -> float:
        """Radius of the bore for its head or washer."""
        return self.mount.seat_mm(self.printed("support")) / 2 + MOUNT_HEAD_PLAY_MM

    @property
    def modulus_GPa(self) -> float:
        """The rope's modulus: the design's own, else the catalogue's."""
        return float(self.get("rope.modulus_GPa", self.rope["modulus_GPa"]))

    @property
    def area_mm2(self) -> float:
        """The rope's area that the modulus refers to."""
        if self.get("rope.modulus_area", self.rope["modulus_area"]) == "nominal":
            return pi / 4 * self.d_mm**2
        return float(self.rope["metallic_area_mm2"])

    @property
    def half_travel_rad(self) -> float:
        """Travel each way."""
        return radians(self["travel.half_angle_deg"])

    @property
    def total_ratio(self) -> float:
        """Drum radius over input radius."""
        both = ("transmission.ratios.input_to_guide", "transmission.ratios.guide_to_drum")
        if all(self.has(field) for field in both):
            return float(self[both[0]] * self[both[1]])
        if self.has("transmission.input_radii_mm"):
            return float(self.drum_mm[0] / self["transmission.input_radii_mm"][0])
        return float(self["transmission.ratio"])

    @property
    def drum_mm(self) -> list[float]:
        """Pitch radii of the drum."""
        return list(self["transmission.drum_radii_mm"])

    @property
    def first_drum_mm(self) -> float:
        """Pitch radius of the drum's step 1."""
        if self.has("transmission.drum_radii_mm"):
            return self.drum_mm[0]
        return float(self["transmission.drum_radius_mm"])

    @property
    def guide_mm(self) -> list[float]:
        """Pitch radii of the guide."""
        if self.has("transmission.guide_radii_mm"):
            return list(self["transmission.guide_radii_mm"])
        return [radius / self["transmission.ratios.guide_to_drum"] for radius in self.drum_mm]

    @property
    def input_mm(self) -> list[float]:
        """Pitch radii of the input pulleys."""
        if self.has("transmission.input_radii_mm"):
            return list(self["transmission.input_radii_mm"])
        return [radius / self["transmission.ratios.input_to_guide"] for radius in self.guide_mm]

    @property
    def nut_mm(self) -> float:
        """Half the tensioner's nut across its corners, or the radius of wider springs."""
        nut = float(self.entry("tensioners", "drum.tensioner")["nut_across_flats_mm"] / sqrt(3.0))
        return nut if self.spring is None else max(nut, self.spring["outside_mm"] / 2)

    @property
    def terminal_mm(self) -> float:
        """How far a terminal with its lug reaches from its axis: see ``terminal_half_mm`` of the drum."""
        hole = self.entry("tensioners", "drum.tensioner")["clearance_mm"] / 2
        return float(max(self.nut_mm, hole + lug_wall_mm(self.printed("drum"), self.wall_mm("drum"))))

    @property
    def spring(self) -> dict[str, Any] | None:
        """The entry of the terminals' springs; None without."""
        return self.entry("springs", "drum.spring") if self.has("drum.spring") else None

    @property
    def spring_free_mm(self) -> float:
        """Height of the springs on a stud without load, with both washers; 0 without springs."""
        if self.spring is None:
            return 0.0
        return float(self.get("drum.spring_count", 1) * self.spring["free_mm"] + 2 * seat_mm(self.spring["outside_mm"]))

    @property
    def nut_pocket_mm(self) -> float:
        """Half width of the nuts' pocket: the cutter's corner does not lift the nut."""
        corner = self.entry("materials", "drum.material")["min_internal_radius_mm"]
        return float(self.nut_mm + self["clearances.running_mm"] + corner)

    def insert(self, part: str, thread_mm: float) -> InsertSpec | None:
        """The insert that a thread gets in a part, as :meth:`mbcdm_cad.design.drive.Drive.insert` has it."""
        if not self.printed(part) or self.get("printing.threads") != "inserts":
            return None
        return shortest_insert((InsertSpec(name=n, **e) for n, e in self.entries("inserts").items()), thread_mm)

    @property
    def gearhead(self) -> Gearhead:
        """The gearhead of each input."""
        return Gearhead(name=self["drive.gearhead"], **self.entry("gearheads", "drive.gearhead"))

    @property
    def drum_inner_mm(self) -> float:
        """y of the drum's inner face."""
        return self.guide_mm[0] - self.d_mm / 2 + float(self["clearances.transfer_gap_mm"])

    @property
    def highest_tension_N(self) -> float:
        """Largest cable tension: preload and the share of the peak torque."""
        share = self["loads.peak_torque_Nm"] * 1e3 / sum(self.drum_mm)
        return float(self["rope.preload_N"] + UNEVEN * share)

    def walk_mm(self, lead_mm: float) -> float:
        """How far a cable walks along its input pulley from the centred drum to the end of travel."""
        return lead_mm * self.total_ratio * self.half_travel_rad / (2 * pi)

    @property
    def fleet_limit_deg(self) -> float:
        """Largest fleet angle that the input pulleys' surface allows; smooth ones as long as none is chosen."""
        if self.get("input_pulleys.surface", "smooth") == "grooved":
            return self.grooved_fleet_deg
        return float(self["limits.fleet_angle_max_deg"])

    def clearing_lead_mm(self, input_radius_mm: float) -> float:
        """Least lead at which the span clears the turn before it, at the largest fleet angle that is allowed."""
        if self.get("input_pulleys.surface", "smooth") == "grooved":
            return self.grooved_lead_mm(input_radius_mm)
        return clearing_lead_mm(self.d_mm, input_radius_mm, self.fleet_limit_deg)

    @property
    def grooved_fleet_deg(self) -> float:
        """Largest fleet angle on grooves."""
        return float(self.get("limits.fleet_angle_grooved_max_deg", GROOVED_FLEET_DEG))

    def grooved_lead_mm(self, input_radius_mm: float) -> float:
        """The same on grooves, whose crests need room too."""
        lead = clearing_lead_mm(self.d_mm, input_radius_mm, self.grooved_fleet_deg)
        return max(lead, GROOVE_LEAD * GROOVE_RADIUS * self.d_mm)

    @property
    def motors_above(self) -> bool:
        """Whether motors and gearheads are on the top plate."""
        return bool(self.get("drive.motor_side", "below") == "above")

    @property
    def shelf_bearing(self) -> str:
        """Field of the input pulleys' bearing in the bearing shelf."""
        return f"input_pulleys.{'upper' if self.motors_above else 'lower'}_bearing"

    @property
    def plate_bearing(self) -> str:
        """Field of the input pulleys' bearing in the top plate."""
        return f"input_pulleys.{'lower' if self.motors_above else 'upper'}_bearing"

    @property
    def shelf_bottom_mm(self) -> float:
        """z of the lower face of the frame's lowest shelf. Raises ``ValueError`` where the pulleys have no place."""
        rests_on = repr([self.peek(field) for field in _SHELF_RESTS_ON])
        if self._shelf_bottom is None or self._shelf_bottom[0] != rests_on:
            try:
                self._shelf_bottom = rests_on, stack(self.trial(**LATER)).shelf_bottom_z
            except NoFigureError as error:
                raise ValueError(str(error)) from None
        return self._shelf_bottom[1]

    def trial(self, **open_fields: float) -> BevelDrive:
        """The drive that the fields known so far make, with figures for those that are still open.

        Of the open fields, ``block__name``, only such may be left to a figure that the asking rule does not depend on.
        Raises ``NoFigureError`` where what is known makes no drive, ``SizingError`` where the file breaks a rule.
        """
        # Only blocks are copied; the values inside a block are shared.
        data = {block: dict(fields) if isinstance(fields, dict) else fields for block, fields in self.data.items()}
        for field, value in open_fields.items():
            block, name = field.split("__")
            data.setdefault(block, {}).setdefault(name, value)
        try:
            design = BevelDesign.model_validate(data)
        except ValidationError as error:
            raise NoFigureError(f"the values known so far describe no drive: {error.errors()[0]['msg']}") from None
        catalogue = Catalogue(design)
        broken = next(every_broken_rule(design, catalogue, broken_rules(design), named_entries(design)), None)
        if broken is not None:
            raise SizingError(broken)
        return drive(design, catalogue, {})


def clearing_lead_mm(d_mm: float, radius_mm: float, fleet_deg: float) -> float:
    """Least lead, mm, at which a straight span that rises by the fleet angle clears its last turn by a rope's diameter.

    The distance grows by nearly as much as the lead, so that two secant steps are enough.
    """
    distance = partial(straight_span_distance_mm, radius_mm, slope=tan(radians(fleet_deg)))
    lead = d_mm * 1.05
    for _ in range(3):
        lead += d_mm * (1.0 + LEAD_SPARE) - distance(lead_mm=lead)
    return lead


def span_for_fleet_mm(walk_mm: float, fleet_deg: float) -> float:
    """Free span at which a walk makes the fleet angle."""
    return walk_mm / tan(radians(fleet_deg))
