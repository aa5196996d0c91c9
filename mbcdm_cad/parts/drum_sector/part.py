"""Drum sector: stepped rim, web with windows and the stop's slot, clamped hub that is the output, lugs at both ends."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import cos, pi, radians, sin
from typing import TYPE_CHECKING

import numpy as np

from mbcdm_cad.parts import milled
from mbcdm_cad.parts.drum_sector.dims import CHAMFER_MM, POCKET_LEAD_MM, SET_SCREW_ANGLES_DEG, DrumDims
from mbcdm_cad.parts.part import CORNER, Gyration, MadePart, cq, ring_mm3
from mbcdm_cad.parts.terminal import Tensioner

if TYPE_CHECKING:
    from mbcdm_cad.parts.sheet import Sheet

# Cells of the grid on which the pockets of the drum's rim are summed: about 0.2 x 0.3 mm on a drum of 65 mm.
_RIM_RADII, _RIM_ANGLES = 80, 500


# A part of the volume, mm3, and the mean square of its distance from the drum's axis, mm2.
_Term = tuple[float, float]


def _ring(outer: float, inner: float, height: float) -> _Term:
    return ring_mm3(outer, inner, height), (outer**2 + inner**2) / 2


def _pockets(d: DrumDims) -> _Term:
    """What the terminals' pockets remove from the rim, lugs included."""
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
            first, last = d.pocket_y(t, reach)
            depth = np.maximum(last - np.maximum(low, first), 0.0)[:, None]
            taken = np.maximum(taken, np.where(inside, depth, 0.0))
    cell = (outer - d.rim_inner_radius) / _RIM_RADII * 2 * half / _RIM_ANGLES
    at = taken.sum(axis=1) * radii * cell
    volume = float(at.sum())
    return volume, float(at @ radii**2) / volume if volume else 0.0


def _lug(d: DrumDims, t: Tensioner) -> _Term:
    """A lug minus the stud's slot, which remains in a pocket."""
    length, r = t.lug_end - t.lug_start, d.stud_hole_radius
    (first, last), (low, high) = d.pocket_y(t, d.swage_pocket), d.lug_y(t)
    # Behind the face to which the pocket is open it stands in the open.
    depth = high - max(first, low) if t.front else min(last, high) - low
    slot = 2 * r * d.lug_half_width + pi / 2 * r**2
    out, along = t.radius_mm + (d.lug_half_width - d.flat_wall) / 2, (t.lug_start + t.lug_end) / 2
    return length * ((d.flat_wall + d.lug_half_width) * depth - slot), out**2 + along**2


def _sector(dims: DrumDims) -> cq.Solid:
    lands = dims.lands
    profile = [(dims.rim_inner_radius, lands[0].y_start)]
    for land in lands:
        profile += [(land.surface_radius_mm, land.y_start), (land.surface_radius_mm, land.y_end)]
    profile.append((dims.rim_inner_radius, lands[-1].y_end))
    half = dims.half_angle_deg
    rim = milled.turned_about_y(profile, -half, 2 * half, "drum rim")
    y = dims.web_start_y
    # The web is drawn with its openings: to cut them out of the drum takes the kernel a quarter of all its time for it.
    openings = [
        milled.sector_outline(w.r_inner, w.r_outer, w.start_deg, w.end_deg, y, dims.corner_radius) for w in dims.windows
    ]
    if dims.has_slot:
        openings.append(_stop_slot(dims, y))

    def flat(outer: float, end: float, holes: Sequence[cq.Wire] = ()) -> cq.Solid:
        inner = dims.hub_radius - 1.0
        if dims.whole:
            return milled.ring_y(inner, outer, y, end - y, holes)
        return milled.extruded_y(milled.sector_outline(inner, outer, -half, half, y), end - y, holes)

    bodies = [rim, flat(dims.rim_inner_radius + 1.0, dims.web_end_y, openings)]
    if dims.root_mm > 0.0:
        bodies.append(flat(dims.root_radius, dims.root_end_y))
    hub_profile = [
        (dims.bore_radius, dims.spigot_y),
        (dims.spigot_radius, dims.spigot_y),
        (dims.spigot_root_radius, dims.hub_start_y),
        (dims.hub_radius, dims.hub_start_y),
        (dims.hub_radius, dims.hub_face_y - CHAMFER_MM),
        (dims.hub_radius - CHAMFER_MM, dims.hub_face_y),
        (dims.bore_radius, dims.hub_face_y),
    ]
    hub = milled.turned_about_y(hub_profile, 0.0, 360.0, "drum hub")
    return milled.fuse([*bodies, hub], "drum")


