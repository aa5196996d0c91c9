"""How the cables run: each round its own input and over to the drum, as in siso_spur."""

from __future__ import annotations

from mbcdm_cad.layouts.miso_spur.drive import RoundDrumDrive
from mbcdm_cad.layouts.siso_spur.routes import routed_round
from mbcdm_cad.routes.geometry import RoutedDrive


def routed(drive: RoundDrumDrive) -> RoutedDrive:
    """Routes of the cables of ``drive``, and the lengths that follow from its file."""
    return routed_round(drive, drive.angles_rad, drive.levels_mm)
