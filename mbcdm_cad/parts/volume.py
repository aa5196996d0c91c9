"""Volumes of parts in closed form, from their dimensions: what an estimate of mass needs, without a kernel.

Every function takes the arguments of the ``create`` function of its part. Small features (edge breaks, corner reliefs,
the ends of slots) are left out; turned parts come out within 0.5 %, the drum within 3 %.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from math import acos, asin, hypot, pi, radians, sqrt
from typing import TYPE_CHECKING, Any

import numpy as np

from mbcdm_cad.parts.axle.dims import AxleDims
from mbcdm_cad.parts.bill import PartSpec
from mbcdm_cad.parts.collar.dims import HEAD_PLAY_MM, CollarDims
from mbcdm_cad.parts.drum_sector.dims import POCKET_LEAD_MM, DrumDims
from mbcdm_cad.parts.drum_shaft.dims import DrumShaftDims, PreloadSpringDims
from mbcdm_cad.parts.idler_pulley.dims import IdlerDims
from mbcdm_cad.parts.input_pulley.dims import STOP_PLAY_MM, Groove, InputPulleyDims, StopSlot
from mbcdm_cad.parts.terminal.dims import Tensioner, TerminalDims

if TYPE_CHECKING:  # a drive without a motor head starts without it
    from mbcdm_cad.parts.motor_head.dims import CouplingBox, HeadDims

# Cells of the grid on which the pockets of the drum's rim are summed: about 0.2 x 0.3 mm on a drum of 65 mm.
_RIM_RADII, _RIM_ANGLES = 80, 500
# Metal that remains in each rounded corner, as a share of the radius squared: 1 - pi/4.
CORNER = 1.0 - pi / 4

Volume = Callable[..., float]


def ring_mm3(outer: float, inner: float, height: float) -> float:
    """Ring, or a cylinder with ``inner`` 0; nothing where it has no height."""
    return pi * (outer**2 - inner**2) * max(height, 0.0)


def segment_mm2(radius: float, distance: float) -> float:
    """Area of a circle beyond a chord at ``distance`` from its middle."""
    at = min(max(distance, -radius), radius)
    return radius**2 * acos(at / radius) - at * sqrt(max(radius**2 - at**2, 0.0))


def pocket_mm3(x: float, y: float, z: float, radius: float, corners: int = 4) -> float:
    """Box milled along y, some of its edges rounded; nothing where it has no extent."""
    if min(x, y, z) <= 0.0:
        return 0.0
    return (x * z - corners * CORNER * min(radius, 0.49 * min(x, z)) ** 2) * y


def _strip_mm2(radius: float, width: float) -> float:
    """Area of a strip through the middle of a circle."""
    h = min(width / 2, radius)
    return 2 * (h * sqrt(radius**2 - h**2) + radius**2 * asin(h / radius)) if radius > 0.0 else 0.0


def sleeve_mm3(bore_radius: float, radius: float, length: float) -> float:
    """Sleeve."""
    return ring_mm3(radius, bore_radius, length)


def nut_mm3(across_flats: float, height: float, thread: float) -> float:
    """Hexagon nut."""
    return sqrt(3) / 2 * across_flats**2 * height - ring_mm3(thread / 2, 0.0, height)


def pin_mm3(radius: float, length: float) -> float:
    """Pin with chamfered ends."""
    c = min(0.3, radius / 3)
    return ring_mm3(radius, 0.0, length) - 2 * pi * c**2 * (radius - c / 3)


def axle_mm3(d: AxleDims) -> float:
    """Axle of an idler with its collar."""
    collar = ring_mm3(d.collar_radius, d.radius, d.collar_top_z - d.collar_bottom_z)
    return pin_mm3(d.radius, d.top_z - d.bottom_z) + collar


def spacer_mm3(d: AxleDims) -> float:
    """Spacer on an idler's axle."""
    return ring_mm3(d.collar_radius, d.radius, d.spacer_top_z - d.spacer_bottom_z)


def idler_mm3(d: IdlerDims) -> float:
    """Idler pulley: its steps less seats and bore."""
    levels = [d.bottom_z, *d.walls_z, d.top_z]
    steps = sum(ring_mm3(r, 0.0, b - a) for r, a, b in zip(d.surface_radii, levels[:-1], levels[1:], strict=True))
    seats = 2 * ring_mm3(d.seat_radius, 0.0, d.seat_depth)
    return steps - seats - ring_mm3(d.shoulder_radius, 0.0, d.top_z - d.bottom_z - 2 * d.seat_depth)


