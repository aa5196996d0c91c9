"""Drum sector of this configuration: place of its stop pin, and take-up of its terminals."""

from __future__ import annotations

from math import hypot, pi, radians, tau

from mbcdm_cad.layouts.miso_bevel.cable_path import winding
from mbcdm_cad.layouts.miso_bevel.drive import BevelDrive, BevelRun
from mbcdm_cad.layouts.miso_bevel.stack import Stack
from mbcdm_cad.parts.drum_sector import sizes
from mbcdm_cad.parts.drum_sector.dims import DrumDims
from mbcdm_cad.parts.drum_sector.sizes import TerminalWay, furthest_anchor_rad
from mbcdm_cad.parts.terminal.take_up import terminal_travel_mm

STOP_PIN_WALL_MM = 1.5


def stop_pin_z(drive: BevelDrive, levels: Stack) -> float:
    """Height of the stop pin: low in the web between the shelves, with metal below it."""
    return levels.shelf_bottom_z + drive.drum.stop_pin_mm / 2 + STOP_PIN_WALL_MM


def longest_mm(drive: BevelDrive, cable: BevelRun, anchor_rad: float) -> float:
    """Length of a cable that leaves its land at ``anchor_rad``, by its pieces; slightly more than the drawn path."""
    w = winding(drive, cable)
    turns = tau * drive.dead_turns + w.reduction * radians(drive.half_travel_deg)
    helix = turns * hypot(cable.input_radius_mm, drive.helix_lead_mm / tau)
    # The bend inward to the stop and the straight end in the terminal: a quarter turn and three diameters each.
    ends = pi / 2 * cable.input_radius_mm + 6.0 * drive.cable.diameter_mm
    return helix + w.free_span_mm + cable.guide_radius_mm * w.guide_wrap_rad + cable.drum_radius_mm * anchor_rad + ends


def terminal_way(drive: BevelDrive) -> TerminalWay:
    """Take-up of all terminals, and the part of it that each uses, mm, for cables anchored as far out as possible."""
    furthest = furthest_anchor_rad(drive)
    return terminal_travel_mm(drive, {c.name: longest_mm(drive, c, furthest) for c in drive.cables})


def drum(drive: BevelDrive, levels: Stack) -> DrumDims:
    """Dimensions of the drum."""
    return sizes.drum(drive, levels, stop_pin_z(drive, levels), terminal_way(drive))
