"""Dimensions of a drum sector: stepped lands, web with windows and the stop's slot, hub, lugs for the terminals.

The payload is screwed on the hub's face: its screws press it on, so that friction carries the torque. Last the drum as
the model of its stiffness sees it."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import cache, cached_property
from math import cos, inf, pi, radians, sin, sqrt

from mbcdm_cad.design.blocks import Payload
from mbcdm_cad.design.bought import InsertSpec, Material
from mbcdm_cad.model.structure.drum_sector import Hub, LandPull
from mbcdm_cad.model.structure.sector_mesh import Opening, Pocket, RimStep, SectorShape
from mbcdm_cad.parts.fits import ScrewHold, screw_hold
from mbcdm_cad.parts.terminal import Tensioner

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


# Number of screws where the design does not say.
SCREWS = 4
# Threads of the screws, the smallest first, and the least depth of their holes.
THREADS_MM = (2.5, 3.0, 4.0, 5.0, 6.0)
LEAST_DEPTH_MM, DEPTH_DIAMETERS = 6.0, 2.0
# The torque at which the payload slips, over the peak torque (usual for joints that hold by friction).
SLIP_SAFETY = 1.5
# Friction of the payload on the hub's face, dry (usual value).
FACE_FRICTION = 0.15
# Walls that differ by less are equal.
_ROUNDING_MM = 1e-9

InsertOf = Callable[[float], InsertSpec | None]


@dataclass(frozen=True)
class JointLoad:
    """What a joint on the hub's face carries at once: torque, force across the axis, moment that tilts it open."""

    torque_Nm: float
    across_N: float = 0.0
    tilt_Nm: float = 0.0


def joint_load(peak_Nm: float, payload: Payload) -> JointLoad:
    """The largest load of the joint: the peak torque and all that the payload adds, in the worst directions."""
    return JointLoad(peak_Nm, payload.across_N, payload.tilt_Nm)


@dataclass(frozen=True)
class PayloadJoint:
    """Screws of one thread in a hub of one material."""

    thread_mm: float
    material: Material
    insert: InsertSpec | None
    screws: int = SCREWS

    @property
    def hole_mm(self) -> float:
        """Diameter of a hole: of the thread, or for an insert."""
        return self.insert.hole_mm if self.insert else self.thread_mm

    @property
    def depth_mm(self) -> float:
        """Depth of a hole."""
        return max(LEAST_DEPTH_MM, DEPTH_DIAMETERS * self.thread_mm, self.insert.depth_mm if self.insert else 0.0)

    @cached_property
    def hold(self) -> ScrewHold:
        """What one tightened screw holds in the hub."""
        return screw_hold(self.thread_mm, self.material, self.insert, self.depth_mm)

    @property
    def clamp_N(self) -> float:
        """Force of one tightened screw."""
        return self.hold.clamp_N

    def slips_Nm(self, circle_mm: float) -> float:
        """Torque at which the payload slips with the screws on a circle of this radius: mu F r for each."""
        return self.screws * self.hold.slips_N(FACE_FRICTION) * circle_mm * 1e-3

    def slips_times(self, load: JointLoad, circle_mm: float) -> float:
        """Friction of all screws over the load: M / r for the torque, and the force across where both add up."""
        return self.slips_Nm(circle_mm) / (load.torque_Nm + load.across_N * circle_mm * 1e-3)

    def opens_times(self, load: JointLoad, circle_mm: float) -> float:
        """What a screw holds over what the tilting moment takes from the one that it pulls most, 2 M / (n r)."""
        return self.screws * self.hold.pull_N * circle_mm * 1e-3 / (2.0 * load.tilt_Nm) if load.tilt_Nm > 0.0 else inf

    def least_circle_mm(self, load: JointLoad) -> float:
        """Least radius of the circle of the screws with which the joint neither slips nor opens; inf if none does."""
        friction_N = self.screws * self.hold.slips_N(FACE_FRICTION) / SLIP_SAFETY - load.across_N
        opens = 2.0 * SLIP_SAFETY * load.tilt_Nm / (self.screws * self.hold.pull_N)
        return max(load.torque_Nm / friction_N, opens) * 1e3 if friction_N > 0.0 else inf

    def least_hub_mm(self, load: JointLoad, bore_mm: float, wall_mm: float) -> float:
        """Least radius of a hub of bore radius ``bore_mm`` for walls beside the holes and for the load."""
        circle = self.least_circle_mm(load)
        return max(bore_mm + self.hole_mm + 2.0 * self._wall_mm(wall_mm), 2.0 * circle - bore_mm)

    def beside_mm(self, circle_mm: float, hub_mm: float, bore_mm: float) -> float:
        """The thinner of the walls beside the holes on a circle of this radius: towards the edge, towards the bore."""
        return min(hub_mm - circle_mm, circle_mm - bore_mm) - self.hole_mm / 2.0

    def has_walls(self, circle_mm: float, hub_mm: float, bore_mm: float, wall_mm: float) -> bool:
        """Whether these walls are as thick as they must be."""
        return self.beside_mm(circle_mm, hub_mm, bore_mm) >= self._wall_mm(wall_mm) - _ROUNDING_MM

    def angles_deg(self, set_screws_deg: tuple[float, ...]) -> tuple[float, ...]:
        """Angles of the screws, evenly on their circle and as far from the hub's set screws as may be."""
        first = start_deg(self.screws, set_screws_deg)
        return tuple(first + 360.0 / self.screws * k for k in range(self.screws))

    def behind_mm(self, circle_mm: float, set_screws_deg: tuple[float, ...], thread_mm: float, wall_mm: float) -> float:
        """Least depth under the hub's face of the set screws' axes, of this thread: behind holes that come near them.

        Four screws stand midway between the set screws; others may leave no wall beside them.
        """
        if self.screws == SCREWS:
            return 0.0
        wall, angles = self._wall_mm(wall_mm), self.angles_deg(set_screws_deg)
        apart = (radians(hole - screw) for hole in angles for screw in set_screws_deg)
        beside = min(abs(circle_mm * sin(a)) for a in apart if cos(a) > 0.0) - (self.hole_mm + thread_mm) / 2.0
        return 0.0 if beside >= wall else self.depth_mm + wall + thread_mm / 2.0

    def _wall_mm(self, wall_mm: float) -> float:
        return self.insert.wall_mm if self.insert else wall_mm


