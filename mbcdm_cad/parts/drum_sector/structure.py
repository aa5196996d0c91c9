"""The drum sector as the plain shapes that :mod:`mbcdm_cad.model.structure` computes."""

from __future__ import annotations

from collections.abc import Iterator
from math import pi, radians

from mbcdm_cad.model.structure.drum_sector import Hub, LandPull
from mbcdm_cad.model.structure.sector_mesh import Opening, Pocket, RimStep, SectorShape
from mbcdm_cad.parts.drum_sector.dims import POCKET_LEAD_MM, SET_SCREW_ANGLES_DEG, DrumDims
from mbcdm_cad.parts.terminal.part import Tensioner


def sector_shape(d: DrumDims) -> SectorShape:
    """Rim, web, windows, the stop's slot and the pockets of the terminals; lugs fill their pockets."""
    end = d.lands[-1].y_end
    rings = [RimStep(d.root_radius, d.web_start_y, d.root_end_y)] if d.root_mm > 0.0 else []
    rings.append(RimStep(d.rim_inner_radius, d.web_start_y, d.web_end_y))
    rings += [RimStep(land.surface_radius_mm, land.y_start, end) for land in d.lands]
    openings = [
        Opening(w.r_inner, w.r_outer, radians(w.start_deg), radians(w.end_deg), d.corner_radius) for w in d.windows
    ]
    if d.has_slot:
        half = d.stop_slot_width / 2.0
        tip = radians(d.stop_slot_end_deg) + half / d.stop_radius
        openings.append(Opening(d.stop_radius - half, d.stop_radius + half, -tip, tip, half))
    pockets = tuple(pocket for t in d.tensioners for pocket in _pockets(d, t))
    half_angle = radians(d.half_angle_deg)
    return SectorShape(half_angle, d.hub_radius, tuple(rings), tuple(openings), pockets, d.rim_inner_radius)


def _pockets(d: DrumDims, t: Tensioner) -> Iterator[Pocket]:
    # On a whole drum on either side of the seam of the mesh, opposite the middle.
    turned = t.anchor_rad % (2.0 * pi)
    places = (turned, turned - 2.0 * pi) if d.whole else (t.anchor_rad,)

    def box(along: tuple[float, float], low: float, half: float) -> Iterator[Pocket]:
        taken = d.pocket_y(t, half)
        for at in places:
            yield Pocket(t.side, at, t.radius_mm, along, (low, t.pocket_top), taken)

    yield from box((t.slack_start - POCKET_LEAD_MM, t.lug_start), -d.flat_wall, d.swage_pocket)
    yield from box((t.lug_start, t.lug_end), d.lug_half_width, d.swage_pocket)
    yield from box((t.lug_end, t.pocket_end), -d.nut_pocket, d.nut_pocket)


def hub(d: DrumDims, set_screw_thread_mm: float) -> Hub:
    """The hub with its holes."""
    return Hub(
        radius_mm=d.hub_radius,
        bore_mm=d.bore_radius,
        back_mm=d.hub_start_y,
        face_mm=d.hub_face_y,
        set_mm=d.set_screw_y,
        set_hole_mm=set_screw_thread_mm / 2.0,
        set_holes=len(SET_SCREW_ANGLES_DEG),
        face_hole_mm=d.payload_hole / 2.0,
        face_holes=len(d.payload_places),
        face_circle_mm=d.payload_circle_radius,
        face_depth_mm=d.payload_depth,
        edge_mm=(d.web_start_y, d.web_end_y + d.root_mm),
        web_mm=d.web_end_y - d.web_start_y,
        half_angle_rad=radians(d.half_angle_deg),
    )


def land_pulls(d: DrumDims, share: dict[str, float], tension_N: dict[str, float]) -> tuple[LandPull, ...]:
    """The cables on their lands; their shares of the torque and preloads by the cable's name."""
    pulls = []
    for t in d.tensioners:
        # Pitch radius and surface differ by half a rope, lands of two steps by far more.
        surface = min((land.surface_radius_mm for land in d.lands), key=lambda radius: abs(radius - t.radius_mm))
        name = t.cable_name
        pulls.append(LandPull(t.side, surface, t.anchor_rad, share[name], tension_N[name], t.y_mm))
    return tuple(pulls)
