"""Moments of inertia of the rotating parts: rotors from the catalogue, bodies of the routes from their parts.

At the input the rotor counts with the square of the gearhead's ratio, which is far more than the pulleys.
"""

from __future__ import annotations

from dataclasses import dataclass

from mbcdm_cad.design.drive import Drive
from mbcdm_cad.layouts.base import NoFigureError
from mbcdm_cad.rig.cables import routes_of
from mbcdm_cad.routes.route import DriveRoutes

_G_CM2 = 1e-7  # kg m2


@dataclass(frozen=True)
class Inertias:
    """Moments of inertia in kg m2, each about its own axis; the rotor's is not reflected through the gearhead."""

    rotor_kg_m2: float
    gear_ratio: float
    bodies_kg_m2: dict[str, float]
    routes: DriveRoutes

    @property
    def inputs_kg_m2(self) -> tuple[float, ...]:
        """Inertia that each input turns on its side of the gearhead."""
        return tuple(self.bodies_kg_m2[body.name] for body in self.routes.inputs)

    @property
    def drum_and_passed_kg_m2(self) -> float:
        """The drum and all bodies that the cables turn with it, reflected to the drum."""
        total = self.bodies_kg_m2[self.routes.drum.name]
        for body in self.routes.passed:
            total += self.bodies_kg_m2[body.name] * body.turns_per_drum**2
        return total

    @property
    def at_drum_kg_m2(self) -> float:
        """The total inertia reflected to the drum, rotors included."""
        total = self.drum_and_passed_kg_m2
        for body in self.routes.inputs:
            at_input = self.bodies_kg_m2[body.name] + self.rotor_kg_m2 * self.gear_ratio**2
            total += at_input * body.turns_per_drum**2
        return total


def inertias(drive: Drive) -> Inertias:
    """Inertias of the moving parts of ``drive``. Raises ValueError where they have no form."""
    rotor = drive.motor.rotor_inertia_g_cm2 * _G_CM2
    try:
        bodies = dict(drive.layout.inertias_kg_m2)
    except NoFigureError as error:
        raise ValueError(str(error)) from None
    return Inertias(rotor, drive.reduction.ratio, bodies, routes_of(drive))