def _box(
    t: Tensioner, s: tuple[float, float], n: tuple[float, float], y: tuple[float, float], radius: float = 0.0
) -> cq.Solid:
    """Between limits along the terminal and across it; with ``radius`` the corners an end mill along Y leaves."""
    corners = [t.at(s[0], n[0]), t.at(s[1], n[0]), t.at(s[1], n[1]), t.at(s[0], n[1])]
    return milled.prism_y(corners, *y, radius)


def _pocket(dims: DrumDims, t: Tensioner) -> cq.Solid:
    """Room for the swage before the lug and for the nuts behind it, open towards the drum's inner face."""
    inner = dims.lands[0].y_start - 1.0
    outer = dims.lands[-1].y_end + 1.0

    def depth(half: float) -> tuple[float, float]:
        if t.front:
            return t.deeper(half), outer
        return inner, outer if t.cut_through else t.deeper(half)

    swage, nuts, top, r = dims.swage_pocket, dims.nut_pocket, t.pocket_top, dims.pocket_radius
    low = -dims.flat_wall
    rooms = [
        _box(t, (t.slack_start - POCKET_LEAD_MM, t.lug_start), (low, top), depth(swage), r),
        _box(t, (t.lug_end, t.pocket_end), (-nuts, top), depth(nuts), r),
        # Around the lug, which is added again later; outside it the cutter passes through and leaves no corners.
        _box(t, (t.lug_start, t.lug_end), (low, top), depth(swage)),
        _box(t, (t.lug_start - r, t.lug_end + r), (dims.lug_half_width, top), depth(swage)),
    ]
    # One tool, because the kernel fails with tools that touch each other in one boolean.
    return milled.fuse(rooms, f"pocket of {t.cable_name}")


def _stud_slot(dims: DrumDims, t: Tensioner) -> cq.Solid:
    """Slot of the lug, open as its pockets are: the stud is inserted sideways, and the cable holds it there."""
    r, start = dims.stud_hole_radius, t.lug_start - 0.5

    def at(n: float, y: float) -> cq.Vector:
        x, z = t.at(start, n)
        return cq.Vector(x, y, z)

    bottom, face = t.deeper(r), t.deeper(-dims.nut_pocket - 1.0)
    outline = cq.Wire.assembleEdges(
        [
            cq.Edge.makeThreePointArc(at(-r, t.y_mm), at(0.0, bottom), at(r, t.y_mm)),
            cq.Edge.makeLine(at(r, t.y_mm), at(r, face)),
            cq.Edge.makeLine(at(r, face), at(-r, face)),
            cq.Edge.makeLine(at(-r, face), at(-r, t.y_mm)),
        ]
    )
    along = cq.Vector(t.side * cos(t.anchor_rad), 0.0, -sin(t.anchor_rad))
    return cq.Solid.extrudeLinear(outline, [], along * (t.lug_end - t.lug_start + 1.0))


def _stop_slot(dims: DrumDims, y: float) -> cq.Wire:
    """Outline at ``y`` of the slot along an arc, its ends round."""
    half, end = dims.stop_slot_width / 2, dims.stop_slot_end_deg

    def at(radius: float, deg: float) -> cq.Vector:
        return cq.Vector(radius * sin(radians(deg)), y, radius * cos(radians(deg)))

    def round_end(deg: float, sense: float) -> tuple[cq.Vector, cq.Vector, cq.Vector]:
        tip = at(dims.stop_radius, deg) + cq.Vector(cos(radians(deg)), 0.0, -sin(radians(deg))) * (sense * half)
        return at(dims.stop_radius - half, deg), tip, at(dims.stop_radius + half, deg)

    first, last = round_end(-end, -1.0), round_end(end, 1.0)
    return cq.Wire.assembleEdges(
        [
            cq.Edge.makeThreePointArc(first[2], at(dims.stop_radius + half, 0.0), last[2]),
            cq.Edge.makeThreePointArc(last[2], last[1], last[0]),
            cq.Edge.makeThreePointArc(last[0], at(dims.stop_radius - half, 0.0), first[0]),
            cq.Edge.makeThreePointArc(first[0], first[1], first[2]),
        ]
    )