def drum_shaft_mm3(d: DrumShaftDims) -> float:
    """Hollow shaft with its flange."""
    flange = ring_mm3(d.flange_radius, d.radius, d.flange_end_y - d.flange_start_y)
    flats = 2 * segment_mm2(d.radius, d.flat) * d.flat_length
    return ring_mm3(d.radius, d.bore_radius, d.y_end - d.y_start) + flange - flats


def preload_spring_mm3(d: PreloadSpringDims) -> float:
    """Ring that the wave spring fills."""
    return ring_mm3(d.outer_radius, d.inner_radius, d.height)


def terminal_mm3(d: TerminalDims) -> float:
    """Swage with its bore and flats, and the stud."""
    swage = pi * d.swage_radius**2 - 2 * segment_mm2(d.swage_radius, d.flat)
    bore = ring_mm3(d.bore_radius, 0.0, d.cable_end - d.swage_start)
    return swage * (d.swage_end - d.swage_start) + ring_mm3(d.stud_radius, 0.0, d.tip - d.swage_end) - bore


def collar_mm3(d: CollarDims, screw_thread: float, screw_clearance: float, head_diameter: float) -> float:
    """Clamp collar: ring less slit, screw and the flat of the screw's head."""
    width = d.top_z - d.bottom_z
    slit = d.slit_width * (d.radius - d.bore_radius) * width
    hole = pi / 4 * (screw_clearance**2 * d.head_seat + screw_thread**2 * sqrt(max(d.radius**2 - d.screw_offset**2, 0)))
    edge = d.screw_offset - head_diameter / 2 - HEAD_PLAY_MM
    x = np.linspace(edge, d.radius, 101)
    flat = float(np.maximum(np.sqrt(np.maximum(d.radius**2 - x**2, 0.0)) - d.head_seat, 0.0).mean()) * (d.radius - edge)
    return ring_mm3(d.radius, d.bore_radius, width) - slit - hole - max(flat, 0.0) * width


def _slot_mm3(slot: StopSlot) -> float:
    """Slot of a cable's stop: a quarter of a ring and a straight piece of the slot's depth, the pocket deeper."""
    depth = abs(slot.end_z - slot.face_z) + slot.width / 2
    reach = slot.stop_radius + STOP_PLAY_MM
    pocket = abs(slot.chord_z - slot.face_z) + reach
    length = slot.stop_start - slot.stop_end + 2 * STOP_PLAY_MM
    straight = max(slot.pitch_radius - slot.bend_radius - slot.stop_start, 0.0)
    return slot.width * depth * (pi / 2 * slot.bend_radius + straight) + 2 * reach * length * pocket


def groove_mm3(groove: Groove) -> float:
    """Pappus: the area of the groove, a segment of its circle, along the helix of the area's centroid."""
    r, half = groove.radius, groove.half_width
    area = segment_mm2(r, r - groove.depth)
    middle = groove.root_radius + r - (2 * half) ** 3 / (12 * area)
    turned = abs(groove.end_angle_rad - groove.start_angle_rad)
    return area * turned * hypot(middle, groove.lead / (2 * pi))


def input_pulley_mm3(d: InputPulleyDims) -> float:
    """Journals, necks and steps less bore, slit, slots and grooves."""
    body = (
        ring_mm3(d.lower_journal_radius, 0.0, d.lower_neck_bottom_z - d.journal_bottom_z)
        + ring_mm3(d.lower_neck_radius, 0.0, d.land_bottom_z - d.lower_neck_bottom_z)
        + ring_mm3(d.lower_land_radius, 0.0, d.wall_z - d.land_bottom_z)
        + ring_mm3(d.upper_land_radius, 0.0, d.land_top_z - d.wall_z)
        + ring_mm3(d.upper_neck_radius, 0.0, d.upper_neck_top_z - d.land_top_z)
        + ring_mm3(d.upper_journal_radius, 0.0, d.journal_top_z - d.upper_neck_top_z)
    )
    bore = ring_mm3(d.bore_radius, 0.0, d.bore_top_z - d.journal_bottom_z)
    both = _strip_mm2(d.lower_journal_radius, d.slit_width)
    slit = both * (d.slit_top_z - d.journal_bottom_z)
    slit -= _strip_mm2(d.bore_radius, d.slit_width) * max(d.bore_top_z - d.journal_bottom_z, 0.0)
    return body - bore - slit - sum(map(_slot_mm3, d.slots)) - sum(map(groove_mm3, d.grooves))


