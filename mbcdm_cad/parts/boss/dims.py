"""Dimensions of a frame's boss: seats of the drum's two bearings, and the pocket of its ring encoder behind them."""

from __future__ import annotations

from dataclasses import dataclass

from mbcdm_cad.parts.drum_sector.design import SectorDrive
from mbcdm_cad.parts.drum_sector.sizes import SPRING_HEIGHT_MM
from mbcdm_cad.parts.drum_shaft import DrumShaftDims

BEARING_WALL_MM = 3.0
EAR_WALL_MM = 1.2
# Thread of the encoder's screws that its housing takes.
ENCODER_GRIP_MM = 2.0


@dataclass(frozen=True)
class BossDims:
    """Boss about the drum's axis, from the frame's back to its own front; ears take the ring encoder's screws."""

    radius: float
    back_y: float
    front_y: float
    encoder_pocket_radius: float
    encoder_pocket_floor_y: float
    seat_radius: float
    rear_seat_end_y: float
    front_seat_start_y: float
    shoulder_radius: float
    screw_radius: float
    screw_circle: float
    screw_depth: float
    ear_reach: float
    ear_half_height: float
    ear_front_y: float


def boss(drive: SectorDrive, shaft: DrumShaftDims, back_y: float, front_y: float) -> BossDims:
    """Boss for the drum's bearings, shaft and encoder."""
    bearing, encoder = drive.bearings.drum, drive.drum_encoder
    screw = drive.screw(encoder.screw)
    return BossDims(
        radius=bearing.outer_diameter_mm / 2 + BEARING_WALL_MM,
        back_y=back_y,
        front_y=front_y,
        encoder_pocket_radius=encoder.diameter_mm / 2 + drive.clearances.running_mm,
        encoder_pocket_floor_y=back_y + encoder.length_mm,
        seat_radius=bearing.outer_diameter_mm / 2,
        rear_seat_end_y=shaft.rear_bearing_y + bearing.width_mm + SPRING_HEIGHT_MM,
        front_seat_start_y=shaft.front_bearing_y,
        shoulder_radius=bearing.outer_shoulder_mm / 2,
        screw_radius=screw.thread_mm / 2,
        screw_circle=encoder.bolt_circle_mm / 2,
        screw_depth=screw.length_mm - ENCODER_GRIP_MM + 0.5,
        ear_reach=encoder.bolt_circle_mm / 2 + screw.thread_mm / 2 + EAR_WALL_MM,
        ear_half_height=screw.thread_mm / 2 + 2 * EAR_WALL_MM,
        ear_front_y=back_y + encoder.length_mm + screw.length_mm - ENCODER_GRIP_MM + 1.0,
    )