def _hub_holes(dims: DrumDims, set_screw_thread: float) -> list[cq.Shape]:
    face, back = dims.hub_face_y, dims.hub_start_y
    tools: list[cq.Shape] = [
        milled.cylinder_y(dims.payload_hole / 2, x, z, face - dims.payload_depth, face + 1)
        for x, z in dims.payload_places
    ]
    if dims.dowels is not None:
        d = dims.dowels
        tools += [
            milled.cylinder_y(d.radius, x, z, face - d.face_depth, face + 1) for x, z in d.places(d.face_angles_deg)
        ]
        tools += [
            milled.cylinder_y(d.radius, x, z, back - 1, back + d.back_depth) for x, z in d.places(d.back_angles_deg)
        ]
    for deg in SET_SCREW_ANGLES_DEG:
        direction = (sin(radians(deg)), 0.0, cos(radians(deg)))
        tools.append(
            milled.cylinder(set_screw_thread / 2, (0.0, dims.set_screw_y, 0.0), direction, dims.hub_radius + 1.0)
        )
    return tools


@dataclass(frozen=True)
class DrumSector(MadePart):
    """Drum sector about +Y with the drum at 0; the thread of its set screws in mm."""

    dims: DrumDims
    set_screw_thread: float

    def solid(self) -> cq.Solid:
        """Drum sector, one solid, where it stands with the drum centred. ``set_screw_thread`` in mm."""
        dims, set_screw_thread = self.dims, self.set_screw_thread
        body: cq.Shape = _sector(dims)
        tools: list[cq.Shape] = []
        if dims.tensioners:
            body = body.cut(*(_pocket(dims, t) for t in dims.tensioners))
            # A lug reaches into the rim but no deeper, because the cable of the next land may run below.
            lugs = (
                _box(t, (t.lug_start, t.lug_end), (-dims.lug_root(t), dims.lug_half_width), dims.lug_y(t))
                for t in dims.tensioners
            )
            body = body.fuse(*lugs).clean()
        tools += [_stud_slot(dims, t) for t in dims.tensioners]
        tools += _hub_holes(dims, set_screw_thread)
        return milled.cut(body, tools, "drum")

    def _terms(self) -> list[_Term]:
        """Rim, web and hub less windows, slot and holes; pockets by a sum over a grid of the rim."""
        d, inner = self.dims, self.dims.rim_inner_radius
        thickness, slot = d.web_end_y - d.web_start_y, d.stop_slot_width
        sector = [
            *(_ring(land.surface_radius_mm, inner, land.y_end - land.y_start) for land in d.lands),
            _ring(inner, d.hub_radius, thickness),
            _ring(d.root_radius, d.hub_radius, d.root_mm),
        ]
        hub = [
            _ring(d.hub_radius, d.bore_radius, d.hub_face_y - d.hub_start_y),
            _ring((d.spigot_radius + d.spigot_root_radius) / 2, d.bore_radius, d.hub_start_y - d.spigot_y),
        ]
        taken = [_pockets(d)]
        for w in d.windows:
            flat = (w.r_outer**2 - w.r_inner**2) / 2 * radians(w.end_deg - w.start_deg)
            flat -= 4 * CORNER * d.corner_radius**2
            taken.append((flat * thickness, (w.r_outer**2 + w.r_inner**2) / 2))
        flat = 2 * radians(d.stop_slot_end_deg) * d.stop_radius * slot + pi / 4 * slot**2
        taken.append((flat * thickness, d.stop_radius**2 + slot**2 / 4))
        holes = ring_mm3(d.payload_hole / 2, 0.0, len(d.payload_places) * d.payload_depth)
        taken.append((holes, d.payload_circle_radius**2))
        screws = ring_mm3(self.set_screw_thread / 2, 0.0, 2 * (d.hub_radius - d.bore_radius))
        taken.append((screws, (d.hub_radius**2 + d.hub_radius * d.bore_radius + d.bore_radius**2) / 3))
        if d.dowels is not None:
            pins = d.dowels
            deep = len(pins.face_angles_deg) * pins.face_depth + len(pins.back_angles_deg) * pins.back_depth
            taken.append((ring_mm3(pins.radius, 0.0, deep), pins.circle_radius**2))
        share = d.half_angle_deg / 180.0
        return [
            *((share * volume, at) for volume, at in sector),
            *hub,
            *(_lug(d, t) for t in d.tensioners),
            *((-volume, at) for volume, at in taken),
        ]

    def volume_mm3(self) -> float:
        """Rim, web and hub less windows, slot and holes."""
        return sum(volume for volume, _ in self._terms())

    def gyration(self) -> Gyration:
        """About the drum's axis, Y, on which all of it counts."""
        terms = self._terms()
        return Gyration((0.0, 1.0, 0.0), 0.0, sum(v * at for v, at in terms) / sum(v for v, _ in terms))

    def sheet(self, part: str) -> Sheet:
        """Described by ``sheet.py`` beside this module."""
        from mbcdm_cad.parts.drum_sector.sheet import drum_sheet

        return drum_sheet(part, self.dims, self.set_screw_thread)
