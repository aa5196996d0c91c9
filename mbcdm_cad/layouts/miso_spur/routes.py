"""How the cables run: each round its own input and over to the drum, as in siso_spur."""

from __future__ import annotations

from mbcdm_cad.layouts.miso_spur.drive import RoundDrumDrive
from mbcdm_cad.layouts.siso_spur.routes import DRUM, routed_round
from mbcdm_cad.layouts.siso_spur.routes import inertias_kg_m2 as of_one_input
from mbcdm_cad.routes.geometry import RoutedDrive


def routed(drive: RoundDrumDrive) -> RoutedDrive:
    """Routes of the cables of ``drive``, and the lengths that follow from its file."""
    return routed_round(drive, drive.angles_rad, drive.levels_mm)


def inertias_kg_m2(drive: RoundDrumDrive) -> dict[str, float]:
    """Inertia of each body of the routes about its own axis, kg m2."""
    found: dict[str, float] = {DRUM: 0.0}
    for k in range(drive.n_inputs):
        # The land of a pulley has the same length at every input.
        own = of_one_input(drive.unit(k))
        found[DRUM] += own.pop(DRUM)
        found |= own
    return found
