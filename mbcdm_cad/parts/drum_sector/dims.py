"""Dimensions of a drum sector: stepped lands, web with windows and the stop's slot, hub, lugs for the terminals."""

from __future__ import annotations

from dataclasses import dataclass
from math import cos, radians, sin, sqrt

from mbcdm_cad.design.bought import InsertSpec
from mbcdm_cad.parts.terminal.part import Tensioner

# Directions of the hub's two set screws, from +Z towards +X.
SET_SCREW_ANGLES_DEG = (45.0, 135.0)
# Half angle from which on a rim is closed all round.
WHOLE_DEG = 180.0
# Pocket before the swage.
POCKET_LEAD_MM = 0.2
# A lug reaches this far below the pocket's inner wall, so that it is joined to the rim.
LUG_ROOT_MM = 0.3

# At 45 degrees, on every outer edge that is chamfered.
CHAMFER_MM = 0.3


@dataclass(frozen=True)
class Land:
    """Cylindrical land of one step: surface radius r_o - d/2, from ``y_start`` to ``y_end``."""

    step: int
    surface_radius_mm: float
    y_start: float
    y_end: float


@dataclass(frozen=True)
class Window:
    """Lightening window of the web: an annular sector, angles from +Z (deg)."""

    r_inner: float
    r_outer: float
    start_deg: float
    end_deg: float


@dataclass(frozen=True)
class HubDowels:
    """Dowels between the hubs of sectors that stand on one shaft: pressed into a face, sliding in the next one's back.

    Lengths in mm; angles from +Z towards +X.
    """

    radius: float
    length: float
    circle_radius: float
    face_depth: float
    back_depth: float
    face_angles_deg: tuple[float, ...]
    back_angles_deg: tuple[float, ...]

    def places(self, angles_deg: tuple[float, ...]) -> tuple[tuple[float, float], ...]:
        """(x, z) of the holes at these angles."""
        r = self.circle_radius
        return tuple((r * sin(radians(a)), r * cos(radians(a))) for a in angles_deg)


@dataclass(frozen=True)
class DrumDims:
    """All dimensions of the drum (mm, deg, rad as named)."""

    half_angle_deg: float
    rim_inner_radius: float
    lands: tuple[Land, ...]
    web_start_y: float
    web_end_y: float
    hub_radius: float
    hub_start_y: float
    hub_face_y: float
    spigot_radius: float
    spigot_root_radius: float  # at the hub; a printed spigot widens to it
    spigot_y: float
    bore_radius: float
    windows: tuple[Window, ...]
    stop_radius: float
    stop_slot_width: float
    stop_slot_end_deg: float
    tensioners: tuple[Tensioner, ...]
    stud_hole_radius: float
    lug_half_width: float
    swage_pocket: float  # half depth along y
    flat_wall: float  # wall inside the pocket that a flat of the swage slides along, from the terminal's axis
    nut_pocket: float
    pocket_radius: float
    set_screw: str
    set_screw_y: float
    set_screw_radius: float  # inner end
    payload_screw_thread: float
    payload_circle_radius: float
    payload_angles_deg: tuple[float, ...]  # from +Z towards +X
    payload_depth: float
    payload_insert: InsertSpec | None
    corner_radius: float
    # The web is thicker round the hub: up to this radius, and in front as far as this; those of hub and web without it.
    root_radius: float
    root_end_y: float
    # How far lugs of a whole drum reach along y beyond the pockets' floor, from the terminal's axis.
    lug_reach: float = 0.0
    dowels: HubDowels | None = None

    @property
    def whole(self) -> bool:
        """Whether the rim is closed all round."""
        return self.half_angle_deg >= WHOLE_DEG

    @property
    def has_slot(self) -> bool:
        """Whether the web has a slot for a stop pin."""
        return self.stop_slot_width > 0.0

    def pocket_y(self, t: Tensioner, half: float) -> tuple[float, float]:
        """From where to where along y a pocket with its floor ``half`` beyond the terminal's axis takes the rim."""
        inner, outer = self.lands[0].y_start, self.lands[-1].y_end
        if t.front:
            return max(t.deeper(half), inner), outer
        return inner, outer if t.cut_through else min(t.deeper(half), outer)

    def lug_y(self, t: Tensioner) -> tuple[float, float]:
        """From where to where along y a lug reaches: to the rim's outer face, on a whole drum to the pockets' floor.

        Beyond that floor lie the turns of its cable; one of plastic reaches up to the nearest.
        """
        end = t.deeper(max(self.nut_pocket, self.lug_reach)) if self.whole else self.lands[-1].y_end
        low, high = sorted((t.deeper(-self.lug_half_width), end))
        return low, high

    @property
    def root_mm(self) -> float:
        """How much thicker the web is round the hub."""
        return self.root_end_y - self.web_end_y if self.root_radius > self.hub_radius else 0.0

    @property
    def payload_hole(self) -> float:
        """Diameter of the payload's holes: of their thread, or of the holes for inserts."""
        return self.payload_insert.hole_mm if self.payload_insert else self.payload_screw_thread

    @property
    def payload_places(self) -> tuple[tuple[float, float], ...]:
        """(x, z) of the payload's holes."""
        angles = [radians(deg) for deg in self.payload_angles_deg]
        return tuple((self.payload_circle_radius * sin(a), self.payload_circle_radius * cos(a)) for a in angles)

    def lug_root(self, t: Tensioner) -> float:
        """How far inside the terminal's axis its lug is rooted in the rim.

        Where a long terminal puts the lug so far along the tangent that the rim falls away below it, as deep as the
        rim's surface is under the lug's far corner.
        """
        return lug_root_mm(self.flat_wall, self.lands[-1].surface_radius_mm, t.radius_mm, t.lug_end)


def lug_root_mm(flat_mm: float, rim_mm: float, radius_mm: float, lug_end_mm: float) -> float:
    """As :meth:`DrumDims.lug_root`: flat beside the swage, the rim's surface, the terminal's radius, its lug's end."""
    least = flat_mm + LUG_ROOT_MM
    falls_to = radius_mm - sqrt(max(rim_mm**2 - lug_end_mm**2, 0.0))
    return least if falls_to <= least else falls_to + LUG_ROOT_MM
