"""Screws. ISO metric threads: pitches (ISO 261, coarse), basic dimensions (ISO 724), tap drills (ISO 2306); joints.

Also the screws that hold a frame on what it is mounted on: socket heads lie on washers where the frame is printed, or
the frame has their threads, cut or in brass inserts. Sizes of ISO 4762 (heads, keys), ISO 273 medium (clearance holes)
and ISO 7089 (washers). Lengths depend on the base, so that these screws are no parts of the drive. No kernel here.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import inf, pi, sqrt

from mbcdm_cad.design.bought import InsertSpec, Material

# Coarse pitch and drill for tapping, mm, by nominal diameter.
_COARSE_MM = {
    1.0: (0.25, 0.75),
    1.2: (0.25, 0.95),
    1.4: (0.3, 1.1),
    1.6: (0.35, 1.25),
    2.0: (0.4, 1.6),
    2.5: (0.45, 2.05),
    3.0: (0.5, 2.5),
    4.0: (0.7, 3.3),
    5.0: (0.8, 4.2),
    6.0: (1.0, 5.0),
    8.0: (1.25, 6.8),
    10.0: (1.5, 8.5),
    12.0: (1.75, 10.2),
    16.0: (2.0, 14.0),
    20.0: (2.5, 17.5),
}
# Height of the fundamental triangle over the pitch.
_TRIANGLE = sqrt(3.0) / 2.0
# Screws of property class 8.8, tightened to seven tenths of their yield (usual values).
SCREW_YIELD_MPA = 640.0
TIGHTENED_SHARE = 0.7
# Shear strength over yield stress (von Mises).
SHEAR_SHARE = 0.577
# Share of a thread's cylinder that is sheared when it strips (usual for ISO threads).
THREAD_SHARE = 0.75
# Share of the strength of its thread that a screw may use: metal, and plastic under a lasting force, which creeps
# (estimate for PA12 and PLA).
METAL_SHARE, PLASTIC_SHARE = 0.7, 0.4
# Stress that the face of a brass insert bears (estimate for CuZn39Pb3, its yield).
BRASS_MPA = 250.0
# Clearance holes of ISO 273, medium, mm.
CLEARANCE_MM = {2.0: 2.4, 2.5: 2.9, 3.0: 3.4, 4.0: 4.5, 5.0: 5.5, 6.0: 6.6}
# Tolerance class of inside threads (ISO 965-1, usual).
THREAD_CLASS = "6H"
# A bottoming tap cuts no full thread on its last turns.
TAP_LEAD_PITCHES = 2.0


@dataclass(frozen=True)
class Thread:
    """An ISO metric coarse thread. Lengths in mm."""

    nominal_mm: float
    pitch_mm: float
    tap_drill_mm: float

    @property
    def name(self) -> str:
        """Designation, such as M2.5."""
        return f"M{self.nominal_mm:g}"

    @property
    def pitch_diameter_mm(self) -> float:
        """d2 = d - 2 (3/8) H (ISO 724)."""
        return self.nominal_mm - 0.75 * _TRIANGLE * self.pitch_mm

    @property
    def minor_diameter_mm(self) -> float:
        """D1 = d - 2 (5/8) H, of the inside thread (ISO 724)."""
        return self.nominal_mm - 1.25 * _TRIANGLE * self.pitch_mm

    @property
    def root_diameter_mm(self) -> float:
        """d3 = d - 2 (17/24) H, of the screw (ISO 68-1 with a round root)."""
        return self.nominal_mm - 17.0 / 12.0 * _TRIANGLE * self.pitch_mm

    @property
    def stress_area_mm2(self) -> float:
        """A_s = pi/4 ((d2 + d3) / 2)^2 (ISO 898-1)."""
        return 0.7853981633974483 * ((self.pitch_diameter_mm + self.root_diameter_mm) / 2.0) ** 2

    def full_thread_mm(self, drilled_mm: float) -> float:
        """Depth of full thread in a blind hole drilled to ``drilled_mm``."""
        return max(0.0, drilled_mm - TAP_LEAD_PITCHES * self.pitch_mm)


def thread(nominal_mm: float) -> Thread:
    """The coarse thread of a nominal diameter. Raises ``ValueError`` naming the sizes there are."""
    found = next((item for item in _COARSE_MM.items() if abs(item[0] - nominal_mm) < 1e-9), None)
    if found is None:
        sizes = ", ".join(f"{d:g}" for d in _COARSE_MM)
        raise ValueError(f"thread M{nominal_mm:g}: not a coarse thread of the table; choose one of {sizes} mm")
    return Thread(found[0], *found[1])


def clamp_force_N(nominal_mm: float) -> float:
    """Force of a tightened screw: seven tenths of yield over its stress area."""
    return TIGHTENED_SHARE * SCREW_YIELD_MPA * thread(nominal_mm).stress_area_mm2


@dataclass(frozen=True)
class ScrewHold:
    """What a tightened screw does for a joint, N: its force, what its thread bears pulled, and the part across."""

    clamp_N: float
    pull_N: float
    across_N: float = inf

    def slips_N(self, friction: float) -> float:
        """Force across at which the joint slips at this screw, or its insert moves in the plastic."""
        return min(friction * self.clamp_N, self.across_N)


def screw_hold(thread_mm: float, material: Material, insert: InsertSpec | None, engaged_mm: float) -> ScrewHold:
    """A screw whose thread is cut in a part, or in a brass insert flush with the face on which the other part lies.

    That part then presses on the brass round its clearance hole, which must be smaller than the insert: nothing that
    the screw tightens creeps. The plastic holds the insert where it is, and bears what pulls the joint open.
    """
    share = PLASTIC_SHARE if material.printed else METAL_SHARE
    across, along = (insert.outside_mm, insert.length_mm) if insert else (thread_mm, engaged_mm)
    strips = share * pi * across * along * THREAD_SHARE * SHEAR_SHARE * material.yield_MPa
    if insert is None:
        holds = min(clamp_force_N(thread_mm), strips)
        return ScrewHold(holds, holds)
    # The body between the knurls is what is sure to lie under the other part.
    ring = pi / 4.0 * max(insert.hole_mm**2 - CLEARANCE_MM[thread_mm] ** 2, 0.0)
    clamp = min(clamp_force_N(thread_mm), BRASS_MPA * ring)
    return ScrewHold(clamp, min(clamp, strips), share * material.yield_MPa * across * along)


@dataclass(frozen=True)
class MountScrew:
    """A screw with its washer. Lengths in mm."""

    thread_mm: float
    hole_mm: float
    head_mm: float
    head_height_mm: float
    key_mm: float
    washer_mm: float
    washer_height_mm: float

    @property
    def name(self) -> str:
        """Designation, such as M4."""
        return f"M{self.thread_mm:g}"

    def seat_mm(self, printed: bool) -> float:
        """Diameter that presses the frame: the head, or the washer under it."""
        return self.washer_mm if printed else self.head_mm

    def height_mm(self, printed: bool) -> float:
        """Height of the head over the frame."""
        return self.head_height_mm + (self.washer_height_mm if printed else 0.0)

    def words(self, printed: bool) -> str:
        """For instructions: ``M4 on washers``."""
        return f"{self.name} on washers" if printed else self.name


@dataclass(frozen=True)
class MountThread:
    """Thread of a mounting screw in the frame: how deep the screw may reach, and its insert where it has one."""

    depth_mm: float
    insert: InsertSpec | None


MOUNT_SCREWS = {
    screw.name: screw
    for screw in (
        MountScrew(3.0, 3.4, 5.5, 3.0, 2.5, 7.0, 0.5),
        MountScrew(4.0, 4.5, 7.0, 4.0, 3.0, 9.0, 0.8),
        MountScrew(5.0, 5.5, 8.5, 5.0, 4.0, 10.0, 1.0),
        MountScrew(6.0, 6.6, 10.0, 6.0, 5.0, 12.0, 1.6),
    )
}