def joints(material: Material, insert_of: InsertOf, screws: int = SCREWS) -> tuple[PayloadJoint, ...]:
    """All joints for a hub of this material, the smallest thread first; ``insert_of``: the insert of a thread.

    Where threads have inserts, one for which the catalogue has none is no joint: the file asks for inserts.
    """
    found = tuple(PayloadJoint(thread, material, insert_of(thread), screws) for thread in THREADS_MM)
    return tuple(joint for joint in found if joint.insert) or found


def circle_radius_mm(stated_mm: float | None, hub_mm: float, bore_mm: float) -> float:
    """Radius of the screws' circle, of which a design may state the diameter; else midway between bore and edge."""
    return (hub_mm + bore_mm) / 2.0 if stated_mm is None else stated_mm / 2.0


def payload_joint(
    candidates: Sequence[PayloadJoint], load: JointLoad, circle_mm: float, hub_mm: float, bore_mm: float, wall_mm: float
) -> PayloadJoint:
    """The smallest thread that holds on a circle of this radius; else of those with walls the one that holds most."""
    first, *more = candidates
    walled = [first, *(j for j in more if j.has_walls(circle_mm, hub_mm, bore_mm, wall_mm))]
    holding = [j for j in walled if j.least_circle_mm(load) <= circle_mm]
    return holding[0] if holding else max(walled, key=lambda j: j.hold.slips_N(FACE_FRICTION))


@cache
def start_deg(screws: int, away_from_deg: tuple[float, ...]) -> float:
    """Angle of the first screw with which the nearest of all is furthest from these directions."""

    def nearest(start: float) -> float:
        pitch = 360.0 / screws
        return min(min((start - deg) % pitch, (deg - start) % pitch) for deg in away_from_deg)

    # Halves of a degree, the first of equal ones: four screws begin at 0.
    return max((0.5 * k for k in range(int(720.0 / screws))), key=lambda start: round(nearest(start), 6))


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
