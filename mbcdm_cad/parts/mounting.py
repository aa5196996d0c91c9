"""Screws that hold a frame on what it is mounted on: their heads lie on the frame, or it has their threads.

Socket heads lie on washers where the frame is printed; threads may be those of brass inserts there.
Sizes of ISO 4762 (heads, keys), ISO 273 medium (clearance holes) and ISO 7089 (washers). Lengths depend on the base, so
that the screws are no parts of the drive.
"""

from __future__ import annotations

from dataclasses import dataclass

from mbcdm_cad.design.bought import InsertSpec


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
