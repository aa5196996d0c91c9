"""Input pulley: two steps, smooth or grooved, journals for bearings and encoder, slit bore for the gearhead's shaft."""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import asin, pi, sqrt
from typing import TYPE_CHECKING

from mbcdm_cad.parts.input_pulley.dims import STOP_PLAY_MM, Groove, InputPulleyDims, StopSlot
from mbcdm_cad.parts.part import MadePart, Ring, ring_mm3, rings_mm3

if TYPE_CHECKING:
    import cadquery as cq

    from mbcdm_cad.parts.sheet import Sheet


def _strip_mm2(radius: float, width: float) -> float:
    """Area of a strip through the middle of a circle."""
    h = min(width / 2, radius)
    return 2 * (h * sqrt(radius**2 - h**2) + radius**2 * asin(h / radius)) if radius > 0.0 else 0.0


def _slot_mm3(slot: StopSlot) -> float:
    """Slot of a cable's stop: a quarter of a ring and a straight piece of the slot's depth, the pocket deeper."""
    depth = abs(slot.end_z - slot.face_z) + slot.width / 2
    reach = slot.stop_radius + STOP_PLAY_MM
    pocket = abs(slot.chord_z - slot.face_z) + reach
    length = slot.stop_start - slot.stop_end + 2 * STOP_PLAY_MM
    straight = max(slot.pitch_radius - slot.bend_radius - slot.stop_start, 0.0)
    return slot.width * depth * (pi / 2 * slot.bend_radius + straight) + 2 * reach * length * pocket


def _groove_ring(groove: Groove) -> Ring:
    inner, outer = groove.root_radius, groove.root_radius + groove.depth
    half, middle = groove.volume_mm3 / (2 * pi * (outer**2 - inner**2)), (groove.start_z + groove.end_z) / 2
    return (inner, outer, middle - half, middle + half)


@dataclass(frozen=True)
class InputPulley(MadePart):
    """Input pulley about its own axis, heights as in the assembly, turned as with the drum centred."""

    dims: InputPulleyDims
    # With a ring for each turn of its helical grooves, as the views of its sheet show them.
    rings: bool = False

    def solid(self) -> cq.Solid:
        """Drawn by ``draw.py`` beside this module."""
        from mbcdm_cad.parts.input_pulley.draw import create_input_pulley

        return create_input_pulley(self.dims, self.rings)

    def in_rings(self) -> tuple[Ring, ...]:
        """Journals, necks and steps less bore and grooves; a groove is as long as a ring of its depth and volume."""
        d = self.dims
        return (
            (d.lower_journal_radius, 0.0, d.journal_bottom_z, d.lower_neck_bottom_z),
            (d.lower_neck_radius, 0.0, d.lower_neck_bottom_z, d.land_bottom_z),
            (d.lower_land_radius, 0.0, d.land_bottom_z, d.wall_z),
            (d.upper_land_radius, 0.0, d.wall_z, d.land_top_z),
            (d.upper_neck_radius, 0.0, d.land_top_z, d.upper_neck_top_z),
            (d.upper_journal_radius, 0.0, d.upper_neck_top_z, d.journal_top_z),
            (0.0, d.bore_radius, d.journal_bottom_z, d.bore_top_z),
            *(_groove_ring(groove) for groove in d.grooves),
        )

    def volume_mm3(self) -> float:
        """Journals, necks and steps less bore, slit, slots and grooves."""
        d = self.dims
        both = _strip_mm2(d.lower_journal_radius, d.slit_width)
        slit = both * (d.slit_top_z - d.journal_bottom_z)
        slit -= _strip_mm2(d.bore_radius, d.slit_width) * max(d.bore_top_z - d.journal_bottom_z, 0.0)
        if d.horn is not None:
            thick = d.lower_neck_bottom_z - d.journal_bottom_z
            slit = len(d.horn.places) * ring_mm3(d.horn.clearance, 0.0, thick)
        if d.hub is not None:
            slit = ring_mm3(d.hub.thread / 2, 0.0, 2 * (d.lower_journal_radius - d.bore_radius))
        return rings_mm3(self.in_rings()) - slit - sum(map(_slot_mm3, d.slots))

    def in_views(self) -> InputPulley:
        """With rings in place of helical grooves, whose hidden lines take minutes to compute."""
        return replace(self, rings=bool(self.dims.grooves))

    def sheet(self, part: str) -> Sheet:
        """Described by ``sheet.py`` beside this module."""
        from mbcdm_cad.parts.input_pulley.sheet import input_pulley_sheet, overhung_pulley_sheet

        plain = self.dims.hub is None and self.dims.horn is None
        return (input_pulley_sheet if plain else overhung_pulley_sheet)(part, self.dims)
