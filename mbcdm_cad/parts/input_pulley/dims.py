"""Dimensions of an input pulley of two steps: lands, journals, bore, and the slots that hold the cables' stops."""

from __future__ import annotations

from dataclasses import dataclass
from math import acos, degrees, hypot, sqrt

ENCODER_INSERTION_MM = 10.0
# Play of a cable's stop in its pocket.
STOP_PLAY_MM = 0.05
# Slot over the cable it holds.
SLOT_PLAY_MM = 0.1
# Diameter of the pocket's cutter in slot widths: its corners are relieved so that the stop's square ends seat.
STOP_CUTTER = 0.85
# Where the slot leaves the land, the wedge outside it is cut back to this thickness.
WEDGE_MM = 0.3

# At 45 degrees, on every outer edge that is chamfered.
CHAMFER_MM = 0.2


@dataclass(frozen=True)
class StopSlot:
    """Slot for one cable's stop, in the pulley's frame with the drum centred (angles rad, heights mm)."""

    cable_name: str
    end_angle_rad: float
    away: int
    end_z: float
    chord_z: float
    chord_offset: float
    face_z: float  # end face the slot is milled from
    pitch_radius: float
    bend_radius: float
    width: float
    stop_radius: float
    stop_start: float  # along the chord, from the axis' foot; positive towards the bend
    stop_end: float

    @property
    def cutter_radius(self) -> float:
        """Radius of the cutter that relieves the pocket's corners."""
        return STOP_CUTTER * self.width / 2

    @property
    def pocket_reach(self) -> float:
        """Furthest point of the pocket from the pulley's axis, its corner's relief included."""
        inset = self.cutter_radius / sqrt(2)
        along, out = self.stop_start + STOP_PLAY_MM, self.bend_radius + self.stop_radius + STOP_PLAY_MM
        return hypot(along - inset, out - inset) + self.cutter_radius

    def open_deg(self, surface_radius: float) -> float:
        """Angle about the bend's centre up to which the slot is open to the outside, on a land of this radius."""
        centre, outer = self.pitch_radius - self.bend_radius, self.bend_radius + self.width / 2
        cosine = ((surface_radius - WEDGE_MM) ** 2 - centre**2 - outer**2) / (2 * centre * outer)
        return degrees(acos(min(1.0, max(0.0, cosine))))

    @property
    def pocket_inner(self) -> float:
        """Nearest the pocket comes to the pulley's axis, reliefs included."""
        return self.bend_radius - self.stop_radius - STOP_PLAY_MM - self.cutter_radius * (1 - 1 / sqrt(2))


@dataclass(frozen=True)
class InputPulleyDims:
    """One input pulley. Heights along Z from lower journal to encoder journal (mm)."""

    name: str
    x: float
    journal_bottom_z: float
    lower_journal_radius: float
    lower_neck_bottom_z: float
    lower_neck_radius: float
    land_bottom_z: float
    lower_surface_radius: float
    wall_z: float
    upper_surface_radius: float
    land_top_z: float
    upper_neck_radius: float
    upper_neck_top_z: float
    upper_journal_radius: float
    journal_top_z: float
    bore_radius: float
    bore_top_z: float
    slit_width: float
    slit_top_z: float
    slots: tuple[StopSlot, ...]
    y: float = 0.0
