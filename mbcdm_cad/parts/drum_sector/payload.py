"""The payload's joint on the hub's face: screws press it on, so that friction carries the torque."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cache, cached_property
from math import cos, inf, radians, sin

from mbcdm_cad.design.blocks import Payload
from mbcdm_cad.design.bought import InsertSpec, Material
from mbcdm_cad.parts.threads import ScrewHold, screw_hold

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
