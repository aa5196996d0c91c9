"""Properties of a rope for tensioning and plucking: axial and bending stiffness, mass, shares. SI."""

from __future__ import annotations

from dataclasses import dataclass
from math import pi

# Wires of a rope and its diameter over theirs (ISO 2408 geometry); a braid's fibres bend freely.
WIRES = {"7x7": (49, 9.0), "7x19": (133, 15.0), "1x19": (19, 5.0)}


@dataclass(frozen=True)
class TensionedRope:
    """Properties of the rope: EA, mass, bending stiffness with wires free and bonded, and shares; SI."""

    axial_stiffness_N: float
    mass_kg_m: float
    loose_N_m2: float
    bonded_N_m2: float
    bedding_share: float
    cut_tolerance_m: float
    friction: float


def rope_stiffnesses(
    construction: str, diameter_m: float, axial_stiffness_N: float, wire_modulus_Pa: float
) -> tuple[float, float]:
    """Bending stiffness (N m^2) with wires that slide freely, and bonded into a round bar of the same EA: EA d^2/16."""
    bonded = axial_stiffness_N * diameter_m**2 / 16.0
    if construction not in WIRES:
        return 0.0, bonded
    count, ratio = WIRES[construction]
    return min(count * wire_modulus_Pa * pi / 64.0 * (diameter_m / ratio) ** 4, bonded), bonded
