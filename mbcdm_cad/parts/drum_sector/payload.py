"""The payload's joint on the hub's face: four screws press it on, so that friction carries the torque."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from math import pi

from mbcdm_cad.design.bought import InsertSpec, Material
from mbcdm_cad.parts.threads import clamp_force_N

SCREWS = 4
# Threads of the screws, the smallest first, and the least depth of their holes.
THREADS_MM = (2.5, 3.0, 4.0, 5.0, 6.0)
LEAST_DEPTH_MM, DEPTH_DIAMETERS = 6.0, 2.0
# The torque at which the payload slips, over the peak torque (usual for joints that hold by friction).
SLIP_SAFETY = 1.5
# Friction of the payload on the hub's face, dry (usual value).
FACE_FRICTION = 0.15
# Shear strength over yield stress (von Mises).
SHEAR_SHARE = 0.577
# Share of a thread's cylinder that is sheared when it strips (usual for ISO threads).
THREAD_SHARE = 0.75
# Share of the strength of its thread that a screw may use: metal, and plastic under a lasting force, which creeps
# (estimate for PA12 and PLA).
METAL_SHARE, PLASTIC_SHARE = 0.7, 0.4

InsertOf = Callable[[float], InsertSpec | None]


@dataclass(frozen=True)
class PayloadJoint:
    """Screws of one thread in a hub of one material."""

    thread_mm: float
    material: Material
    insert: InsertSpec | None

    @property
    def hole_mm(self) -> float:
        """Diameter of a hole: of the thread, or for an insert."""
        return self.insert.hole_mm if self.insert else self.thread_mm

    @property
    def depth_mm(self) -> float:
        """Depth of a hole."""
        return max(LEAST_DEPTH_MM, DEPTH_DIAMETERS * self.thread_mm, self.insert.depth_mm if self.insert else 0.0)

    @property
    def clamp_N(self) -> float:
        """Force of one tightened screw: its own, or what its thread or insert holds in the hub."""
        across, along = (
            (self.insert.outside_mm, self.insert.length_mm) if self.insert else (self.thread_mm, self.depth_mm)
        )
        strips = pi * across * along * THREAD_SHARE * SHEAR_SHARE * self.material.yield_MPa
        return min(clamp_force_N(self.thread_mm), (PLASTIC_SHARE if self.material.printed else METAL_SHARE) * strips)

    def slips_Nm(self, circle_mm: float) -> float:
        """Torque at which the payload slips with the screws on a circle of this radius: mu F r for each."""
        return SCREWS * FACE_FRICTION * self.clamp_N * circle_mm * 1e-3

    def least_hub_mm(self, peak_Nm: float, bore_mm: float, wall_mm: float) -> float:
        """Least radius of a hub of bore radius ``bore_mm`` for walls beside the holes and for the torque."""
        circle = SLIP_SAFETY * peak_Nm / self.slips_Nm(1.0)
        wall = self.insert.wall_mm if self.insert else wall_mm
        return max(bore_mm + self.hole_mm + 2.0 * wall, 2.0 * circle - bore_mm)


def joints(material: Material, insert_of: InsertOf) -> tuple[PayloadJoint, ...]:
    """All joints for a hub of this material, the smallest thread first; ``insert_of``: the insert of a thread."""
    return tuple(PayloadJoint(thread, material, insert_of(thread)) for thread in THREADS_MM)


def payload_joint(
    material: Material, insert_of: InsertOf, peak_Nm: float, hub_mm: float, bore_mm: float, wall_mm: float
) -> PayloadJoint:
    """The smallest thread that holds in a hub of these radii; else of those with walls the one that holds most."""
    first, *more = joints(material, insert_of)
    walled = [first, *(j for j in more if j.least_hub_mm(0.0, bore_mm, wall_mm) <= hub_mm)]
    holding = [j for j in walled if j.slips_Nm((hub_mm + bore_mm) / 2.0) >= SLIP_SAFETY * peak_Nm]
    return holding[0] if holding else max(walled, key=lambda j: j.clamp_N)
