"""Moments of inertia of the pulleys and of the drum, which are the sectors of all inputs, from those of each input."""

from __future__ import annotations

from mbcdm_cad.layouts.miso_spur.drive import RoundDrumDrive
from mbcdm_cad.layouts.siso_spur.inertias import inertias_kg_m2 as of_one_input
from mbcdm_cad.layouts.siso_spur.routes import DRUM


def inertias_kg_m2(drive: RoundDrumDrive) -> dict[str, float]:
    """Inertia of each body of the routes about its own axis, kg m2."""
    found: dict[str, float] = {DRUM: 0.0}
    for k in range(drive.n_inputs):
        # The land of a pulley has the same length at every input.
        own = of_one_input(drive.unit(k))
        found[DRUM] += own.pop(DRUM)
        found |= own
    return found
