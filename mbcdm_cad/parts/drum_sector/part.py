"""The drum sector as a part; the pockets of its rim are summed over a grid."""

from __future__ import annotations

from dataclasses import dataclass
from math import pi, radians
from typing import TYPE_CHECKING

import numpy as np

from mbcdm_cad.parts.drum_sector.dims import POCKET_LEAD_MM, DrumDims
from mbcdm_cad.parts.part import MadePart
from mbcdm_cad.parts.terminal.dims import Tensioner
from mbcdm_cad.parts.volume import CORNER, ring_mm3

if TYPE_CHECKING:
    import cadquery as cq

    from mbcdm_cad.parts.sheets.description import Sheet

# Cells of the grid on which the pockets of the drum's rim are summed: about 0.2 x 0.3 mm on a drum of 65 mm.
_RIM_RADII, _RIM_ANGLES = 80, 500


def _depth_y(d: DrumDims, t: Tensioner, half: float) -> float:
    return d.lands[-1].y_end if t.cut_through else min(t.y_mm + half, d.lands[-1].y_end)


def _pockets_mm3(d: DrumDims) -> float:
    """Volume that the terminals' pockets remove from the rim, lugs included."""
    outer = d.lands[-1].surface_radius_mm
    half = radians(d.half_angle_deg)
    radii = d.rim_inner_radius + (np.arange(_RIM_RADII) + 0.5) * (outer - d.rim_inner_radius) / _RIM_RADII
    angles = -half + (np.arange(_RIM_ANGLES) + 0.5) * 2 * half / _RIM_ANGLES
    starts = np.array([land.y_start for land in d.lands])
    surfaces = np.array([land.surface_radius_mm for land in d.lands])
    low = starts[np.minimum(np.searchsorted(surfaces, radii), len(starts) - 1)]
    x, z = np.multiply.outer(radii, np.sin(angles)), np.multiply.outer(radii, np.cos(angles))
    taken = np.zeros_like(x)
    for t in d.tensioners:
        sine, cosine = np.sin(t.anchor_rad), np.cos(t.anchor_rad)
        out = t.side * x * sine + z * cosine - t.radius_mm
        along = t.side * x * cosine - z * sine
        for start, end, floor, reach in (
            (t.slack_start - POCKET_LEAD_MM, t.lug_end, -d.flat_wall, d.swage_pocket),
            (t.lug_end, t.pocket_end, -d.nut_pocket, d.nut_pocket),
        ):
            inside = (along > start) & (along < end) & (out > floor) & (out < t.pocket_top)
            depth = np.maximum(_depth_y(d, t, reach) - low, 0.0)[:, None]
            taken = np.maximum(taken, np.where(inside, depth, 0.0))
    cell = (outer - d.rim_inner_radius) / _RIM_RADII * 2 * half / _RIM_ANGLES
    return float((taken * radii[:, None]).sum() * cell)


def _lug_mm3(d: DrumDims, t: Tensioner) -> float:
    """Volume of a lug minus the stud's slot, which remains in a pocket."""
    length, r = t.lug_end - t.lug_start, d.stud_hole_radius
    depth = _depth_y(d, t, d.swage_pocket) - (t.y_mm - d.lug_half_width)
    slot = 2 * r * d.lug_half_width + pi / 2 * r**2
    return length * ((d.flat_wall + d.lug_half_width) * depth - slot)


@dataclass(frozen=True)
class DrumSector(MadePart):
    """Drum sector about +Y with the drum at 0; the thread of its set screws in mm."""

    dims: DrumDims
    set_screw_thread: float

    def solid(self) -> cq.Solid:
        """Drawn by ``draw.py`` beside this module."""
        from mbcdm_cad.parts.drum_sector.draw import create_drum

        return create_drum(self.dims, self.set_screw_thread)

    def volume_mm3(self) -> float:
        """Rim, web and hub less windows, slot and holes; pockets by a sum over a grid of the rim."""
        d, set_screw_thread = self.dims, self.set_screw_thread
        share = d.half_angle_deg / 180.0
        rim = share * sum(
            ring_mm3(land.surface_radius_mm, d.rim_inner_radius, land.y_end - land.y_start) for land in d.lands
        )
        thickness = d.web_end_y - d.web_start_y
        web = share * ring_mm3(d.rim_inner_radius, d.hub_radius, thickness)
        hub = ring_mm3(d.hub_radius, d.bore_radius, d.hub_face_y - d.hub_start_y)
        hub += ring_mm3(d.spigot_radius, d.bore_radius, d.hub_start_y - d.spigot_y)
        windows = sum(
            (w.r_outer**2 - w.r_inner**2) / 2 * radians(w.end_deg - w.start_deg) - 4 * CORNER * d.corner_radius**2
            for w in d.windows
        )
        slot = 2 * radians(d.stop_slot_end_deg) * d.stop_radius * d.stop_slot_width + pi / 4 * d.stop_slot_width**2
        holes = ring_mm3(d.payload_hole / 2, 0.0, 4 * d.payload_depth)
        holes += ring_mm3(set_screw_thread / 2, 0.0, 2 * (d.hub_radius - d.bore_radius))
        if d.dowels is not None:
            deep = (
                len(d.dowels.face_angles_deg) * d.dowels.face_depth
                + len(d.dowels.back_angles_deg) * d.dowels.back_depth
            )
            holes += ring_mm3(d.dowels.radius, 0.0, deep)
        lugs = sum(_lug_mm3(d, t) for t in d.tensioners)
        return rim + web + hub - (windows + slot) * thickness - holes - _pockets_mm3(d) + lugs

    def sheet(self, part: str) -> Sheet:
        """Described by ``sheet.py`` beside this module."""
        from mbcdm_cad.parts.drum_sector.sheet import drum_sheet

        return drum_sheet(part, self.dims, self.set_screw_thread)
