"""The screws that hold the top plate on the side walls."""

from math import hypot, sqrt
from typing import NamedTuple

from mbcdm_cad.design.bought import Screw
from mbcdm_cad.layouts.miso_bevel.drive import BevelDrive
from mbcdm_cad.parts.motor_head.dims import body_radius_mm, outer_half_width_mm

# Screws and dowels of the top plate; the shortest that engage over one diameter are used.
PLATE_SCREWS = ("M2x6", "M2x8", "M2x10", "M2x12")
# Distance of the top plate's screws from its front and back edges.
PLATE_SCREW_INSET_MM = 3.5
# Radius of the counterbore over that of the head.
HEAD_PLAY_MM = 0.2


class Edges(NamedTuple):
    """Front and back edge of the top plate, and the radius of its corners; mm."""

    front_y: float
    back_y: float
    corner_mm: float

    @property
    def screws_y(self) -> tuple[float, float]:
        """y of the front and back screws, clear of the rounded corners."""
        inset = max(PLATE_SCREW_INSET_MM, self.corner_mm)
        return self.front_y - inset, self.back_y + inset


def plate_screw_of(drive: BevelDrive) -> Screw:
    """The top plate's screw: the shortest that engages over its diameter, else the longest."""
    screws = [drive.screw(name) for name in PLATE_SCREWS]
    sunk = [
        screw
        for screw in screws
        if screw.length_mm - drive.support.top_plate_mm + screw.head_height_mm >= screw.thread_mm
    ]
    return sunk[0] if sunk else screws[-1]


def counterbore_radius_mm(drive: BevelDrive) -> float:
    """Radius of the counterbore for a head of these screws."""
    return plate_screw_of(drive).head_diameter_mm / 2 + HEAD_PLAY_MM


def key_reach_mm(drive: BevelDrive) -> float:
    """Distance from an input's axis to the middle of a screw whose key passes the motor on the plate."""
    return body_radius_mm(drive) + plate_screw_of(drive).key_mm / 3**0.5 + drive.clearances.running_mm


def beside_box_mm(drive: BevelDrive, edges: Edges) -> float:
    """Least distance in x from an input's axis to the screws beside its coupling box: for counterbore and key."""
    counterbore = outer_half_width_mm(drive) + counterbore_radius_mm(drive) + drive.clearances.running_mm
    across = min(abs(y - drive.input_y_mm) for y in edges.screws_y)
    return max(counterbore, sqrt(max(key_reach_mm(drive) ** 2 - across**2, 0.0)))


def key_gap_mm(drive: BevelDrive, x_mm: float, y_mm: float) -> float:
    """Gap between the key of a screw at (x, y) and the motors on the plate."""
    reach = key_reach_mm(drive) - drive.clearances.running_mm
    return min(hypot(x_mm - side * drive.input_x_mm, y_mm - drive.input_y_mm) for side in (-1, 1)) - reach