def motor_head_mm3(d: HeadDims) -> float:
    """Flange, box and motor shelf less pocket, seat and holes."""
    f, flange = d.flange, d.flange_top_z - d.bottom_z
    plate = (2 * f.half_x * (f.front_y - f.back_y) - 4 * CORNER * d.corner_radius**2) * flange
    return (
        coupling_box_mm3(d, plate)
        - len(f.screws) * ring_mm3(d.screw_clearance, 0.0, flange)
        - len(f.dowels) * ring_mm3(d.dowel_radius, 0.0, flange)
    )


def coupling_box_mm3(d: CouplingBox, plate_mm3: float = 0.0) -> float:
    """A plate with a coupling box on it, less the box's pocket, bearing seat and holes."""
    flange, height = d.flange_top_z - d.bottom_z, d.top_z - d.flange_top_z
    body = plate_mm3 + (2 * d.outer_x * (d.front_y - d.back_y) - 4 * CORNER * d.corner_radius**2) * height
    inner, shelf = d.inner_x, d.top_z - d.shelf_bottom_z
    return (
        body
        - pocket_mm3(2 * inner, d.front_y + inner, d.shelf_bottom_z - d.flange_top_z, d.corner_radius)
        - ring_mm3(d.pilot_radius, 0.0, shelf)
        - ring_mm3(d.shoulder_radius, 0.0, flange - d.seat_depth)
        - ring_mm3(d.seat_radius, 0.0, d.seat_depth)
        # About half of each key hole lies outside the shoulder's bore.
        - len(d.gear_screws)
        * (ring_mm3(d.gear_screw_clearance, 0.0, shelf) + ring_mm3(d.key_hole_radius, 0.0, flange - d.seat_depth) / 2)
    )


def drum_mm3(d: DrumDims, set_screw_thread: float) -> float:
    """Rim, web and hub less windows, slot and holes; pockets by a sum over a grid of the rim."""
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
        deep = len(d.dowels.face_angles_deg) * d.dowels.face_depth + len(d.dowels.back_angles_deg) * d.dowels.back_depth
        holes += ring_mm3(d.dowels.radius, 0.0, deep)
    lugs = sum(_lug_mm3(d, t) for t in d.tensioners)
    return rim + web + hub - (windows + slot) * thickness - holes - _pockets_mm3(d) + lugs


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


VOLUMES: dict[str, Volume] = {
    "mbcdm_cad.parts.ring:create_sleeve": sleeve_mm3,
    "mbcdm_cad.parts.ring:create_nut": nut_mm3,
    "mbcdm_cad.parts.ring:create_pin": pin_mm3,
    "mbcdm_cad.parts.axle.draw:create_axle": axle_mm3,
    "mbcdm_cad.parts.axle.draw:create_spacer": spacer_mm3,
    "mbcdm_cad.parts.idler_pulley.draw:create_idler_pulley": idler_mm3,
    "mbcdm_cad.parts.drum_shaft.draw:create_drum_shaft": drum_shaft_mm3,
    "mbcdm_cad.parts.bought.draw:create_preload_spring": preload_spring_mm3,
    "mbcdm_cad.parts.terminal.draw:create_terminal": terminal_mm3,
    "mbcdm_cad.parts.collar.draw:create_collar": collar_mm3,
    "mbcdm_cad.parts.input_pulley.draw:create_input_pulley": input_pulley_mm3,
    "mbcdm_cad.parts.drum_sector.draw:create_drum": drum_mm3,
    "mbcdm_cad.parts.motor_head.draw:create_motor_head": motor_head_mm3,
}


def estimated_mm3(spec: PartSpec, own: Mapping[str, Volume]) -> float:
    """Volume of a part, by its maker; ``own`` are a layout's parts. Raises ``LookupError`` for one without a volume."""
    volume = own.get(spec.maker) or VOLUMES.get(spec.maker)
    if volume is None:
        raise LookupError(
            f"{spec.name}: no volume for {spec.maker}; every made part has one, in VOLUMES of parts/volume.py or in "
            "support/volume.py of its layout"
        )
    args: tuple[Any, ...] = spec.args
    return float(volume(*args))
