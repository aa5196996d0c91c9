"""Space of a drum sector: its outline with the drum centred, and the rings that it sweeps as it turns."""

from __future__ import annotations

from collections.abc import Callable
from math import cos, hypot, radians, sin
from typing import Any, NamedTuple

import numpy as np

from mbcdm_cad.checks.comparison import Check, Comparison, at_least, worst
from mbcdm_cad.layouts.sector import SectorLayout
from mbcdm_cad.parts.drum_sector.dims import DrumDims
from mbcdm_cad.parts.drum_sector.sizes import nut_corner_radius_mm

# Grid of the rim: 0.1 mm and finer near the outside of the reference design, 0.3 mm along it.
_RADII = 40
_ANGLES = 160


class Ring(NamedTuple):
    """A zone of the drum: radii from the Y axis, the lowest y in it, and how far up it reaches.

    ``top``: largest z over the travel. A terminal's stud runs along the tangent, down from its cable's end, so that
    only its sides stand over the cable's radius while some wrap is left.
    """

    name: str
    inner: float
    outer: float
    y: float
    top: float


def rim_points(d: DrumDims) -> np.ndarray:
    """(x, z) of the rim where no pocket that goes through it takes the metal, on a grid near its edges."""
    outer = d.lands[-1].surface_radius_mm
    # Fine near the outside, which determines the box.
    radii = outer - (outer - d.rim_inner_radius) * np.linspace(0.0, 1.0, _RADII) ** 2
    half = radians(d.half_angle_deg)
    # Widest at the ends or, on a sector of more than half a turn, at right angles to Z.
    side = np.linspace(half / 2, half, _ANGLES)
    side = np.append(side, min(half, np.pi / 2))
    angles = np.concatenate([-side, [0.0], side])
    x = np.multiply.outer(radii, np.sin(angles))
    z = np.multiply.outer(radii, np.cos(angles))
    kept = np.ones_like(x, dtype=bool)
    for t in d.tensioners:
        if t.cut_through:
            sine, cosine = sin(t.anchor_rad), cos(t.anchor_rad)
            out = t.side * x * sine + z * cosine - t.radius_mm
            along = t.side * x * cosine - z * sine
            floor = np.where(along > t.lug_end, -d.nut_pocket, -d.flat_wall)
            kept &= ~((along > t.slack_start) & (along < t.pocket_end) & (out > floor))
    return np.stack([x[kept], z[kept]], axis=1)


def wrap_points(d: DrumDims, flank_mm: float) -> np.ndarray:
    """(x, z) of the outside of the cables on the drum, from the top to the anchors: it may overhang the rim."""
    share = np.linspace(0.0, 1.0, _ANGLES)
    return np.concatenate(
        [
            (t.radius_mm + flank_mm)
            * np.stack([t.side * np.sin(t.anchor_rad * share), np.cos(t.anchor_rad * share)], axis=1)
            for t in d.tensioners
        ]
    )


def drum_zones(s: SectorLayout) -> list[Ring]:
    """Rings that together enclose everything that turns with the drum in front of the frame."""
    d = s.drum
    spec = s.drive.tensioner
    half = max(nut_corner_radius_mm(s.drive), d.lug_half_width, spec.swage_diameter_mm / 2)
    zones = [
        _disc("drum's rim", d.rim_inner_radius, d.lands[-1].surface_radius_mm, d.lands[0].y_start),
        _disc("drum's web", d.spigot_radius, d.rim_inner_radius, d.web_start_y),
        _disc("drum's hub", 0.0, d.hub_radius, d.spigot_y),
    ]
    for t in d.tensioners:
        name = f"terminal of {t.cable_name}"
        below = max(half, d.lug_root(t))
        top = t.radius_mm + half
        zones.append(Ring(name, t.radius_mm - below, hypot(top, t.last_tip), t.y_mm - half, top))
    for c in s.steps:
        radii = (c.drum_radius_mm - s.flank_mm, c.drum_radius_mm + s.flank_mm)
        zones.append(_disc(f"{c.name} on the drum", *radii, c.land_y_mm - s.flank_mm))
    return zones


def _disc(name: str, inner: float, outer: float, y: float) -> Ring:
    return Ring(name, inner, outer, y, outer)


def before_frame(s: SectorLayout, front: str) -> Comparison:
    """Gap from all parts that turn with the drum to frame and boss behind them; ``front``: the frame's name."""
    v, running, found = s.levels, s.drive.clearances.running_mm, []
    for ring in drum_zones(s):
        if ring.name != "drum's hub":
            found.append(at_least(f"{ring.name} from the front of the {front}", ring.y - v.front_y, running, "mm"))
        if ring.inner < s.frame.boss.radius and ring.name != "drum's hub":
            found.append(at_least(f"{ring.name} from the front of the boss", ring.y - v.boss_front_y, running, "mm"))
    found.append(at_least("hub from the front of the boss", s.drum.hub_start_y - v.boss_front_y, running, "mm"))
    return worst(found)


def frame_front_check(measure: Callable[[Any], Comparison]) -> Check:
    """The check of :func:`before_frame`."""
    title, source, advice = "Drum clears the frame", "clearances.running_mm", "choose a smaller drum.tensioner"
    return Check("frame_front", title, source, measure, advice=advice)
