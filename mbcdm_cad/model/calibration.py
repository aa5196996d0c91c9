"""The modulus that a measured backlash implies. The paper never prints E, so every E used here is calibrated.

All stretches are proportional to 1/E and the tensions do not depend on it, hence
E = E_used theta(E_used)/theta_measured.
"""

from __future__ import annotations

from typing import Literal

import numpy as np

from mbcdm_cad.model.backlash import cable_backlash, drum_backlash, mean_radii
from mbcdm_cad.model.errors import ModelError
from mbcdm_cad.model.si import DriveSI

Reading = Literal["reversal", "single"]
Route = Literal["mean_radii", "all_cables"]


def implied_modulus_Pa(
    d: DriveSI, theta_b_rad: float, load_Nm: float, reading: Reading = "reversal", route: Route = "mean_radii"
) -> float:
    """E (Pa, on the area of ``d``) for which the model gives ``theta_b_rad`` at ``load_Nm``.

    ``reading``: the measured figure is the swing at a load reversal, or the one-sided turn on first loading.
    ``route``: corrected Eq. (20) with the paper's simplified tensions at the mean radii, or all cables at once.
    """
    if not theta_b_rad > 0.0:
        raise ModelError(f"theta_b_rad: {theta_b_rad:.6g} is not a backlash; give a measured angle above 0 rad")
    if reading not in ("reversal", "single"):
        raise ModelError(f"reading {reading!r} is unknown; use 'reversal' or 'single'")
    if route == "mean_radii":
        one_sided = float(np.ravel(cable_backlash(mean_radii(d), load_Nm).backlash_simplified_rad)[0])
        predicted = 2.0 * one_sided if reading == "reversal" else one_sided
    elif route == "all_cables":
        drum = drum_backlash(d, load_Nm)
        predicted = float(drum.reversal_swing_rad if reading == "reversal" else drum.first_loading_rad)
    else:
        raise ModelError(f"route {route!r} is unknown; use 'mean_radii' or 'all_cables'")
    return float(d.modulus_Pa) * predicted / theta_b_rad
