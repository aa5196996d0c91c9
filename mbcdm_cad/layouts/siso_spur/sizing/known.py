"""What the sizing rules of siso_spur read: fields, catalogue, and results of checks on a trial drive."""

from collections.abc import Mapping

from mbcdm_cad.design.bought import Gearhead
from mbcdm_cad.design.paths import at
from mbcdm_cad.layouts.base import Layout
from mbcdm_cad.layouts.siso_spur.drive import MOST_SECTOR_TRAVEL_DEG, PITCH_SPREAD
from mbcdm_cad.layouts.siso_spur.first_stage import FirstStage, of_data
from mbcdm_cad.layouts.siso_spur.layout import SpurLayout
from mbcdm_cad.layouts.trial_sizing import TrialKnown
from mbcdm_cad.parts.drum_sector.dims import WHOLE_DEG


class SpurKnown(TrialKnown):
    """Adds the values of an input beside the drum."""

    layout: type[Layout] = SpurLayout
    asked: tuple[str, ...] = (
        at.travel.half_angle_deg,
        at.loads.peak_torque_Nm,
        at.transmission.drum_radius_mm,
        at.transmission.input_to_drum,
        at.transmission.parallel,
        at.rope.type,
        at.rope.preload_N,
        at.drive.motor,
        at.drive.gearhead,
    )

    # The neck between the stop slots of anchored cables can be too small for the shoulder of a bearing that fits it.
    own_checks: Mapping[str, tuple[str, ...]] = {
        # Several sectors on one shaft.
        at.drum.hub_diameter_mm: ("dowel_holes", "hub_dowels"),
        at.input_pulleys.lower_bearing: ("bearing_shoulders",),
        at.input_pulleys.upper_bearing: ("bearing_shoulders",),
        # A shaft that stands out as the output.
        at.drum.bearing: ("shaft_end_stress", "shaft_end_twist", "shaft_end_flange"),
        at.drum.shaft_bore_mm: ("shaft_end_stress", "shaft_end_twist"),
        at.drum.hub_face_y_mm: ("shaft_end_bond", "sectors_apart", "dowel_holes"),
    }

    most_sector_travel_deg = MOST_SECTOR_TRAVEL_DEG

    @property
    def whole_drum(self) -> bool:
        """Whether the file states a whole drum, or a travel that asks for one."""
        stated, half = self.peek(at.drum.sector_half_angle_deg), self.peek(at.travel.half_angle_deg)
        ends = self.peek(at.travel.from_deg), self.peek(at.travel.to_deg)
        if stated is not None:
            return bool(stated >= WHOLE_DEG)
        if half is None and None not in ends:
            half = (ends[1] - ends[0]) / 2
        return half is not None and bool(half > self.most_sector_travel_deg)

    @property
    def first_stage(self) -> FirstStage | None:
        """The first cable stage, None without; ``SizingError`` says what is wrong with its words."""
        return of_data(self.get) if self.has("first_stage") else None

    @property
    def gearhead(self) -> Gearhead:
        """See the base class; a first cable stage takes its place."""
        first = self.first_stage
        return super().gearhead if first is None else first.output

    @property
    def anchored(self) -> bool:
        """Whether two cables end on each input."""
        return bool(self.get(at.transmission.cables, "continuous") == "two_anchored")

    @property
    def parallel(self) -> int:
        """Number of cables side by side."""
        return int(self.get(at.transmission.parallel, 1))

    @property
    def parallel_spread(self) -> float:
        """How far the preload of one of several parallel cables may be from the stated one, over it, at least."""
        return 0.0 if self.parallel == 1 else PITCH_SPREAD

    @property
    def half_torque_N(self) -> float:
        """See the base class; parallel cables share it."""
        return super().half_torque_N / self.parallel

    @property
    def ratio(self) -> float:
        """Drum radius over input radius."""
        if self.has(at.transmission.input_to_drum):
            return float(self[at.transmission.input_to_drum])
        return float(self[at.transmission.drum_radius_mm] / self[at.transmission.input_radius_mm])

    @property
    def has_ratio(self) -> bool:
        """See the base class; if False, the ratio follows from the motor."""
        return self.has(at.transmission.input_to_drum) or self.has(at.transmission.input_radius_mm)

    @property
    def input_mm(self) -> float:
        """Pitch radius of the input."""
        return float(self[at.transmission.drum_radius_mm]) / self.ratio

    @property
    def drum_mm(self) -> float:
        """Pitch radius of the drum."""
        return float(self[at.transmission.drum_radius_mm])
