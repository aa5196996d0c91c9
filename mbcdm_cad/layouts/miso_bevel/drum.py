"""Drum sector of this configuration: place of its stop pin, and take-up of its terminals."""

from __future__ import annotations

from mbcdm_cad.layouts.miso_bevel.drive import BevelDrive
from mbcdm_cad.layouts.miso_bevel.stack import Stack
from mbcdm_cad.layouts.miso_bevel.tensioning import terminal_way
from mbcdm_cad.parts.drum_sector import sizes
from mbcdm_cad.parts.drum_sector.dims import DrumDims

STOP_PIN_WALL_MM = 1.5


def stop_pin_z(drive: BevelDrive, levels: Stack) -> float:
    """Height of the stop pin: low in the web between the shelves, with metal below it."""
    return levels.shelf_bottom_z + drive.drum.stop_pin_mm / 2 + STOP_PIN_WALL_MM


def drum(drive: BevelDrive, levels: Stack) -> DrumDims:
    """Dimensions of the drum."""
    return sizes.drum(drive, levels, stop_pin_z(drive, levels), terminal_way(drive))
